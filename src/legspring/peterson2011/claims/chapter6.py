"""The claims of chapters 6 and 7: forces, measured and computed, and what animals choose."""

import math
from dataclasses import replace

import xarray as xr

from legspring.peterson2011.claims.criteria import ALL, FEWEST
from legspring.peterson2011.claims.evidence import (
    STEEP_SLOPE,
    Optima,
    Outcome,
    Part,
    Results,
    at,
    both_ways,
    by_both,
    exists,
    grows,
    mean,
    median,
    pushes,
    share,
    turns,
    unknown,
    within,
    yes,
)
from legspring.peterson2011.force_tables import CLEAR, OBJECTIVES, peak_range, table_cells
from legspring.peterson2011.published import published_forces
from legspring.peterson2011.tables import LEG_WORDS

ROUNDING = 0.02
"""Deviation from the thesis's ranges, printed with two decimals, that counts as none, m g."""


def measured(results: Results) -> list[Part]:
    """Claim 18: the signs of the measured forces, fore-aft and, where a push or a pull shows in them, lateral."""
    low, high = extremes(results)
    turning = low["slope_deg"].isin([15.0, 30.0])
    front = low.notnull() & turning & (low["leg"] == "F")
    sides = [("F", 0.0, True), ("M", 0.0, True), ("B", 0.0, True), ("F", 90.0, False), ("M", 90.0, False)]
    return [
        *(_side(results, leg, slope, pushing) for leg, slope, pushing in [*sides, ("B", 90.0, True)]),
        *(_outward(results, leg) for leg in "FMB"),
        share(
            "ranges of front forces at 15 and 30 deg that have both signs",
            (low < 0.0) & (high > 0.0),
            front,
            ALL,
            fewest=min(FEWEST, int(front.sum())),
        ),
    ]


def extremes(results: Results) -> tuple[xr.DataArray, xr.DataArray]:
    """Least and greatest measured force of each pair of legs at each slope."""
    forces = results.measured["experiment"]
    return forces.sel(extreme="min", drop=True), forces.sel(extreme="max", drop=True)


def _side(results: Results, leg: str, slope: float, pushing: bool) -> Part:
    """Judge whether the measured fore-aft forces of a pair of legs lie mostly on one side of zero."""
    forward = pushing == (leg == "B")
    what = f"fore-aft force of the {LEG_WORDS[leg]} legs at {slope:.0f} deg"
    wanted = f"mostly {'above' if forward else 'below'} 0 ({'push' if pushing else 'pull'})"
    place = {"leg": leg, "axis": "fore_aft", "slope_deg": slope}
    low, high = (float(extreme.sel(place)) for extreme in extremes(results))
    if math.isnan(low + high):
        return unknown(what, wanted, "The thesis's tables give no numbers.")
    # A range that reaches equally far to both sides decides nothing.
    reach = high + low if forward else -high - low
    reason = "The range reaches as far to the other side of zero."
    return yes(what, wanted, f"{low:.2f} to {high:.2f}", reach > 0.0, reason)


def _outward(results: Results, leg: str) -> Part:
    """Judge whether the lateral forces on the level are those of a leg that pushes: inwards, from the foot's side."""
    what = f"lateral force of the {LEG_WORDS[leg]} legs at 0 deg"
    claimed = "mostly above 0 (push)"
    low, high = (float(extreme.sel(leg=leg, axis="lateral", slope_deg=0.0)) for extreme in extremes(results))
    if math.isnan(low + high):
        return unknown(what, claimed, "The thesis's tables give no numbers.")
    return yes(what, claimed, f"{low:.2f} to {high:.2f}", low + high > 0.0, "The range reaches farther to pulling.")


def fixed_forces(results: Results) -> list[Part]:
    """Claim 19: where the legs of gaits with fixed actuation turn, and how even the back legs' forces are."""
    gaits, criteria = results.published, results.criteria
    there, border = exists(gaits), criteria.border
    front, middle = (turns(pushes(gaits, leg), there, "slope_deg") for leg in "FM")
    back = gaits["peak_force"].sel(leg="B")
    spread = back.std(["slope_deg", "heading"]) / back.mean(["slope_deg", "heading"])
    first = middle.dropna("heading")
    return [
        share(
            "headings at which the front legs turn between 10 and 30 deg",
            (front >= 10.0 - border) & (front <= 30.0 + border),
            front.notnull(),
            criteria.as_a_rule,
        ),
        grows("slope of that turn with heading", front, "heading", criteria.as_a_rule),
        within(
            "slope at which the middle legs turn at the lowest heading",
            mean(first[:1]),
            35.0 - border,
            35.0 + border,
            "deg",
            claimed="near 35 deg",
            of=middle,
        ),
        share(
            "gaits with pulling middle legs from 0.25 rad",
            ~pushes(gaits, "M"),
            at(gaits, heading=(0.25, 1.0)),
            criteria.nearly_all,
        ),
        *(
            within(
                f"spread of the back legs' {axis.replace('_', '-')} force, in units of its mean",
                float(spread.sel(axis=axis)),
                0.0,
                criteria.uniform,
                claimed="nearly uniform",
                of=back.sel(axis=axis),
            )
            for axis in ("lateral", "fore_aft")
        ),
    ]


