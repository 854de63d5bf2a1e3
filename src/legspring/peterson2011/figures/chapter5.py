"""Chapter 5: gaits with the actuation that is best for stability or for efficiency."""

import json
from functools import partial
from itertools import count
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from legspring.drawing.style import COLOURS, MARKERS, PAGE, label, new_figure, styled
from legspring.figures.maps import NEUTRAL, Limits, draw_atlas, draw_panels, edges, family_order
from legspring.peterson2011.figures.chapter4 import COSTS, EIGENVALUES, PHASES, UNSTABLE
from legspring.peterson2011.figures.registry import FAMILY_WORDS, NOT_UNIQUE, ThesisFigure
from legspring.peterson2011.tables import LEG_WORDS

ACTUATIONS = (0.2, 0.9)
"""Range of the actuation that the objective allows, in units of the nominal length."""


@styled
def existence(optima: xr.Dataset) -> Figure:
    """Mark the families that have an optimised gait in each cell, for either objective.

    Parameters
    ----------
    optima
        Gaits over objective, slope, heading and family.
    """
    objectives = [str(objective) for objective in optima["objective"].values]
    families = family_order(optima)
    figure = new_figure(PAGE, 0.42 * PAGE)
    panels = figure.subplots(1, len(objectives), sharex=True, sharey=True, squeeze=False)[0]
    slope, heading = optima["slope_deg"].values, optima["heading"].values
    # Each family has a place of its own in the cell.
    across, up = (0.23 * float(np.diff(edges(values)[:2])[0]) for values in (slope, heading))
    for axes, objective in zip(panels, objectives, strict=True):
        for number, family in enumerate(families):
            gaits = optima.sel(objective=objective, family=family).transpose("slope_deg", "heading", ...)
            unstable = gaits["max_multiplier"].values > 1.0 + NEUTRAL
            look: dict[str, Any] = {"marker": MARKERS[number], "color": COLOURS[number], "markersize": 3.5}
            stable = gaits["speed"].notnull().values & ~unstable
            for cells, face, words in ((stable, COLOURS[number], family), (unstable, "white", f"_{family}, unstable")):
                rows, columns = np.nonzero(cells)
                axes.plot(
                    slope[rows] + (across if number % 2 else -across),
                    heading[columns] + (up if number < 2 else -up),
                    linestyle="none",
                    markerfacecolor=face,
                    markeredgewidth=0.6,
                    label=words,
                    **look,
                )
        axes.set_xticks(edges(slope), minor=True)
        axes.set_yticks(edges(heading), minor=True)
        axes.grid(which="minor", color="0.9", linewidth=0.4)
        axes.set(title=objective, xlabel=label(optima["slope_deg"].attrs), ylabel=label(optima["heading"].attrs))
        axes.set(xlim=edges(slope)[[0, -1]], ylim=edges(heading)[[0, -1]])
        axes.label_outer()
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=len(families))
    return figure


def by_family(optima: xr.Dataset, name: str, objective: str, limits: Limits, **at: Any) -> Figure:
    """Draw a map of a variable for each family.

    Parameters
    ----------
    optima
        Gaits over objective, slope, heading and family.
    name
        The variable; actuation is shown in units of the legs' nominal lengths.
    objective
        What is optimal.
    limits
        Range of colours.
    **at
        The leg, for variables that have one.
    """
    if name == "actuation":
        optima = optima.assign(actuation=in_lengths(optima))
    places = [{"objective": objective, "family": family, **at} for family in family_order(optima)]
    return draw_panels(optima, name, places, limits=limits)


def in_lengths(gaits: xr.Dataset) -> xr.DataArray:
    """Return the actuation in units of each leg's nominal length."""
    lengths = {leg["pair"]: leg["length"] for leg in json.loads(gaits.attrs["parameters"])["legs"]}
    nominal = xr.DataArray([lengths[str(leg)] for leg in gaits["leg"].values], coords={"leg": gaits["leg"]})
    return (gaits["actuation"] / nominal).assign_attrs(long_name="actuation", units="l0")


Quantity = tuple[str, Limits, str]
"""A variable, its range of colours, and what a caption says about it."""
OF_LEGS: tuple[Quantity, ...] = (
    (
        "actuation",
        ACTUATIONS,
        "actuation of the {leg} legs in units of their nominal length l0, for each family. The colours span what is "
        "allowed, so that gaits at either limit, 0.2 l0 and 0.9 l0, stand out.",
    ),
    (
        "phase",
        PHASES,
        "phase of the {leg} legs, for each family. The larger it is, the later in their cycle they touch down: high "
        "phases mean short and weak stances. The objective resists phases above 60 deg.",
    ),
)
EIGENVALUE: Quantity = (
    "reduced_eigenvalue",
    EIGENVALUES,
    "largest eigenvalue magnitude of the map of speed and heading",
)
COST: Quantity = ("transport_cost", COSTS, "transport cost, which is at least the sine of the slope")


def _figures(objective: str, first: int, *quantities: Quantity) -> list[ThesisFigure]:
    """Return the figures of one objective: of each pair of legs, and of the quantities."""
    numbers = (f"5.{number}" for number in count(first))
    head = f"Optimised for {objective}"
    figures = []
    for name, limits, words in OF_LEGS:
        for leg, where in LEG_WORDS.items():
            draw = partial(by_family, name=name, objective=objective, limits=limits, leg=leg)
            figures.append(
                ThesisFigure(
                    next(numbers), "optima", draw, f"{head}: {words.format(leg=where)} {NOT_UNIQUE} {UNSTABLE}"
                )
            )
    for name, limits, words in quantities:
        draw_all = partial(by_family, name=name, objective=objective, limits=limits)
        draw_best = partial(draw_atlas, name=name, objective=objective, limits=limits)
        best = f"{head}: {words}; the best family of each cell, which the markers tell. {UNSTABLE}"
        figures.append(ThesisFigure(next(numbers), "optima", draw_all, f"{head}: {words}; each family. {UNSTABLE}"))
        figures.append(ThesisFigure(next(numbers), "selected", draw_best, best))
    return figures


FIGURES = (
    ThesisFigure(
        "5.1",
        "optima",
        existence,
        f"Where there is a gait with optimised actuation, by family ({FAMILY_WORDS}). Each family has its own corner "
        "of a cell, so that all that exist there can be seen. Gaits that are unstable by the complete map are hollow.",
    ),
    *_figures("stability", 2, EIGENVALUE, COST),
    *_figures("efficiency", 12, COST, EIGENVALUE),
)
