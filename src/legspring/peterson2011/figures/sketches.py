"""Sketches of the model and of a gait's conditions, drawn to scale from a computed gait."""

import math

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse
from numpy.typing import NDArray

from legspring.drawing.strokes import angle, arrow, dimension, spring
from legspring.drawing.style import COLOURS, GRAY, PAGE, new_figure, styled
from legspring.gait import Gait

Floats = NDArray[np.float64]

AHEAD = 90.0
"""Direction of straight ahead, which is uphill, in a figure, deg."""
RADII = {"F": 25.0, "M": 8.0, "B": 6.0}
"""Where the angles of pairs of legs are drawn so that they keep out of each other's way, mm."""


@styled
def sketch_of_model(gait: Gait) -> Figure:
    """Draw the model from above at a touch-down, from the side, and the length of a leg over a stride.

    Parameters
    ----------
    gait
        The gait, of an animal whose hips are at the centre of mass.
    """
    run = gait.simulate(strides=1)
    figure = new_figure(PAGE, 0.62 * PAGE)
    panels = figure.subplot_mosaic([["above", "side"], ["above", "length"]], width_ratios=(1.15, 1.0))
    _from_above(panels["above"], gait, run)
    _from_the_side(panels["side"], gait.slope_deg)
    _length(panels["length"], gait, run)
    for letter, axes in zip("abc", panels.values(), strict=True):
        axes.set_title(f"{letter}) {axes.get_title()}", loc="left")
        axes.set_title("")
    return figure


@styled
def sketch_of_path(gait: Gait) -> Figure:
    """Draw a stride's path with what has to hold at its touch-downs.

    Parameters
    ----------
    gait
        The gait.
    """
    run = gait.simulate(strides=1)
    step, half = 1e3 * gait.system.step_length, run.sizes["time"] // 2
    along, left = 1e3 * run["position"].sel(axis="fore_aft"), -1e3 * run["position"].sel(axis="lateral")
    height, reach = float(np.abs(left).max()), 0.3 * step
    figure = new_figure(PAGE, 0.42 * PAGE)
    axes = figure.subplots()
    axes.set(xlim=(-0.06 * step, 2.0 * step + 1.3 * reach), ylim=(-2.1 * height, 1.3 * height))
    axes.axis("off")
    axes.plot(along, left, color=COLOURS[0], linewidth=1.5)
    axes.plot([0.0, 2.0 * step + reach], [0.0, 0.0], color=GRAY, linewidth=0.6, linestyle="--")
    axes.text(2.0 * step + reach, -0.04 * height, "uphill", ha="right", va="top", color=GRAY)
    for number, time in enumerate(("0", r"t_\mathrm{des}", r"2\,t_\mathrm{des}")):
        now = run.isel(time=number * half)
        x, heading = number * step, r"-\delta_0" if number == 1 else r"\delta_0"
        # The lateral scale is not that along the path: an arrow with scaled components stays tangent to it.
        rise = -reach * float(now["velocity"].sel(axis="lateral") / now["velocity"].sel(axis="fore_aft"))
        _velocity(axes, x, reach, rise, heading)
        axes.plot(x, -1e3 * now["position"].sel(axis="lateral"), "o", color="black", markersize=5)
        axes.text(x + 0.02 * step, -0.2 * math.copysign(height, rise), f"$t={time}$", va="center")
        axes.plot([x, x], [-1.75 * height, 0.0], color="0.8", linewidth=0.6, zorder=0)
        if number:
            conditions = f"$v=v_0$  (3.1)\n$\\delta={heading}$  (3.2)\n$x=0$  (3.4)"
            axes.text(x + 0.02 * step, -1.05 * height, conditions, va="top", linespacing=1.5)
            dimension(axes, (x - step, -1.75 * height), (x, -1.75 * height))
            distance = r"$v_\mathrm{des}\,t_\mathrm{des}$  (3.3)"
            axes.text(x - 0.5 * step, -1.8 * height, distance, ha="center", va="top")
    _scales(axes, (0.2 * step, -1.2 * height), 2.0, 0.5)
    return figure


def _velocity(axes: Axes, x: float, reach: float, rise: float, heading: str) -> None:
    """Draw the velocity at a place on the line uphill, and its heading."""
    arrow(axes, (x, 0.0), (x + reach, rise), COLOURS[1])
    axes.text(x + reach, 1.17 * rise, r"$v_0$", ha="center", va="center", color=COLOURS[1])
    part = np.linspace(0.0, 1.0, 20)
    bend = 0.75 * (1.0 - 0.12 * part**2)
    axes.plot(x + bend * reach, part * bend * rise, color=GRAY, linewidth=0.8)
    axes.text(x + 0.78 * reach, 0.35 * rise, f"${heading}$", va="center")


