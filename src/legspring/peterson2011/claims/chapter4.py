"""The claims of chapter 4: gaits with the thesis's fixed actuation."""

import math

import numpy as np
import xarray as xr

from legspring.peterson2011.claims.criteria import ALL, NONE
from legspring.peterson2011.claims.evidence import (
    LOW_SLOPE,
    STEEP_SLOPE,
    Part,
    Results,
    animal_of,
    at,
    both_ways,
    degrees,
    exists,
    grows,
    mean,
    median,
    pushes,
    ratio,
    share,
    turns,
    unknown,
    within,
    yes,
)

EXACT = 1e-6
"""Difference of costs that counts as none where the thesis says "exactly"."""


def existence(results: Results) -> list[Part]:
    """Claim 1: the cells with a gait, and where the others lie."""
    gaits, criteria = results.published, results.criteria
    there = exists(gaits)
    everywhere = there | ~there
    origin = (gaits["slope_deg"] == 0.0) & (gaits["heading"] == 0.0)
    middle = (gaits["slope_deg"] >= 25.0) & (gaits["slope_deg"] <= 65.0) & (gaits["heading"] >= 0.4 - 1e-9)
    place = "with slopes of 25 to 65 deg and headings from 0.40 rad"
    return [
        share("cells with a gait", there, everywhere, criteria.most),
        # All empty cells there are: however few, they are no sample.
        share(f"empty cells that lie among those {place}", middle, ~there & ~origin, criteria.as_a_rule, fewest=1),
        share(f"cells {place} that are empty", ~there, middle & everywhere, criteria.as_a_rule),
        share(
            "gaits of the four families at 0 deg, 0 rad in which every leg works",
            there,
            origin & everywhere,
            NONE,
            fewest=1,
        ),
    ]


def uniqueness(results: Results) -> list[Part]:
    """Claim 2: cells with more than one gait, and with gaits of more than one family."""
    gaits = results.atlas
    labels = gaits["family"].where(exists(gaits), "")
    count = exists(gaits).sum("branch")
    families = xr.apply_ufunc(
        lambda row: len(set(map(str, row)) - {""}), labels, input_core_dims=[["branch"]], vectorize=True
    )
    second = "There are further solutions, in which the back legs' phase is less negative; the thesis shows one only."
    return [
        share("cells with two gaits or more", count > 1, count > 0, NONE, reason=second),
        share("cells with gaits of two families or more", families > 1, count > 0, NONE, reason=second),
    ]


def speed(results: Results) -> list[Part]:
    """Claim 3: the initial speed against the desired one."""
    gaits, criteria = results.published, results.criteria
    animal = animal_of(gaits)
    desired = xr.DataArray(
        [animal.desired_speed(math.radians(slope)) for slope in gaits["slope_deg"].values],
        {"slope_deg": gaits["slope_deg"]},
    )
    deviation = abs(gaits["speed"] / desired - 1.0)
    return [
        grows("initial speed with slope", gaits["speed"], "slope_deg", criteria.nearly_all, falls=True),
        share(
            f"gaits whose initial speed is within {criteria.follows:.0%} of the desired one",
            deviation <= criteria.follows,
            exists(gaits),
            criteria.nearly_all,
        ),
    ]


def functions(results: Results) -> list[Part]:
    """Claim 4: which legs push where, and their phases."""
    gaits, criteria = results.published, results.criteria
    there, front, back = exists(gaits), pushes(gaits, "F"), degrees(gaits, "B")
    rows = there.any("slope_deg")
    turning = turns(front, there, "slope_deg")
    before = front & (gaits["slope_deg"] < turning)
    again = (front & (gaits["slope_deg"] > turning)).any("slope_deg")
    # The last cell before the turn against the other cells in which the front legs push.
    last = gaits.where(before).isel(slope_deg=_last(before))
    latest = degrees(last, "F") >= degrees(gaits, "F").where(before).max("slope_deg")
    stance = gaits["liftoff"].sel(leg="F", drop=True)
    shortest = last["liftoff"].sel(leg="F", drop=True) <= stance.where(before).min("slope_deg")
    low = (gaits["slope_deg"] <= 35.0) & (gaits["heading"] <= 0.2 + 1e-9)
    return [
        share(
            "headings at which the front legs push first, pull later and stay so",
            turning.notnull() & ~again,
            rows,
            criteria.as_a_rule,
        ),
        share(
            "turns at which the phase is the latest and the stance the shortest",
            latest & shortest,
            turning.notnull(),
            criteria.as_a_rule,
        ),
        *both_ways(
            ("gaits with pushing middle legs", pushes(gaits, "M")),
            ("at slopes up to 35 deg and headings up to 0.20 rad", low),
            there,
            only=criteria.nearly_all,
            there=criteria.most,
        ),
        share(
            f"gaits whose back legs have a phase below {criteria.early:.0f} deg",
            back < criteria.early,
            there,
            criteria.most,
        ),
        back_legs(results),
    ]


