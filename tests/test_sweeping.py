"""Sweeps over anything, which lose nothing."""

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

import legspring as ls
from legspring import Animal, Gait, blocks, plans, stores, sweeping
from legspring.batches import GAIT, MEASURES, NOT_REACHED, Batch
from legspring.candidates import box_of
from legspring.figures import draw_sobol, draw_sweep
from legspring.stores import finished, open_sweep

GRID = {"slope_deg": np.linspace(35.0, 55.0, 9), "F.stiffness": np.linspace(1.2, 1.8, 5)}


@pytest.fixture(scope="module")
def climbing(roach: Animal) -> list[Gait]:
    return ls.find_gaits(roach, slope_deg=45, heading=0.15)


@pytest.fixture(scope="module")
def found(roach: Animal, climbing: list[Gait]) -> xr.Dataset:
    return ls.sweep(roach, GRID, gaits=climbing)


def at(found: xr.Dataset, **place: float) -> xr.Dataset:
    """Return one point of a result."""
    return found.sel({name.replace("__", "."): value for name, value in place.items()}, method="nearest")


def test_what_is_followed_is_what_a_search_finds(roach: Animal, found: xr.Dataset) -> None:
    assert set(np.unique(found["outcome"])) <= {GAIT, NOT_REACHED}
    rng = np.random.default_rng(2)
    for slope_deg, stiffness in zip(rng.choice(GRID["slope_deg"], 6), rng.choice(GRID["F.stiffness"], 6), strict=True):
        here = found.sel({"slope_deg": slope_deg, "F.stiffness": stiffness})
        gaits = ls.find_gaits(roach.replace(**{"F.stiffness": stiffness}), slope_deg=slope_deg, heading=0.15)
        for branch in here["branch"].values:
            one = here.sel(branch=branch)
            if one["outcome"] == GAIT:
                gait = min(gaits, key=lambda gait: abs(gait.speed - one["speed"].item()))
                for name in MEASURES:
                    if name in one:
                        wanted = abs(gait.multipliers[0]) if name == "max_multiplier" else getattr(gait, name)
                        assert one[name].values == pytest.approx(wanted, rel=1e-7, abs=1e-8), name
                parts = np.stack([gait.multipliers.real, gait.multipliers.imag], axis=-1)
                assert one["multipliers"].values == pytest.approx(parts, abs=1e-7)
                assert one["family"].attrs["flag_meanings"].split("; ")[int(one["family"])] == gait.family


def test_a_gait_keeps_its_number(climbing: list[Gait], found: xr.Dataset) -> None:
    """Neighbours of one branch are close; the branches are apart."""
    own = found.sel({"slope_deg": 45.0, "F.stiffness": 1.5}, method="nearest")
    for gait in climbing:
        assert own["max_multiplier"].sel(branch=gait.branch).item() == pytest.approx(abs(gait.multipliers[0]), abs=1e-6)
    # A leg's force has the same sign everywhere, which the other branch's phases would not give it so soon.
    steps = abs(found["phase"].diff("slope_deg"))
    apart = abs(found["phase"].diff("branch")).max("leg")
    assert float(steps.max()) < float(apart.min())


def test_what_is_not_reached_is_beyond_a_fold(roach: Animal, climbing: list[Gait]) -> None:
    """Curves of the same gaits end in between."""
    wide = ls.sweep(roach, {"heading": np.linspace(0.1, 0.6, 26)}, gaits=climbing)
    for gait in climbing:
        outcome = wide["outcome"].sel(branch=gait.branch).values
        last = wide["heading"].values[outcome == GAIT].max()
        curve = ls.follow(gait, "heading", within=(0.1, 0.6))
        ends = [one.value for one in curve.special if one.kind == "fold"] or [
            curve.to_dataset()["heading"].values.max()
        ]
        assert 0.0 <= min(ends) - last <= 0.0201 or outcome[-1] == GAIT


