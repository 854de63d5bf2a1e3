"""Maps of gaits with the best actuation."""

import json
import math
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import legspring as ls
from legspring import exchange
from legspring.asking import tuned
from legspring.files import save_netcdf
from legspring.measures.registry import BY_NAME
from legspring.optima import optimal_atlas, select
from legspring.optimum import TIE
from legspring.solve import refined
from legspring.stores import finished
from tests.made_up import DIMENSIONS, FAMILIES, made_up_optima

CELL = ("objective", "slope_deg", "heading", "family")
GRID: dict[str, Any] = {"slopes_deg": (60, 65), "headings": (0.15, 0.2), "impulses": (-0.5, 0.5), "workers": 1}
ONE: dict[str, Any] = {"slopes_deg": (60,), "headings": (0.15,), "workers": 1}


@pytest.fixture(scope="module")
def default(roach: ls.Animal) -> xr.Dataset:
    return optimal_atlas(roach, **GRID)


@pytest.fixture(scope="module")
def thesis(roach: ls.Animal) -> xr.Dataset:
    return optimal_atlas(roach, **GRID, map="reduced", method="nelder-mead")


@pytest.fixture(scope="module")
def one(roach: ls.Animal) -> xr.Dataset:
    return optimal_atlas(roach, **ONE)


@pytest.fixture(params=["default", "thesis"])
def small(request: pytest.FixtureRequest) -> xr.Dataset:
    return request.getfixturevalue(request.param)


def test_schema(small: xr.Dataset) -> None:
    sizes = {"objective": 2, "slope_deg": 2, "heading": 2, "family": 4, "leg": 3, "single_leg": 6, "axis": 2}
    assert dict(small.sizes) == sizes | {"impulse": 2}
    assert small.objective.values.tolist() == ["stability", "efficiency"]
    assert small.family.values.tolist() == FAMILIES
    assert small.slope_deg.values.tolist() == [60, 65] and small.heading.values.tolist() == [0.15, 0.2]
    for name, variable in small.data_vars.items():
        assert variable.attrs["long_name"]
        assert name in ("ending", "active") or variable.attrs["units"]
    assert ls.Animal(**json.loads(small.attrs["parameters"])) == ls.cockroach()
    assert small.attrs["source"] == f"legspring {ls.__version__}"
    assert small.attrs["seed"] == 0


def test_form_is_that_of_made_up_optima(small: xr.Dataset) -> None:
    promised = made_up_optima((60, 65), (0.15, 0.2))
    assert set(promised.data_vars) <= set(small.data_vars)
    assert set(promised.coords) == set(small.coords)
    for name, more in DIMENSIONS.items():
        assert small[name].dims == promised[name].dims == (*CELL, *more)
        if name in BY_NAME:
            assert small[name].attrs == promised[name].attrs
    assert small.active.dims == promised.active.dims


def test_optima_recover_as_their_gaits_do(small: xr.Dataset) -> None:
    known = small.sel(objective="stability", slope_deg=60, heading=0.15, family="B")
    roach = ls.cockroach().replace(actuation=known["actuation"].values.tolist())
    gaits = ls.find_gaits(roach, slope_deg=60, heading=0.15, family="B")
    (gait,) = (gait for gait in gaits if np.allclose(gait.phase, known["phase"], atol=1e-5))
    steps = [gait.recover(impulse).steps for impulse in (-0.5, 0.5)]
    assert None not in steps and known["recovery_steps"].values.tolist() == steps
    assert known["recovered"].values.tolist() == [1.0, 1.0]


def test_methods_are_told(default: xr.Dataset, thesis: xr.Dataset) -> None:
    assert (default.attrs["method"], default.attrs["map"]) == ("default", "complete")
    assert (thesis.attrs["method"], thesis.attrs["map"]) == ("nelder-mead", "reduced")


def test_all_is_there_or_all_is_missing(small: xr.Dataset) -> None:
    there = np.isfinite(small.penalised)
    assert 8 <= int(there.sum()) <= 24
    assert bool(there.sel(family="B").all())
    for name, values in small.data_vars.items():
        known = values != "" if name == "ending" else np.isfinite(values) if name != "active" else there
        assert bool((known == there).all()), name
    assert bool((small.active.where(~there, "") == "").all())


def test_values_are_those_of_gaits(small: xr.Dataset, roach: ls.Animal) -> None:
    of = "max_multiplier" if small.attrs["map"] == "complete" else "reduced_eigenvalue"
    for place in np.argwhere(np.isfinite(small.penalised.values)):
        one = small.isel(dict(zip(CELL, place.tolist(), strict=True)))
        slope, family = math.radians(one.slope_deg.item()), one.family.item()
        problem = tuned(roach, slope, one.heading.item(), family, one.actuation.values)
        z = np.concatenate([[one.speed.item() / problem.system.desired_speed], one.phase.values])
        gait = refined(problem, z)
        assert gait is not None and gait.invalid() is None
        assert one.phase.values == pytest.approx(gait.phase, abs=1e-8)
        assert one.transport_cost.item() == pytest.approx(gait.transport_cost, abs=1e-8)
        assert one.max_multiplier.item() == pytest.approx(abs(gait.multipliers[0]), abs=1e-6)
        assert one.peak_force.values == pytest.approx(gait.peak_force, abs=1e-6)
        own = one.transport_cost if one.objective == "efficiency" else one[of]
        # At an optimum eigenvalues may meet, where they are sensitive.
        assert one.value.item() == pytest.approx(own.item(), abs=1e-5)
        assert one.penalised.item() >= one.value.item()


