"""Strokes that sketches are made of."""

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Arc, Ellipse
from numpy.typing import NDArray

from legspring.drawing.style import GRAY


def spring(axes: Axes, start: tuple[float, float], end: tuple[float, float], colour: str, width: float = 1.0) -> None:
    """Draw a spring, straight at its ends; the width is that to either side."""
    reach = np.subtract(end, start)
    length = float(np.hypot(*reach))
    along = np.concatenate([[0.0], np.linspace(0.3, 0.8, 13), [1.0]])
    aside = np.concatenate([[0.0, 0.0], np.tile([1.0, -1.0], 6)[:11], [0.0, 0.0]])
    points = np.outer(along, reach) + width * np.outer(aside, [-reach[1], reach[0]]) / length
    axes.plot(start[0] + points[:, 0], start[1] + points[:, 1], color=colour, linewidth=1.0)


def body_length(mass: float, inertia: float) -> float:
    """Return how long a rod of this mass (kg) and moment of inertia (kg m^2) is, m."""
    return math.sqrt(12.0 * inertia / mass)


def body(mass: float, inertia: float, tilt: float = 0.0) -> Ellipse:
    """Return an ellipse as long as a rod of this mass and moment of inertia, at the origin, upright or tilted (deg)."""
    length = body_length(mass, inertia)
    look: dict[str, Any] = {"facecolor": "0.93", "edgecolor": "0.7", "linewidth": 0.6, "zorder": 0}
    return Ellipse((0.0, 0.0), 0.4 * length, length, angle=tilt, **look)


def tilt_of_body(hips: NDArray[np.float64], sagittal: bool) -> float:
    """Return how an ellipse lies along hips, ``(L, 2)`` from the centre of mass, deg: across, from the side."""
    across, along = np.abs(hips).max(axis=0)
    return 90.0 if sagittal and across > along else 0.0


def round_length(most: float) -> tuple[float, str]:
    """Return the longest round length of at most so much, in m, and what it is called."""
    power = 10.0 ** math.floor(math.log10(most))
    length = power * max(digit for digit in (1.0, 2.0, 5.0) if digit * power <= most)
    return length, f"{1e3 * length:g} mm" if length < 0.1 else f"{length:g} m"


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
