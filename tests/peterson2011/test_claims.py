"""Verdicts on the thesis's claims: the known ones, and that each could have come out otherwise."""

import csv
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import legspring as ls
from legspring.mapping import HEADINGS, SLOPES_DEG
from legspring.peterson2011.claims import CLAIMS, Outcome, Results, Verdict, judge
from legspring.peterson2011.claims.criteria import ALL, NONE, OURS
from legspring.peterson2011.claims.evidence import THESIS_SEARCH, share, within
from legspring.peterson2011.force_tables import peak_range
from legspring.peterson2011.published import published_forces
from legspring.peterson2011.reproduce import save_cells

HOLDS, PARTLY, FAILS, OPEN = Outcome.HOLDS, Outcome.PARTLY, Outcome.FAILS, Outcome.OPEN
UNDECIDED = Outcome.UNDECIDED
FAMILIES = ("A", "FB", "MB", "B")
BASE = ("objective", "slope_deg", "heading", "family")
Change = Callable[[xr.Dataset], xr.Dataset]


@pytest.fixture(scope="module")
def atlas(roach: ls.Animal) -> xr.Dataset:
    """The thesis's map, with a few impulses."""
    return ls.atlas(roach, impulses=(-0.8, 0.5, 0.8))


@pytest.fixture(scope="module")
def results(roach: ls.Animal, atlas: xr.Dataset) -> Results:
    """The true map, optima that are just as the thesis claims, and no gait whose back legs pull."""
    optima = as_claimed(roach, atlas)
    best = select(optima)
    none = xr.full_like(atlas[["speed"]], np.nan)
    return Results(atlas, optima, optima, best, best, published_forces(), back_pulls=none)


def as_claimed(roach: ls.Animal, atlas: xr.Dataset) -> xr.Dataset:
    """Make optima up, on the whole grid, of which all that the thesis claims is true."""
    slope, heading = (atlas[name] for name in ("slope_deg", "heading"))
    axes = {"objective": ["stability", "efficiency"], "family": list(FAMILIES), "leg": ["F", "M", "B"]}
    objective, family, leg = (xr.DataArray(labels, dims=name, coords={name: labels}) for name, labels in axes.items())
    everywhere = xr.zeros_like(objective == "", dtype=float) + 0.0 * slope + 0.0 * heading
    stable, efficient = (everywhere + (objective == name) for name in axes["objective"])
    sine = np.sin(np.deg2rad(slope))
    front, middle = family.isin(["A", "FB"]), family.isin(["A", "MB"])
    dip = -0.12 * (abs(heading - 0.1) < 0.01)
    eigenvalue = {
        "A": either(slope < 20.0, 0.3 + 0.1 * heading + dip, 0.4 + heading) + 0.35 * efficient,
        "FB": 0.6 - 0.5 * heading,
        "MB": either(slope < 20.0, 0.9, 0.045),
        "B": either(slope < 20.0, 0.9, 0.04),
    }
    cost = {
        "A": 0.55 + 0.002 * slope + 0.4 * heading + dip * (slope < 15.0) + 0.6 * stable,
        "FB": 0.45 + 0.002 * slope + 0.3 * heading,
        "MB": sine + 0.02,
        "B": either((slope == 10.0) | ((slope == 15.0) & (heading < 0.12)), 0.9, sine),
    }
    there = {
        "A": (slope <= 35.0) & (heading < 0.2) & (slope + heading > 0.0),
        "FB": (slope <= 35.0) & (heading > 0.14),
        "MB": (slope >= 15.0) & (slope <= 30.0) & (heading < 0.14),
        "B": slope >= 10.0,
    }
    shift = 0.03 * efficient
    actuation = {
        "F": np.minimum(0.9, 0.2 + 0.014 * slope) + shift,
        "M": either(middle, 0.2, 0.2 + heading),
        "B": 0.3 + 0.004 * slope + 0.3 * heading * middle - shift,
    }
    phase = {"F": 55.0 * front, "M": either(middle, 65.0, 50.0), "B": -30.0}
    sign = {"F": 1 - 2 * front, "M": 1 - 2 * middle, "B": 1}
    length = xr.DataArray([0.032, 0.026, 0.019], dims="leg", coords={"leg": leg})
    zero = everywhere + 0.0 * (family == "")
    values = {
        "speed": zero + 0.3,
        "reduced_eigenvalue": along("family", eigenvalue, zero),
        "transport_cost": along("family", cost, zero),
        "actuation": along("leg", actuation, zero) * length,
        "phase": np.deg2rad(along("leg", phase, zero)),
        "peak_force": 0.3 * along("leg", sign, zero) * xr.ones_like(atlas["axis"] == "", dtype=float),
    }
    values["max_multiplier"] = values["reduced_eigenvalue"]
    optima = xr.Dataset(values, attrs={"parameters": atlas.attrs["parameters"]})
    optima["value"] = either(objective == "stability", optima["reduced_eigenvalue"], optima["transport_cost"])
    return optima.where(along("family", there, zero) > 0).transpose(*BASE, ...)