def optimal_forces(results: Results) -> list[Part]:
    """Claim 20: where the legs of the selected gaits push."""
    return by_both(results, _optimal_forces)


def _optimal_forces(optima: Optima) -> list[Part]:
    criteria = optima.criteria
    nearly, rule, border = criteria.nearly_all, criteria.as_a_rule, criteria.border
    stable, efficient = optima.best("stability"), optima.best("efficiency")
    there, slope, heading = exists(stable), stable["slope_deg"], stable["heading"]
    front, middle = pushes(stable, "F"), pushes(stable, "M")
    # At 20 deg itself either may be so.
    below, above, high = slope < 19.0, slope > 21.0, heading > 0.2 + 1e-9
    turn = turns(pushes(efficient, "F"), exists(efficient), "slope_deg")
    corner = (efficient["slope_deg"] < 19.0) & (efficient["heading"] <= 0.1 + 1e-9)
    return [
        *both_ways(
            ("stability: gaits with pushing front legs", front),
            ("below 20 deg", slope <= 20.0),
            there,
            only=rule,
            there=rule,
        ),
        share("stability: gaits above 20 deg with pulling middle legs", ~middle, there & above, nearly),
        share(
            "stability: gaits below 20 deg, above 0.20 rad, with pulling middle legs",
            ~middle,
            there & below & high,
            rule,
        ),
        share(
            "stability: gaits below 20 deg, up to 0.20 rad, with pushing middle legs",
            middle,
            there & below & ~high,
            rule,
        ),
        share(
            "efficiency: headings at which the front legs turn between 10 and 20 deg",
            (turn >= 10.0 - border) & (turn <= 20.0 + border),
            turn.notnull(),
            rule,
        ),
        *both_ways(
            ("efficiency: gaits with pushing middle legs", pushes(efficient, "M")),
            ("below 20 deg, up to 0.10 rad", corner),
            exists(efficient),
            only=nearly,
            there=rule,
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
        within(
            "least lateral force of the back legs",
            float(low.min()),
            0.30 - ROUNDING,
            0.30 + ROUNDING,
            "m g",
            claimed="0.30 m g",
            of=low,
        ),
        within("greatest one", float(high.max()), 0.42 - ROUNDING, 0.42 + ROUNDING, "m g", claimed="0.42 m g", of=high),
        share("slopes at which all of it is beyond the measured range", beyond > 0.0, beyond.notnull(), ALL),
    ]


def _compare(name: str, gaits: xr.Dataset, results: Results) -> list[Part]:
    """Compare the greatest magnitudes, and the signs of front forces where the measured ones have but one."""
    model, animal = xr.align(peak_range(gaits), results.measured["experiment"])
    criteria = results.criteria
    ratio = abs(model).max("extreme") / abs(animal).max("extreme")
    clear = (animal.prod("extreme", skipna=False) >= 0.0) & ratio.notnull() & (animal["leg"] == "F")
    return [
        share(
            f"{name}: greatest forces within a factor of {criteria.factor:g} of the measured ones",
            (ratio <= criteria.factor) & (ratio >= 1.0 / criteria.factor),
            ratio.notnull(),
            criteria.as_a_rule,
        ),
        share(
            f"{name}: front forces with the measured sign, where that is clear",
            model.sum("extreme") * animal.sum("extreme") > 0.0,
            clear,
            criteria.nearly_all,
        ),
    ]


def steep_recovery(results: Results) -> list[Part]:
    """Claim 22: the fewest steps to recover from an impulse of half the momentum on steep slopes, and their mean."""
    return [
        *_steep_recovery(results.published, "fixed actuation"),
        *by_both(results, lambda optima: _steep_recovery(optima.best("stability"), "for stability")),
        *by_both(results, lambda optima: _steep_recovery(optima.best("efficiency"), "for efficiency")),
    ]


def _steep_recovery(gaits: xr.Dataset, words: str) -> list[Part]:
    if "recovery_steps" not in gaits:
        return [unknown(f"{words}: steps on slopes from 60 deg", "close to one", "They were not computed.")]
    steps = gaits["recovery_steps"].sel(impulse=0.5, method="nearest", tolerance=1e-6)
    steep = steps.where(gaits["slope_deg"] >= STEEP_SLOPE)
    return [
        within(f"{words}: {what} on slopes from 60 deg", value, 1.0, 2.0, claimed="close to one", of=steep)
        for what, value in (("fewest steps", float(steep.min())), ("mean number of steps", mean(steep)))
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
    stable = _over_low_slopes(optima.best("stability"), "reduced_eigenvalue")
    cheap = _over_low_slopes(optima.best("efficiency"), "transport_cost")
    return [
        within("heading of the most stable gaits up to 10 deg", _least(stable), 0.1, 0.15, "rad", of=stable),
        within(
            "heading of the cheapest gaits up to 10 deg",
            _least(cheap),
            0.075,
            0.125,
            "rad",
            claimed="about 0.10 rad",
            of=cheap,
        ),
    ]


def _over_low_slopes(gaits: xr.Dataset, name: str) -> xr.DataArray:
    """Mean of each heading over low slopes, missing unless there is a gait on every one of them."""
    return gaits[name].where(at(gaits, slope_deg=(0.0, 10.0)), drop=True).mean("slope_deg", skipna=False)


def _least(row: xr.DataArray) -> float:
    return float(row.idxmin("heading")) if bool(row.notnull().any()) else math.nan


DUTY = {"level": (0.0, 0.52, 0.66), "vertical": (90.0, 0.50, 0.74)}
"""Duty factors of animals as the thesis quotes them: slope in deg, from, to."""


def duty(results: Results) -> list[Part]:
    """Claim 26: how long legs are down, by pairs, against what the thesis quotes of animals."""
    gaits = results.published
    if "duty_factor" not in gaits:
        return [unknown("duty factors", "52 to 74 %", "They were not computed.")]
    parts = []
    for name, (slope, low, high) in DUTY.items():
        there = at(gaits, slope_deg=(slope, slope), heading=(0.05, 0.25))
        for pair in gaits["leg"].values:
            legs = [leg for leg in gaits["single_leg"].values if str(leg).startswith(str(pair))]
            share_down = gaits["duty_factor"].where(there).sel(single_leg=legs)
            what = f"median share for which legs {pair} are down on the {name}, headings of 0.05 to 0.25 rad"
            parts.append(within(what, median(share_down), low, high, of=share_down))
    return parts


def printed_forces(results: Results) -> list[Part]:
    """Claim 28: whether the numbers of Tables 6.1 to 6.3 come out again."""
    printed = published_forces()
    fixed = abs(peak_range(results.published) - printed["model"])
    return [
        share("numbers with fixed actuation that are ours, to 0.02 m g", fixed <= ROUNDING, fixed.notnull(), ALL),
        *(part for objective in OBJECTIVES for part in _printed_optima(results, objective, printed[objective])),
    ]


def _printed_optima(results: Results, objective: str, printed: xr.DataArray) -> list[Part]:
    """Look for the printed numbers among those of the best gaits, by all searches, and among all optimised gaits."""
    best = [peak_range(optima.best(objective)) for optima in results.searches]
    if results.starts is not None:
        best += [results.starts[objective].sel(start=n, drop=True) for n in results.starts["start"].values]
    away = xr.concat([abs(one - printed) for one in best], dim="search").min("search")
    searches = (
        f"the best gaits, or those of {len(best) - 1} {'run' if len(best) == 2 else 'runs'} of the thesis's search"
    )
    reason = "Where the thesis's search ends depends on where it starts, which is not known."
    found = share(f"{objective}: numbers that are those of {searches}", away <= CLEAR, away.notnull(), ALL, reason)
    if found.outcome == Outcome.FAILS:
        found = replace(found, outcome=Outcome.UNDECIDED)
    all_of_them = [table_cells(optima.families.sel(objective=objective))["peak_force"] for optima in results.searches]
    low = xr.concat([force.min(["heading", "family"]) for force in all_of_them], dim="search").min("search")
    high = xr.concat([force.max(["heading", "family"]) for force in all_of_them], dim="search").max("search")
    inside = (printed >= low - CLEAR) & (printed <= high + CLEAR)
    among = printed.notnull() & low.notnull()
    return [found, share(f"{objective}: numbers in the range of all optimised gaits that we know", inside, among, ALL)]