def test_a_gait_does_not_jump_to_another(roach: Animal, climbing: list[Gait], monkeypatch: pytest.MonkeyPatch) -> None:
    """Beyond the line of folds where one branch ends lies the other one, near enough to land on."""
    over = {"slope_deg": np.linspace(40.0, 50.0, 9), "mass": np.linspace(2e-3, 3e-3, 7)}
    whole = ls.sweep(roach, over, gaits=climbing)
    monkeypatch.setattr(plans, "FOLLOWED", 8)
    monkeypatch.setattr(plans, "FEWEST", 1)
    parts = ls.sweep(roach, over, gaits=climbing)
    for found in (whole, parts):
        assert set(np.unique(found["outcome"])) == {GAIT, NOT_REACHED}
    assert np.mean(whole["outcome"].values != parts["outcome"].values) < 0.03


def test_a_gait_goes_on_where_another_crosses() -> None:
    """Two families of the walker cross; each is a gait with a number of its own on both sides."""
    walker = ls.load_animal("walker")
    gaits = ls.find_gaits(walker, energy=820)
    found = ls.sweep(walker, {"angle": [-2.8306, -2.8167, -2.8028, -2.7889]}, gaits=gaits)
    for gait in gaits:
        curve = ls.follow(gait, "angle", within=(-2.84, -2.77)).to_dataset()
        order = np.argsort(curve["angle"].values)
        for n, angle in enumerate(found["angle"].values):
            one = found.isel(angle=n, branch=gait.branch)
            if one["outcome"] == GAIT:
                speed = np.interp(angle, curve["angle"].values[order], curve["speed"].values[order])
                assert one["speed"].item() == pytest.approx(speed, abs=2e-3)
    assert np.sum(found["outcome"] == GAIT) >= 6


def test_laws_with_a_kink(roach: Animal) -> None:
    """However little of a range lies beyond it."""
    gaits = ls.find_gaits(roach, slope_deg=5, heading=0.15)
    for values in ([-0.2, 5.0, 10.0], [-10.0, -5.0, 0.0, 5.0, 20.0]):
        found = ls.sweep(roach, {"slope_deg": values}, gaits=gaits)
        for slope_deg in values:
            one = found.sel(slope_deg=slope_deg, branch=0)
            if one["outcome"] == GAIT:
                speeds = [gait.speed for gait in ls.find_gaits(roach, slope_deg=slope_deg, heading=0.15)]
                assert min(abs(speed - one["speed"].item()) for speed in speeds) < 1e-8
        assert np.sum(found["outcome"] == GAIT) >= 3


def test_maps_have_no_holes(roach: Animal, climbing: list[Gait]) -> None:
    """Where all four places around have the gait, so has the one in the midst."""
    over = {"slope_deg": np.linspace(30.0, 60.0, 61), "F.stiffness": np.linspace(1.0, 2.0, 41)}
    there = (ls.sweep(roach, over, gaits=climbing[1])["outcome"] == GAIT).values[..., 0]
    around = there[:-2, 1:-1] & there[2:, 1:-1] & there[1:-1, :-2] & there[1:-1, 2:]
    assert around.sum() > 1000 and not np.any(around & ~there[1:-1, 1:-1])
    # Of the places beside the line where it ends, a search finds it in none that is further off than the next one.
    rows = np.argwhere(there[:, 1:] & ~there[:, :-1])[::12]
    for row, column in rows:
        animal = roach.replace(**{"F.stiffness": over["F.stiffness"][max(column - 1, 0)]})
        assert len(ls.find_gaits(animal, slope_deg=over["slope_deg"][row], heading=0.15)) == 1


def test_gaits_without_room_are_counted() -> None:
    roach = ls.cockroach()
    found = ls.sweep(roach, {"slope_deg": [45.0]}, heading=0.15, branches=1, starts=12)
    assert found.sizes["multiplier"] == 4 and found["found"].values.tolist() == [2]
    assert sweeping.fates_of(found)[-1].startswith("1: further gaits")


def test_the_same_gait_twice_counts_once(roach: Animal, climbing: list[Gait]) -> None:
    found = ls.sweep(roach, {"slope_deg": [44.0, 45.0]}, gaits=[climbing[0], climbing[0]], measures=["speed"])
    assert found["outcome"].values.tolist() == [[GAIT, plans.DOUBLE]] * 2
    assert np.isnan(found["speed"].values[:, 1]).all() and np.isfinite(found["speed"].values[:, 0]).all()


