"""The claim of chapter 1 and 2: what was known before, of a model with one leg."""

import numpy as np
import xarray as xr

from legspring.peterson2011.claims.evidence import Part, Results, share, unknown

SWITCH_DEG = (15.0, 40.0)
"""Slopes between which the thesis has such a leg switch from pushing to pulling."""


def steepest(true: xr.DataArray) -> xr.DataArray:
    """Return the slope up to which something is so, midway to the next cell; missing if nowhere, or everywhere."""
    slopes = true["slope_deg"].values

    def end(row: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> float:
        places = np.flatnonzero(row)
        last = places[-1] if places.size else len(slopes)
        return float(0.5 * (slopes[last] + slopes[last + 1])) if last + 1 < len(slopes) else np.nan

    ends: xr.DataArray = xr.apply_ufunc(
        end, true, input_core_dims=[["slope_deg"]], vectorize=True, output_dtypes=[float]
    )
    return ends


def single_leg(results: Results) -> list[Part]:
    """Claim 27: up to which slope a pushing leg is stable and robust, and whether a pulling one is above."""
    legs, criteria = results.single_leg, results.criteria
    if legs is None:
        return [unknown("gaits of a single leg", "push, then pull", "They were not computed.")]
    push, pull = (legs.sel(function=name, drop=True) for name in ("push", "pull"))
    level, above = push.isel(slope_deg=0), pull["slope_deg"] > SWITCH_DEG[1]
    known, there = pull["max_multiplier"].notnull(), push["max_multiplier"].notnull().any("slope_deg")
    return [
        share(
            "legs and headings with a gait that pushes on the level",
            level["max_multiplier"].notnull(),
            xr.ones_like(level["max_multiplier"], dtype=bool),
            criteria.as_a_rule,
        ),
        *(
            share(
                f"legs and headings at which pushing gaits {what} up to a slope of 15 to 40 deg, and not above",
                (steepest(so) >= SWITCH_DEG[0]) & (steepest(so) <= SWITCH_DEG[1]),
                there,
                criteria.as_a_rule,
            )
            for what, so in (("are stable", push["max_multiplier"] < 1.0), ("recover", push["recovered"] == 1.0))
        ),
        share(
            "pulling gaits above 40 deg that are stable",
            pull["max_multiplier"] < 1.0,
            known & above,
            criteria.nearly_all,
        ),
        share("pulling gaits above 40 deg that recover", pull["recovered"] == 1.0, known & above, criteria.nearly_all),
        share(
            "legs and headings at which, on the level, pushing is more stable than pulling",
            level["max_multiplier"] < pull["max_multiplier"].isel(slope_deg=0),
            level["max_multiplier"].notnull(),
            criteria.as_a_rule,
            reason="On the level, a leg that pulls, on the other side of the body, is slightly more stable.",
        ),
    ]
