"""Chapter 3: gaits and how they are judged."""

import numpy as np
from matplotlib.figure import Figure

from legspring.drawing.style import COLOURS, COLUMN, GRAY, new_figure, styled, units
from legspring.layout import System
from legspring.measures.robustness import push_knots
from legspring.peterson2011.figures.registry import ThesisFigure
from legspring.peterson2011.figures.sketches import sketch_of_path


@styled
def push(system: System, impulse: float = 0.5) -> Figure:
    """Draw the lateral force that disturbs a step against time.

    Parameters
    ----------
    system
        The animal on its slope.
    impulse
        In units of m v_des.
    """
    knots = push_knots(system, impulse)
    step = 1e3 * system.step_duration
    time = np.concatenate([[0.0], step * knots[:, 0], [step]])
    force = np.concatenate([[0.0], knots[:, 1] / system.weight, [0.0]])
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


FIGURES = (
    ThesisFigure(
        "3.1",
        "gait",
        sketch_of_path,
        "Path of the centre of mass over a stride of a computed gait, and the conditions that make it one: after each "
        "step the speed is the same (3.1), the heading has changed its sign (3.2), the step is as long as desired "
        "(3.3), and there is no way gone to the side (3.4). The lateral scale is stretched.",
    ),
    ThesisFigure(
        "3.2",
        "system",
        push,
        "The push to the side in the first step by which robustness is measured, here of half of the momentum "
        "at the desired speed.",
    ),
)
