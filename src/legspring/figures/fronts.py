"""Figures of fronts: what one good thing costs of another, and what it takes."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from legspring.checks import shown
from legspring.drawing.style import COLOURS, PAGE, new_figure, sequential, styled
from legspring.fronts import Front


@styled
def draw_front(front: Front | xr.Dataset) -> Figure:
    """Draw a front: its criteria against one another, and how parameters go along it.

    Of three criteria or more, the third is the colour; of two, colours are families.

    Parameters
    ----------
    front
        What `legspring.pareto` returns, or its dataset, or the file of that opened with xarray.

    Raises
    ------
    ValueError
        For something else, or a front without gaits.
    """
    data = front.to_dataset() if isinstance(front, Front) else front
    if not {"objectives", "parameters"} <= set(map(str, data.data_vars)):
        raise ValueError(f"front = {shown(type(front).__name__)}: must be one of legspring.pareto")
    if not data.sizes["point"]:
        raise ValueError("front: must have gaits to be drawn")
    values = data["objectives"].values
    figure = new_figure(PAGE, 0.42 * PAGE)
    left, right = figure.subplots(1, 2)
    _draw_values(figure, left, data, values)
    shares = (data["parameters"].values - data["least"].values) / (data["most"] - data["least"]).values
    order = np.argsort(values[:, 0], kind="stable")
    for n, name in enumerate(data["parameter"].values.tolist()):
        colour, marker = COLOURS[n % len(COLOURS)], "osD^v<>p"[n % 8]
        right.plot(values[order, 0], 100.0 * shares[order, n], marker=marker, color=colour, markersize=3.5, label=name)
    right.set(xlabel=_label(data, 0), ylabel="place in its range (%)", ylim=(-4.0, 104.0))
    right.legend(loc="upper center", bbox_to_anchor=(0.5, 1.0), ncols=2, fontsize="small").set_in_layout(False)
    right.set_ylim(-4.0, 104.0 + 13.0 * ((shares.shape[1] + 1) // 2))
    right.set_yticks(range(0, 101, 20))
    figure.suptitle(str(data.attrs.get("title", "")))
    return figure


def _draw_values(figure: Figure, axes: Axes, data: xr.Dataset, values: np.ndarray) -> None:
    """Draw the criteria, the first two as axes."""
    axes.set(xlabel=_label(data, 0), ylabel=_label(data, 1))
    if values.shape[1] > 2:
        mesh = axes.scatter(values[:, 0], values[:, 1], c=values[:, 2], cmap=sequential(), s=22)
        figure.colorbar(mesh, ax=axes, label=_label(data, 2))
        return
    families = data["family"].values.astype(str).tolist()
    names = list(dict.fromkeys(families))
    order = np.argsort(values[:, 0], kind="stable")
    axes.plot(values[order, 0], values[order, 1], color="0.8", linewidth=0.8, zorder=1)
    for n, name in enumerate(names):
        rows = [row for row, family in enumerate(families) if family == name]
        axes.plot(values[rows, 0], values[rows, 1], "o", color=COLOURS[n % len(COLOURS)], markersize=4)
    handles: list[Any] = [
        Line2D([], [], linestyle="", marker="o", color=COLOURS[n % len(COLOURS)], label=f"family {name}")
        for n, name in enumerate(names)
    ]
    axes.legend(handles=handles)


def _label(data: xr.Dataset, n: int) -> str:
    """Return what a criterion is called, with its unit and what is better."""
    name, unit = str(data["objective"].values[n]).replace("_", " "), str(data["objective_unit"].values[n])
    word = "less is better" if str(data["best"].values[n]) == "least" else "more is better"
    return f"{name}{f' ({unit})' if unit != '1' else ''}\n{word}"
