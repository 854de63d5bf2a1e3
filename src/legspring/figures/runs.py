"""Figures of single runs: a gait, a simulation, a recovery."""

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from legspring.drawing.style import COLOURS, COLUMN, GRAY, PAGE, new_figure, styled, units
from legspring.gait import Gait
from legspring.measures.robustness import BACK, SURELY_BACK, Recovery

Floats = NDArray[np.float64]

INSTANTS = 5
"""How often a gait's legs are drawn in a stride, its two ends among them."""
LEAST_DISTANCE = 1e-6
"""Smallest distance from a gait that is shown."""


@styled
def draw_gait(gait: Gait) -> Figure:
    """Draw a stride of a gait: from above, with the legs at some instants, and the forces of the legs against time.

    Parameters
    ----------
    gait
        The gait.
    """
    run = gait.simulate(strides=1)
    figure, above = _draw_run(run)
    _draw_legs(above, run, np.array([leg.hip for leg in gait.animal.legs]))
    angles = (f"{pair} {math.degrees(phase):.1f}" for pair, phase in zip(gait.animal.pairs, gait.phase, strict=True))
    phases = f", phases {', '.join(angles)} deg" if any(gait.actuation) else ""
    figure.suptitle(
        f"{gait.animal.name}: family {gait.family}, slope {gait.slope_deg:g} deg, heading {gait.heading:.4g} rad, "
        f"speed {gait.speed:.4g} m/s{phases}"
    )
    return figure


@styled
def draw_simulation(dataset: xr.Dataset) -> Figure:
    """Draw a simulation: the path and the footholds from above, velocity, forces and stances against time.

    Parameters
    ----------
    dataset
        Of `legspring.simulate`, or its file opened with xarray.
    """
    figure, _ = _draw_run(dataset)
    about = dataset.attrs
    figure.suptitle(
        f"{about['animal']}: slope {about['slope_deg']:g} deg, start at heading {about['heading']:.4g} rad, "
        f"speed {about['speed']:.4g} m/s"
    )
    return figure


@styled
def draw_recovery(recovery: Recovery) -> Figure:
    """Draw the distance from the gait at the end of each step after a push, with the thresholds of being back.

    Parameters
    ----------
    recovery
        Of `legspring.Gait.recover`.
    """
    figure = new_figure(COLUMN, 0.7 * COLUMN)
    axes = figure.subplots()
    steps = np.arange(1, len(recovery.distance))
    axes.semilogy(steps, recovery.distance[1:], ".-", color=COLOURS[0], linewidth=0.6)
    for threshold, line, words in ((BACK, "--", "1 %"), (SURELY_BACK, ":", "0.1 %")):
        axes.axhline(threshold, linestyle=line, color=GRAY)
        axes.text(1.0, threshold, words, transform=axes.get_yaxis_transform(), ha="right", va="bottom")
    outcome = "settled on another gait" if recovery.other_gait else "not back"
    if recovery.steps is not None:
        outcome = f"back after {recovery.steps} steps"
        axes.plot(recovery.steps, recovery.distance[recovery.steps], "o", color=COLOURS[1])
    # Further down there is but rounding.
    axes.set_ylim(bottom=min(LEAST_DISTANCE, 0.1 * np.nanmax(recovery.distance) or LEAST_DISTANCE))
    axes.set(xlabel="step", ylabel="distance from the gait", xlim=(0, len(recovery.distance)))
    axes.set_title(f"impulse {recovery.impulse:g} {units('m v_des')}: {outcome}")
    return figure


def _draw_run(run: xr.Dataset) -> tuple[Figure, Axes]:
    """Draw what a gait and a simulation have in common; return the figure and its view from above."""
    figure = new_figure(PAGE, 0.72 * PAGE)
    axes = [str(name) for name in run["axis"].values]
    names = ["velocity", *axes, "stance"]
    panels = figure.subplot_mosaic([["above", name] for name in names], width_ratios=(1.0, 1.5))
    legs = [str(leg) for leg in run["leg"].values]
    colours = [COLOURS[number % len(COLOURS)] for number in range(len(legs))]
    _draw_path(panels["above"], run, colours)
    _draw_velocity(panels["velocity"], run)
    for axis in axes:
        _draw_forces(panels[axis], run, axis, colours)
    _draw_stances(panels["stance"], run, colours)
    for name in names:
        panels[name].sharex(panels["stance"])
        panels[name].set_xlim(0.0, 1e3 * run["time"].values[-1])
        if name != "stance":
            panels[name].tick_params(labelbottom=False)
    handles, words = panels[axes[0]].get_legend_handles_labels()
    figure.legend(handles, words, loc="outside lower center", ncols=len(words))
    return figure, panels["above"]


