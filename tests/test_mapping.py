"""Maps over slope and heading as datasets."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import legspring as ls
from legspring import Animal, blocks, sweeping
from legspring.files import save_csv, save_netcdf
from legspring.mapping import HEADINGS, SLOPES_DEG, find_all
from legspring.measures.registry import MEASURES, OF_RECOVERIES, mapped, yaws
from legspring.stores import finished
from tests.conftest import Cells


@pytest.fixture(scope="module")
def small(roach: ls.Animal) -> xr.Dataset:
    return ls.atlas(roach, slopes_deg=[35, 40, 45], headings=[0.4, 0.45], impulses=[-0.5, 0.5])


def test_schema(small: xr.Dataset) -> None:
    measures = (*mapped(ls.cockroach()), *OF_RECOVERIES)
    assert list(small.data_vars) == [*(measure.name for measure in measures), "outcome"]
    cell = {"slope_deg": 3, "heading": 2, "branch": 2}
    assert dict(small.sizes) == cell | {"leg": 3, "single_leg": 6, "axis": 2, "impulse": 2}
    for measure in measures:
        assert small[measure.name].attrs == measure.attributes
        assert small[measure.name].dims == (*cell, *measure.dimensions)
    assert list(small.leg.values) == ["F", "M", "B"]
    for variable in small.data_vars.values():
        assert variable.attrs["long_name"]
    assert small.speed.attrs["units"] == "m/s"
    assert "Peterson" in small.attrs["references"]
    assert small.attrs["source"] == f"legspring {ls.__version__}"
    assert ls.Animal(**json.loads(small.attrs["parameters"])) == ls.cockroach()


def test_values_are_those_of_the_gaits(small: xr.Dataset, thesis_map: Cells) -> None:
    for gait in thesis_map[35, 0.4]:
        cell = small.sel(slope_deg=35, heading=0.4, branch=gait.branch)
        assert cell.family.item() == gait.family
        assert cell.speed.item() == pytest.approx(gait.speed, abs=1e-10)
        assert cell.phase.values == pytest.approx(gait.phase, abs=1e-9)
        assert cell.max_multiplier.item() == pytest.approx(abs(gait.multipliers[0]), abs=1e-8)
        assert cell.peak_force.sel(leg="M", axis="fore_aft").item() == pytest.approx(gait.peak_force[1, 1], abs=1e-9)
        assert cell.recovery_steps.sel(impulse=0.5).item() == gait.recover(0.5).steps
        assert cell.recovered.sel(impulse=0.5).item() == 1.0


def test_a_body_that_yaws_has_more_to_say(rigid: ls.Animal) -> None:
    maps = ls.atlas(rigid, slopes_deg=[25, 30], headings=[0.15, 0.2], impulses=())
    more = [measure for measure in MEASURES if measure.mapped is yaws]
    assert {measure.name for measure in more} == {"yaw", "yaw_rate", "yaw_amplitude", "peak_moment"}
    assert set(maps.data_vars) >= {measure.name for measure in more}
    (gait, *_) = ls.find_gaits(rigid, slope_deg=30, heading=0.15)
    cell = maps.sel(slope_deg=30, heading=0.15, branch=0)
    for measure in more:
        assert cell[measure.name].item() == pytest.approx(measure.of(gait), rel=1e-6)


def test_missing_where_there_is_no_gait(small: xr.Dataset) -> None:
    empty = small.sel(heading=0.45)
    assert np.all(empty.family.values == "")
    others = empty.drop_vars(["family", "outcome"])
    assert all(np.all(np.isnan(v.values)) for v in others.data_vars.values())
    meanings = dict(
        zip(small["outcome"].attrs["flag_values"], small["outcome"].attrs["flag_meanings"].split("; "), strict=True)
    )
    assert {meanings[n] for n in np.unique(empty["outcome"])} == {"no further gait", "the search has found nothing"}


def test_file_holds_the_dataset(small: xr.Dataset, tmp_path: Path) -> None:
    save_netcdf(small, tmp_path / "atlas.nc")
    with xr.open_dataset(tmp_path / "atlas.nc") as loaded:
        xr.testing.assert_equal(loaded.load().drop_vars("family"), small.drop_vars("family"))
        assert loaded.family.values.tolist() == small.family.values.tolist()
        assert loaded.attrs == small.attrs
    assert [path.name for path in tmp_path.iterdir()] == ["atlas.nc"]


def test_a_failed_save_leaves_nothing_behind(small: xr.Dataset, tmp_path: Path) -> None:
    good = tmp_path / "atlas.nc"
    good.write_text("what was there")
    bad = small.assign(broken=("x", np.array([object()])))
    with pytest.raises((TypeError, ValueError)):
        save_netcdf(bad, good)
    assert good.read_text() == "what was there"
    assert [path.name for path in tmp_path.iterdir()] == ["atlas.nc"]


def test_a_map_is_kept_in_blocks(roach: Animal, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    grid: dict[str, Any] = {"slopes_deg": [20, 25, 30, 35, 40], "headings": [0.2, 0.3, 0.4], "impulses": [0.5]}
    whole, store, worked = ls.atlas(roach, **grid), tmp_path / "map.zarr", blocks.block_of
    calls = list[int]()

    def stopped(*given: Any) -> Any:
        calls.append(1)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return worked(*given)

    with monkeypatch.context() as patch:
        patch.setattr(sweeping, "block_of", stopped)
        with pytest.raises(KeyboardInterrupt):
            ls.atlas(roach, **grid, store=store, workers=1)
        done, count = finished(store)
        assert 2 == done < count
        calls[:] = [1] * 10
        again = ls.atlas(roach, **grid, store=store, workers=1)
        assert len(calls) == 10 + count - done
    xr.testing.assert_identical(again.drop_attrs(), whole.drop_attrs())
    # Families are searched for in each block, and all of a place are there wherever blocks end.
    for slope_deg, heading in ((25, 0.3), (30, 0.2), (40, 0.4)):
        here = whole.sel(slope_deg=slope_deg, heading=heading)
        assert int((here["family"] != "").sum()) == len(ls.find_gaits(roach, slope_deg=slope_deg, heading=heading))


def test_places_of_which_nothing_can_be_asked(roach: Animal) -> None:
    """A leg is longer than what its actuation takes off it; the grid goes on around places where it is not."""
    over = {"F.length": [0.01, 0.032], "F.actuation": [0.005, 0.016]}
    maps = ls.atlas(roach, over=over, slope_deg=45, heading=0.15, impulses=())
    meanings = dict(
        zip(maps["outcome"].attrs["flag_values"], maps["outcome"].attrs["flag_meanings"].split("; "), strict=True)
    )
    words = [meanings[n] for n in maps["outcome"].isel(branch=0).values.ravel().tolist()]
    assert words[1] == "there is no such animal, or nothing of the kind can be asked of it"
    assert words[3] == "a gait" and words.count(words[1]) == 1


def test_an_axis_may_be_a_measure(tmp_path: Path) -> None:
    walker = ls.load_animal("walker")
    maps = ls.atlas(walker, over={"energy": [810, 816]}, starts=16, store=tmp_path / "walks.zarr")
    assert "energy" in maps.coords and maps["apex_height"].attrs["missing"] == "no flight begins in a step"
    for energy in (810, 816):
        gaits = ls.find_gaits(walker, energy=energy)
        here = maps["mean_speed"].sel(energy=energy).values
        assert here[: len(gaits)] == pytest.approx([gait.mean_speed for gait in gaits], rel=1e-9)
    assert "the animal keeps its energy" in maps["recovered"].attrs["missing"]


def test_maps_by_following_do_not_grow(roach: Animal, tmp_path: Path) -> None:
    """Sheets are numbered all over."""
    asked: dict[str, Any] = {"heading": 0.15, "method": "follow", "impulses": (), "store": tmp_path / "map.zarr"}
    ls.atlas(roach, over={"slope_deg": [40, 45]}, **asked)
    with pytest.raises(ValueError, match="is of another sweep, of which values is different"):
        ls.atlas(roach, over={"slope_deg": [40, 45, 50]}, **asked)


def test_a_map_as_a_table(small: xr.Dataset, tmp_path: Path) -> None:
    save_csv(small, tmp_path / "map.csv")
    lines = (tmp_path / "map.csv").read_text().splitlines()
    assert len(lines) == 1 + small["outcome"].size
    assert lines[0].startswith("slope_deg (degrees),heading (rad),branch,family,")
    assert sum(",a gait" in line for line in lines) == int((small["family"] != "").sum())
    assert sum("no further gait" in line for line in lines) > 0


def test_threads_do_not_change_the_result(roach: ls.Animal) -> None:
    one, two = (
        ls.atlas(roach, slopes_deg=[0, 5], headings=[0.2, 0.25], impulses=(), workers=workers) for workers in (1, 2)
    )
    xr.testing.assert_identical(one.drop_attrs(), two.drop_attrs())


@pytest.mark.parametrize(
    "arguments",
    [
        {"slopes_deg": [5, 0]},
        {"slopes_deg": [0, 200]},
        {"headings": []},
        {"headings": [0.1, math.nan]},
        {"impulses": [0.1, 0.1]},
        {"impulses": [11]},
    ],
)
def test_grids_must_rise_and_be_in_range(roach: ls.Animal, arguments: dict[str, list[float]]) -> None:
    with pytest.raises(ValueError, match=next(iter(arguments))):
        ls.atlas(roach, **arguments)  # type: ignore[arg-type]


def test_what_is_let_go_is_in_the_map() -> None:
    leg = ls.load_animal("effective_leg")
    maps = ls.atlas(leg, slopes_deg=(0, 45), headings=(0.15,), free=("T.angle",), impulses=())
    angle = maps["T.angle"]
    assert angle.dims == maps["speed"].dims and angle.attrs["units"] == "rad"
    gaits = ls.find_gaits(leg, slope_deg=45, heading=0.15, free=("T.angle",))
    assert [gait.freed for gait in gaits] == [{"T.angle": gait.animal.legs[0].angle} for gait in gaits]
    here = angle.sel(slope_deg=45, heading=0.15).dropna("branch").values
    np.testing.assert_allclose(here, [gait.freed["T.angle"] for gait in gaits], atol=1e-8)


# By following ---------------------------------------------------------------------------------------------------


def test_both_methods_find_the_same(roach: Animal) -> None:
    grid: dict[str, Any] = {"slopes_deg": range(0, 91, 15), "headings": (0.1, 0.2, 0.3), "impulses": ()}
    search, follow = (ls.atlas(roach, method=method, **grid) for method in ("search", "follow"))
    # Low slopes are a corner that so few lines do not lead to.
    assert follow.attrs["search"].endswith(", 10 gaits by search alone")
    assert follow["speed"].values == pytest.approx(search["speed"].values, rel=1e-9, nan_ok=True)
    assert bool((follow["sheet"] >= 0).where(follow["speed"].notnull(), True).all())


@pytest.mark.long
def test_one_gait_leads_to_all_of_the_thesis(roach: Animal, thesis_map: Cells) -> None:
    """A few gaits of one cell, followed along all lines of the grid, past folds and from family to family."""
    maps = ls.atlas(roach, method="follow", impulses=(), workers=2)
    known = maps["speed"].notnull()
    assert int(known.sum()) == sum(map(len, thesis_map.values())) == 286
    assert maps.attrs["search"].endswith(", 0 gaits by search alone")
    for (slope, heading), gaits in thesis_map.items():
        cell = maps.sel(slope_deg=slope, heading=heading)
        assert cell["speed"].values[: len(gaits)] == pytest.approx([gait.speed for gait in gaits], rel=1e-9)
    sheets = maps["sheet"]
    assert bool((sheets.where(known, 0) >= 0).all()) and bool((sheets.where(~known, -1) == -1).all())
    # The two branches of B are two sheets, which meet in folds; each is one all over the slopes.
    steep = maps.sel(slope_deg=slice(50, 90), heading=0.2)["sheet"].values
    first, second = ({int(sheet) for sheet in steep[:, branch] if sheet >= 0} for branch in (0, 1))
    assert len(first) == 1 == len(second) and first != second


@pytest.mark.parametrize("method", ["search", "follow"])
def test_maps_over_anything_by_either_method(roach: Animal, method: str) -> None:
    over = {"F.stiffness": [1.2, 1.5, 1.8], "slope_deg": [40.0, 50.0]}
    maps = ls.atlas(roach, over=over, heading=0.2, method=method, impulses=(), workers=1)
    assert int(maps["speed"].notnull().sum()) == 11


def test_a_method_is_one_of_two(roach: Animal) -> None:
    with pytest.raises(ValueError, match="method = 'magic': must be one of search, follow"):
        ls.atlas(roach, method="magic")


@pytest.mark.long
def test_gaits_of_the_yawing_cockroach(rigid: Animal) -> None:
    found, _ = find_all(rigid, SLOPES_DEG, HEADINGS)
    assert sum(map(len, found.values())) == 316
