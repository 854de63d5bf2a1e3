"""Sketches of animals: body, hips, feet at touch-down, springs, and the way gravity pulls."""

import math
import textwrap
from collections.abc import Sequence
from itertools import zip_longest

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon
from numpy.typing import NDArray

from legspring.drawing.strokes import arrow, body, round_length, spring, tilt_of_body
from legspring.drawing.style import COLOURS, COLUMN, GRAY, PAGE, SMALL, new_figure, styled
from legspring.figures.runs import length_unit
from legspring.gait import Gait
from legspring.model import Animal, Leg

Floats = NDArray[np.float64]

RULES = {
    "clock": "put down by the clock",
    "ground": "put down where the foot, held ready, meets the ground",
    "lift-off": "put down when another leg lifts off",
}
ROOM, NARROW = 0.14, math.radians(10)
"""Room for the words of an angle, in units of the animal's size; half of an angle too narrow for them."""
MANY = 4
"""Pairs up to which each has its angle drawn."""
IMAGE = "0.75"
"""Colour of legs that are the mirror images of others."""
COLUMNS = 4
"""How many animals are drawn side by side."""
STRIDES = 2
"""How much of a gait is drawn."""


@styled
def draw_animal(animal: Animal, gait: Gait | None = None) -> Figure:
    """Draw an animal at a touch-down, to scale: from above or, where its legs come down to the ground, from the side.

    Legs put down at the start of a step are in colour, their mirror images are pale. Along each actuated leg a band
    shows between which lengths its force-free length varies.

    Parameters
    ----------
    animal
        The animal.
    gait
        One of its gaits: two strides of it are drawn beside.
    """
    figure = new_figure(COLUMN if gait is None else PAGE, 1.05 * COLUMN)
    if gait is None:
        sketch = figure.subplots()
    elif animal.sagittal:
        sketch, beside = figure.subplots(1, 2, width_ratios=(1.0, 1.6))
    else:
        sketch, beside = figure.subplots(1, 2, width_ratios=(1.3, 1.0))
    _sketch(sketch, animal)
    if gait is not None:
        _path(beside, gait)
    lines = [animal.name, *textwrap.wrap(animal.summary, 60 if gait is None else 110)]
    figure.suptitle("\n".join(lines))
    rules = [part for rule in _rules(animal) for part in textwrap.wrap(rule, 60 if gait is None else 120)]
    figure.supxlabel("\n".join(rules), fontsize=SMALL, color=GRAY)
    return figure


@styled
def draw_animals(animals: Sequence[Animal]) -> Figure:
    """Draw several animals side by side, each as `draw_animal` does.

    Parameters
    ----------
    animals
        The animals.
    """
    rows = math.ceil(len(animals) / COLUMNS)
    figure = new_figure(PAGE, rows * PAGE / COLUMNS)
    panels = figure.subplots(rows, COLUMNS, squeeze=False).ravel()
    for axes, animal in zip_longest(panels, animals):
        if animal is None:
            axes.axis("off")
            continue
        _sketch(axes, animal, words=False)
        axes.set_title(textwrap.fill(animal.name.replace("_", " "), 20))
    return figure


def _rules(animal: Animal) -> list[str]:
    """Say when legs touch down and lift off, and what is special about them."""
    lines = []
    for leg in {leg.pair: leg for leg in reversed(animal.legs)}.values():
        off = "at zero force" if leg.stance is None else f"{leg.stance:g} steps later"
        extra = ", with damper" if leg.damping else ""
        lines.append(f"{RULES[leg.touchdown]}, lifted off {off}{extra}")
    return list(dict.fromkeys(lines))


def _direction(leg: Leg) -> Floats:
    """Direction from the hip to the foot."""
    return np.array([-math.sin(leg.angle), math.cos(leg.angle)])


def _sketch(axes: Axes, animal: Animal, words: bool = True) -> None:
    """Draw the animal around its centre of mass, with names and angles or without."""
    size = max(math.hypot(*leg.hip) + leg.length for leg in animal.legs)
    first = [animal.legs[i] for i in animal.first_legs]
    if animal.body.yaw == "free":
        tilt = tilt_of_body(np.array([leg.hip for leg in animal.legs]), animal.sagittal)
        axes.add_patch(body(animal.body.mass, animal.body.inertia or 0.0, tilt))
    for leg in sorted(animal.legs, key=lambda leg: leg in first):
        number = animal.pairs.index(leg.pair)
        _leg(axes, leg, COLOURS[number % len(COLOURS)] if leg in first else IMAGE, size)
    told: list[float] = []
    for number, leg in enumerate(first if words else ()):
        # Where there are many pairs, an angle that they have in common is drawn once.
        if len(first) <= MANY or abs(leg.angle) not in told:
            (_attack if animal.sagittal else _angle)(axes, leg, (0.3 + 0.13 * min(number, MANY)) * leg.length, size)
            told.append(abs(leg.angle))
    for together in _by_place(animal.legs) if words else ():
        leg = together[0]
        colour = COLOURS[animal.pairs.index(leg.pair) % len(COLOURS)] if leg in first else GRAY
        _name(axes, leg, ", ".join(one.name for one in together), colour, animal.sagittal, size)
    axes.plot(0.0, 0.0, "o", color="black", markersize=6, zorder=4)
    if animal.sagittal:
        _ground(axes, first, size)
    _gravity(axes, animal, size)
    _scale(axes, size)
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.axis("off")


