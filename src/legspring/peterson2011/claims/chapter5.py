"""The claims of chapter 5: gaits whose actuation is optimised for stability or for efficiency."""

import math

import numpy as np
import xarray as xr

from legspring.peterson2011.claims.chapter4 import back_legs
from legspring.peterson2011.claims.criteria import ACCURACY, ALL, SAME
from legspring.peterson2011.claims.evidence import (
    LOW_SLOPE,
    STEEP_SLOPE,
    Optima,
    Part,
    Results,
    actuation,
    at,
    both_ways,
    by_both,
    degrees,
    exists,
    grows,
    mean,
    median,
    near,
    share,
    turns,
    unknown,
    within,
)

BORDER = 20.0
"""Slope from which on family B is selected, deg."""
OBJECTIVES = ("stability", "efficiency")


def families(results: Results) -> list[Part]:
    """Claim 9: which families exist where."""
    return [*by_both(results, _families), back_legs(results)]


def _families(optima: Optima) -> list[Part]:
    # A family exists in a cell if either objective has a gait there.
    there = exists(optima.families).any("objective")
    count = there.sum("family")
    somewhere = there.any(["slope_deg", "heading"]).sum()
    # B is missing where other families have a gait.
    missing = ~there.sel(family="B", drop=True) & (count > 0)
    flat = missing["slope_deg"] <= 5.0
    criteria = optima.criteria
    return [
        within("families that exist somewhere", float(somewhere.where(somewhere > 0)), 4.0, 4.0),
        within(
            "cells with several families",
            float((count > 1).sum().where((count > 0).any())),
            1.0,
            math.inf,
            claimed="some",
            of=count,
        ),
        within("greatest number of families in a cell", float(count.where(count > 0).max()), 3.0, 3.0, of=count),
        *both_ways(
            ("cells without family B", missing),
            ("at slopes up to 5 deg", flat),
            count > 0,
            only=criteria.nearly_all,
            there=criteria.most,
        ),
    ]


def stable_actuation(results: Results) -> list[Part]:
    """Claim 10: actuations of the gaits optimised for stability, over slope and heading."""
    return by_both(results, _stable_actuation)


def _stable_actuation(optima: Optima) -> list[Part]:
    gaits = {family: optima.of("stability", family) for family in ("A", "FB", "MB", "B")}
    front, all_push = actuation(gaits["B"], "F"), exists(gaits["A"])
    stable = optima.families.sel(objective="stability")
    middle = actuation(stable, "M").sel(family=["FB", "B"])
    back = actuation(stable, "B")
    criteria = optima.criteria
    rule = criteria.as_a_rule
    reached = _reach(front, criteria.limit)
    least = f"gaits of A whose middle legs are actuated by up to {criteria.little:g} l0"
    return [
        grows(
            "front actuation with slope in B, up to 50 deg", front.where(front["slope_deg"] <= 50.0), "slope_deg", rule
        ),
        share(
            "headings at which it comes to its limit, 0.9 l0, anywhere in B",
            reached.notnull(),
            exists(gaits["B"]).any("slope_deg"),
            rule,
        ),
        within(
            "slope at which it comes there first, where it does (median)",
            median(reached),
            (1.0 - criteria.near) * 50.0,
            (1.0 + criteria.near) * 50.0,
            "deg",
            claimed="near 50 deg",
            of=reached,
        ),
        share(least, actuation(gaits["A"], "M") <= criteria.little + SAME, all_push, rule),
        grows("middle actuation with heading in FB and B", middle, "heading", rule),
        grows("back actuation with slope", back, "slope_deg", rule),
        grows("back actuation with heading in A and MB", back.sel(family=["A", "MB"]), "heading", rule),
    ]


def _reach(values: xr.DataArray, limit: float) -> xr.DataArray:
    """Least slope of each heading at which an actuation is at its limit; missing where it never is."""
    return values["slope_deg"].where(values >= limit - SAME).min("slope_deg")


def stable_phase(results: Results) -> list[Part]:
    """Claim 11: phases of the gaits optimised for stability."""
    return by_both(results, _stable_phase)