def test_each_goal_is_best_at_its_own(default: xr.Dataset) -> None:
    stable, cheap = (default.sel(objective=goal) for goal in ("stability", "efficiency"))
    both = np.isfinite(stable.penalised) & np.isfinite(cheap.penalised)
    assert bool(both.any())
    assert bool((stable.max_multiplier <= cheap.max_multiplier + TIE).where(both, True).all())
    assert bool((cheap.transport_cost <= stable.transport_cost + TIE).where(both, True).all())
    floor = np.sin(np.radians(default.slope_deg))
    assert bool((abs(cheap.value.sel(family="B") - floor) < TIE).all())


def test_no_worse_than_a_search_of_one_cell(default: xr.Dataset, roach: ls.Animal) -> None:
    for family in ("FB", "MB", "B"):
        alone = ls.optimize(roach, slope_deg=60, heading=0.2, family=family)
        here = default.penalised.sel(objective="stability", slope_deg=60, heading=0.2, family=family).item()
        assert alone is None or here < alone.penalised + TIE


def test_what_was_computed_is_not_computed_again(
    roach: ls.Animal, one: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    xr.testing.assert_equal(optimal_atlas(roach, **ONE, cache=tmp_path), one)
    assert bool(np.isfinite(one.penalised).any())

    def refused(*_: object) -> None:
        raise AssertionError("computed again")

    for name in ("scan", "explore", "finished"):
        monkeypatch.setattr(exchange, name, refused)
    xr.testing.assert_equal(optimal_atlas(roach, **ONE, cache=tmp_path), one)
    with pytest.raises(AssertionError, match="computed again"):
        optimal_atlas(roach, **ONE, cache=tmp_path, seed=1)
    with pytest.raises(AssertionError, match="computed again"):
        optimal_atlas(roach, **ONE)


def test_a_search_that_was_stopped_goes_on(
    roach: ls.Animal, one: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stopped(*_: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(exchange, "finished", stopped)
        with pytest.raises(KeyboardInterrupt):
            optimal_atlas(roach, **ONE, cache=tmp_path)
    # The searches are done; only the last part is left to do.
    monkeypatch.setattr(exchange, "scan", stopped)
    start = time.perf_counter()
    resumed = optimal_atlas(roach, **ONE, cache=tmp_path)
    xr.testing.assert_equal(resumed, one)
    # It does not pass off the time of the last part as that of all.
    took = time.perf_counter() - start
    assert resumed.attrs["seconds"] > took
    # What it keeps is text, and a damaged piece of it is computed anew.
    files = list(tmp_path.iterdir())
    assert {path.suffix for path in files} == {".json"}
    for path in files:
        path.write_text(path.read_text(encoding="utf-8")[:-3], encoding="utf-8")
    monkeypatch.undo()
    xr.testing.assert_equal(optimal_atlas(roach, **ONE, cache=tmp_path), one)


def test_a_store_holds_the_result(
    roach: ls.Animal, one: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = tmp_path / "optima.zarr"

    def stopped(*_: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(exchange, "finished", stopped)
        with pytest.raises(KeyboardInterrupt):
            optimal_atlas(roach, **ONE, store=store)
    assert finished(store) == (0, 1) and len(list((tmp_path / ".optima.zarr.search").iterdir())) > 0
    with monkeypatch.context() as patch:
        patch.setattr(exchange, "scan", stopped)
        xr.testing.assert_equal(optimal_atlas(roach, **ONE, store=store), one)
    assert finished(store) == (1, 1) and not (tmp_path / ".optima.zarr.search").exists()
    with monkeypatch.context() as patch:
        patch.setattr(exchange, "search", stopped)
        again = optimal_atlas(roach, **ONE, store=store)
    xr.testing.assert_equal(again, one)
    for name, variable in one.variables.items():
        assert again[name].dims == variable.dims and again[name].attrs == variable.attrs, name
    assert select(again).family.values.tolist() == select(one).family.values.tolist()
    with pytest.raises(ValueError, match="is of another sweep, of which search is different"):
        optimal_atlas(roach, **ONE, store=store, seed=1)


@pytest.mark.long
def test_a_cluster_does_not_change_the_result(roach: ls.Animal, one: xr.Dataset) -> None:
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        xr.testing.assert_equal(optimal_atlas(roach, **ONE, cluster=client), one)


def test_other_optima_are_starts(roach: ls.Animal, default: xr.Dataset, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where no search of its own finds anything, what is known is still there."""
    monkeypatch.setattr(exchange, "scan", lambda *_: [])
    nothing = optimal_atlas(roach, **ONE)
    assert not np.isfinite(nothing.penalised).any()
    known = optimal_atlas(roach, **ONE, starts=default).penalised
    expected = default.penalised.sel(slope_deg=[60], heading=[0.15])
    assert bool((np.isfinite(known) == np.isfinite(expected)).all())
    assert bool((known <= expected + TIE).where(np.isfinite(expected), True).all())


def test_file_holds_the_dataset(small: xr.Dataset, tmp_path: Path) -> None:
    save_netcdf(small, tmp_path / "optima.nc")
    with xr.open_dataset(tmp_path / "optima.nc") as loaded:
        assert loaded.attrs == small.attrs
        for name in small.data_vars:
            assert loaded[name].dims == small[name].dims
            np.testing.assert_array_equal(loaded[name].values, small[name].values)
        chosen, expected = select(loaded.load()), select(small)
        assert chosen.family.values.tolist() == expected.family.values.tolist()


@pytest.mark.long
def test_processes_do_not_change_the_result(roach: ls.Animal, one: xr.Dataset) -> None:
    xr.testing.assert_equal(optimal_atlas(roach, **ONE | {"workers": 2}), one)


def chosen_from(**rows: tuple[float, float, float]) -> xr.Dataset:
    """Select from families with (penalised, transport cost, actuation in units of nominal lengths), one cell."""
    made = made_up_optima((0, 5), (0.1, 0.2)).isel(slope_deg=[0], heading=[0]).copy(deep=True)
    for name in made.data_vars:
        made[name].values[...] = "" if name == "active" else np.nan
    for family, (penalised, cost, size) in rows.items():
        here = FAMILIES.index(family)
        made.penalised.values[:, :, :, here] = penalised
        made.transport_cost.values[:, :, :, here] = cost
        made.actuation.values[:, :, :, here] = np.multiply(size, [0.032, 0.026, 0.019])
    return select(made)


@pytest.mark.parametrize(
    ("rows", "winner"),
    [
        ({"A": (0.3, 0.5, 0.5), "B": (0.2, 0.9, 0.5)}, "B"),
        ({"A": (0.2009, 0.5, 0.5), "B": (0.2, 0.9, 0.5)}, "A"),
        ({"A": (0.2011, 0.5, 0.5), "B": (0.2, 0.9, 0.5)}, "B"),
        ({"MB": (0.2, 0.5, 0.6), "B": (0.2, 0.5009, 0.4)}, "B"),
        ({"MB": (0.2, 0.5, 0.6), "B": (0.2, 0.5011, 0.4)}, "MB"),
        ({"A": (0.2, 0.5, 0.6), "FB": (0.2005, 0.9, 0.2), "MB": (0.3, 0.1, 0.1)}, "A"),
        ({"FB": (0.2, 0.5, 0.5)}, "FB"),
        ({}, ""),
    ],
)
def test_selection(rows: dict[str, tuple[float, float, float]], winner: str) -> None:
    chosen = chosen_from(**rows)
    assert set(chosen.family.values.ravel()) == {winner}
    if winner:
        assert chosen.penalised.values.ravel() == pytest.approx([rows[winner][0]] * 2)
        assert chosen.transport_cost.values.ravel() == pytest.approx([rows[winner][1]] * 2)
    else:
        assert np.all(np.isnan(chosen.penalised.values))


def test_selection_goes_cell_by_cell() -> None:
    made = made_up_optima((0, 5, 10), (0.1, 0.2))
    chosen = select(made)
    assert "family" not in chosen.dims
    assert chosen.family.dims == ("objective", "slope_deg", "heading")
    assert chosen.family.attrs["long_name"]
    assert np.all(chosen.family.values[:, -1, -1] == "")
    for place in np.ndindex(chosen.family.shape):
        family = chosen.family.values[place]
        here = made.penalised.values[place]
        assert (family == "") == bool(np.all(np.isnan(here)))
        if family:
            assert here[FAMILIES.index(family)] <= np.nanmin(here) + TIE
            np.testing.assert_array_equal(chosen.phase.values[place], made.phase.sel(family=family).values[place])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"slopes_deg": (5, 0)}, "slopes_deg"),
        ({"headings": ()}, "headings"),
        ({"map": "some"}, "map = 'some'"),
        ({"method": "simplex"}, "method = 'simplex'"),
        ({"constraints": "none"}, "constraints = 'none'"),
        ({"workers": 0}, "workers = 0"),
    ],
)
def test_wrong_arguments(roach: ls.Animal, change: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        optimal_atlas(roach, **(ONE | change))


def test_bodies_that_yaw_are_refused(roach: ls.Animal) -> None:
    with pytest.raises(ValueError, match="yaw held"):
        optimal_atlas(roach.replace(yaw="free", inertia=2.04e-7), **ONE)
