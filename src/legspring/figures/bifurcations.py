"""Figures of curves of gaits: what becomes of them as something varies, and their multipliers in the unit circle."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from legspring.checks import shown
from legspring.continuation import Continuation
from legspring.drawing.style import COLOURS, GRAY, PAGE, new_figure, sequential, styled

LOOKS = {
    "stable": {"linestyle": "-", "linewidth": 1.6},
    "unstable": {"linestyle": "--", "linewidth": 1.0},
    "no gait": {"linestyle": ":", "linewidth": 1.0},
}
MARKS = {
    "fold": ("o", "white"),
    "period doubling": ("s", "white"),
    "symmetry breaking": ("D", "white"),
    "branch point": ("P", "black"),
    "multiplier of 1": ("P", "white"),
    "Neimark-Sacker": ("^", "white"),
    "idle leg": ("v", "0.7"),
    "ignored window": ("X", "0.4"),
    "wrong start": ("<", "0.7"),
    "no lift-off": (">", "0.7"),
    "edge of validity": ("d", "0.7"),
    "grazing lift-off": ("*", "0.4"),
    "grazing touch-down": ("p", "0.4"),
    "kink": ("|", "black"),
}
"""Marker and filling of special points; where only events change places, there is nothing to be seen."""
OUTSIDE = 1.6
"""Largest part of a multiplier that is drawn."""
Curves = Continuation | xr.Dataset | Sequence[Continuation | xr.Dataset]


@styled
def draw_bifurcations(curves: Curves, y: str = "speed") -> Figure:
    """Draw curves of gaits: one of their numbers against what varies, and their multipliers in the unit circle.

    Solid lines are stable gaits, dashed ones unstable; dotted ones are solutions that are no gaits. Colours are
    families, markers special points.

    Parameters
    ----------
    curves
        One or several that were followed along the same parameter: what `legspring.follow` returns, or their datasets.
    y
        What is drawn: ``"speed"``, ``"heading"``, ``"max_multiplier"``, the phase of a pair, as ``"phase_F"``; or any
        other number that the datasets have.

    Raises
    ------
    ValueError
        For something else, or curves along different parameters.
    """
    some = [curves] if isinstance(curves, Continuation | xr.Dataset) else list(curves)
    data = [one.to_dataset() if isinstance(one, Continuation) else one for one in some]
    if not data or any("followed" not in one.attrs for one in data):
        raise ValueError(f"curves = {shown(curves)}: must be curves that were followed, or their datasets")
    followed = {str(one.attrs["followed"]) for one in data}
    if len(followed) > 1:
        raise ValueError(f"curves: must be along one parameter, and not along {', '.join(sorted(followed))}")
    (name,) = followed
    families = list(dict.fromkeys(str(one.attrs["family"]) for one in data))
    figure = new_figure(PAGE, 3.1)
    left, right = figure.subplots(1, 2, width_ratios=(1.75, 1.0))
    met: set[str] = set()
    for one in data:
        colour = COLOURS[families.index(str(one.attrs["family"])) % len(COLOURS)]
        _draw_curve(left, one, name, y, colour)
        met |= _draw_special(left, one, y, colour)
    values = data[0][name]
    left.set(xlabel=_label(values, name), ylabel=_label(_of(data[0], y), y))
    _draw_circle(figure, right, data, name)
    handles = [Line2D([], [], color="black", label=words, **look) for words, look in LOOKS.items()]  # type: ignore[arg-type]
    if len(families) > 1:
        handles += [Line2D([], [], color=COLOURS[n % len(COLOURS)], label=one) for n, one in enumerate(families)]
    for kind, (marker, filling) in MARKS.items():
        if kind in met:
            look: Any = {"marker": marker, "markerfacecolor": filling, "markeredgecolor": "black"}
            handles.append(Line2D([], [], linestyle="", label=kind, **look))
    figure.legend(handles=handles, loc="outside lower center", ncols=6)
    figure.suptitle(f"{data[0].attrs['animal']}: {'families' if len(families) > 1 else 'family'} {', '.join(families)}")
    return figure


def _of(curve: xr.Dataset, y: str, special: bool = False) -> xr.DataArray:
    """Return a number of each point, or of each special one."""
    prefix = "special_" if special else ""
    if f"{prefix}{y}" in curve and curve[f"{prefix}{y}"].ndim == 1:
        return curve[f"{prefix}{y}"]
    what, _, leg = y.partition("_")
    if what == "phase" and leg in curve["leg"].values:
        return curve[f"{prefix}phase"].sel(leg=leg)
    valid = [str(key) for key, one in curve.data_vars.items() if one.dims == ("point",) and one.dtype.kind == "f"]
    phases = [f"phase_{leg}" for leg in curve["leg"].values]
    raise ValueError(f"y = {shown(y)}: must be one of {', '.join(valid + phases)}")


def _of_special(curve: xr.Dataset, y: str) -> NDArray[Any]:
    """Return a number of each special point; missing where it is not known."""
    try:
        return _of(curve, y, special=True).values
    except ValueError:
        return np.full(curve.sizes["special"], np.nan)


def _label(values: xr.DataArray, name: str) -> str:
    words = values.attrs.get("long_name", name)
    unit = values.attrs.get("units", "")
    return f"{words} ({unit})" if unit not in ("", "1") else str(words)


def _draw_curve(axes: Axes, curve: xr.Dataset, name: str, y: str, colour: str) -> None:
    """Draw the parts of a curve, each as what it is."""
    after = curve["special_after"].values + 1
    x = np.insert(curve[name].values, after, curve["special_value"].values)
    height, valid, stable = _of(curve, y).values, *(curve[one].values.astype(bool) for one in ("valid", "stable"))
    height = np.insert(height, after, _of_special(curve, y))
    # A special point belongs to what comes before it.
    valid, stable = (np.insert(one, after, one[after - 1]) for one in (valid, stable))
    for words, some in (("stable", valid & stable), ("unstable", valid & ~stable), ("no gait", ~valid)):
        shown_x, shown_y = _parts(x, some), _parts(height, some)
        axes.plot(shown_x, shown_y, color=colour if words != "no gait" else GRAY, **LOOKS[words])  # type: ignore[arg-type]


def _parts(values: NDArray[Any], some: NDArray[np.bool_]) -> NDArray[Any]:
    """Return values of which only some are seen, with the next one, so that no line has gaps."""
    seen = some.copy()
    seen[1:] |= some[:-1]
    return np.where(seen, values, np.nan)


def _draw_special(axes: Axes, curve: xr.Dataset, y: str, colour: str) -> set[str]:
    """Mark the special points, where the number is known there; return their kinds."""
    heights, met = _of_special(curve, y), set()
    for kind, x, height in zip(curve["special_kind"].values, curve["special_value"].values, heights, strict=True):
        if str(kind) in MARKS:
            marker, filling = MARKS[str(kind)]
            axes.plot(x, height, marker, color=colour, markerfacecolor=filling, markeredgecolor=colour, zorder=3)
            met.add(str(kind))
    return met


def _draw_circle(figure: Figure, axes: Axes, curves: Sequence[xr.Dataset], name: str) -> None:
    """Draw the multipliers in the unit circle, in colours of what varies."""
    angles = np.linspace(0.0, 2.0 * np.pi, 200)
    axes.plot(np.cos(angles), np.sin(angles), color="black", linewidth=0.6)
    values = np.concatenate([one[name].values for one in curves])
    parts = np.concatenate([one["multipliers"].values.reshape(len(one[name]), -1, 2) for one in curves])
    known = np.concatenate([one["valid"].values.astype(bool) for one in curves])
    x, height = np.clip(parts[known, :, 0], -OUTSIDE, OUTSIDE), np.clip(parts[known, :, 1], -OUTSIDE, OUTSIDE)
    shades = np.repeat(values[known], x.shape[1]) if x.size else np.zeros(0)
    dots = axes.scatter(x.ravel(), height.ravel(), c=shades, s=5, cmap=sequential(), linewidths=0.0)
    axes.set(xlabel="multiplier, real part", ylabel="imaginary part", aspect="equal")
    axes.set(xlim=(-OUTSIDE, OUTSIDE), ylim=(-OUTSIDE, OUTSIDE))
    figure.colorbar(dots, ax=axes, label=_label(curves[0][name], name), shrink=0.8)
