"""Chapter 4: gaits with fixed actuation, over slope and heading."""

from functools import partial

import xarray as xr
from matplotlib.figure import Figure

from legspring.drawing.style import styled
from legspring.figures.maps import add_bar, add_legend, add_letters, draw_atlas, draw_map, panel_grid
from legspring.peterson2011.figures.registry import FAMILY_WORDS, ThesisFigure

PHASES = (-75.0, 75.0)
"""Range of colours of phases, deg."""
EIGENVALUES, COSTS, STEPS = (0.0, 0.7), (0.0, 2.0), (0.0, 50.0)


@styled
def speed_and_phases(atlas: xr.Dataset, branch: int = 0) -> Figure:
    """Draw maps of initial speed and of the phases of the legs."""
    legs = [str(leg) for leg in atlas["leg"].values]
    figure, grid = panel_grid(1 + len(legs))
    maps = [draw_map(grid[0], atlas, "speed", limits=(0.0, 0.4), title="speed", families=False, branch=branch)]
    for axes, leg in zip(grid[1:], legs, strict=True):
        title = f"phase, legs {leg}"
        maps.append(draw_map(axes, atlas, "phase", limits=PHASES, title=title, families=False, leg=leg, branch=branch))
    add_letters(maps)
    for drawn in maps:
        add_bar(figure, [drawn])
    add_legend(figure, maps)
    return figure


UNSTABLE = "Gaits that are unstable by the complete map are hatched in black."

FIGURES = (
    ThesisFigure(
        "4.1",
        "atlas",
        speed_and_phases,
        "Fixed actuation: initial speed of a step, and the phases of front, middle and back legs. Of several gaits "
        "in a cell, these maps and those that follow show the one with the most negative phase of the back legs; "
        f"the thesis shows no other. {UNSTABLE}",
    ),
    ThesisFigure(
        "4.2",
        "atlas",
        partial(draw_atlas, name="reduced_eigenvalue", limits=EIGENVALUES),
        f"Fixed actuation: largest eigenvalue magnitude, with markers for the families ({FAMILY_WORDS}). It is that of "
        "the map of speed and heading, as in the thesis. Where legs of the step before are still down, as in most "
        "cells, a disturbance decays at another rate: that of the complete map. "
        f"{UNSTABLE}",
    ),
    ThesisFigure(
        "4.3",
        "atlas",
        partial(draw_atlas, name="recovery_steps", limits=STEPS, impulse=0.5),
        "Fixed actuation: steps to recover from a push to the side of half of the momentum at the desired speed. "
        f"Gaits that never recover are crossed. {UNSTABLE}",
    ),
    ThesisFigure(
        "4.4",
        "atlas",
        partial(draw_atlas, name="recovery_steps", y="impulse", limits=STEPS, families=False, heading=0.15),
        "Fixed actuation, heading 0.15 rad: steps to recover against slope and impulse. The row without an impulse "
        f"has nothing to recover from. {UNSTABLE}",
    ),
    ThesisFigure(
        "4.5",
        "atlas",
        partial(draw_atlas, name="transport_cost", limits=COSTS),
        "Fixed actuation: transport cost. Where no leg does negative work, as in almost all gaits in "
        f"which only the back legs push, it is the sine of the slope, the least that there can be. {UNSTABLE}",
    ),
)