def _stable_phase(optima: Optima) -> list[Part]:
    criteria, gaits = optima.criteria, optima.families.sel(objective="stability")
    front, middle, back_only = gaits.sel(family=["A", "FB"]), gaits.sel(family="MB"), gaits.sel(family="B")
    from_on = f"from {criteria.late:.0f} deg"
    late = criteria.late - ACCURACY["deg"]
    return [
        share(
            f"gaits with pushing front legs whose front phase is {from_on}",
            degrees(front, "F") >= late,
            exists(front),
            criteria.as_a_rule,
        ),
        share(
            f"gaits of MB whose middle phase is {from_on}",
            degrees(middle, "M") >= late,
            exists(middle),
            criteria.as_a_rule,
        ),
        share(
            f"gaits of B from 60 deg whose middle phase is {from_on}",
            degrees(back_only, "M") >= late,
            at(back_only, slope_deg=(STEEP_SLOPE, 90.0)),
            criteria.as_a_rule,
        ),
        share("gaits whose back phase is negative", degrees(gaits, "B") < 0.0, exists(gaits), criteria.nearly_all),
    ]


def stability(results: Results) -> list[Part]:
    """Claim 12: eigenvalues of the gaits optimised for stability."""
    return by_both(results, _stability)


def _stability(optima: Optima) -> list[Part]:
    criteria, gaits = optima.criteria, optima.families.sel(objective="stability")
    value, pulling = gaits["reduced_eigenvalue"], gaits.sel(family=["MB", "B"])
    higher = at(pulling, slope_deg=(BORDER, 90.0))
    artefact = "The thesis's map leaves out the legs that are still down."
    ideal = f"gaits of MB and B from 20 deg with an eigenvalue up to {criteria.ideal:g}"
    return [
        *(part for objective in OBJECTIVES for part in _all_stable(optima, objective)),
        share(ideal, pulling["reduced_eigenvalue"] <= criteria.ideal + SAME, higher, criteria.as_a_rule),
        share(
            "the same by the complete map",
            pulling["max_multiplier"] <= criteria.ideal + SAME,
            higher,
            criteria.as_a_rule,
            reason=artefact,
        ),
        grows("eigenvalue of A with heading", value.sel(family="A"), "heading", criteria.as_a_rule),
        grows("eigenvalue of FB with heading", value.sel(family="FB"), "heading", criteria.as_a_rule, falls=True),
    ]


def _all_stable(optima: Optima, objective: str) -> list[Part]:
    """Judge whether all gaits that are optimal for an objective are stable, and how unstable they can be."""
    gaits = optima.families.sel(objective=objective)
    value = gaits["reduced_eigenvalue"]
    head = f"{objective}: "
    reason = "Efficiency does not ask for stability." if objective == "efficiency" else ""
    return [
        share(f"{head}gaits that are stable by the thesis's map", value < 1.0, exists(gaits), ALL, reason),
        share(f"{head}gaits stable by the complete map", gaits["max_multiplier"] < 1.0, exists(gaits), ALL, reason),
    ]


def stable_families(results: Results) -> list[Part]:
    """Claim 13: the most stable family over slope and heading."""
    return by_both(results, _stable_families)


def _stable_families(optima: Optima) -> list[Part]:
    criteria, gaits = optima.criteria, optima.best("stability")
    family, there, below = gaits["family"], exists(gaits), gaits["slope_deg"] < BORDER
    low, high = gaits["heading"] < 0.2 - 1e-9, gaits["heading"] > 0.2 - 1e-9
    nearly, rule = criteria.nearly_all, criteria.as_a_rule
    return [
        *both_ways(("gaits chosen of B", family == "B"), ("from 20 deg on", ~below), there, only=nearly, there=nearly),
        *both_ways(
            ("gaits chosen of A", family == "A"),
            ("below 20 deg and 0.20 rad", below & low),
            there,
            only=rule,
            there=rule,
        ),
        *both_ways(
            ("gaits chosen of FB", family == "FB"),
            ("below 20 deg, from 0.20 rad", below & high),
            there,
            only=rule,
            there=rule,
        ),
        share("cells in which MB is chosen", family == "MB", there, criteria.rarely),
    ]


def efficient_gaits(results: Results) -> list[Part]:
    """Claim 14: actuations for efficiency against those for stability, cell by cell, and the middle phase."""
    return by_both(results, _efficient_gaits)