def back_legs(results: Results) -> Part:
    """Judge whether the back legs push in every gait there is."""
    what, wanted = "gaits whose back legs pull", "none"
    if results.back_pulls is None:
        return unknown(what, wanted, "Gaits whose back legs pull have not been looked for.")
    gaits = results.back_pulls
    cells = int(exists(gaits).any("branch").sum())
    reason = "Such gaits exist; the thesis did not meet them."
    found = f"{int(exists(gaits).sum())} in {cells} cells"
    return yes(what, wanted, found, cells == 0, reason, of=exists(gaits))


def _last(true: xr.DataArray) -> xr.DataArray:
    """Index of the last true cell of each row over slope; 0 if there is none."""
    index = xr.DataArray(np.arange(true.sizes["slope_deg"]), dims="slope_deg")
    return index.where(true, 0).max("slope_deg").astype(int)


def stability(results: Results) -> list[Part]:
    """Claim 5: where the gaits are stable, and how much so over the headings of low slopes."""
    gaits = results.published
    there, value = exists(gaits), gaits["reduced_eigenvalue"]
    steep = mean(value, at(gaits, slope_deg=(STEEP_SLOPE, 90.0)))
    low = at(gaits, slope_deg=(0.0, LOW_SLOPE))
    row = value.where(low).mean("slope_deg")
    middle = turns(pushes(gaits, "M").where(low, False), low, "heading")
    part = "mean eigenvalue from 60 deg, in units of that up to 10 deg"
    return [
        share("gaits that are stable by the thesis's map", value < 1.0, there, ALL),
        share("gaits that are stable by the complete map", gaits["max_multiplier"] < 1.0, there, ALL),
        within(part, ratio(steep, mean(value, low)), 0.0, 0.5, claimed="less", of=value),
        within(
            "heading with the least mean eigenvalue on slopes up to 10 deg",
            _place(row, "min"),
            0.3,
            0.4,
            "rad",
            of=row,
        ),
        within(
            "heading with the least one below 0.2 rad",
            _place(row.where(row["heading"] < 0.2), "min"),
            0.05,
            0.15,
            "rad",
        ),
        within(
            "heading with the greatest one from 0.05 rad",
            _place(row.where(row["heading"] > 0.01), "max"),
            0.15,
            0.25,
            "rad",
            claimed="about 0.20 rad",
        ),
        within(
            "heading at which the middle legs turn there (mean)",
            mean(middle),
            0.15,
            0.25,
            "rad",
            claimed="about 0.20 rad",
            of=middle,
        ),
    ]


def _place(row: xr.DataArray, extreme: str) -> float:
    """Heading with the least or the greatest value of a row; nan if it is empty."""
    if not bool(row.notnull().any()):
        return math.nan
    return float(row.idxmin("heading") if extreme == "min" else row.idxmax("heading"))


def recovery(results: Results) -> list[Part]:
    """Claim 6: steps to recover from an impulse of half the momentum, and their rank correlation with stability."""
    gaits, criteria = results.published, results.criteria
    steps = gaits["recovery_steps"].sel(impulse=0.5, method="nearest", tolerance=1e-6)
    known = steps.notnull()
    ranks = [values.values[known.values].argsort().argsort() for values in (steps, gaits["reduced_eigenvalue"])]
    correlation = float(np.corrcoef(ranks)[0, 1]) if int(known.sum()) > 2 else math.nan
    return [
        share("gaits that recover within ten steps", steps <= 10.0, exists(gaits), criteria.most),
        within("greatest number of steps", float(steps.max()), 70.0, math.inf, of=steps),
        within("rank correlation of steps and eigenvalue", correlation, criteria.alike, 1.0, claimed="alike", of=steps),
    ]


