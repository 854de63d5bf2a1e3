"""Footfalls: when each leg is down."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from legspring.drawing.style import COLOURS, COLUMN, GRAY, PAGE, SMALL, new_figure, styled
from legspring.gait import Gait

STRIDES = 2
"""How much of a gait is drawn."""
ROOM, ROW, BAR = 1.0, 0.26, 0.6
"""Heights: of all but the legs, and of a leg, in inches; of a bar, in rows."""
WORDS = {"push": "pushes", "pull": "pulls"}
MOST_STRIDES = 3
"""Longest run that has the width of a column, in strides."""
JUST_DOWN = 1e-9
"""Stretch, by its length, below which a leg has just been put down."""

Span = tuple[float, float]


@styled
def draw_footfalls(run: Gait | xr.Dataset) -> Figure:
    """Draw a bar for each stance of each leg against time in strides, its colour for whether the leg pushes or pulls.

    A line marks each touch-down; the number beside the first one of a leg says when it was, in strides.

    Parameters
    ----------
    run
        A gait, of which two strides are drawn, or a simulation: the Dataset of `legspring.simulate`, or its file opened
        with xarray.
    """
    title = ""
    if isinstance(run, Gait):
        title, run = f"family {run.family}, ", run.simulate(strides=STRIDES)
    about, legs = run.attrs, [str(name) for name in run["leg"].values]
    strides = float(run["time"].values[-1]) / about["stride_duration"]
    figure = new_figure(COLUMN if strides <= MOST_STRIDES else PAGE, ROOM + ROW * len(legs))
    axes = figure.subplots()
    pairs = [str(pair) for pair in run["pairs"].values]
    functions = dict(zip(pairs, (str(function) for function in run["leg_function"].values), strict=True))
    colours = dict(zip(WORDS, COLOURS, strict=False))
    for row, (leg, pair) in enumerate(zip(legs, run["pair"].values, strict=True)):
        bars, touchdowns = footfalls(run, leg)
        _draw_leg(axes, row, bars, touchdowns, colours[functions[str(pair)]])
    axes.grid(axis="x", color=GRAY, linewidth=0.4, linestyle=":")
    axes.set_axisbelow(True)
    axes.set_yticks(range(len(legs)), legs)
    axes.set(xlabel="time (strides)", xlim=(0.0, strides), ylim=(len(legs) - 0.5, -0.8))
    used = [function for function in WORDS if function in functions.values()]
    handles = [Patch(color=colours[function], label=WORDS[function]) for function in used]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    figure.suptitle(f"{about['animal']}: {title}slope {about['slope_deg']:g} deg,\nheading {about['heading']:.4g} rad")
    return figure


def footfalls(run: xr.Dataset, leg: str) -> tuple[list[Span], list[float]]:
    """Return the start and end of a leg's stances in a simulation, and its touch-downs; in strides.

    A stance may begin before the simulation, and end after it; where a leg is put down anew, one follows another.
    """
    stride = run.attrs["stride_duration"]
    own = (run["event_leg"].values == leg) & (run["event_time"].values < run["time"].values[-1])
    begun = 0.0 if bool(run["stance"].sel(leg=leg).values[0]) else None
    # The start of a simulation is no event in it.
    first = run.isel(time=0).sel(leg=leg)
    length = float(first["leg_length"])
    touchdowns = [0.0] if abs(length - float(first["free_length"])) < JUST_DOWN * length else []
    bars = []
    for time, kind in zip(run["event_time"].values[own] / stride, run["event_kind"].values[own], strict=True):
        if begun is not None:
            bars.append((begun, float(time)))
        begun = float(time) if kind == "touch-down" else None
        touchdowns += [] if begun is None else [begun]
    if begun is not None:
        bars.append((begun, float(run["time"].values[-1]) / stride))
    return bars, touchdowns


def _draw_leg(axes: Axes, row: int, bars: Sequence[Span], touchdowns: Sequence[float], colour: str) -> None:
    starts = np.array([start for start, _ in bars])
    axes.barh(np.full(len(bars), row), [end - start for start, end in bars], BAR, starts, color=colour, linewidth=0.0)
    axes.vlines(touchdowns, row - 0.5 * BAR, row + 0.5 * BAR, color="black", linewidth=1.2, clip_on=False)
    for time in touchdowns[:1]:
        above, offset = (time, row - 0.5 * BAR), (1.5, 0.0)
        axes.annotate(f"{time:.2f}", above, offset, textcoords="offset points", va="bottom", fontsize=SMALL - 1)