def _efficient_gaits(optima: Optima) -> list[Part]:
    criteria = optima.criteria
    stable, efficient = (optima.families.sel(objective=name, drop=True) for name in OBJECTIVES)
    front, back = (actuation(efficient, leg) - actuation(stable, leg) for leg in "FB")
    middle = efficient.sel(family=["A", "MB"])
    return [
        within(
            "mean change of the front actuation",
            mean(front),
            2.0 * SAME,
            criteria.slight,
            "l0",
            claimed="slightly more",
            of=front,
        ),
        within(
            "mean change of the back actuation",
            mean(back),
            -criteria.slight,
            -2.0 * SAME,
            "l0",
            claimed="slightly less",
            of=back,
        ),
        share(
            f"gaits with pushing middle legs whose middle phase is from {criteria.late:.0f} deg",
            degrees(middle, "M") >= criteria.late - ACCURACY["deg"],
            exists(middle),
            criteria.as_a_rule,
        ),
    ]


def efficiency(results: Results) -> list[Part]:
    """Claim 15: costs of the gaits optimised for efficiency."""
    return by_both(results, _efficiency)


def _efficiency(optima: Optima) -> list[Part]:
    criteria, gaits = optima.criteria, optima.families.sel(objective="efficiency")
    cost, stable = gaits["transport_cost"], gaits["reduced_eigenvalue"] < 1.0
    excess = cost - np.sin(np.deg2rad(gaits["slope_deg"]))
    back_only, middle, front = (cost.sel(family=name, drop=True) for name in ("B", "A", "FB"))
    front_too, rule = cost.sel(family=["A", "FB"]), criteria.as_a_rule
    of_middle = excess.sel(family="MB")
    return [
        share(
            "gaits of B that cost sin(slope) to 0.001",
            abs(excess.sel(family="B")) <= SAME,
            back_only.notnull(),
            criteria.nearly_all,
        ),
        within("mean cost of MB beyond that", mean(of_middle), -SAME, 0.05, claimed="nearly none", of=of_middle),
        grows("cost of A and FB with slope", front_too, "slope_deg", rule),
        grows("cost of A and FB with heading", front_too, "heading", rule),
        grows("cost of A and FB with heading, stable gaits alone", front_too.where(stable), "heading", rule),
        share(
            "cells with both in which FB is cheaper than A", front < middle, front.notnull() & middle.notnull(), rule
        ),
    ]


def efficient_families(results: Results) -> list[Part]:
    """Claim 16: the cheapest family over slope and heading, and its borders."""
    return by_both(results, _efficient_families)


def _efficient_families(optima: Optima) -> list[Part]:
    criteria, gaits = optima.criteria, optima.best("efficiency")
    family, there = gaits["family"], exists(gaits)
    first = {name: _first_slope_of_b(optima.best(name)) for name in OBJECTIVES}
    turn = turns(family == "A", there & family.isin(["A", "FB"]), "heading")
    low = gaits["slope_deg"] <= LOW_SLOPE
    small = gaits["heading"] < 0.125 - 1e-9
    nearly, rule = criteria.nearly_all, criteria.as_a_rule
    return [
        share("cells from 20 deg in which B is chosen", family == "B", there & (gaits["slope_deg"] >= BORDER), nearly),
        within(
            "mean slope from which on B is chosen, less that for stability",
            mean(first["efficiency"]) - mean(first["stability"]),
            -math.inf,
            -ACCURACY["deg"],
            "deg",
            claimed="below 0",
            of=first["efficiency"] - first["stability"],
        ),
        *both_ways(
            ("gaits chosen of A", family == "A"),
            ("up to 10 deg with headings below 0.125 rad", low & small),
            there,
            only=rule,
            there=rule,
        ),
        *both_ways(
            ("gaits chosen of FB", family == "FB"),
            ("up to 10 deg with headings from 0.125 rad", low & ~small),
            there,
            only=rule,
            there=rule,
        ),
        within(
            "heading at which A gives way to FB (mean)",
            mean(turn),
            0.125 - 0.05 * criteria.border / 2.5,
            0.15 + 0.05 * criteria.border / 2.5,
            "rad",
            claimed="about 0.15 rad (0.125)",
            of=turn,
        ),
    ]


def _first_slope_of_b(gaits: xr.Dataset) -> xr.DataArray:
    """For each heading, the least slope at which family B is selected."""
    return gaits["slope_deg"].where(exists(gaits) & (gaits["family"] == "B")).min("slope_deg")