def test_gaits_whose_conditions_are_not_plain() -> None:
    animal = ls.load_animal("injured_cockroach")
    gait = ls.find_gaits(animal, slope_deg=30, heading=0.0 if animal.tuned else None)[0]
    value = gait.animal.legs[0].angle
    name = f"{gait.animal.legs[0].pair}.angle"
    box = box_of([gait], {name: (value - 0.02, value + 0.02)})
    assert not Batch.is_plain(gait, box)
    few = ls.sweep(animal, {name: [value - 0.01, value, value + 0.01]}, gaits=gait, measures=["speed", "peak_force"])
    assert few["outcome"].values[1, 0] == GAIT
    assert few["speed"].values[1, 0] == pytest.approx(gait.speed, rel=1e-9)
    assert few["peak_force"].values[1, 0] == pytest.approx(gait.peak_force, rel=1e-6)


@pytest.mark.parametrize("sampling", ["latin", "sobol", "random"])
def test_samples(roach: Animal, climbing: list[Gait], sampling: str) -> None:
    over = {"slope_deg": (40.0, 50.0), "M.stiffness": (1.3, 1.7), "mass": (0.9 * 2.5e-3, 1.1 * 2.5e-3)}
    one = ls.sweep(roach, over, samples=24, sampling=sampling, seed=4, gaits=climbing[0], workers=1)
    two = ls.sweep(roach, over, samples=24, sampling=sampling, seed=4, gaits=climbing[0], workers=2)
    xr.testing.assert_equal(one, two)
    assert one.sizes["point"] == 24 and np.mean(one["outcome"] == GAIT) > 0.8
    for name, (low, high) in over.items():
        values = one[name].values
        assert np.all((values >= low) & (values <= high)) and len(np.unique(values)) == 24
    if sampling == "latin":
        # One in each of as many slices.
        slices = np.floor(24 * (np.sort(one["slope_deg"].values) - 40.0) / 10.0)
        assert slices.tolist() == list(range(24))


def test_a_list_of_points(roach: Animal, climbing: list[Gait]) -> None:
    over = {"slope_deg": [44.0, 47.0, 41.0], "heading": [0.15, 0.1, 0.2]}
    listed = ls.sweep(roach, over, sampling="list", gaits=climbing[:1])
    for n, (slope_deg, heading) in enumerate(zip(*over.values(), strict=True)):
        gaits = ls.find_gaits(roach, slope_deg=slope_deg, heading=heading)
        assert listed["outcome"].values[n, 0] == GAIT
        assert min(abs(gait.speed - listed["speed"].values[n, 0]) for gait in gaits) < 1e-8


def test_searching_at_each_point(roach: Animal) -> None:
    small = ls.sweep(
        roach, {"slope_deg": [15.0, 45.0]}, heading=0.2, starts=12, branches=3, measures=["speed", "friction"]
    )
    for slope_deg in (15.0, 45.0):
        here = small.sel(slope_deg=slope_deg)
        gaits = ls.find_gaits(roach, slope_deg=slope_deg, heading=0.2)
        assert int((here["outcome"] == GAIT).sum()) == len(gaits)
        for gait in gaits:
            one = here.sel(branch=gait.branch)
            assert one["speed"].item() == pytest.approx(gait.speed, rel=1e-8)
            assert one["friction"].item() == pytest.approx(gait.friction, rel=1e-8)
    none = ls.sweep(roach, {"heading": [0.7]}, slope_deg=40, starts=4)
    assert none["outcome"].values[0, 0] != GAIT and np.isnan(none["speed"].values).all()


# What varies with what -------------------------------------------------------------------------------------------


