"""Figures of a run against time: its motion and the lengths of its legs, and its energy."""

from collections.abc import Mapping
from typing import Literal

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import ArrayLike, NDArray

from legspring.checks import shown
from legspring.drawing.style import COLOURS, GRAY, PAGE, new_figure, styled
from legspring.figures.runs import axis_names, length_unit
from legspring.gait import Gait
from legspring.measures.robustness import Recovery

STRIDES = 2
"""How much of a gait is drawn."""
ROW, ROOM = 1.15, 0.75
"""Heights of a panel, and of all but the panels, in inches."""
PREFIXES = ((1.0, "J"), (1e3, "mJ"), (1e6, "µJ"), (1e9, "nJ"))
LENGTHS: Mapping[str, Literal["-", "--"]] = {"actual": "-", "force-free": "--"}
LEAST = 1e-3
"""Share of the greatest energy below which there is nothing to be seen."""
ROUNDING = 1e-9
"""Moment, by mass and length of the legs in SI units, that is none."""
HELD = {"kinetic": "kinetic_energy", "height": "potential_energy"}
"""What is drawn of the energy that the body has."""


def _run_of(run: Gait | Recovery | xr.Dataset) -> tuple[xr.Dataset, str]:
    """Return what is drawn, and a title."""
    family = ""
    if isinstance(run, Gait):
        family, run = f"family {run.family}, ", run.simulate(strides=STRIDES)
    elif isinstance(run, Recovery):
        run = run.simulate()
    if not isinstance(run, xr.Dataset) or "energy_balance" not in run:
        raise ValueError(f"run = {shown(run)}: must be a gait, a recovery, or the Dataset of a simulation")
    about = run.attrs
    place = f"slope {about['slope_deg']:g} deg, heading {about['heading']:.4g} rad, speed {about['speed']:.4g} m/s"
    return run, f"{about['animal']}: {family}{place}"


@styled
def draw_motion(run: Gait | Recovery | xr.Dataset) -> Figure:
    """Draw a run against time: place, yaw and moment of the body, and the legs' lengths, actual and force-free.

    Parameters
    ----------
    run
        A gait, of which two strides are drawn, a recovery, or a simulation: the Dataset of `legspring.simulate`, or its
        file opened with xarray.

    Raises
    ------
    ValueError
        For anything else.
    """
    run, title = _run_of(run)
    pairs = [str(pair) for pair in run["pairs"].values]
    figure = new_figure(PAGE, ROOM + ROW * max(4, len(pairs)))
    halves = figure.add_gridspec(1, 2)
    rows = halves[0].subgridspec(4, 1)
    panels = [figure.add_subplot(rows[row]) for row in range(4)]
    unit, words = length_unit(run)
    for axes, name, place in zip(panels[:2], axis_names(run), run["position"].values.T, strict=True):
        _draw(axes, run, unit * place, f"{name}\n({words})")
    _draw(panels[2], run, np.degrees(run["yaw"]), "yaw (deg)")
    # Of forces through the centre of mass there is but rounding.
    moment, scale = run["moment"].values, float(run["leg_length"].max()) * run.attrs["mass"]
    _draw(panels[3], run, np.where(np.abs(moment) > ROUNDING * scale, moment, 0.0), "moment\n(N m)")
    panels[3].ticklabel_format(axis="y", scilimits=(-3, 3))
    rows = halves[1].subgridspec(len(pairs), 1)
    lengths = [figure.add_subplot(rows[row]) for row in range(len(pairs))]
    for axes, pair in zip(lengths, pairs, strict=True):
        _draw_lengths(axes, run.sel(leg=run["pair"] == pair), unit)
        axes.set_ylabel(f"length ({words})" if len(pairs) < 6 else words)
    for column in (panels, lengths):
        for axes in column[:-1]:
            axes.sharex(column[-1])
            axes.tick_params(labelbottom=False)
        column[-1].set_xlabel("time (ms)")
    looks = [Line2D([], [], color="black", linestyle=dashes, label=name) for name, dashes in LENGTHS.items()]
    figure.legend(handles=looks, loc="outside lower right", ncols=2)
    figure.suptitle(title)
    return figure


