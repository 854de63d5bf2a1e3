"""Strokes that sketches are made of."""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Arc

from legspring.figures.style import GRAY


def spring(axes: Axes, start: tuple[float, float], end: tuple[float, float], colour: str, width: float = 1.0) -> None:
    """Draw a spring, straight at its ends; the width is that to either side."""
    reach = np.subtract(end, start)
    length = float(np.hypot(*reach))
    along = np.concatenate([[0.0], np.linspace(0.3, 0.8, 13), [1.0]])
    aside = np.concatenate([[0.0, 0.0], np.tile([1.0, -1.0], 6)[:11], [0.0, 0.0]])
    points = np.outer(along, reach) + width * np.outer(aside, [-reach[1], reach[0]]) / length
    axes.plot(start[0] + points[:, 0], start[1] + points[:, 1], color=colour, linewidth=1.0)


def angle(axes: Axes, centre: tuple[float, float], radius: float, start: float, end: float, words: str) -> None:
    """Draw an angle between two directions (deg) with its name outside of the arc."""
    low, high = sorted((start, end))
    axes.add_patch(Arc(centre, 2 * radius, 2 * radius, theta1=low, theta2=high, color=GRAY, linewidth=0.8))
    middle = math.radians(0.5 * (start + end))
    away = radius * 1.0 + 0.06 * float(np.ptp(axes.dataLim.intervaly))
    axes.text(centre[0] + away * math.cos(middle), centre[1] + away * math.sin(middle), words, ha="center", va="center")


def arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float], colour: str = "black") -> None:
    """Draw an arrow."""
    axes.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": colour, "shrinkA": 0, "shrinkB": 0})


def dimension(axes: Axes, start: tuple[float, float], end: tuple[float, float]) -> None:
    """Draw an arrow with two heads, for a length."""
    axes.annotate("", end, start, arrowprops={"arrowstyle": "<->", "color": GRAY, "shrinkA": 0, "shrinkB": 0})