def _leg(axes: Axes, leg: Leg, colour: str, size: float) -> None:
    """Draw a leg, its foot, and how much its force-free length varies."""
    hip, along = np.array(leg.hip), _direction(leg)
    foot = hip + leg.length * along
    above = 2 if colour != IMAGE else 1
    if leg.actuation:
        band = np.array([hip + (leg.length + sign * leg.actuation) * along for sign in (-1, 1)])
        axes.plot(*band.T, color=colour, linewidth=7.0, alpha=0.18, solid_capstyle="butt", zorder=0)
    if hip.any():
        axes.plot(*np.array([[0.0, 0.0], hip]).T, color=GRAY, linewidth=0.8, zorder=above)
    if leg.damping:
        _damper(axes, hip, foot, colour, math.copysign(0.06 * size, -leg.angle))
    spring(axes, tuple(hip), tuple(foot), colour, 0.028 * size)
    axes.plot(*hip, "o", color=colour, markerfacecolor="white", markersize=3.5, zorder=3)
    axes.plot(*foot, "o", color=colour, zorder=3)


def _by_place(legs: Sequence[Leg]) -> list[list[Leg]]:
    """Return the legs, those together whose feet are at one place."""
    places: dict[tuple[float, ...], list[Leg]] = {}
    for leg in legs:
        foot = np.array(leg.hip) + leg.length * _direction(leg)
        places.setdefault(tuple(np.round(foot / leg.length, 6).tolist()), []).append(leg)
    return list(places.values())


def _name(axes: Axes, leg: Leg, words: str, colour: str, aside: bool, size: float) -> None:
    """Write the name of a leg, and of others at its place, beyond its foot, or beside it."""
    foot = np.array(leg.hip) + leg.length * _direction(leg)
    place = foot + size * np.array([0.08, 0.07]) if aside else foot + (leg.actuation + 0.09 * size) * _direction(leg)
    axes.text(place[0], place[1], words, ha="center", va="center", color=colour)
    axes.update_datalim([place - 0.05 * size, place + 0.05 * size])


def _damper(axes: Axes, hip: Floats, foot: Floats, colour: str, distance: float) -> None:
    """Draw a dashpot at a distance to the right of the spring, seen from the hip."""
    along = (foot - hip) / np.hypot(*(foot - hip))
    aside = distance * np.array([along[1], -along[0]])
    length = float(np.hypot(*(foot - hip)))

    def line(*points: tuple[float, float]) -> None:
        places = [hip + part * length * along + shift * aside for part, shift in points]
        axes.plot(*np.array(places).T, color=colour, linewidth=0.8)

    line((0.2, 0.0), (0.2, 1.0), (0.5, 1.0))
    line((0.5, 0.65), (0.5, 1.35))
    line((0.42, 0.5), (0.6, 0.5), (0.6, 1.5), (0.42, 1.5))
    line((0.6, 1.0), (0.88, 1.0), (0.88, 0.0))


def _arc(axes: Axes, centre: Floats, radius: float, low: float, high: float, size: float) -> None:
    """Draw an angle between two directions (rad, counter-clockwise from the right); a narrow one further out."""
    words, half = f"{math.degrees(abs(high - low)):.3g}°", 0.5 * abs(high - low)
    radius = max(radius, min(ROOM * size / max(math.sin(half), 1e-9), 2.0 * radius))
    turns = np.linspace(low, high, 40)
    axes.plot(centre[0] + radius * np.cos(turns), centre[1] + radius * np.sin(turns), color=GRAY, linewidth=0.7)
    # Where it is too narrow for words, they are on the other side of its first direction.
    middle = 0.5 * (low + high) if half > NARROW else low - math.copysign(NARROW, high - low)
    across, up = math.cos(middle), math.sin(middle)
    away = radius + (0.03 if abs(across) > 0.5 else 0.075) * size
    axes.text(
        centre[0] + away * across,
        centre[1] + away * up,
        words,
        ha="left" if across > 0.5 else "right" if across < -0.5 else "center",
        va="center",
        fontsize=SMALL,
        color=GRAY,
        bbox={"facecolor": "white", "alpha": 0.7, "linewidth": 0.0, "pad": 0.3},
    )


