"""What the report says about a body that yaws: its numbers are those of the data."""

import json

import numpy as np
import pytest
import xarray as xr

import legspring as ls
from legspring.peterson2011 import yawing as what
from legspring.peterson2011.published import published_forces
from legspring.peterson2011.report import Section
from legspring.peterson2011.walks import straight, walk, with_hips

GRID = {"slopes_deg": (0, 15, 30, 45), "headings": (0.05, 0.15, 0.25), "impulses": ()}


@pytest.fixture(scope="module")
def point_mass(roach: ls.Animal) -> xr.Dataset:
    return ls.atlas(roach, **GRID)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def yawing(rigid: ls.Animal) -> xr.Dataset:
    return ls.atlas(rigid, starts=12, **GRID)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def held(rigid: ls.Animal) -> xr.Dataset:
    return ls.atlas(rigid.replace(yaw="held"), starts=12, **GRID)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def fates(point_mass: xr.Dataset) -> xr.Dataset:
    return what.fates(point_mass)


@pytest.fixture(scope="module")
def hips() -> xr.Dataset:
    return what.hips_moved_back()


@pytest.fixture(scope="module")
def section(
    point_mass: xr.Dataset, yawing: xr.Dataset, held: xr.Dataset, fates: xr.Dataset, hips: xr.Dataset
) -> Section:
    return what.section(point_mass, yawing, held, fates, hips)


def test_fates_are_those_of_walks(
    point_mass: xr.Dataset, fates: xr.Dataset, roach: ls.Animal, rigid: ls.Animal
) -> None:
    assert fates["heading"].values == pytest.approx([0.15])
    there = fates["reached"].notnull()
    np.testing.assert_array_equal(there, point_mass.sel(heading=[0.15])["speed"].notnull())
    np.testing.assert_array_equal((fates["reached"] == 1.0).values, there.values & (fates["loss"].values == ""))
    for slope in (15.0, 45.0):
        (gait, *_) = ls.find_gaits(roach, slope_deg=slope, heading=0.15)
        end = walk(gait, straight(roach, rigid))
        one = fates.sel(slope_deg=slope, heading=0.15, branch=0)
        assert float(one["reached"]) == pytest.approx(end.places[-1], abs=1e-6)
        assert one["loss"].item() == str(end.loss or "")


def test_gaits_come_back_from_an_atlas(point_mass: xr.Dataset, roach: ls.Animal) -> None:
    place, gait = next(what.gaits_of(point_mass.sel(slope_deg=[30], heading=[0.15])))
    (first, *_) = ls.find_gaits(roach, slope_deg=30, heading=0.15)
    assert place == {"slope_deg": 30.0, "heading": 0.15, "branch": 0}
    assert gait.phase == pytest.approx(first.phase, abs=1e-9)
    assert gait.reduced_eigenvalue == pytest.approx(first.reduced_eigenvalue, abs=1e-8)


def test_hips_centred_on_the_centre_of_mass_make_stable_gaits(hips: xr.Dataset, rigid: ls.Animal) -> None:
    assert float(hips["stable"].sel(back=0.0)) == 0.0
    assert float(hips["stable"].sel(back=7.0)) == float(hips["stable"].max()) >= 5.0
    assert np.mean([leg.hip[1] for leg in rigid.legs]) == pytest.approx(0.007)
    # A gait that counts as stable does come back from a small push.
    centred = with_hips(rigid, [(leg.hip[0], leg.hip[1] - 0.007) for leg in rigid.legs[:3]])
    gaits = [gait for here in (30, 60) for gait in ls.find_gaits(centred, slope_deg=here, heading=0.15)]
    stable = [gait for gait in gaits if abs(gait.multipliers[0]) < 0.9]
    assert stable and all(gait.recover(0.02).recovered for gait in stable)
    others = [gait for gait in gaits if abs(gait.multipliers[0]) > 1.1]
    assert others and not any(gait.recover(0.02).recovered for gait in others)


def test_outside_is_the_distance_to_what_was_measured(yawing: xr.Dataset) -> None:
    measured = published_forces()["experiment"]
    for leg, axis in (("F", "lateral"), ("B", "fore_aft")):
        misses = []
        for slope in yawing["slope_deg"].values:
            low, high = (
                float(measured.sel(leg=leg, axis=axis, slope_deg=slope, extreme=end)) for end in ("min", "max")
            )
            forces = yawing["peak_force"].sel(leg=leg, axis=axis, slope_deg=slope).values.ravel()
            misses += [max(low - force, force - high, 0.0) for force in forces[np.isfinite(forces)]]
        assert float(what.outside(yawing).sel(leg=leg, axis=axis)) == pytest.approx(np.mean(misses))
    assert np.isnan(what.outside(yawing).sel(leg="M", axis="lateral"))


def test_the_section_says_what_the_data_say(
    section: Section, point_mass: xr.Dataset, held: xr.Dataset, yawing: xr.Dataset, fates: xr.Dataset
) -> None:
    text = " ".join(section.paragraphs)
    gaits, cells = int((yawing["family"] != "").sum()), int((yawing["family"] != "").any("branch").sum())
    assert f"finds {gaits} gaits in {cells} of 12 cells" in text
    assert f"{int((fates['reached'] == 1.0).sum())} arrived" in text
    assert f"with hips and yaw, {int((yawing['max_multiplier'] < 1.0 - 1e-6).sum())} of {gaits}" in text
    force = yawing["peak_force"].sel(leg="B", axis="lateral")
    assert f"{float(force.min()):.2f} to {float(force.max()):.2f} (hips and yaw)" in text
    assert "It never changes its sign" in text
    published, both = (
        float(what.outside(gaits).sel(leg="B", axis="lateral")) for gaits in (point_mass.isel(branch=[0]), held)
    )
    assert f"where the hips are makes it {published - both:.2f} nearer" in text
    assert "nan" not in text and "  " not in text
    hips, back, misses = section.tables
    assert [row[0] for row in hips.cells] == [0.0, 4.0, 7.0, 10.0]
    assert [row[0] for row in back.cells] == list(what.SLOPES_DEG)
    assert back.header[1:] == (
        "measured",
        "point mass, published",
        "point mass, all gaits",
        "hips, yaw held",
        "hips and yaw",
    )
    assert len(misses.cells) == 4
    assert all(len(row) == len(table.header) for table in section.tables for row in table.rows)


def test_datasets_know_their_animal(fates: xr.Dataset, hips: xr.Dataset) -> None:
    assert json.loads(fates.attrs["parameters"])["name"] == "cockroach"
    assert json.loads(hips.attrs["parameters"])["name"] == "cockroach_rigid"
