"""Every family for itself: gaits with fixed and with optimised actuation, family by family."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import xarray as xr
from matplotlib.figure import Figure

from legspring.drawing.style import PAGE, label, new_figure, styled, units
from legspring.figures.maps import Limits, add_legend, add_letters, draw_map, family_order
from legspring.peterson2011.figures.chapter4 import COSTS, EIGENVALUES, PHASES, STEPS, UNSTABLE
from legspring.peterson2011.figures.chapter6 import AXIS_WORDS, FORCES, SUMS
from legspring.peterson2011.figures.registry import FAMILY_WORDS, Source, ThesisFigure
from legspring.peterson2011.tables import LEG_WORDS

SPEEDS = (0.0, 0.4)
IMPULSE, HEADING = 0.5, 0.15


class Column(NamedTuple):
    """A column of maps: variable, place in its other dimensions, title, range of colours, and what these mean."""

    name: str
    at: Mapping[str, Any]
    title: str
    limits: Limits
    words: str


def of_families(atlas: xr.Dataset) -> xr.Dataset:
    """Return the first gait of each family in each cell of an atlas, over ``family`` in place of branches."""
    families = family_order(atlas)
    chosen = []
    for family in families:
        there = atlas["family"] == family
        first = atlas.isel(branch=there.argmax("branch")).drop_vars(["branch", "family"])
        chosen.append(first.where(there.any("branch")))
    return xr.concat(chosen, dim="family").assign_coords(family=families).assign_attrs(atlas.attrs)


@styled
def matrix(gaits: xr.Dataset, columns: Sequence[Column], at: Mapping[str, Any] | None = None) -> Figure:
    """Draw maps, a row for each family; neighbouring columns in the same colours share a bar.

    Parameters
    ----------
    gaits
        Over slope, heading and family.
    columns
        What is drawn.
    at
        Where all maps lie in further dimensions, such as objective.
    """
    families = family_order(gaits)
    figure = new_figure(PAGE, 0.23 * PAGE * len(families) + 0.5)
    panels = figure.subplots(len(families), len(columns), sharex=True, sharey=True, squeeze=False)
    maps = []
    for column, axes_of_column in zip(columns, panels.T, strict=True):
        for family, axes in zip(families, axes_of_column, strict=True):
            place = {**(at or {}), **column.at, "family": family}
            title = f"{family}: {column.title}"
            maps.append(draw_map(axes, gaits, column.name, limits=column.limits, families=False, title=title, **place))
    starts = [n for n, column in enumerate(columns) if n == 0 or column.words != columns[n - 1].words]
    for start, end in zip(starts, [*starts[1:], len(columns)], strict=True):
        drawn = maps[start * len(families)].mesh
        beyond = panels[:, start:end].ravel().tolist()
        # What has one sign has nothing below its range.
        extend = "both" if columns[start].limits[0] < 0.0 else "max"
        figure.colorbar(drawn, ax=beyond, location="bottom", label=columns[start].words, extend=extend, pad=0.02)
    add_legend(figure, maps)
    return figure


def force_columns(axis: str) -> tuple[Column, ...]:
    """Return the peak forces of each pair of legs along an axis, and the largest sum."""
    words = f"{AXIS_WORDS[axis]} force ({units('m g')})"
    legs = (
        Column("peak_force", {"leg": leg, "axis": axis}, f"{name} legs", FORCES, f"peak {words}")
        for leg, name in LEG_WORDS.items()
    )
    return (*legs, Column("net_force_max", {"axis": axis}, "all legs", SUMS, f"largest sum ({units('m g')})"))


MEASURED = (
    Column("speed", {}, "speed", SPEEDS, "speed (m/s)"),
    Column("reduced_eigenvalue", {}, "eigenvalue", EIGENVALUES, "largest eigenvalue"),
    Column("recovery_steps", {"impulse": IMPULSE}, "recovery", STEPS, "steps to recover"),
    Column("transport_cost", {}, "cost", COSTS, "transport cost"),
)
PHASE_COLUMNS = tuple(
    Column("phase", {"leg": leg}, f"{name} legs", PHASES, "phase (deg)") for leg, name in LEG_WORDS.items()
)
BY_OBJECTIVE = tuple(
    Column("recovery_steps", {"impulse": IMPULSE, "objective": goal}, goal, STEPS, "steps to recover")
    for goal in ("stability", "efficiency")
)

ACTUATIONS: tuple[tuple[str, Source, Mapping[str, Any], str], ...] = (
    ("fixed", "families", {}, "Fixed actuation"),
    ("stability", "optima", {"objective": "stability"}, "Optimised for stability"),
    ("efficiency", "optima", {"objective": "efficiency"}, "Optimised for efficiency"),
)


@styled
def recovery_of_best(selected: xr.Dataset) -> Figure:
    """Draw the steps to recover of the best gaits of each cell: over the grid, and over impulses at 0.15 rad."""
    figure = new_figure(PAGE, 0.74 * PAGE)
    panels = figure.subplots(2, 2, sharex=True)
    maps = []
    for (over_headings, over_impulses), goal in zip(panels, ("stability", "efficiency"), strict=True):
        gaits = selected.sel(objective=goal)
        title = f"{goal}, impulse {IMPULSE:g}"
        maps.append(draw_map(over_headings, gaits, "recovery_steps", limits=STEPS, title=title, impulse=IMPULSE))
        here, title = gaits.sel(heading=HEADING), f"{goal}, heading {HEADING:g} rad"
        maps.append(
            draw_map(over_impulses, here, "recovery_steps", y="impulse", limits=STEPS, families=False, title=title)
        )
        # Not the quantity of the panel beside it, as in other figures.
        over_impulses.set_ylabel(label(here["impulse"].attrs))
        over_impulses.tick_params(labelleft=True)
    add_letters(maps)
    figure.colorbar(maps[0].mesh, ax=panels.ravel().tolist(), label="steps to recover", extend="max", pad=0.02)
    add_legend(figure, maps)
    return figure


def _figure(name: str, source: Source, draw: Callable[..., Figure], words: str) -> ThesisFigure:
    return ThesisFigure(f"families_{name}", source, draw, f"{words} {UNSTABLE}")


FAMILY_FIGURES = (
    _figure(
        "fixed",
        "families",
        partial(matrix, columns=MEASURED),
        f"Fixed actuation, every family for itself ({FAMILY_WORDS}), whichever of a cell's gaits it is: initial speed, "
        "largest eigenvalue, steps to recover from an impulse of 0.5, and transport cost.",
    ),
    _figure(
        "fixed_phases",
        "families",
        partial(matrix, columns=PHASE_COLUMNS),
        "Fixed actuation, every family for itself: phases of front, middle and back legs.",
    ),
    *(
        _figure(
            f"forces_{axis}_{actuation}",
            source,
            partial(matrix, columns=force_columns(axis), at=at),
            f"{words}, every family for itself: {AXIS_WORDS[axis]} force of front, middle and back legs at its peak, "
            "and the largest sum over all legs.",
        )
        for actuation, source, at, words in ACTUATIONS
        for axis in AXIS_WORDS
    ),
    _figure(
        "recovery",
        "optima",
        partial(matrix, columns=BY_OBJECTIVE),
        "Robustness of gaits with optimised actuation, every family for itself: steps to recover from an impulse of "
        "0.5, of those optimised for stability and for efficiency. Gaits that never recover are crossed.",
    ),
    _figure(
        "recovery_of_best",
        "selected",
        recovery_of_best,
        "Robustness of the best family of each cell, for stability (above) and efficiency (below): steps to recover "
        "from an impulse of 0.5, and from impulses of all sizes at a heading of 0.15 rad. Gaits that never recover are "
        "crossed.",
    ),
)