def either(true: xr.DataArray, yes: Any, no: Any) -> xr.DataArray:
    """Return one value where something is true and another one elsewhere."""
    return (0.0 * true + yes).where(true, no)


def along(dim: str, values: dict[str, Any], zero: xr.DataArray) -> xr.DataArray:
    """Put the values of families or of legs beside each other."""
    if dim == "family":
        return xr.concat(
            [(zero.sel(family=name) + value).assign_coords(family=name) for name, value in values.items()], dim
        )
    return xr.concat([(zero + value).assign_coords(leg=name) for name, value in values.items()], dim)


def select(optima: xr.Dataset) -> xr.Dataset:
    """Take the best family of each cell."""
    there = optima["value"].notnull().any("family")
    best = optima.isel(family=optima["value"].fillna(np.inf).argmin("family")).reset_coords("family").where(there)
    return best.assign(family=best["family"].where(there, "").astype(object))


def verdict(results: Results, number: int) -> Verdict:
    """Judge one claim."""
    return CLAIMS[number - 1].judge(results)


def changed(results: Results, change: Change) -> Results:
    """Change the atlas and all optima alike."""
    optima = change(results.optima)
    best = select(optima)
    return replace(
        results,
        atlas=change(results.atlas),
        optima=optima,
        nelder_mead=optima,
        selected=best,
        selected_nelder_mead=best,
    )


def system(**variables: Any) -> Change:
    """Return a change that sets variables, where there are gaits, to numbers or to functions of themselves."""

    def change(dataset: xr.Dataset) -> xr.Dataset:
        there = dataset["speed"].notnull()
        new = {
            name: (value(dataset[name]) if callable(value) else xr.full_like(dataset[name], value)).where(there)
            for name, value in variables.items()
            if name in dataset
        }
        return dataset.assign(new)

    return change


def turned(dim: str, *names: str) -> Change:
    """Return a change that turns variables, or everything, around along a dimension."""

    def change(dataset: xr.Dataset) -> xr.Dataset:
        chosen = dataset[[name for name in names if name in dataset]] if names else dataset
        return dataset.assign(
            dict(chosen.isel({dim: slice(None, None, -1)}).assign_coords({dim: dataset[dim]}).data_vars)
        )

    return change


def without(keep: Callable[[xr.Dataset], xr.DataArray]) -> Change:
    """Return a change that leaves only some gaits."""
    return lambda dataset: dataset.where(keep(dataset))


def swapped(dataset: xr.Dataset) -> xr.Dataset:
    """Give each objective the gaits of the other one."""
    if "objective" not in dataset.dims:
        return dataset
    return dataset.isel(objective=[1, 0]).assign_coords(objective=dataset["objective"])


def rising(values: xr.DataArray) -> xr.DataArray:
    """Make values grow with heading."""
    return values + 9.0 * values["heading"]


def renamed(dataset: xr.Dataset) -> xr.Dataset:
    """Give A and FB, and MB and B, the gaits of each other."""
    if "family" not in dataset.dims:
        return dataset
    return dataset.sel(family=["FB", "A", "B", "MB"]).assign_coords(family=dataset["family"])


def test_every_claim_once(results: Results) -> None:
    assert [judged.number for judged in judge(results)] == list(range(1, len(CLAIMS) + 1))
    assert [claim.chapter for claim in CLAIMS] == [4] * 8 + [5] * 9 + [6] * 6 + [4, 5, 6, 2, 6]