def _draw_path(axes: Axes, run: xr.Dataset, colours: Sequence[str]) -> None:
    """Draw the path of the centre of mass and the footholds."""
    unit, words = length_unit(run)
    position = unit * run["position"].values
    axes.plot(position[:, 0], position[:, 1], color="black", label="centre of mass")
    for foot, colour in zip(np.moveaxis(unit * run["foot"].values, 1, 0), colours, strict=True):
        holds = np.unique(np.round(foot[np.isfinite(foot[:, 0])], 6), axis=0)
        axes.plot(holds[:, 0], holds[:, 1], "o", color=colour, markersize=4)
    across, along = axis_names(run)
    uphill = ", uphill" if along == "fore-aft" else ""
    axes.set(xlabel=f"{across} ({words})", ylabel=f"{along}{uphill} ({words})")
    # Long runs would be but a line.
    across, along = np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim())
    if along < 4.0 * across:
        axes.set_aspect("equal", adjustable="datalim")


def length_unit(run: xr.Dataset) -> tuple[float, str]:
    """Return the unit of lengths that suits an animal's legs."""
    return (1e3, "mm") if float(run["free_length"].max()) < 0.1 else (1.0, "m")


def axis_names(run: xr.Dataset) -> list[str]:
    """Return words for the two directions, which depend on where one looks from."""
    return [str(name).replace("_", "-") for name in run["axis"].values]


def _draw_legs(axes: Axes, run: xr.Dataset, hips: Floats) -> None:
    """Draw the centre of mass and, from there over their hips, the legs in stance; the later the darker."""
    last, (unit, _) = run.sizes["time"] - 1, length_unit(run)
    for number in range(INSTANTS):
        now = run.isel(time=round(number * last / (INSTANTS - 1)))
        shade = 0.3 + 0.7 * number / (INSTANTS - 1)
        cosine, sine = np.cos(now["yaw"].item()), np.sin(now["yaw"].item())
        turned = hips @ np.array([[cosine, sine], [-sine, cosine]])
        body = unit * now["position"].values
        for leg, (hip, foot) in enumerate(zip(body + unit * turned, unit * now["foot"].values, strict=True)):
            if np.isnan(foot[0]):
                continue
            colour = COLOURS[leg % len(COLOURS)]
            axes.plot(*zip(body, hip, strict=True), color=GRAY, alpha=shade, linewidth=0.8)
            axes.plot(*zip(hip, foot, strict=True), color=colour, alpha=shade, linewidth=0.8)
        axes.plot(*body, "o", color="black", alpha=shade, markersize=5)


def _draw_velocity(axes: Axes, run: xr.Dataset) -> None:
    time, velocity = 1e3 * run["time"].values, run["velocity"]
    for number, dashes in ((1, "-"), (0, "--")):
        axes.plot(time, velocity.isel(axis=number), dashes, color="black", label=axis_names(run)[number])
    axes.set_ylabel(f"velocity ({velocity.units})")
    # Above the lines, whatever they do.
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.1, ncols=2)


def _draw_forces(axes: Axes, run: xr.Dataset, axis: str, colours: Sequence[str]) -> None:
    """Draw one component of the force of each leg, and of all together."""
    time, force = 1e3 * run["time"].values, run["force"].sel(axis=axis)
    axes.plot(time, force.sum("leg"), color="0.75", linewidth=2.0, label="sum")
    for leg, colour in zip(force["leg"].values, colours, strict=True):
        stance = run["stance"].sel(leg=leg).astype(bool)
        axes.plot(time, force.sel(leg=leg).where(stance), color=colour, label=str(leg))
    axes.axhline(0.0, color=GRAY, linewidth=0.4)
    axes.set_ylabel(f"{axis.replace('_', '-')}\nforce ({units(force.units)})")


def _draw_stances(axes: Axes, run: xr.Dataset, colours: Sequence[str]) -> None:
    """Draw a bar for as long as each leg is in stance."""
    time, legs = 1e3 * run["time"].values, [str(leg) for leg in run["leg"].values]
    for row, colour in enumerate(colours):
        down = run["stance"].values[:, row].astype(bool)
        axes.fill_between(time, row - 0.35, row + 0.35, where=down, color=colour, linewidth=0.0)
    axes.set_yticks(range(len(legs)), legs)
    axes.set(xlabel="time (ms)", ylabel="stance", ylim=(len(legs) - 0.4, -0.6))