def _from_above(axes: Axes, gait: Gait, run: xr.Dataset) -> None:
    """Draw the legs that have just been put down, those that remain, the heading and the angles."""
    axes.add_patch(Ellipse((0.0, -3.0), 13.0, 40.0, facecolor="0.95", edgecolor="0.8", linewidth=0.6, zorder=0))
    axes.plot([0.0, 0.0], [0.0, 38.0], color=GRAY, linewidth=0.6, linestyle="--")
    axes.text(0.0, 39.0, "straight ahead: uphill", ha="center", va="bottom", color=GRAY)
    colours = iter(COLOURS)
    for leg, foot in zip(gait.animal.legs, 1e3 * run["foot"].isel(time=0).values, strict=True):
        if leg.offset == 0.0:
            colour = next(colours)
            _leg(axes, leg.name, foot, colour, beyond=1e3 * leg.length)
            nominal = 1e3 * leg.length * np.array([-math.sin(leg.angle), math.cos(leg.angle)])
            axes.plot(*nominal, "o", markersize=7, markerfacecolor="none", markeredgecolor=colour, markeredgewidth=0.6)
            end = AHEAD + math.degrees(leg.angle)
            angle(axes, (0.0, 0.0), RADII.get(leg.pair, 8.0), AHEAD, end, rf"$\beta_{leg.pair}$")
        elif np.isfinite(foot[0]):
            _leg(axes, leg.name, foot, "0.7")
    tip = 20.0 * np.array([-math.sin(gait.heading), math.cos(gait.heading)])
    arrow(axes, (0.0, 0.0), (tip[0], tip[1]))
    axes.text(tip[0], tip[1] + 0.5, r"$v_0$", ha="center", va="bottom")
    angle(axes, (0.0, 0.0), 14.0, AHEAD, AHEAD + math.degrees(gait.heading), r"$\delta_0$")
    axes.plot(0.0, 0.0, "o", color="black", markersize=7)
    axes.text(2.0, -1.0, "COM", va="top")
    axes.set(title="from above, at a touch-down", aspect="equal")
    axes.axis("off")


def _leg(axes: Axes, name: str, foot: Floats, colour: str, beyond: float = 0.0) -> None:
    """Draw a leg, its foot, and its name further out than both foot and the given length."""
    spring(axes, (0.0, 0.0), (foot[0], foot[1]), colour)
    axes.plot(*foot, "o", color=colour)
    length = float(np.hypot(*foot))
    place = foot / length * (max(length, beyond) + 2.6)
    axes.text(place[0], place[1], name, ha="center", va="center", color=colour)


def _from_the_side(axes: Axes, slope_deg: float) -> None:
    slope = math.radians(slope_deg)
    up, out = np.array([math.cos(slope), math.sin(slope)]), np.array([-math.sin(slope), math.cos(slope)])
    axes.plot([0.0, 11.0], [0.0, 0.0], color=GRAY, linewidth=0.6, linestyle="--")
    axes.plot(*zip((0.0, 0.0), 11.0 * up, strict=True), color="black")
    angle(axes, (0.0, 0.0), 4.0, 0.0, slope_deg, r"$\sigma$")
    body = 6.5 * up + 0.9 * out
    axes.add_patch(Ellipse((body[0], body[1]), 3.4, 0.9, angle=slope_deg, facecolor="0.9", edgecolor="0.6"))
    for hip in (-1.1, 0.0, 1.1):
        axes.plot(*zip(body + hip * up, body + (hip + 0.2) * up - 0.9 * out, strict=True), color="0.6", linewidth=0.8)
    axes.plot(*body, "o", color="black", markersize=5)
    arrow(axes, (body[0], body[1]), (body[0], body[1] - 2.8))
    axes.text(body[0] + 0.2, body[1] - 2.6, r"$m\,g$", va="center")
    pull = body - 2.8 * math.sin(slope) * up
    arrow(axes, (body[0], body[1]), (pull[0], pull[1]), COLOURS[1])
    axes.text(
        pull[0] + 0.6 * out[0], pull[1] + 0.6 * out[1], r"$m\,g\,\sin\sigma$", ha="right", va="bottom", color=COLOURS[1]
    )
    axes.text(11.2 * up[0], 11.2 * up[1], "uphill", va="center", color=GRAY)
    axes.set(title="from the side", aspect="equal", ylim=(-0.5, 6.0))
    axes.axis("off")


def _length(axes: Axes, gait: Gait, run: xr.Dataset) -> None:
    leg = gait.animal.legs[0]
    pair = gait.animal.pairs.index(leg.pair)
    time = run["time"].values / gait.system.step_duration
    change = gait.system.functions[pair] * gait.actuation[pair]
    free = leg.length - change * np.sin(math.pi * time + gait.phase[pair])
    axes.plot(time, 1e3 * free, "--", color=COLOURS[1], label="force-free")
    axes.plot(time, 1e3 * run["leg_length"].sel(leg=leg.name), color=COLOURS[0], label="actual")
    axes.axhline(1e3 * leg.length, color=GRAY, linewidth=0.6)
    axes.text(2.02, 1e3 * leg.length, r"$l_0$", va="center")
    dimension(axes, (1.88, 1e3 * leg.length), (1.88, 1e3 * (leg.length + abs(change))))
    axes.text(1.86, 1e3 * (leg.length + 0.5 * abs(change)), r"$|l_\mathrm{dev}|$", ha="right", va="center")
    axes.axhline(1e3 * (leg.length + abs(change)), color=GRAY, linewidth=0.4, linestyle=":")
    off = float(gait.liftoff[pair])
    end = leg.length - change * math.sin(math.pi * off + gait.phase[pair])
    axes.plot(0.0, 1e3 * free[0], "o", color="black", clip_on=False, label="touch-down")
    axes.plot(off, 1e3 * end, "o", color="black", markerfacecolor="white", label="lift-off")
    axes.set(title=f"length of leg {leg.name}", xlabel=r"time ($t_\mathrm{des}$)", ylabel="mm", xlim=(0.0, 2.0))
    axes.legend(loc="lower left")


def _scales(axes: Axes, corner: tuple[float, float], along: float, across: float) -> None:
    """Draw how long some mm are along the path and across it, which are not to the same scale."""
    x, y = corner
    axes.plot([x + along, x, x], [y, y, y + across], color=GRAY, linewidth=1.0)
    axes.text(x + 0.5 * along, y - 0.06, f"{along:g} mm", ha="center", va="top", color=GRAY)
    axes.text(x - 0.1, y + 0.5 * across, f"{across:g} mm", ha="right", va="center", color=GRAY)