def test_sobol_indices_that_are_known() -> None:
    """Of Ishigami's function."""
    size, low, high = 3, -np.pi, np.pi
    x = low + (high - low) * plans.sampled("saltelli", 4096, size, 1)
    assert x.shape == (4096 * 5, 3)
    values = np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])
    coords = {f"x{n}": ("point", column) for n, column in enumerate(x.T)} | {"branch": [0]}
    about = {"sampling": "saltelli", "samples": 4096}
    made = xr.Dataset({"cost": (("point", "branch"), values[:, None])}, coords, about)
    shares = ls.sobol_indices(made, "cost")
    b, a = 0.1, 7.0
    v1, v2, v13 = 0.5 * (1 + b * np.pi**4 / 5) ** 2, a**2 / 8, b**2 * np.pi**8 * (1 / 18 - 1 / 50)
    total = v1 + v2 + v13
    assert shares["first_order"].values == pytest.approx([v1 / total, v2 / total, 0.0], abs=0.02)
    assert shares["total_order"].values == pytest.approx([(v1 + v13) / total, v2 / total, v13 / total], abs=0.02)
    for kind in ("first_order", "total_order"):
        assert np.all(shares[f"{kind}_low"] <= shares[kind] + 1e-12) and np.all(shares[kind] <= shares[f"{kind}_high"])
    # What is missing at some base points is left out of all.
    made["cost"][7] = np.nan
    assert ls.sobol_indices(made, "cost").attrs["base_points"] == 2048
    for name, branch, words in (("luck", 0, "must be one of cost"), ("cost", 3, "must be one of 0")):
        with pytest.raises(ValueError, match=words):
            ls.sobol_indices(made, name, branch=branch)
    with pytest.raises(ValueError, match=r"must be of legspring\.sweep"):
        ls.sobol_indices(xr.Dataset(), "cost")
    with pytest.raises(ValueError, match="must have all of those"):
        ls.sobol_indices(made.isel(point=slice(0, 4096)), "cost")
    made["cost"][: 4096 - 4] = np.nan
    with pytest.raises(ValueError, match="must be at 8 or more"):
        ls.sobol_indices(made, "cost")


def test_what_gaits_vary_with(roach: Animal, climbing: list[Gait]) -> None:
    """Up a slope the cost is that of climbing, whatever the stiffness."""
    over = {"slope_deg": (40.0, 50.0), "M.stiffness": (1.45, 1.55)}
    runs = ls.sweep(roach, over, samples=32, sampling="saltelli", gaits=climbing[0])
    shares = ls.sobol_indices(runs, "step_duration")
    assert shares["first_order"].values == pytest.approx([1.0, 0.0], abs=0.05)
    assert isinstance(draw_sobol(shares), Figure)
    with pytest.raises(ValueError, match="power of two"):
        ls.sweep(roach, over, samples=33, sampling="saltelli", gaits=climbing[0])


def test_pictures(roach: Animal, climbing: list[Gait], found: xr.Dataset) -> None:
    assert isinstance(draw_sweep(found, "max_multiplier"), Figure)
    assert isinstance(draw_sweep(found, "phase", leg="F", x="F.stiffness", y="slope_deg"), Figure)
    lines = draw_sweep(found.isel({"F.stiffness": 2}, drop=True), "transport_cost")
    assert len(lines.axes) == 1
    runs = ls.sweep(
        roach, {"slope_deg": (40, 50), "mass": (2e-3, 3e-3)}, samples=16, sampling="sobol", gaits=climbing[0]
    )
    assert isinstance(draw_sweep(runs, "transport_cost"), Figure)
    for name, places, words in (
        ("luck", {}, "must be a measure"),
        ("phase", {}, "leg is missing: must be one of F, M, B"),
        ("speed", {"x": "wings"}, "must be of slope_deg, F.stiffness"),
        ("speed", {"leg": "F"}, "must be a dimension of speed"),
        ("speed", {"branch": 9}, "branch = 9: must be one of 0, 1"),
        ("speed", {"x": "slope_deg", "y": "slope_deg"}, "must be two axes"),
    ):
        with pytest.raises(ValueError, match=words):
            draw_sweep(found, name, **places)


# What is kept ----------------------------------------------------------------------------------------------------


