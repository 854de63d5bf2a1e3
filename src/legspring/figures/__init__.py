"""Figures and films of gaits, simulations, recoveries and atlases; they draw what they are given and compute nothing.

Every function but `animate` returns a `matplotlib.figure.Figure` that no window manages; `save_figure` writes it to a
file.
Importing this package imports matplotlib.
"""

from legspring.drawing.film import Film, animate
from legspring.drawing.style import save_figure
from legspring.figures.animals import draw_animal, draw_animals
from legspring.figures.basins import draw_basin, draw_pushes, draw_rough
from legspring.figures.bifurcations import draw_bifurcations
from legspring.figures.boundaries import draw_boundaries
from legspring.figures.footfalls import draw_footfalls
from legspring.figures.fronts import draw_front
from legspring.figures.maps import draw_atlas
from legspring.figures.runs import draw_gait, draw_recovery, draw_simulation
from legspring.figures.series import draw_energy, draw_motion
from legspring.figures.sweeps import draw_sobol, draw_sweep

__all__ = [
    "Film",
    "animate",
    "draw_animal",
    "draw_animals",
    "draw_atlas",
    "draw_basin",
    "draw_bifurcations",
    "draw_boundaries",
    "draw_energy",
    "draw_footfalls",
    "draw_front",
    "draw_gait",
    "draw_motion",
    "draw_pushes",
    "draw_recovery",
    "draw_rough",
    "draw_simulation",
    "draw_sobol",
    "draw_sweep",
    "save_figure",
]
