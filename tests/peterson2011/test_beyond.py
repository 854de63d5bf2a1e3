"""The chapter beyond the thesis: its numbers are those of the data."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import legspring as ls
from legspring.peterson2011.beyond import sections
from legspring.peterson2011.decay import decays
from legspring.peterson2011.figures.beyond import BEYOND
from legspring.peterson2011.report import Section
from legspring.peterson2011.tables import Table

NAMES = ("second", "surfaces", "survival", "stability", "back", "trade", "families", "one leg", "yaw")
FAMILIES = Section("Every family", ["Words."], tables=[Table("", "", ("one",), ((1.0,),))])
SURFACES = replace(FAMILIES, heading="Where families end")
SURVIVAL = replace(FAMILIES, heading="Stable or robust?")
ONE_LEG = replace(FAMILIES, heading="One leg")
YAW = Section("A body that yaws", ["Words."], tables=[Table("", "", ("one",), ((1.0,),))])


@pytest.fixture(scope="module")
def simulated(roach: ls.Animal) -> xr.Dataset:
    return decays(roach, [(75.0, 0.15), (60.0, 0.40), (30.0, 0.15)])


@pytest.fixture(scope="module")
def atlas(roach: ls.Animal) -> xr.Dataset:
    return ls.atlas(roach, impulses=())


@pytest.fixture(scope="module")
def back_pulls(roach: ls.Animal) -> xr.Dataset:
    families = {"F": ("F",), "none": ()}
    return ls.atlas(roach.replace(families=families), slopes_deg=(0, 45, 75), headings=(0.15, 0.2), impulses=())


def fronts() -> xr.Dataset:
    """Return a conflict at 0 deg, between and within families, and none at 20."""
    dims = ("slope_deg", "family", "point")
    empty = [math.nan] * 3
    eigenvalues = [[[0.30, 0.34, 0.60], [0.45, 0.5, math.nan]], [empty, [0.20, math.nan, math.nan]]]
    costs = [[[1.20, 0.80, 0.65], [0.70, 0.60, math.nan]], [empty, [0.342, math.nan, math.nan]]]
    return xr.Dataset(
        {"reduced_eigenvalue": (dims, eigenvalues), "transport_cost": (dims, costs)},
        coords={"slope_deg": [0.0, 20.0], "family": ["A", "B"]},
        attrs={"heading": 0.15},
    )


@pytest.fixture(scope="module")
def chapter(atlas: xr.Dataset, simulated: xr.Dataset, back_pulls: xr.Dataset) -> dict[str, Section]:
    pictures = {name: Path(f"{name}.png") for name in (*BEYOND, "4.2")}
    written = sections(atlas, simulated, back_pulls, fronts(), SURFACES, SURVIVAL, FAMILIES, ONE_LEG, YAW, pictures)
    return dict(zip(NAMES, written, strict=True))


def words(section: Section) -> str:
    return " ".join(section.paragraphs)


def test_the_chapter_has_all_figures(chapter: dict[str, Section]) -> None:
    shown = [picture for section in chapter.values() for picture in section.figures]
    assert [picture.path.stem for picture in shown] == list(BEYOND)
    assert [picture.caption for picture in shown] == [figure.caption for figure in BEYOND.values()]
    for section in chapter.values():
        assert section.tables and all(len(row) == len(table.header) for table in section.tables for row in table.rows)
        assert "nan" not in words(section) and "  " not in words(section)


def test_second_branch_in_words(chapter: dict[str, Section]) -> None:
    text = words(chapter["second"])
    assert "100 of the 186 cells" in text
    assert "85 of them it is of the same family" in text
    stable, true, cost = chapter["second"].paragraphs[1:]
    assert "more stable in 96 cells" in stable and "less stable in 4 cells" in stable
    assert "more stable in 91 cells" in true
    assert "cheaper in 34 cells" in cost and cost.endswith("dearer in none.")
    (table,) = chapter["second"].tables
    row = dict(zip(table.columns, next(row for row in table.cells if row[:2] == (0.0, 0.4)), strict=True))
    assert (row["family_published"], row["family_second"]) == ("FB", "FB")
    assert row["eigenvalue_published"] == pytest.approx(0.572, abs=1e-3)
    assert row["eigenvalue_second"] == pytest.approx(0.336, abs=1e-3)
    assert row["cost_published"] == pytest.approx(1.067, abs=1e-3)
    assert row["cost_second"] == pytest.approx(0.685, abs=1e-3)


def test_true_stability_in_words(chapter: dict[str, Section], atlas: xr.Dataset, simulated: xr.Dataset) -> None:
    text, first = words(chapter["stability"]), atlas.sel(branch=0)
    difference = (first["max_multiplier"] - first["reduced_eigenvalue"]).values
    assert "160 of the 186 published gaits (86%)" in text
    assert "all 286" in text
    assert f"{np.count_nonzero(difference > 1e-6)} gaits are less stable" in text
    assert f"thesis {float(first['reduced_eigenvalue'].values[np.nanargmax(difference) // 10, 0]):.3f}" in text
    assert f"186 of 186 gaits are stable; the least stable one, with {float(first['max_multiplier'].max()):.3f}" in text
    worst = float(abs(simulated["reduced_eigenvalue"] / simulated["decay"] - 1.0).max())
    assert f"eigenvalue by up to {worst:.1%}" in text
    assert "closer in 3 of 3 gaits" in text


def test_back_legs_that_pull_in_words(chapter: dict[str, Section], atlas: xr.Dataset, back_pulls: xr.Dataset) -> None:
    gaits = back_pulls["speed"].notnull()
    text = words(chapter["back"])
    assert f"found {int(gaits.sum())} in {int(gaits.any('branch').sum())} cells of 6" in text
    change = (back_pulls["max_multiplier"] - atlas["max_multiplier"].sel(branch=0)).values
    assert f"{np.count_nonzero(change < 0)} are more stable and {np.count_nonzero(change > 0)} less stable" in text
    (table,) = chapter["back"].tables
    assert [row[0] for row in table.cells] == ["front", "none"]
    assert sum(float(row[1]) for row in table.cells if not isinstance(row[1], str | tuple)) == int(gaits.sum())


def test_what_stability_costs_in_words(chapter: dict[str, Section]) -> None:
    text = words(chapter["trade"])
    assert "at 0 deg from A with eigenvalue 0.300 and cost 1.200 to B with 0.500 and 0.600." in text
    assert "no conflict at 20 deg" in text
    (table,) = chapter["trade"].tables
    # A's cheapest gait is worse than B's in both.
    at_0 = [(0.0, 0.30, 1.20, "A"), (0.0, 0.34, 0.80, "A"), (0.0, 0.45, 0.70, "B"), (0.0, 0.50, 0.60, "B")]
    assert list(table.cells) == [*at_0, (20.0, 0.20, 0.342, "B")]


def test_nothing_found_is_said_to_be_so(atlas: xr.Dataset, simulated: xr.Dataset, back_pulls: xr.Dataset) -> None:
    nothing: Any = back_pulls.where(False, drop=False).assign(family=xr.full_like(back_pulls["family"], ""))
    numbers = fronts()
    found = sections(
        atlas.isel(branch=[0]),
        simulated.isel(gait=[]),
        nothing,
        numbers.where(False),
        SURFACES,
        SURVIVAL,
        FAMILIES,
        ONE_LEG,
        YAW,
        {},
    )
    texts = dict(zip(NAMES, map(words, found), strict=True))
    assert "None of the 186 cells with a gait has a second one." in texts["second"]
    assert "found no gait" in texts["back"]
    assert "no gaits with optimised actuation" in texts["trade"]
    assert not any(section.figures for section in found)
