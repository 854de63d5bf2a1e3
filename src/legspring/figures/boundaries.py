"""Figures of boundaries: lines of folds, of idle legs, of stability lost, in two parameters."""

from collections.abc import Sequence

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from legspring.checks import shown
from legspring.drawing.style import COLOURS, PAGE, new_figure, styled
from legspring.planes import Boundary

CORNERS = {"cusp": ("^", "black"), "fold": ("o", "white")}
"""Marker and filling of what is special on a boundary; all else is a small dot."""
Boundaries = Boundary | xr.Dataset | Sequence[Boundary | xr.Dataset]


@styled
def draw_boundaries(boundaries: Boundaries) -> Figure:
    """Draw boundaries in the plane of their two parameters, a colour for each kind.

    Parameters
    ----------
    boundaries
        One or several in the same two parameters: what `legspring.boundary` returns, or their datasets.

    Raises
    ------
    ValueError
        For something else, or boundaries in other parameters.
    """
    some = [boundaries] if isinstance(boundaries, Boundary | xr.Dataset) else list(boundaries)
    data = [one.to_dataset() if isinstance(one, Boundary) else one for one in some]
    if not data or any("boundary" not in one.attrs for one in data):
        raise ValueError(f"boundaries = {shown(boundaries)}: must be boundaries that were followed, or their datasets")
    planes = {tuple(map(str, one.attrs["parameters"])) for one in data}
    if len(planes) > 1:
        raise ValueError("boundaries: must be in the same two parameters, in the same order")
    ((first, second),) = planes
    figure = new_figure(PAGE, 3.6)
    axes = figure.subplots()
    add_boundaries(axes, data)
    axes.set(xlabel=_label(data[0], first), ylabel=_label(data[0], second))
    figure.suptitle(f"{data[0].attrs['animal']}")
    figure.legend(loc="outside lower center", ncols=4)
    return figure


def add_boundaries(axes: Axes, data: Sequence[xr.Dataset]) -> None:
    """Draw boundaries into a map of their two parameters, with labels for a legend."""
    kinds = list(dict.fromkeys(str(one.attrs["boundary"]) for one in data))
    first, second = (str(name) for name in data[0].attrs["parameters"])
    met: set[str] = set()
    for one in data:
        kind = str(one.attrs["boundary"])
        colour = COLOURS[kinds.index(kind) % len(COLOURS)]
        axes.plot(one[first], one[second], color=colour, label=kind if kind not in met else None)
        met.add(kind)
        for what, x, y in zip(
            one["special_kind"].values, one[f"special_{first}"].values, one[f"special_{second}"].values, strict=True
        ):
            marker, filling = CORNERS.get(str(what), (".", colour))
            axes.plot(x, y, marker, color=colour, markerfacecolor=filling, markeredgecolor=colour, zorder=3)
            if str(what) in CORNERS and str(what) not in met:
                axes.add_line(
                    Line2D([], [], linestyle="", color="black", marker=marker, markerfacecolor=filling, label=what)
                )
                met.add(str(what))


def _label(data: xr.Dataset, name: str) -> str:
    unit = str(data[name].attrs.get("units", ""))
    words = {"slope_deg": "slope"}.get(name, name.replace("_", " "))
    return f"{words} ({unit})" if unit not in ("", "1") else words
