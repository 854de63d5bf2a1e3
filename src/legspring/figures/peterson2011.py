"""The figures of chapters 2 to 4 of D. E. Peterson's thesis (2011), drawn from our own data in its colour ranges."""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from legspring.figures.maps import add_legend, draw_atlas, draw_map
from legspring.figures.style import COLOURS, COLUMN, GRAY, PAGE, new_figure, styled, units
from legspring.measures.robustness import push_knots
from legspring.setting import Setting

FIGURE_2_2: Mapping[str, Any] = {
    "slope_deg": 0.0,
    "heading": 0.15,
    "speed": 0.375,
    "phase": tuple(math.radians(phase) for phase in (63.0, 4.0, -49.0)),
    "family": "A",
    "strides": 2,
}
"""Arguments of `legspring.simulate` for `figure_2_2`. The thesis states the phases and that all legs push;
slope, heading and speed, which it does not state, are those of a level gait."""


@styled
def figure_2_2(simulation: xr.Dataset) -> Figure:
    """Draw each leg's actual and force-free length against time, zero in swing; left legs left, right legs right.

    Parameters
    ----------
    simulation
        Of `legspring.simulate`, with legs whose names end in L or R; the thesis's: `FIGURE_2_2`.
    """
    rows = list(dict.fromkeys(str(leg)[:-1] for leg in simulation["leg"].values))
    figure = new_figure(PAGE, 1.3 * len(rows) + 0.6)
    panels = figure.subplots(len(rows), 2, sharex=True, sharey=True, squeeze=False)
    time, step = 1e3 * simulation["time"].values, 1e3 * simulation.attrs["step_duration"]
    for (row, column), axes in np.ndenumerate(panels):
        leg = rows[row] + "LR"[column]
        for start in np.arange(step, time[-1], step):
            axes.axvline(start, color="0.85", linewidth=0.6)
        for name, words, line, colour in (
            ("leg_length", "actual", "-", COLOURS[0]),
            ("free_length", "force-free", "--", COLOURS[1]),
        ):
            length = 1e3 * simulation[name].sel(leg=leg).fillna(0.0)
            axes.plot(time, length, line, color=colour, label=words)
        axes.set_title(leg, loc="left")
        axes.set_xlim(0.0, time[-1])
    figure.supxlabel("time (ms)")
    figure.supylabel("length (mm); zero in swing")
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper right", ncols=2)
    about = simulation.attrs
    phases = ", ".join(f"{phase:.0f}" for phase in np.rad2deg(about["phase"]))
    figure.suptitle(
        f"Phases {phases} deg; slope {about['slope_deg']:g} deg, heading {about['heading']:g} rad and "
        f"speed {about['speed']:g} m/s are our choice",
        x=0.02,
        ha="left",
    )
    return figure


@styled
def figure_3_2(setting: Setting, impulse: float = 0.5) -> Figure:
    """Draw the lateral force that disturbs a step against time.

    Parameters
    ----------
    setting
        The animal on its slope.
    impulse
        In units of m v_des.
    """
    knots = push_knots(setting, impulse)
    step = 1e3 * setting.step_duration
    time = np.concatenate([[0.0], step * knots[:, 0], [step]])
    force = np.concatenate([[0.0], knots[:, 1] / setting.weight, [0.0]])
    figure = new_figure(COLUMN, 0.6 * COLUMN)
    axes = figure.subplots()
    axes.plot(time, force, color=COLOURS[0])
    axes.fill_between(time, force, color=COLOURS[0], alpha=0.2, linewidth=0.0)
    axes.axhline(0.0, color=GRAY, linewidth=0.6)
    axes.annotate(
        f"area: {impulse:g} {units('m v_des')}",
        (time[2], 0.6 * force[2]),
        xytext=(0.35 * step, 0.6 * force[2]),
        va="center",
    )
    axes.set(xlim=(0.0, step), xlabel="time in a step (ms)", ylabel=f"lateral force ({units('m g')})")
    return figure


@styled
def figure_4_1(atlas: xr.Dataset, branch: int = 0) -> Figure:
    """Draw maps of initial speed and of the phases of the legs."""
    figure = new_figure(PAGE, 0.75 * PAGE)
    first, *rest = figure.subplots(2, 2, sharex=True, sharey=True).flat
    handles = draw_map(
        first, atlas, "speed", limits=(0.0, 0.4), title="a) initial speed", families=False, branch=branch
    )
    for letter, axes, leg in zip("bcd", rest, atlas["leg"].values, strict=False):
        title = f"{letter}) phase, legs {leg}"
        limits = (-75.0, 75.0)
        draw_map(axes, atlas, "phase", limits=limits, title=title, families=False, leg=str(leg), branch=branch)
    for axes in figure.axes[:4]:
        axes.label_outer()
    add_legend(figure, handles)
    return figure


def figure_4_2(atlas: xr.Dataset, branch: int = 0) -> Figure:
    """Draw a map of the largest eigenvalue of the thesis's reduced map."""
    return draw_atlas(atlas, "reduced_eigenvalue", limits=(0.0, 0.7), branch=branch)


def figure_4_3(atlas: xr.Dataset, branch: int = 0) -> Figure:
    """Draw a map of the steps to recover from half of the momentum at the desired speed."""
    return draw_atlas(atlas, "recovery_steps", limits=(0.0, 50.0), branch=branch, impulse=0.5)


def figure_4_4(atlas: xr.Dataset, branch: int = 0) -> Figure:
    """Draw the steps to recover over slope and impulse, at a heading of 0.15 rad."""
    return draw_atlas(
        atlas, "recovery_steps", y="impulse", limits=(0.0, 50.0), branch=branch, families=False, heading=0.15
    )


def figure_4_5(atlas: xr.Dataset, branch: int = 0) -> Figure:
    """Draw a map of the transport cost."""
    return draw_atlas(atlas, "transport_cost", limits=(0.0, 2.0), branch=branch)


CHAPTER_4: Mapping[str, Callable[[xr.Dataset], Figure]] = {
    "4.1": figure_4_1,
    "4.2": figure_4_2,
    "4.3": figure_4_3,
    "4.4": figure_4_4,
    "4.5": figure_4_5,
}
"""The figures that an atlas gives, by number."""