@pytest.mark.parametrize(
    ("number", "outcome", "found"),
    [
        (1, PARTLY, "186 of 190"),
        (2, FAILS, "100 of 186"),
        (3, HOLDS, "186 of 186"),
        (4, HOLDS, "156 of 186"),
        (5, PARTLY, "0.45 rad"),
        (6, HOLDS, "74"),
        (7, HOLDS, "15 deg"),
        (8, HOLDS, "128 of 129"),
        (18, PARTLY, "0.64 to 0.84"),
        (19, HOLDS, "37.5 deg"),
        (21, PARTLY, "0.304 m g"),
        (22, FAILS, "5"),
        (24, PARTLY, "0.524"),
        (26, PARTLY, "0.607"),
    ],
)
def test_true_results(results: Results, number: int, outcome: Outcome, found: str) -> None:
    judged = verdict(results, number)
    assert judged.verdict == outcome
    assert found in judged.found
    assert bool(judged.why) == (outcome != HOLDS)


@pytest.mark.parametrize("number", [9, 10, 11, 12, 13, 14, 15, 16, 17, 20])
def test_optima_as_claimed(results: Results, number: int) -> None:
    judged = verdict(results, number)
    assert judged.verdict == HOLDS, judged.why


def test_headings_of_animals_are_not_ours_to_judge(results: Results) -> None:
    judged = verdict(results, 23)
    assert [part.outcome for part in judged.parts] == [HOLDS, HOLDS, OPEN]
    assert judged.verdict == PARTLY


@pytest.mark.parametrize(
    ("number", "change", "outcome"),
    [
        (1, without(lambda data: (data["slope_deg"] == 0.0) & (data["heading"] < 0.2)), PARTLY),
        (1, without(lambda data: data["slope_deg"] < 30.0), PARTLY),
        (2, without(lambda data: data["branch"] == 0 if "branch" in data.dims else data["speed"] > 0.0), HOLDS),
        (3, turned("slope_deg", "speed"), FAILS),
        (4, system(peak_force=lambda force: -force, phase=0.5), PARTLY),
        (5, system(reduced_eigenvalue=1.5, max_multiplier=1.5), PARTLY),
        (5, turned("heading", "reduced_eigenvalue"), PARTLY),
        (6, system(recovery_steps=60.0), FAILS),
        (7, system(recovery_steps=60.0, recovered=0.0), FAILS),
        (8, system(transport_cost=lambda cost: -cost), FAILS),
        (10, turned("slope_deg", "actuation"), PARTLY),
        (10, system(actuation=0.01), FAILS),
        (11, system(phase=lambda phase: -phase), FAILS),
        (12, system(reduced_eigenvalue=1.5, max_multiplier=1.5), FAILS),
        (13, renamed, FAILS),
        (14, swapped, PARTLY),
        (14, system(actuation=0.01, phase=0.0), FAILS),
        (15, system(transport_cost=3.0), FAILS),
        (16, system(value=lambda value: -value), PARTLY),
        (16, renamed, FAILS),
        (17, swapped, PARTLY),
        (17, system(transport_cost=3.0, phase=0.0), PARTLY),
        (19, system(peak_force=lambda force: -force), FAILS),
        (20, system(peak_force=lambda force: -force), FAILS),
        # Of optimised gaits, which stay as they are, it is another matter.
        (22, system(recovery_steps=1.0), PARTLY),
        (23, system(reduced_eigenvalue=rising, transport_cost=rising), FAILS),
    ],
)
def test_other_results_have_other_verdicts(results: Results, number: int, change: Change, outcome: Outcome) -> None:
    judged = verdict(changed(results, change), number)
    assert judged.verdict == outcome, judged.found
    assert judged.why or outcome == HOLDS


def test_families_that_never_overlap(results: Results) -> None:
    alone = replace(results, optima=results.optima.where(results.optima["family"] == "B"), back_pulls=results.atlas)
    judged = verdict(alone, 9)
    assert judged.parts[-1].outcome == FAILS
    assert judged.parts[0].outcome == PARTLY


def test_measured_forces_as_claimed(results: Results) -> None:
    animal = results.measured.copy(deep=True)
    place = {"axis": "fore_aft", "extreme": ["min", "max"]}
    animal["experiment"].loc[{"axis": "lateral", "slope_deg": 0.0}] = 0.2
    animal["experiment"].loc[place | {"leg": ["F", "M"], "slope_deg": 0.0}] = -0.3
    animal["experiment"].loc[place | {"leg": "M", "slope_deg": 90.0}] = 0.3
    assert verdict(replace(results, measured=animal), 18).verdict == HOLDS
    assert verdict(replace(results, measured=-animal), 18).verdict == FAILS


