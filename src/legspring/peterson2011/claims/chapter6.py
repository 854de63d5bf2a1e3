"""The claims of chapters 6 and 7: forces, measured and computed, and what animals choose."""

import math

import xarray as xr

from legspring.peterson2011.claims.evidence import (
    MOST,
    NEARLY_ALL,
    STEEP_SLOPE,
    Optima,
    Part,
    Results,
    at,
    by_both,
    exists,
    grows,
    mean,
    pushes,
    share,
    turns,
    unknown,
    within,
    yes,
)
from legspring.peterson2011.tables import OBJECTIVES, peak_range

NAMES = {"F": "front", "M": "middle", "B": "back"}
FACTOR = 2.0
"""Ratio up to which forces are of the same size."""
UNIFORM = 0.25
"""Standard deviation, in units of the mean, up to which forces are nearly uniform."""
ROUNDING = 0.02
"""Deviation from the thesis's ranges, printed with two decimals, that counts as none, m g."""


def measured(results: Results) -> list[Part]:
    """Claim 18: the signs of the measured fore-aft forces."""
    low, high = extremes(results)
    turning = low["slope_deg"].isin([15.0, 30.0])
    front = low.notnull() & turning & (low["leg"] == "F")
    sides = [("F", 0.0, True), ("M", 0.0, True), ("B", 0.0, True), ("F", 90.0, False), ("M", 90.0, False)]
    return [
        *(_side(results, leg, slope, pushing) for leg, slope, pushing in [*sides, ("B", 90.0, True)]),
        share("ranges of front forces at 15 and 30 deg that have both signs", (low < 0.0) & (high > 0.0), front, 1.0),
    ]


def extremes(results: Results) -> tuple[xr.DataArray, xr.DataArray]:
    """Least and greatest measured force of each pair of legs at each slope."""
    forces = results.measured["experiment"]
    return forces.sel(extreme="min", drop=True), forces.sel(extreme="max", drop=True)


def _side(results: Results, leg: str, slope: float, pushing: bool) -> Part:
    """Judge whether the measured fore-aft forces of a pair of legs lie mostly on one side of zero."""
    forward = pushing == (leg == "B")
    what = f"fore-aft force of the {NAMES[leg]} legs at {slope:.0f} deg"
    wanted = f"mostly {'above' if forward else 'below'} 0 ({'push' if pushing else 'pull'})"
    place = {"leg": leg, "axis": "fore_aft", "slope_deg": slope}
    low, high = (float(extreme.sel(place)) for extreme in extremes(results))
    if math.isnan(low + high):
        return unknown(what, wanted, "The thesis's tables give no numbers.")
    # A range that reaches equally far to both sides decides nothing.
    reach = high + low if forward else -high - low
    reason = "The range reaches as far to the other side of zero."
    return yes(what, wanted, f"{low:.2f} to {high:.2f}", reach > 0.0, reason)


def fixed_forces(results: Results) -> list[Part]:
    """Claim 19: where the legs of gaits with fixed actuation turn, and how even the back legs' forces are."""
    gaits = results.published
    there = exists(gaits)
    front, middle = (turns(pushes(gaits, leg), there, "slope_deg") for leg in "FM")
    back = gaits["peak_force"].sel(leg="B")
    spread = back.std(["slope_deg", "heading"]) / back.mean(["slope_deg", "heading"])
    first = middle.dropna("heading")
    return [
        share(
            "headings at which the front legs turn within a cell of 10 to 30 deg",
            (front >= 7.5) & (front <= 32.5),
            front.notnull(),
            MOST,
        ),
        grows("slope of that turn with heading", front, "heading"),
        within("slope at which the middle legs turn at the lowest heading", mean(first[:1]), 30.0, 40.0, "deg"),
        share(
            "gaits with pulling middle legs from 0.25 rad",
            ~pushes(gaits, "M"),
            at(gaits, heading=(0.25, 1.0)),
            NEARLY_ALL,
        ),
        within(
            "spread of the back legs' lateral force, in units of its mean",
            float(spread.sel(axis="lateral")),
            0.0,
            UNIFORM,
        ),
        within(
            "spread of the back legs' fore-aft force, in units of its mean",
            float(spread.sel(axis="fore_aft")),
            0.0,
            UNIFORM,
        ),
    ]


def optimal_forces(results: Results) -> list[Part]:
    """Claim 20: where the legs of the selected gaits push."""
    return by_both(results, _optimal_forces)