def objectives(results: Results) -> list[Part]:
    """Claim 17: where the objectives agree on the gait, and where they conflict."""
    return by_both(results, _objectives)


def _objectives(optima: Optima) -> list[Part]:
    criteria = optima.criteria
    stable, efficient = (optima.families.sel(objective=name, drop=True) for name in OBJECTIVES)
    pulling = {"family": ["FB", "B"]}
    legs = xr.DataArray(list("FMB"), dims="leg", coords={"leg": list("FMB")})
    actuations, phases = (
        xr.concat([abs(of(efficient, leg) - of(stable, leg)).sel(pulling) for leg in "FMB"], legs)
        for of in (actuation, degrees)
    )
    level = [gaits.sel(family="A").where(gaits["slope_deg"] <= LOW_SLOPE) for gaits in (stable, efficient)]
    numbers = [
        near(f"median {words} of A up to 10 deg, for {goal}", median(gaits[name]), number, criteria, of=gaits[name])
        for gaits, goal, eigenvalue, cost in zip(level, OBJECTIVES, (0.3, 0.65), (1.2, 0.6), strict=True)
        for words, name, number in (
            ("eigenvalue", "reduced_eigenvalue", eigenvalue),
            ("cost", "transport_cost", cost),
        )
    ]
    middle = degrees(level[1], "M")
    same = "nearly the same"
    return [
        within(
            "median difference of actuations in FB and B",
            median(actuations),
            0.0,
            criteria.same_actuation,
            "l0",
            claimed=same,
            of=actuations,
        ),
        within(
            "median difference of phases there",
            median(phases),
            0.0,
            criteria.same_phase,
            "deg",
            claimed=same,
            of=phases,
        ),
        *numbers,
        within(
            "median phase of the middle legs there, for efficiency",
            median(middle),
            60.0,
            math.inf,
            "deg",
            claimed="very high",
            of=middle,
        ),
    ]


def same_eigenvalues(results: Results) -> list[Part]:
    """Claim 25: eigenvalues of FB and B under both objectives, and what the thesis shows without words."""
    pictures = "The thesis shows it as a picture, without numbers; ours is beside the one found with its search."
    return [
        *by_both(results, _same_eigenvalues),
        *(_where(results, family) for family in ("A", "FB", "MB")),
        unknown("efficiency: front phases (Figure 5.15)", "a picture", pictures, found=_front_phases(results)),
    ]


def _same_eigenvalues(optima: Optima) -> list[Part]:
    values = [optima.families["reduced_eigenvalue"].sel(objective=name, drop=True) for name in OBJECTIVES]
    parts = []
    for family in ("FB", "B"):
        change = abs(values[1] - values[0]).sel(family=family, drop=True)
        what = f"{family}: cells whose eigenvalues under the two objectives differ by up to {optima.criteria.ideal:g}"
        word = optima.criteria.as_a_rule
        parts.append(share(what, change <= optima.criteria.ideal + SAME, change.notnull(), word))
    return parts


def _where(results: Results, family: str) -> Part:
    """Say where a family exists, for either objective."""
    found = []
    for optima in results.searches:
        there = exists(optima.families.sel(family=family)).any("objective")
        slopes, headings = (there[name].values[there.any(other)] for name, other in zip(*PLACE, strict=True))
        if slopes.size:
            ranges = f"{slopes.min():g} to {slopes.max():g} deg, {headings.min():g} to {headings.max():g} rad"
            found.append(f"{int(there.sum())} cells, {ranges}")
    what, reason = f"where {family} exists (Figure 5.1)", "The thesis shows it as a picture, without numbers."
    return unknown(what, "a picture", reason, found="; by Nelder-Mead ".join(found) or "nowhere")


PLACE = (("slope_deg", "heading"), ("heading", "slope_deg"))


def _front_phases(results: Results) -> str:
    """Say what the front phases of efficient gaits are, by families."""
    found = []
    for family in ("A", "FB", "MB", "B"):
        phases = [degrees(optima.of("efficiency", family), "F") for optima in results.searches]
        ours, other = (median(values) for values in phases)
        found.append(f"{family} {ours:.0f} ({other:.0f}) deg")
    return f"medians (by Nelder-Mead): {', '.join(found)}"