def _angle(axes: Axes, leg: Leg, radius: float, size: float) -> None:
    """Draw the touch-down angle, from straight ahead."""
    hip = np.array(leg.hip)
    axes.plot([hip[0], hip[0]], [hip[1], hip[1] + radius + 0.05 * size], color=GRAY, linewidth=0.6, linestyle=":")
    _arc(axes, hip, radius, math.pi / 2, math.pi / 2 + leg.angle, size)


def _attack(axes: Axes, leg: Leg, radius: float, size: float) -> None:
    """Draw the angle of attack, between the ground ahead of the foot or behind it, and the leg."""
    foot, up = np.array(leg.hip) + leg.length * _direction(leg), -_direction(leg)
    _arc(axes, foot, radius, math.pi if up[0] < 0.0 else 0.0, math.atan2(up[1], up[0]), size)


def _ground(axes: Axes, legs: Sequence[Leg], size: float) -> None:
    """Draw the ground under the first leg's foot, and where forward is."""
    feet = np.array([leg.hip + leg.length * _direction(leg) for leg in legs])
    foot, left, right = feet[0], feet[:, 0].min() - 0.8 * size, feet[:, 0].max() + 0.5 * size
    axes.plot([left, right], [foot[1], foot[1]], color="black", linewidth=0.8, zorder=0)
    low = foot[1] - 0.06 * size
    corners = [(left, low), (right, low), (right, foot[1]), (left, foot[1])]
    axes.add_patch(Polygon(corners, facecolor="none", edgecolor=GRAY, hatch="/////", linewidth=0.0))
    arrow(axes, (0.08 * size, 0.0), (0.45 * size, 0.0))
    axes.text(0.27 * size, 0.03 * size, "forward", ha="center", va="bottom", fontsize=SMALL)


def _gravity(axes: Axes, animal: Animal, size: float) -> None:
    """Draw which way gravity pulls, to the right of the animal."""
    low, high = animal.speed_law.domain_deg
    right = axes.dataLim.x1 + 0.22 * size
    if low == high == 0.0:
        axes.add_patch(Circle((right, 0.0), 0.05 * size, facecolor="white", edgecolor="black", linewidth=0.8))
        axes.plot([right - 0.035 * size, right + 0.035 * size], [-0.035 * size, 0.035 * size], "k", linewidth=0.8)
        axes.plot([right - 0.035 * size, right + 0.035 * size], [0.035 * size, -0.035 * size], "k", linewidth=0.8)
        axes.text(right, -0.09 * size, "$g$", ha="center", va="top")
        return
    arrow(axes, (right, 0.2 * size), (right, -0.2 * size))
    whole = animal.sagittal or low == high == 90.0
    axes.text(right + 0.06 * size, 0.0, "$g$" if whole else r"$g\,\sin\sigma$", va="center")
    axes.update_datalim([(right, 0.25 * size), (right + 0.35 * size, -0.25 * size)])


def _scale(axes: Axes, size: float) -> None:
    """Draw how long a round length is."""
    length, words = round_length(0.7 * size)
    left, low = axes.dataLim.x0, axes.dataLim.y0 - 0.12 * size
    axes.plot([left, left + length], [low, low], color=GRAY, linewidth=1.5, solid_capstyle="butt")
    axes.text(left + 0.5 * length, low - 0.02 * size, words, ha="center", va="top", color=GRAY, fontsize=SMALL)
    axes.update_datalim([(left, low - 0.12 * size)])


def _path(axes: Axes, gait: Gait) -> None:
    """Draw the path of the centre of mass over some strides, with the legs as they are put down."""
    run = gait.simulate(strides=STRIDES)
    unit, words = length_unit(run)
    position = unit * run["position"].values
    axes.plot(position[:, 0], position[:, 1], color="black")
    stance = run["stance"].values.astype(bool)
    for number, pair in enumerate(gait.animal.pair_of):
        starts = np.flatnonzero(stance[1:, number] & ~stance[:-1, number]) + 1
        for row in [0, *starts] if stance[0, number] else starts:
            hip, foot = unit * run["hip"].values[row, number], unit * run["foot"].values[row, number]
            colour = COLOURS[pair % len(COLOURS)]
            axes.plot(*np.array([hip, foot]).T, color=colour, linewidth=0.8, alpha=0.6)
            axes.plot(*foot, "o", color=colour, markersize=3)
    across, along = ("forward", "up") if gait.animal.sagittal else ("to the right", "ahead")
    axes.set(xlabel=f"{across} ({words})", ylabel=f"{along} ({words})")
    axes.set_aspect("equal", adjustable="datalim")
    slope = "" if gait.animal.sagittal and not gait.slope_deg else f", slope {gait.slope_deg:g} deg"
    axes.set_title(f"{STRIDES} strides{slope}, {gait.mean_speed:.3g} m/s")