def _optimal_forces(optima: Optima) -> list[Part]:
    stable, efficient = optima.best("stability"), optima.best("efficiency")
    below, above = at(stable, slope_deg=(0.0, 19.0)), at(stable, slope_deg=(21.0, 90.0))
    middle = pushes(stable, "M")
    turn = turns(pushes(efficient, "F"), exists(efficient), "slope_deg")
    corner = at(efficient, slope_deg=(0.0, 19.0), heading=(0.0, 0.1))
    return [
        share("stability: gaits below 20 deg with pushing front legs", pushes(stable, "F"), below, MOST),
        share("stability: gaits above 20 deg with pulling middle legs", ~middle, above, NEARLY_ALL),
        share(
            "stability: gaits below 20 deg, above 0.20 rad, with pulling middle legs",
            ~middle,
            below & (stable["heading"] > 0.2 + 1e-9),
            MOST,
        ),
        share(
            "efficiency: headings at which the front legs turn within a cell of 10 to 20 deg",
            (turn >= 7.5) & (turn <= 22.5),
            turn.notnull(),
            MOST,
        ),
        share(
            "efficiency: gaits with pushing middle legs that lie below 20 deg and up to 0.10 rad",
            corner,
            pushes(efficient, "M"),
            NEARLY_ALL,
        ),
    ]


def agreement(results: Results) -> list[Part]:
    """Claim 21: ranges of forces over the headings of Tables 6.1 to 6.3 against the measured ones."""
    fixed, stable, efficient = results.published, *(results.selected.sel(objective=name) for name in OBJECTIVES)
    named = {"fixed actuation": fixed, "stability": stable, "efficiency": efficient}
    parts = [part for name, gaits in named.items() for part in _compare(name, gaits, results)]
    lateral, animal = xr.align(peak_range(fixed), results.measured["experiment"])
    lateral, animal = (force.sel(leg="B", axis="lateral") for force in (lateral, animal))
    low, high = (lateral.sel(extreme=name, drop=True) for name in ("min", "max"))
    beyond = low - animal.sel(extreme="max", drop=True)
    return [
        *parts,
        within("least lateral force of the back legs", float(low.min()), 0.30 - ROUNDING, 0.30 + ROUNDING, "m g"),
        within("greatest one", float(high.max()), 0.42 - ROUNDING, 0.42 + ROUNDING, "m g"),
        share(
            "slopes at which all of it is beyond the measured range",
            beyond > 0.0,
            beyond.notnull(),
            1.0,
        ),
    ]


def _compare(name: str, gaits: xr.Dataset, results: Results) -> list[Part]:
    """Compare the greatest magnitudes, and the signs of front forces where the measured ones have but one."""
    model, animal = xr.align(peak_range(gaits), results.measured["experiment"])
    ratio = abs(model).max("extreme") / abs(animal).max("extreme")
    clear = (animal.prod("extreme", skipna=False) >= 0.0) & ratio.notnull() & (animal["leg"] == "F")
    return [
        share(
            f"{name}: greatest forces within a factor of 2 of the measured ones",
            (ratio <= FACTOR) & (ratio >= 1.0 / FACTOR),
            ratio.notnull(),
            MOST,
        ),
        share(
            f"{name}: front forces with the measured sign, where that is clear",
            model.sum("extreme") * animal.sum("extreme") > 0.0,
            clear,
            NEARLY_ALL,
        ),
    ]


def steep_recovery(results: Results) -> list[Part]:
    """Claim 22: the fewest steps to recover from an impulse of half the momentum on steep slopes."""
    gaits = results.published
    steps = gaits["recovery_steps"].sel(impulse=0.5, method="nearest", tolerance=1e-6)
    steep = steps.where(gaits["slope_deg"] >= STEEP_SLOPE)
    fewest = float(steep.min())
    slow = "Legs that are still down carry a disturbance from step to step; the thesis's map leaves them out."
    return [
        within("fewest steps on slopes from 60 deg", fewest, 1.0, 2.0, reason=slow),
        within("mean number there", mean(steep), 1.0, 2.0),
    ]


def chosen_heading(results: Results) -> list[Part]:
    """Claim 23: the headings of the best gaits on low slopes; what animals do is no result of ours."""
    return [
        *by_both(results, _chosen_heading),
        unknown(
            "headings of animals", "0.05 to 0.25 rad", "The headings of animals are from the literature, not computed."
        ),
    ]


def _chosen_heading(optima: Optima) -> list[Part]:
    stable = _best_heading(optima.best("stability"), "reduced_eigenvalue")
    cheap = _best_heading(optima.best("efficiency"), "transport_cost")
    return [
        within("heading of the most stable gaits up to 10 deg", stable, 0.1, 0.15, "rad"),
        within("heading of the cheapest gaits up to 10 deg", cheap, 0.075, 0.125, "rad"),
    ]


def _best_heading(gaits: xr.Dataset, name: str) -> float:
    """Heading with the least mean over low slopes, among those with a gait on every one of them."""
    row = gaits[name].where(at(gaits, slope_deg=(0.0, 10.0)), drop=True).mean("slope_deg", skipna=False)
    return float(row.idxmin("heading")) if bool(row.notnull().any()) else math.nan