def _draw(axes: Axes, run: xr.Dataset, values: ArrayLike, words: str) -> None:
    axes.plot(1e3 * run["time"].values, np.asarray(values), color="black")
    axes.set(ylabel=words, xlim=(0.0, 1e3 * float(run["time"][-1])))


def _draw_lengths(axes: Axes, legs: xr.Dataset, unit: float) -> None:
    """Draw the lengths of a pair of legs while they are down."""
    time = 1e3 * legs["time"].values
    for colour, leg in zip(COLOURS, legs["leg"].values, strict=False):
        for (name, dashes), kind in zip(LENGTHS.items(), ("leg_length", "free_length"), strict=True):
            label = str(leg) if name == "actual" else None
            axes.plot(time, unit * legs[kind].sel(leg=leg), dashes, color=colour, label=label)
    axes.set_xlim(0.0, time[-1])
    # Above the lines, whatever they do.
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.1, ncols=2)


@styled
def draw_energy(run: Gait | Recovery | xr.Dataset) -> Figure:
    """Draw the energy of a run against time: what body and springs have, and the work that it comes from.

    Parameters
    ----------
    run
        A gait, of which two strides are drawn, a recovery, or a simulation: the Dataset of `legspring.simulate`, or its
        file opened with xarray.

    Raises
    ------
    ValueError
        For anything else.
    """
    run, title = _run_of(run)
    springs, actuation = run["spring_energy"], run["actuation_work"]
    held = {words: run[name].values for words, name in HELD.items()} | {"springs": springs.sum("leg").values}
    total = np.sum(list(held.values()), axis=0)
    work = {"actuation": actuation.sum("leg").values, "lost": -run["lost_energy"].values}
    greatest = max(float(np.max(np.abs(values))) for values in (*held.values(), total))
    factor, unit = next((each for each in PREFIXES if greatest * each[0] >= 1.0), PREFIXES[-1])
    work = {words: values for words, values in work.items() if np.max(np.abs(values)) > LEAST * greatest}
    if "push_work" in run:
        work["push"] = run["push_work"].values
    figure = new_figure(PAGE, ROOM + 3.2 * ROW)
    panels = figure.subplots(2, 2, sharex=True)
    change = total - total[0]
    panels[0, 1].plot(1e3 * run["time"].values, factor * change, color="0.75", linewidth=3.0, label="all")
    stiffness = {str(leg): springs.sel(leg=leg).values for leg in springs["leg"].values}
    actuated = {str(leg): actuation.sel(leg=leg).values for leg in actuation["leg"].values}
    for axes, values, words in (
        (panels[0, 0], held | {"all": total}, "a) energy"),
        (panels[0, 1], work, "b) its change, and work"),
        (panels[1, 0], stiffness, "c) in the springs"),
        (panels[1, 1], actuated, "d) work of the actuation"),
    ):
        _lines(axes, run, values, factor)
        axes.set_title(f"{words} ({unit})")
        _widen(axes, LEAST * factor * greatest)
    for axes in panels[0]:
        axes.legend(loc="best", ncols=2, frameon=True, framealpha=0.75, edgecolor="none")
    for axes in panels[1]:
        axes.set_xlabel("time (ms)")
    handles, names = panels[1, 0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=min(len(names), 7))
    error = float(np.max(np.abs(run["energy_balance"])))
    figure.suptitle(f"{title}\nunaccounted for: {factor * error:.1g} {unit} at most")
    return figure


def _widen(axes: Axes, least: float) -> None:
    """Keep what is but noise from filling the panel."""
    low, high = axes.get_ylim()
    if high - low < least:
        middle = 0.5 * (low + high)
        axes.set_ylim(middle - 0.5 * least, middle + 0.5 * least)


def _lines(axes: Axes, run: xr.Dataset, values: Mapping[str, NDArray[np.float64]], factor: float) -> None:
    time = 1e3 * run["time"].values
    for number, (words, line) in enumerate(values.items()):
        dashes = "--" if number >= len(COLOURS) else "-"
        axes.plot(time, factor * line, dashes, color=COLOURS[number % len(COLOURS)], label=words)
    axes.axhline(0.0, color=GRAY, linewidth=0.4)
    axes.set_xlim(0.0, time[-1])