def test_forces_like_those_of_animals(results: Results) -> None:
    published = results.atlas.isel(branch=0)
    animal = peak_range(published)
    # Only the back legs' lateral force is to differ.
    animal = animal.where((animal["leg"] != "B") | (animal["axis"] != "lateral"), 0.6 * animal)
    best = published[["speed", "peak_force"]].expand_dims(objective=["stability", "efficiency"])
    same = replace(results, selected=best, measured=xr.Dataset({"experiment": animal}))
    assert verdict(same, 21).verdict == HOLDS
    assert verdict(replace(same, measured=-3.0 * same.measured), 21).verdict == PARTLY


def test_searches_that_disagree(results: Results) -> None:
    low = system(phase=lambda phase: -phase)(results.optima)
    judged = verdict(replace(results, nelder_mead=low), 11)
    assert judged.verdict == PARTLY
    assert {part.outcome for part in judged.parts} == {PARTLY}
    assert "by Nelder-Mead 0 of" in judged.found
    assert "One of the two searches does not bear it out." in judged.why


def test_without_data_nothing_is_judged(results: Results) -> None:
    nothing = replace(changed(results, without(lambda data: data["speed"] < 0.0)), back_pulls=None)
    judged = judge(nothing)
    assert {verdict.number for verdict in judged if verdict.verdict == OPEN} >= set(range(9, 18)) | {20, 22, 23}
    assert all(verdict.why.startswith("Not checked") for verdict in judged if verdict.verdict == OPEN)


def test_a_single_cell_decides_nothing(results: Results) -> None:
    def change(dataset: xr.Dataset) -> xr.Dataset:
        place = {"slope_deg": SLOPES_DEG[5], "heading": HEADINGS[5]}
        return dataset.where((dataset["slope_deg"] != place["slope_deg"]) | (dataset["heading"] != place["heading"]))

    before, after = judge(results), judge(changed(results, change))
    assert [verdict.verdict for verdict in before] == [verdict.verdict for verdict in after]


def test_words_that_mean_less_or_more(results: Results) -> None:
    (part,) = [part for part in verdict(results, 6).parts if part.what == "gaits that recover within ten steps"]
    assert (part.claimed, part.outcome, part.lenient, part.strict) == ("most", HOLDS, HOLDS, FAILS)
    assert (verdict(results, 6).lenient, verdict(results, 6).strict) == (HOLDS, PARTLY)


def test_few_cells_decide_nothing_but_that_not_all_are_so() -> None:
    cells = xr.DataArray([True, True, False, False], {"heading": [0.0, 0.1, 0.2, 0.3]})
    assert share("x", cells, cells, OURS.as_a_rule).outcome == UNDECIDED
    assert share("x", cells, cells, OURS.as_a_rule, fewest=2).outcome == HOLDS
    assert share("x", cells, cells, ALL).outcome == UNDECIDED
    assert share("x", cells, cells | ~cells, ALL).outcome == FAILS
    assert share("x", cells, ~cells, NONE, fewest=2).outcome == HOLDS


def test_numbers_are_compared_as_exactly_as_they_are_known() -> None:
    assert within("x", 60.0 - 2e-6, 60.0, 90.0, "deg").outcome == HOLDS
    assert within("x", 59.9, 60.0, 90.0, "deg").outcome == FAILS


def test_cells_and_code_stand_behind_a_verdict(results: Results, tmp_path: Path) -> None:
    judged = verdict(results, 12)
    save_cells(judged, tmp_path / "cells.csv")
    with open(tmp_path / "cells.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    stable = [row for row in rows if row["part"] == "1" and row["search"] == THESIS_SEARCH]
    assert judged.parts[0].found == f"{sum(float(row['value']) for row in stable):.0f} of {len(stable)} (100%)"
    assert {row["family"] for row in stable} == set(FAMILIES)
    assert "def stability(" in judged.code and "def _stability(" in judged.code


def test_efficient_gaits_are_asked_for_stability_too(results: Results) -> None:
    def unstable(dataset: xr.Dataset) -> xr.Dataset:
        if "objective" not in dataset.dims:
            return dataset
        value = dataset["reduced_eigenvalue"]
        return dataset.assign(reduced_eigenvalue=value + 2.0 * (dataset["objective"] == "efficiency"))

    judged = verdict(changed(results, unstable), 12)
    assert next(part.what for part in judged.parts if part.outcome == FAILS).startswith("efficiency: ")