@pytest.fixture
def small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Cut points into many blocks."""
    monkeypatch.setattr(plans, "FOLLOWED", 6)
    monkeypatch.setattr(plans, "FEWEST", 1)


def test_a_store_holds_the_same(
    roach: Animal, climbing: list[Gait], found: xr.Dataset, tmp_path: Path, small_blocks: None
) -> None:
    kept = ls.sweep(roach, GRID, gaits=climbing, store=tmp_path / "runs.zarr", workers=2)
    alone = ls.sweep(roach, GRID, gaits=climbing, workers=1)
    both = (kept["outcome"].values == GAIT) & (found["outcome"].values == GAIT)
    assert both.mean() > 0.6 and np.mean(kept["outcome"].values == found["outcome"].values) > 0.95
    for name in found.data_vars:
        assert np.array_equal(kept[name].values, alone[name].values, equal_nan=True), name
        if name in plans.COUNTS:
            continue
        # Blocks are reached on other ways, on which a gait next to a fold may not be.
        one, other = kept[name].values[both], found[name].values[both]
        assert one == pytest.approx(other, rel=1e-7, abs=1e-7, nan_ok=True), name
    assert kept.attrs["animal"] == "cockroach" and kept["speed"].attrs["units"] == "m/s"
    done, count = finished(tmp_path / "runs.zarr")
    assert done == count > 5
    kept.load().drop_vars("done").to_netcdf(tmp_path / "runs.nc")
    with xr.open_dataset(tmp_path / "runs.nc") as back:
        assert np.array_equal(back["speed"].values, kept["speed"].values, equal_nan=True)


def test_what_is_done_is_not_done_again(
    roach: Animal, climbing: list[Gait], tmp_path: Path, small_blocks: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    work, calls = blocks.block_of, list[int]()

    def counting(plan: Any) -> Any:
        calls.append(1)
        if len(calls) == 4:
            raise KeyboardInterrupt
        return work(plan)

    path, asked = tmp_path / "runs.zarr", {"gaits": climbing, "workers": 1}
    whole = ls.sweep(roach, GRID, **asked)  # type: ignore[arg-type]
    monkeypatch.setattr(sweeping, "block_of", counting)
    with pytest.raises(KeyboardInterrupt):
        ls.sweep(roach, GRID, store=path, **asked)  # type: ignore[arg-type]
    done, count = finished(path)
    assert done == 3
    unfinished = open_sweep(path)
    assert int((unfinished["outcome"] == GAIT).sum()) < int((whole["outcome"] == GAIT).sum())
    calls[:] = [0] * 10
    again = ls.sweep(roach, GRID, store=path, **asked)  # type: ignore[arg-type]
    assert len(calls) == 10 + count - 3
    for name in whole.data_vars:
        assert np.array_equal(again[name].values, whole[name].values, equal_nan=True)


@pytest.mark.parametrize(
    "how", ["removed", *(pytest.param(one, marks=pytest.mark.long) for one in ("changed", "cut off"))]
)
def test_what_is_damaged_is_done_again(
    roach: Animal, climbing: list[Gait], tmp_path: Path, small_blocks: None, how: str
) -> None:
    path = tmp_path / "runs.zarr"
    whole = ls.sweep(roach, GRID, gaits=climbing, store=path).load()
    chunks = sorted(file for file in (path / "speed").rglob("*") if file.is_file() and file.name != "zarr.json")
    assert len(chunks) > 5
    content = chunks[2].read_bytes()
    if how == "removed":
        chunks[2].unlink()
    else:
        chunks[2].write_bytes(
            content[:-7] if how == "cut off" else content[:9] + bytes([content[9] ^ 1]) + content[10:]
        )
    again = ls.sweep(roach, GRID, gaits=climbing, store=path)
    for name in whole.data_vars:
        assert np.array_equal(again[name].values, whole[name].values, equal_nan=True)


@pytest.mark.long
def test_values_may_be_added(roach: Animal, climbing: list[Gait], tmp_path: Path, small_blocks: None) -> None:
    path = tmp_path / "runs.zarr"
    first = {"slope_deg": GRID["slope_deg"][:4], "F.stiffness": GRID["F.stiffness"]}
    climbing = climbing[:1]
    ls.sweep(roach, first, gaits=climbing, store=path)
    more = ls.sweep(roach, GRID, gaits=climbing, store=path)
    whole = ls.sweep(roach, GRID, gaits=climbing)
    for name in whole.data_vars:
        assert more[name].values == pytest.approx(whole[name].values, rel=1e-7, abs=1e-7, nan_ok=True), name
    for over, words in (
        (first, "must not have fewer"),
        ({**GRID, "slope_deg": GRID["slope_deg"] + 1.0}, "has other values of slope_deg"),
        ({"slope_deg": GRID["slope_deg"]}, "of which names is different"),
    ):
        with pytest.raises(ValueError, match=words):
            ls.sweep(roach, over, gaits=climbing, store=path)


LATER = ["slope_deg/zarr.json", "done/zarr.json", "done", "branch"]


@pytest.mark.parametrize(
    "what",
    ["slope_deg/c/0", "speed/zarr.json", "speed", *(pytest.param(one, marks=pytest.mark.long) for one in LATER)],
)
def test_what_is_around_blocks_is_mended(
    roach: Animal, climbing: list[Gait], tmp_path: Path, small_blocks: None, monkeypatch: pytest.MonkeyPatch, what: str
) -> None:
    path, over = tmp_path / "runs.zarr", {"slope_deg": np.linspace(44.0, 46.0, 14)}
    whole = ls.sweep(roach, over, gaits=climbing, store=path).load()
    place = path / what
    if place.is_dir():
        shutil.rmtree(place)
    else:
        content = bytearray(place.read_bytes())
        content[len(content) // 2] ^= 0x55
        place.write_bytes(bytes(content))
    calls = list[int]()

    def counting(part: plans.Plan) -> Any:
        calls.append(1)
        return blocks.block_of(part)

    with monkeypatch.context() as patch:
        patch.setattr(sweeping, "block_of", counting)
        again = ls.sweep(roach, over, gaits=climbing, store=path)
    for name in whole.variables:
        assert np.array_equal(again[name].values, whole[name].values), name
    # What was there of blocks, and known to be so, is not worked on again.
    assert len(calls) == (finished(path)[1] if what in ("speed", "done") else 0)


def test_a_link_is_the_store_that_it_leads_to(roach: Animal, climbing: list[Gait], tmp_path: Path) -> None:
    path, link = tmp_path / "real.zarr", tmp_path / "link.zarr"
    link.symlink_to(path)
    ls.sweep(roach, {"slope_deg": [44.0, 45.0]}, gaits=climbing, store=link)
    assert link.is_symlink() and finished(path) == finished(link)
    ls.sweep(roach, {"slope_deg": [44.0, 45.0, 46.0]}, gaits=climbing, store=link)
    assert link.is_symlink() and open_sweep(path).sizes["slope_deg"] == 3
    with stores.opened(path, *_about(path)), pytest.raises(ValueError, match="in use"):
        ls.sweep(roach, {"slope_deg": [44.0, 45.0, 46.0]}, gaits=climbing, store=link)


def test_points_of_which_nothing_can_be_asked(roach: Animal) -> None:
    """Wherever they are."""
    for values in ([-1.0, 1.5], [1.5, -1.0]):
        found = ls.sweep(roach, {"F.stiffness": values}, sampling="list", slope_deg=45, heading=0.15, starts=8)
        outcome = dict(zip(values, found["outcome"].values[:, 0].tolist(), strict=True))
        assert outcome == {-1.0: plans.UNASKABLE, 1.5: GAIT}
    with pytest.raises(ValueError, match="slope"):
        ls.sweep(roach, {"slope_deg": [95.0, 200.0]}, heading=0.15)


def test_what_is_let_go_is_said() -> None:
    leg = ls.load_animal("effective_leg")
    over, asked = {"slope_deg": [44.0, 45.0]}, {"heading": 0.15, "free": ("T.angle",)}
    gaits = ls.find_gaits(leg, slope_deg=45, **asked)  # type: ignore[arg-type]
    searched, followed = ls.sweep(leg, over, **asked), ls.sweep(leg, over, gaits=gaits)  # type: ignore[arg-type]
    for found in (searched, followed):
        here = found["T.angle"].sel(slope_deg=45.0).dropna("branch").values
        assert sorted(here) == pytest.approx(sorted(gait.freed["T.angle"] for gait in gaits), abs=1e-7)
    with pytest.raises(ValueError, match=r"free = 'T\.angle': must be left out, as it varies"):
        ls.sweep(leg, {"T.angle": [0.1, 0.2]}, slope_deg=20, **asked)  # type: ignore[arg-type]


def test_recoveries(roach: Animal, climbing: list[Gait]) -> None:
    found = ls.sweep(roach, {"slope_deg": [45.0]}, gaits=climbing, impulses=[-0.5, 0.5])
    for gait in climbing:
        steps = found["recovery_steps"].sel(branch=gait.branch, slope_deg=45.0).values
        assert steps == pytest.approx(gait.recovery_steps([-0.5, 0.5]), nan_ok=True)


def test_other_points_are_not_taken_for_these(roach: Animal, climbing: list[Gait], tmp_path: Path) -> None:
    ranges, asked = {"slope_deg": (40.0, 50.0)}, {"samples": 8, "sampling": "random", "gaits": climbing[:1]}
    ls.sweep(roach, ranges, seed=0, store=tmp_path / "a.zarr", **asked)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="has other values of slope_deg"):
        ls.sweep(roach, ranges, seed=1, store=tmp_path / "a.zarr", **asked)  # type: ignore[arg-type]
    more = ls.sweep(roach, ranges, seed=0, store=tmp_path / "a.zarr", **asked | {"samples": 12})  # type: ignore[arg-type]
    fresh = ls.sweep(roach, ranges, seed=0, **asked | {"samples": 12})  # type: ignore[arg-type]
    assert more["speed"].values == pytest.approx(fresh["speed"].values, rel=1e-9)
    assert np.array_equal(more["slope_deg"].values, fresh["slope_deg"].values)


def test_killed_while_it_grows(
    roach: Animal, climbing: list[Gait], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, asked = tmp_path / "runs.zarr", {"gaits": climbing[:1], "store": tmp_path / "runs.zarr"}
    ls.sweep(roach, {"slope_deg": [40.0, 42.0]}, **asked)  # type: ignore[arg-type]
    for name in ("write_coordinate", "make_array", "with_blocks_of", "shutil.rmtree"):
        with monkeypatch.context() as patch:
            patch.setattr(f"legspring.stores.{name}", _interrupted)
            with pytest.raises(KeyboardInterrupt):
                ls.sweep(roach, {"slope_deg": [40.0, 42.0, 44.0]}, **asked)  # type: ignore[arg-type]
        assert open_sweep(path).load().sizes["slope_deg"] in (2, 3)
    # Killed between the two moves.
    path.rename(tmp_path / ".runs.zarr.before")
    whole = ls.sweep(roach, {"slope_deg": [40.0, 42.0, 44.0]}, **asked)  # type: ignore[arg-type]
    assert int((whole["outcome"] == GAIT).sum()) == 3 and finished(path)[0] == finished(path)[1]


def _interrupted(*_: Any, **__: Any) -> None:
    raise KeyboardInterrupt


def test_stores_that_are_refused(
    roach: Animal, climbing: list[Gait], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, asked = tmp_path / "runs.zarr", {"gaits": climbing}
    over = {"slope_deg": [44.0, 45.0]}
    ls.sweep(roach, over, store=path, **asked)  # type: ignore[arg-type]

    def refused(words: str, **other: Any) -> None:
        with pytest.raises((ValueError, OSError)) as error:
            ls.sweep(roach, over, **asked | {"store": path} | other)
        assert words in str(error.value) and "\n" not in str(error.value)

    refused("of which gaits is different", gaits=climbing[:1])
    refused("of which measures is different", measures=["speed"])
    (tmp_path / "note").write_text("mine")
    refused("must be a folder, and is a file", store=tmp_path / "note")
    refused("must be the name of a folder", store=5)
    refused("must be the name of a folder", store="")
    refused("must be the name of a folder", store="/")
    with pytest.raises(ValueError, match=r"must be the store of a sweep$"):
        open_sweep(tmp_path / "nowhere")
    refused("must exist", store=tmp_path / "nowhere" / "runs.zarr")
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "file").write_text("mine")
    refused("must be the store of a sweep, or a new folder", store=tmp_path / "folder")
    with stores.opened(path, *_about(path)):
        refused("is in use by another program")
    with monkeypatch.context() as patch:
        patch.setattr(sweeping, "code_stamp", lambda: "another")
        refused("of which version is different")
    with monkeypatch.context() as patch:
        patch.setattr(stores, "FORMAT", 2)
        refused("is of format 1, and this version of legspring reads format 2")


def _about(path: Path) -> tuple[Any, Any]:
    """Return a layout and an identity with which a store opens."""
    import json

    identity = json.loads(open_sweep(path).attrs["identity"])
    data = open_sweep(path)
    shape = data["outcome"].shape
    variables = {"outcome": stores.Variable(("slope_deg", "branch"), shape, "int16", -2, {})}
    coords: dict[str, tuple[Any, ...]] = {"slope_deg": ("slope_deg", data["slope_deg"].values, {})}
    return stores.Layout({"slope_deg": shape[0]}, (shape[0],), variables, coords, {}), identity


@pytest.mark.long
def test_on_a_cluster(roach: Animal, climbing: list[Gait], small_blocks: None, tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    whole = ls.sweep(roach, GRID, gaits=climbing)
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        for where in (client, cluster.scheduler_address):
            same = ls.sweep(roach, GRID, gaits=climbing, cluster=where)
            xr.testing.assert_equal(same, whole)
        kept = ls.sweep(roach, GRID, gaits=climbing, cluster=client, store=tmp_path / "runs.zarr")
        assert np.array_equal(kept["speed"].values, whole["speed"].values, equal_nan=True)
    for bad in ("nowhere", 3):
        with pytest.raises(ValueError, match="must be local, an address"):
            ls.sweep(roach, GRID, gaits=climbing, cluster=bad)


@pytest.mark.parametrize(
    ("over", "asked", "words"),
    [
        ({}, {}, "must map parameters to values"),
        ({"slope_deg": []}, {}, "must be finite numbers"),
        ({"slope_deg": [1.0, float("nan")]}, {}, "must be finite numbers"),
        ({"slope_deg": [2.0, 1.0]}, {}, "must be rising numbers"),
        ({"slope_deg": (0.0, 1.0)}, {"sampling": "sobol"}, "samples is missing"),
        ({"slope_deg": (0.0, 1.0)}, {"samples": 3}, "must be left out for a grid"),
        ({"slope_deg": [0.0, 1.0, 2.0]}, {"sampling": "latin", "samples": 3}, "must be a range"),
        ({"slope_deg": [0.0, 1.0], "mass": [1.0]}, {"sampling": "list"}, "as many values of each parameter"),
        ({"slope_deg": [0.0, 1.0]}, {"sampling": "good"}, "sampling = 'good'"),
        ({"slope_deg": [40.0, 50.0]}, {"measures": ["luck"]}, "measures = 'luck': must be one of"),
        ({"slope_deg": [40.0, 50.0]}, {"heading": 0.1}, "heading: must be left out"),
        ({"nonsense": [40.0, 50.0]}, {}, "nonsense"),
        ({"FL.stiffness": [1.4, 1.6]}, {}, "must be of both legs of a pair"),
        ({"F.phase": [0.0, 0.1]}, {}, "must be no parameter that was free"),
        ({"F.stiffness": [-1.0, 1.0]}, {}, "must be within 0 and inf"),
        ({"slope_deg": [40.0, 50.0]}, {"workers": 0}, "workers = 0"),
        ({"slope_deg": ["45"]}, {}, "must be finite numbers"),
        ({"slope_deg": [True]}, {}, "must be finite numbers"),
        ({"slope_deg": [45.0]}, {"gaits": 5}, "gaits = 5: must be a gait, or several"),
        ({"slope_deg": [40.0, 50.0]}, {"cluster": "nowhere"}, "cluster = 'nowhere'"),
    ],
)
def test_what_is_refused(roach: Animal, climbing: list[Gait], over: Any, asked: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError) as refused:
        ls.sweep(roach, over, **{"gaits": climbing} | asked)
    assert words in str(refused.value) and "\n" not in str(refused.value)


def test_gaits_of_another_animal(roach: Animal, climbing: list[Gait]) -> None:
    with pytest.raises(ValueError, match="must be the one whose gaits are followed"):
        ls.sweep(roach.replace(mass=3e-3), {"slope_deg": [45.0]}, gaits=climbing)
