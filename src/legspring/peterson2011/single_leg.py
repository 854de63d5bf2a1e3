"""The model that the thesis starts from: one leg a step, which pushes or pulls, on slopes. A section of the report."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from legspring.atlases import atlas
from legspring.model import load_animal
from legspring.peterson2011.claims.chapter2 import SWITCH_DEG, steepest
from legspring.peterson2011.report import Section
from legspring.peterson2011.tables import Cell, Table

HEADINGS = (0.05, 0.10, 0.15, 0.20)
IMPULSES = (-0.5, 0.5)
FUNCTIONS = ("push", "pull")


class Variant(NamedTuple):
    """A leg that the source may have meant: nominal length (m), stiffness (N/m), and what they are those of."""

    words: str
    length: float
    stiffness: float


VARIANTS = (
    Variant("middle leg, stiffness of three", 0.026, 4.5),
    Variant("front leg, stiffness of three", 0.032, 4.5),
    Variant("back leg, stiffness of three", 0.019, 4.5),
    Variant("middle leg, half as stiff", 0.026, 2.25),
)


def map_single_legs(slopes_deg: Sequence[float], workers: int | None = None) -> xr.Dataset:
    """Find gaits of one leg over slope and heading; the angle at which it is put down is let go.

    Returns
    -------
    xarray.Dataset
        Over variant, function (push or pull), slope_deg and heading: ``max_multiplier``, ``T.angle`` (rad), ``phase``
        (rad), ``recovered`` (1 if the gait comes back from both impulses, 0 if not) and ``recovery_steps`` (the more of
        the two) of the most stable gait there; missing where there is none.
    """
    animal = load_animal("effective_leg")
    maps = []
    for variant in VARIANTS:
        length = variant.length
        maps.append(
            atlas(
                animal.replace(length=length, actuation=0.5 * length, stiffness=variant.stiffness),
                slopes_deg=slopes_deg,
                headings=HEADINGS,
                free=("T.angle",),
                impulses=IMPULSES,
                workers=workers,
            )
        )
    both = [xr.concat([_of_function(one, name) for name in FUNCTIONS], dim="function") for one in maps]
    found = xr.concat(both, dim="variant").assign_coords(
        variant=[variant.words for variant in VARIANTS], function=list(FUNCTIONS)
    )
    return found.assign_attrs(maps[0].attrs | {"title": "Gaits of one leg that pushes or pulls"})


def _of_function(gaits: xr.Dataset, name: str) -> xr.Dataset:
    """Return the most stable gaits of one function of the leg."""
    gaits = gaits.where(gaits["family"] == name)
    best = gaits.isel(branch=gaits["max_multiplier"].fillna(np.inf).argmin("branch")).drop_vars("branch")
    return xr.Dataset(
        {
            "max_multiplier": best["max_multiplier"],
            "T.angle": best["T.angle"],
            "phase": best["phase"].sel(leg="T", drop=True),
            "recovered": best["recovered"].min("impulse", skipna=False),
            "recovery_steps": best["recovery_steps"].max("impulse", skipna=False),
        }
    )


def section(legs: xr.Dataset) -> Section:
    """Write the section.

    Parameters
    ----------
    legs
        Of `map_single_legs`.
    """
    push = legs.sel(function="push")
    stable, robust = steepest(push["max_multiplier"] < 1.0), steepest(push["recovered"] == 1.0)
    rows: list[tuple[Cell, ...]] = []
    for variant in legs["variant"].values.tolist():
        for heading in legs["heading"].values.tolist():
            here = {"variant": variant, "heading": heading}
            level = [float(legs["max_multiplier"].sel(here | {"function": name})[0]) for name in FUNCTIONS]
            rows.append((variant, heading, *level, float(stable.sel(here)), float(robust.sel(here))))
    table = Table(
        "",
        "Gaits of one leg. The largest multiplier on the level, of a leg that pushes and of one that pulls, and the "
        "slopes up to which gaits that push are stable and come back from impulses of +-0.5.",
        (
            "leg",
            "heading_rad",
            "push_on_the_level",
            "pull_on_the_level",
            "push_is_stable_to_deg",
            "push_recovers_to_deg",
        ),
        tuple(rows),
    )
    low, high = (float(end) for end in (stable.min(), stable.max()))
    inside = (stable >= SWITCH_DEG[0]) & (stable <= SWITCH_DEG[1])
    pull = legs.sel(function="pull")["max_multiplier"]
    both = pull.notnull() & push["max_multiplier"].notnull()
    paragraphs = [
        "The thesis starts from a model with one actuated leg a step, of which it says that it does best by pushing on "
        "the level and by pulling on steep slopes, with the switch between 15 and 40 deg. Which legs that model had is "
        "left open there: their length, stiffness and actuation, where they are put down, and by which of the gaits "
        "stability was compared. Here the leg has the thesis's equations, speeds and step durations, an actuation of "
        "half its length, and lengths and stiffnesses of those of the six legs; the angle at which it is put down is "
        "an unknown, as in the appendix's programs.",
        f"A leg that pushes has gaits in {_share(push['max_multiplier'].notnull())} of all cells, on the level among "
        f"them, but stable ones only up to slopes of {low:g} to {high:g} deg, depending on heading and leg; in "
        f"{int(inside.sum())} of {inside.size} cases that end is between 15 and 40 deg. A leg that pulls has gaits in "
        f"{_share(pull.notnull())} of the cells, with multipliers up to {float(pull.max()):.2f}. So far this is as the "
        "thesis has it; but here pushing is not the better choice below, only one that works: the leg that pulls is "
        f"the more stable one in {_share((pull < push['max_multiplier']).where(both))} of the cells that have both.",
    ]
    return Section("One leg, before there were six", paragraphs, tables=[table])


def _share(true: xr.DataArray) -> str:
    return f"{float(true.mean()):.0%}"