def impulses(results: Results) -> list[Part]:
    """Claim 7: recovery from all impulses at a heading of 0.15 rad."""
    criteria = results.criteria
    gaits = results.published.sel(heading=0.15, method="nearest", tolerance=1e-6)
    steps = gaits["recovery_steps"]
    # Without an impulse there is nothing to recover from.
    pushed = exists(gaits) & (abs(gaits["impulse"]) > 1e-9)
    slowest = steps.max("impulse")
    return [
        share("pairs of gait and impulse with a recovery", gaits["recovered"] == 1.0, pushed, ALL),
        share(
            f"recoveries above 20 deg within {criteria.quick:.0f} steps",
            steps <= criteria.quick,
            pushed & (gaits["slope_deg"] > 20.0),
            criteria.nearly_all,
        ),
        within(
            "slope of the slowest recovery",
            _slope(slowest),
            15.0 - criteria.border,
            15.0 + criteria.border,
            "deg",
            claimed="15 deg",
            of=slowest,
        ),
    ]


def _slope(values: xr.DataArray) -> float:
    return float(values.idxmax("slope_deg")) if bool(values.notnull().any()) else math.nan


def cost(results: Results) -> list[Part]:
    """Claim 8: the cost of family B against the least possible one, and that of the others over heading."""
    gaits, criteria = results.published, results.criteria
    there, value = exists(gaits), gaits["transport_cost"]
    least = np.sin(np.deg2rad(gaits["slope_deg"]))
    back_only = gaits["family"] == "B"
    low = at(gaits, slope_deg=(0.0, LOW_SLOPE))
    return [
        share(
            "gaits of family B that cost sin(slope) to 1e-6",
            abs(value - least) <= EXACT,
            back_only & there,
            criteria.nearly_all,
        ),
        share("other gaits that cost more", value > least + EXACT, there & ~back_only, criteria.nearly_all),
        grows("cost with heading on slopes up to 10 deg", value.where(low), "heading", criteria.as_a_rule),
        within(
            "rise of the cost where the middle legs turn there, in units of its mean rise elsewhere",
            _jump(gaits, low),
            1.5,
            math.inf,
            claimed="jumps",
            of=value.where(low),
        ),
    ]


def _jump(gaits: xr.Dataset, cells: xr.DataArray) -> float:
    """Mean rise of the cost from heading to heading at which the middle legs turn, over that at the others."""
    rise = gaits["transport_cost"].where(cells).diff("heading")
    turning = pushes(gaits, "M").where(cells, False).astype(int).diff("heading") == -1
    return ratio(mean(rise, turning), mean(rise, ~turning))


def towards_zero(results: Results) -> list[Part]:
    """Claim 24: from 25 deg on, how near to ideal the stability of gaits with fixed actuation, and their cost, are."""
    gaits, criteria = results.published, results.criteria
    value, steep = gaits["reduced_eigenvalue"], at(gaits, slope_deg=(25.0, 90.0))
    least = np.sin(np.deg2rad(gaits["slope_deg"]))
    medians = [
        within(
            f"median eigenvalue over headings at {slope:g} deg",
            median(value.where(at(gaits, slope_deg=(slope, slope)))),
            0.0,
            criteria.ideal,
            claimed="approaching zero",
            of=value.where(at(gaits, slope_deg=(slope, slope))),
        )
        for slope in (25.0, 40.0, 90.0)
    ]
    return [
        share(
            f"gaits from 25 deg with an eigenvalue up to {criteria.ideal:g}",
            value <= criteria.ideal,
            steep,
            criteria.most,
        ),
        *medians,
        grows("eigenvalue with slope from 25 deg", value.where(steep), "slope_deg", criteria.as_a_rule, falls=True),
        share(
            "gaits from 25 deg that recover from an impulse of half the momentum within ten steps",
            gaits["recovery_steps"].sel(impulse=0.5, method="nearest", tolerance=1e-6) <= 10.0,
            steep,
            criteria.most,
        ),
        share("gaits from 25 deg that cost sin(slope)", gaits["transport_cost"] <= least + EXACT, steep, criteria.most),
    ]
