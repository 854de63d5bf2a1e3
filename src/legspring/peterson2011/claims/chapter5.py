"""The claims of chapter 5: gaits whose actuation is optimised for stability or for efficiency."""

import math

import numpy as np
import xarray as xr

from legspring.peterson2011.claims.chapter4 import back_legs
from legspring.peterson2011.claims.evidence import (
    FEW,
    LOW_SLOPE,
    MOST,
    NEARLY_ALL,
    SAME,
    STEEP_SLOPE,
    Optima,
    Part,
    Results,
    actuation,
    at,
    by_both,
    degrees,
    exists,
    grows,
    mean,
    near,
    share,
    turns,
    within,
)

HIGH_DEG = 45.0
"""Phase from which on it is high, deg: the search's soft limit is 60 deg."""
LIMIT = 0.88
"""Actuation, in units of the leg's length, that is as good as its limit of 0.9."""
LITTLE = 0.25
"""Actuation, in units of the leg's length, that is as little as possible: its limit is 0.2."""
IDEAL = 0.05
"""Eigenvalue below which stability is ideal."""
BORDER = 20.0
"""Slope from which on family B is selected, deg."""
SLIGHT = 0.2
"""Difference of actuations, in units of the leg's length, that is slight."""


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
    return [
        within("families that exist somewhere", float(somewhere.where(somewhere > 0)), 4.0, 4.0),
        share("cells with several families", count > 1, count > 0, FEW),
        within("greatest number of families in a cell", float(count.where(count > 0).max()), 3.0, 3.0),
        share("cells without family B that have a slope up to 5 deg", flat, missing, NEARLY_ALL),
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
    return [
        grows("front actuation with slope in B, up to 50 deg", front.where(front["slope_deg"] <= 50.0), "slope_deg"),
        within("slope at which it reaches its limit in B", _reach(front), 40.0, 60.0, "deg"),
        share(
            "gaits of A whose middle legs are actuated by up to 0.25 l0",
            actuation(gaits["A"], "M") <= LITTLE,
            all_push,
            MOST,
        ),
        grows("middle actuation with heading in FB and B", middle, "heading"),
        grows("back actuation with slope", back, "slope_deg"),
        grows("back actuation with heading in A and MB", back.sel(family=["A", "MB"]), "heading"),
    ]


def _reach(values: xr.DataArray) -> float:
    """Least slope at which the mean over headings is at its limit."""
    row = values.mean("heading")
    reached = row["slope_deg"].values[(row >= LIMIT).values]
    return float(reached[0]) if reached.size else math.nan if bool(row.isnull().all()) else math.inf


def stable_phase(results: Results) -> list[Part]:
    """Claim 11: phases of the gaits optimised for stability."""
    return by_both(results, _stable_phase)


def _stable_phase(optima: Optima) -> list[Part]:
    gaits = optima.families.sel(objective="stability")
    front, middle = gaits.sel(family=["A", "FB"]), gaits.sel(family="MB")
    back_only = gaits.sel(family="B")
    return [
        share(
            "gaits with pushing front legs whose front phase is from 45 deg",
            degrees(front, "F") >= HIGH_DEG,
            exists(front),
            MOST,
        ),
        share("gaits of MB whose middle phase is from 45 deg", degrees(middle, "M") >= HIGH_DEG, exists(middle), MOST),
        share(
            "gaits of B from 60 deg whose middle phase is from 45 deg",
            degrees(back_only, "M") >= HIGH_DEG,
            at(back_only, slope_deg=(STEEP_SLOPE, 90.0)),
            MOST,
        ),
        share("gaits whose back phase is negative", degrees(gaits, "B") < 0.0, exists(gaits), NEARLY_ALL),
    ]


def stability(results: Results) -> list[Part]:
    """Claim 12: eigenvalues of the gaits optimised for stability."""
    return by_both(results, _stability)


def _stability(optima: Optima) -> list[Part]:
    gaits = optima.families.sel(objective="stability")
    value, pulling = gaits["reduced_eigenvalue"], gaits.sel(family=["MB", "B"])
    higher = at(pulling, slope_deg=(BORDER, 90.0))
    artefact = "The thesis's map leaves out the legs that are still down."
    return [
        share("gaits that are stable by the thesis's map", value < 1.0, exists(gaits), 1.0),
        share(
            "gaits of MB and B from 20 deg with an eigenvalue up to 0.05",
            pulling["reduced_eigenvalue"] <= IDEAL,
            higher,
            MOST,
        ),
        share("the same by the complete map", pulling["max_multiplier"] <= IDEAL, higher, MOST, reason=artefact),
        grows("eigenvalue of A with heading", value.sel(family="A"), "heading"),
        grows("eigenvalue of FB with heading", value.sel(family="FB"), "heading", falls=True),
    ]


def stable_families(results: Results) -> list[Part]:
    """Claim 13: the most stable family over slope and heading."""
    return by_both(results, _stable_families)


def _stable_families(optima: Optima) -> list[Part]:
    gaits = optima.best("stability")
    family, below = gaits["family"], gaits["slope_deg"] < BORDER
    low, high = gaits["heading"] < 0.2 - 1e-9, gaits["heading"] > 0.2 - 1e-9
    return [
        share("cells from 20 deg in which B is selected", family == "B", exists(gaits) & ~below, NEARLY_ALL),
        share("cells below 20 deg and 0.20 rad in which A is", family == "A", exists(gaits) & below & low, MOST),
        share("cells below 20 deg, from 0.20 rad, in which FB is", family == "FB", exists(gaits) & below & high, MOST),
        share("cells in which MB is", family == "MB", exists(gaits), most=FEW),
    ]


def efficient_gaits(results: Results) -> list[Part]:
    """Claim 14: actuations for efficiency against those for stability, cell by cell, and the middle phase."""
    return by_both(results, _efficient_gaits)


def _efficient_gaits(optima: Optima) -> list[Part]:
    stable, efficient = (optima.families.sel(objective=name, drop=True) for name in ("stability", "efficiency"))
    front, back = (mean(actuation(efficient, leg) - actuation(stable, leg)) for leg in "FB")
    middle = efficient.sel(family=["A", "MB"])
    return [
        within("mean change of the front actuation", front, SAME, SLIGHT, "l0"),
        within("mean change of the back actuation", back, -SLIGHT, -SAME, "l0"),
        share(
            "gaits with pushing middle legs whose middle phase is from 45 deg",
            degrees(middle, "M") >= HIGH_DEG,
            exists(middle),
            MOST,
        ),
    ]


def efficiency(results: Results) -> list[Part]:
    """Claim 15: costs of the gaits optimised for efficiency."""
    return by_both(results, _efficiency)


def _efficiency(optima: Optima) -> list[Part]:
    gaits = optima.families.sel(objective="efficiency")
    cost = gaits["transport_cost"]
    excess = cost - np.sin(np.deg2rad(gaits["slope_deg"]))
    back_only, middle, front = (cost.sel(family=name, drop=True) for name in ("B", "A", "FB"))
    front_too = cost.sel(family=["A", "FB"])
    return [
        share(
            "gaits of B that cost sin(slope) to 0.001",
            abs(excess.sel(family="B")) <= SAME,
            back_only.notnull(),
            NEARLY_ALL,
        ),
        within("mean cost of MB beyond that", mean(excess.sel(family="MB")), -SAME, 0.05),
        grows("cost of A and FB with slope", front_too, "slope_deg"),
        grows("cost of A and FB with heading", front_too, "heading"),
        share(
            "cells with both in which FB is cheaper than A", front < middle, front.notnull() & middle.notnull(), MOST
        ),
    ]


def efficient_families(results: Results) -> list[Part]:
    """Claim 16: the cheapest family over slope and heading, and its borders."""
    return by_both(results, _efficient_families)


def _efficient_families(optima: Optima) -> list[Part]:
    gaits = optima.best("efficiency")
    family, there = gaits["family"], exists(gaits)
    border = {name: mean(_first_slope_of_b(optima.best(name))) for name in ("stability", "efficiency")}
    turn = turns(family == "A", there & family.isin(["A", "FB"]), "heading")
    low = there & (gaits["slope_deg"] <= LOW_SLOPE)
    return [
        share(
            "cells from 20 deg in which B is selected",
            family == "B",
            there & (gaits["slope_deg"] >= BORDER),
            NEARLY_ALL,
        ),
        within(
            "mean slope from which on B is selected, to be less than for stability",
            border["efficiency"],
            0.0,
            border["stability"] - 1e-9,
            "deg",
        ),
        share(
            "cells up to 10 deg with headings from 0.20 rad in which FB is",
            family == "FB",
            low & (gaits["heading"] >= 0.2 - 1e-9),
            MOST,
        ),
        within("heading at which A gives way to FB (mean)", mean(turn), 0.1, 0.175, "rad"),
    ]


def _first_slope_of_b(gaits: xr.Dataset) -> xr.DataArray:
    """For each heading, the least slope at which family B is selected."""
    return gaits["slope_deg"].where(exists(gaits) & (gaits["family"] == "B")).min("slope_deg")


def objectives(results: Results) -> list[Part]:
    """Claim 17: where the objectives agree on the gait, and where they conflict."""
    return by_both(results, _objectives)


def _objectives(optima: Optima) -> list[Part]:
    stable, efficient = (optima.families.sel(objective=name, drop=True) for name in ("stability", "efficiency"))
    pulling = {"family": ["FB", "B"]}
    actuations = [abs(actuation(efficient, leg) - actuation(stable, leg)).sel(pulling) for leg in "FMB"]
    phases = [abs(degrees(efficient, leg) - degrees(stable, leg)).sel(pulling) for leg in "FMB"]
    level = [gaits.sel(family="A").where(gaits["slope_deg"] <= LOW_SLOPE) for gaits in (stable, efficient)]
    return [
        within("median difference of actuations in FB and B", _median(*actuations), 0.0, 0.05, "l0"),
        within("median difference of phases there", _median(*phases), 0.0, 10.0, "deg"),
        near("median eigenvalue of A up to 10 deg, for stability", _median(level[0]["reduced_eigenvalue"]), 0.3),
        near("median cost there, for stability", _median(level[0]["transport_cost"]), 1.2),
        near("median eigenvalue there, for efficiency", _median(level[1]["reduced_eigenvalue"]), 0.65),
        near("median cost there, for efficiency", _median(level[1]["transport_cost"]), 0.6),
        within(
            "median phase of the middle legs there, for efficiency",
            _median(degrees(level[1], "M")),
            60.0,
            math.inf,
            "deg",
        ),
    ]


def _median(*values: xr.DataArray) -> float:
    """Median of all known values; nan if there are none."""
    numbers = np.concatenate([array.values.ravel() for array in values])
    known = numbers[np.isfinite(numbers)]
    return float(np.median(known)) if known.size else math.nan
