"""Chapter 6: peak forces, as measured and of the model."""

from functools import partial
from string import ascii_lowercase

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from legspring.drawing.style import COLOURS, GRAY, PAGE, label, new_figure, styled, units
from legspring.figures.maps import add_bar, add_legend, add_letters, draw_map, panel_grid
from legspring.peterson2011.figures.chapter4 import UNSTABLE
from legspring.peterson2011.figures.registry import NOT_UNIQUE, ThesisFigure
from legspring.peterson2011.tables import LEG_WORDS

FORCES, SUMS = (-1.0, 1.0), (-0.5, 2.0)
"""Ranges of colours, in units of m g."""
AXIS_WORDS = {"lateral": "lateral", "fore_aft": "fore-aft"}


@styled
def measured_ranges(forces: xr.Dataset, axis: str) -> Figure:
    """Draw the ranges of measured peak forces against slope, in a panel for each pair of legs.

    Parameters
    ----------
    forces
        Of `legspring.peterson2011.published.published_forces`.
    axis
        Direction of the force.
    """
    figure = new_figure(PAGE, 0.33 * PAGE)
    legs = [str(leg) for leg in forces["leg"].values]
    panels = figure.subplots(1, len(legs), sharex=True, sharey=True, squeeze=False)[0]
    slope = forces["slope_deg"].values
    for letter, axes, leg in zip(ascii_lowercase, panels, legs, strict=False):
        # A bar that ends at the border of a panel would look cut off.
        axes.use_sticky_edges = False
        ranges = forces["experiment"].sel(leg=leg, axis=axis)
        low, high = (ranges.sel(extreme=extreme).values for extreme in ("min", "max"))
        axes.axhline(0.0, color=GRAY, linewidth=0.6)
        axes.bar(slope, high - low, bottom=low, width=7.0, color=COLOURS[0], alpha=0.75)
        if not np.isfinite(low).any():
            words = "no numbers in\nTables 6.1 to 6.3"
            axes.text(0.5, 0.75, words, transform=axes.transAxes, ha="center", va="center", color=GRAY)
        axes.set(title=f"{letter}) {LEG_WORDS[leg]} legs", xlabel=label(forces["slope_deg"].attrs), xticks=slope)
    panels[0].set_ylabel(f"peak {AXIS_WORDS[axis]} force ({units('m g')})")
    return figure


@styled
def peak_forces(gaits: xr.Dataset, axis: str, objective: str | None = None) -> Figure:
    """Draw maps of the peak force of each pair of legs, and of the largest sum over all legs.

    Parameters
    ----------
    gaits
        An atlas, whose branch 0 is drawn, or the gaits selected for each objective.
    axis
        Direction of the force.
    objective
        Which of the selected gaits.
    """
    at = {"branch": 0} if objective is None else {"objective": objective}
    legs = [str(leg) for leg in gaits["leg"].values]
    figure, grid = panel_grid(1 + len(legs))
    panels = [
        ("peak_force", FORCES, f"{LEG_WORDS.get(leg, leg)} legs", f"peak {AXIS_WORDS[axis]} force", {"leg": leg})
        for leg in legs
    ]
    panels.append(("net_force_max", SUMS, "all legs", f"largest sum of {AXIS_WORDS[axis]} forces", {}))
    maps = []
    for axes, (name, limits, title, words, leg_at) in zip(grid, panels, strict=True):
        drawn = draw_map(axes, gaits, name, limits=limits, families=False, title=title, axis=axis, **at, **leg_at)
        maps.append(drawn._replace(words=f"{words} ({units('m g')})"))
        add_bar(figure, maps[-1:])
    add_letters(maps)
    add_legend(figure, maps)
    return figure


def _measured(number: str, axis: str) -> ThesisFigure:
    return ThesisFigure(
        number,
        "measured",
        partial(measured_ranges, axis=axis),
        f"Peak {AXIS_WORDS[axis]} forces as measured on cockroaches: from the least to the greatest, at each slope "
        "(from the thesis's Tables 6.1 to 6.3). Middle legs were measured on the level and "
        "the vertical only, and the tables give no numbers for them.",
    )


def _computed(number: int, axis: str, what: str, objective: str | None) -> ThesisFigure:
    return ThesisFigure(
        f"6.{number}",
        "atlas" if objective is None else "selected",
        partial(peak_forces, axis=axis, objective=objective),
        f"{what}: {AXIS_WORDS[axis]} force of front, middle and back legs, at its peak and with its sign, and the "
        "largest sum over all legs during a step. The sum's colours have a range of their own."
        + ("" if objective is None else f" {NOT_UNIQUE} {UNSTABLE}"),
    )


FIGURES = (
    _measured("6.1", "lateral"),
    _measured("6.2", "fore_aft"),
    *(
        _computed(first + number, axis, what, objective)
        for first, what, objective in (
            (3, "Fixed actuation", None),
            (5, "Optimised for stability, best family of each cell", "stability"),
            (7, "Optimised for efficiency, best family of each cell", "efficiency"),
        )
        for number, axis in enumerate(AXIS_WORDS)
    ),
)
