"""Chapter 2: the model."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from legspring.drawing.style import COLOURS, PAGE, new_figure, styled
from legspring.peterson2011.figures.registry import ThesisFigure
from legspring.peterson2011.figures.sketches import sketch_of_model

GAIT: Mapping[str, Any] = {"slope_deg": 20.0, "heading": 0.3}
"""Arguments of `legspring.find_gaits` for the gait of the sketches, Figures 2.1 and 3.1; the first one it finds."""

SIMULATION: Mapping[str, Any] = {
    "slope_deg": 0.0,
    "heading": 0.15,
    "speed": 0.375,
    "phase": tuple(math.radians(phase) for phase in (63.0, 4.0, -49.0)),
    "family": "A",
    "strides": 2,
}
"""Arguments of `legspring.simulate` for Figure 2.2. The thesis states the phases and that all legs push;
slope, heading and speed, which it does not state, are those of a level gait."""


@styled
def leg_lengths(simulation: xr.Dataset) -> Figure:
    """Draw each leg's actual and force-free length against time, zero in swing; left legs left, right legs right.

    Parameters
    ----------
    simulation
        Of `legspring.simulate`, with legs whose names end in L or R; the thesis's: `SIMULATION`.
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
    phases = ", ".join(f"{phase:.0f}" for phase in np.rad2deg(simulation["phase"].values))
    figure.suptitle(
        f"Phases {phases} deg; slope {about['slope_deg']:g} deg, heading {about['heading']:g} rad and "
        f"speed {about['speed']:g} m/s are our choice",
        x=0.02,
        ha="left",
    )
    return figure


FIGURES = (
    ThesisFigure(
        "2.1",
        "gait",
        sketch_of_model,
        "The model: a centre of mass (COM) on six springy legs whose force-free lengths vary with the clock. A leg is "
        "put down at its angle beta (circle: where a leg of nominal length l0 would stand) without force, and lifts "
        "off when its force is zero again. Drawn to scale from a computed gait; gray legs remain from the step before.",
    ),
    ThesisFigure(
        "2.2",
        "simulation",
        leg_lengths,
        "Actual and force-free length of each leg over four steps, zero in swing; all legs push. The thesis gives "
        "the phases. It does not give slope, heading and speed, for which we took those of a gait on the level. "
        "Gray lines mark the beginnings of steps.",
    ),
)
