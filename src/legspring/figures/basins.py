"""Figures of basins, of pushes and of rough ground: from where a gait comes back, and how long it goes on."""

import json

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from legspring.checks import shown
from legspring.drawing.style import COLOURS, PAGE, label, new_figure, sequential, styled
from legspring.figures.maps import edges
from legspring.settling import words_of

ELSEWHERE = ("0.35", "0.5", "0.62", "0.74", "0.84", "0.9", "0.95")
"""Colours of what does not settle, by its number, from -1 down."""


@styled
def draw_basin(dataset: xr.Dataset) -> Figure:
    """Draw where starts lead to, a colour for each attractor, and after how many steps that is known.

    Parameters
    ----------
    dataset
        Of `legspring.basin`, or its file opened with xarray.

    Raises
    ------
    ValueError
        For something else.
    """
    if not {"settles_on", "steps"} <= set(map(str, dataset.data_vars)):
        raise ValueError(f"dataset = {shown(type(dataset).__name__)}: must be one of legspring.basin")
    axes_names = [str(name) for name in dataset["settles_on"].dims]
    figure = new_figure(PAGE, 0.42 * PAGE if len(axes_names) == 2 else 0.25 * PAGE)
    if len(axes_names) == 1:
        draw_line(figure.subplots(), dataset, axes_names[0])
        return figure
    left, right = figure.subplots(1, 2, sharex=True, sharey=True)
    x, y = axes_names
    fates, steps = (dataset[name].transpose(y, x).values for name in ("settles_on", "steps"))
    across, up = (edges(dataset[name].values) for name in (x, y))
    colours = colours_of(fates)
    bounds = np.append(np.array(list(colours)) - 0.5, max(colours) + 0.5)
    left.pcolormesh(
        across, up, fates, cmap=ListedColormap(list(colours.values())), norm=BoundaryNorm(bounds, len(colours))
    )
    mesh = right.pcolormesh(across, up, np.where(fates >= 0, steps, np.nan), cmap=sequential())
    figure.colorbar(mesh, ax=right, label="steps until it is near")
    start = json.loads(str(dataset.attrs.get("gait", "{}")))
    for panel in (left, right):
        panel.set(xlabel=label(dataset[x].attrs, x), ylabel=label(dataset[y].attrs, y))
        if x in start and y in start:
            panel.plot(start[x], start[y], "*", color="white", markeredgecolor="black", markersize=7)
    right.label_outer()
    handles = [Patch(color=colour, label=words_of(dataset, n)) for n, colour in sorted(colours.items(), reverse=True)]
    star = Line2D([], [], linestyle="", marker="*", color="white", markeredgecolor="black", markersize=7, label="gait")
    figure.legend(handles=[*handles, star], loc="outside upper center", ncols=4)
    return figure


@styled
def draw_pushes(dataset: xr.Dataset, impulse: float | None = None) -> Figure:
    """Draw the largest push that is survived, over its direction and its moment, and how soon the gait is back.

    Parameters
    ----------
    dataset
        Of `legspring.pushes`, or its file opened with xarray.
    impulse
        For which to show how soon; by default the smallest.

    Raises
    ------
    ValueError
        For something else, or an impulse that was not tried.
    """
    if not {"survived", "recovery_steps"} <= set(map(str, dataset.data_vars)):
        raise ValueError(f"dataset = {shown(type(dataset).__name__)}: must be one of legspring.pushes")
    sizes = dataset["impulse"].values
    size = float(sizes[0] if impulse is None else impulse)
    if not np.isclose(sizes, size).any():
        raise ValueError(f"impulse = {size:g}: must be one of {', '.join(f'{one:g}' for one in sizes)}")
    figure = new_figure(PAGE, 0.45 * PAGE)
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    across, up = edges(dataset["moment"].values), edges(np.degrees(dataset["direction"].values))
    steps = dataset["recovery_steps"].sel(impulse=size, method="nearest").values
    words = ("largest impulse survived (m v_des)", f"steps until it is back from {size:g} m v_des")
    for axes, values, about in zip(panels, (dataset["survived"].values, steps), words, strict=True):
        mesh = axes.pcolormesh(across, up, values, cmap=sequential())
        figure.colorbar(mesh, ax=axes, label=about)
        axes.set_xlabel("part of the stride at which it begins")
    panels[0].set(ylabel="direction (deg), 0: to the right, 90: ahead", yticks=range(0, 360, 90))
    whole = dataset["lost"].isnull().values
    if whole.any():
        panels[0].contourf(
            dataset["moment"], np.degrees(dataset["direction"]), whole, levels=[0.5, 1.5], colors="none", hatches=["//"]
        )
        figure.legend(
            handles=[Patch(facecolor="white", edgecolor="0.3", hatch="//", label="all that were tried are survived")],
            loc="outside upper center",
        )
    return figure


@styled
def draw_rough(dataset: xr.Dataset) -> Figure:
    """Draw how many runs go on over rough ground, and how their speeds and headings spread.

    Parameters
    ----------
    dataset
        Of `legspring.rough`, or its file opened with xarray.

    Raises
    ------
    ValueError
        For something else.
    """
    if not {"survival", "speed_spread"} <= set(map(str, dataset.data_vars)):
        raise ValueError(f"dataset = {shown(type(dataset).__name__)}: must be one of legspring.rough")
    figure = new_figure(PAGE, 0.38 * PAGE)
    panels = figure.subplots(1, 3, sharex=True)
    step = dataset["step"].values
    for n, scale in enumerate(dataset["scale"].values):
        one, colour = dataset.isel(scale=n), COLOURS[n % len(COLOURS)]
        panels[0].plot(step, one["survival"], color=colour, label=f"{scale:g}")
        panels[0].fill_between(step, one["survival_low"], one["survival_high"], color=colour, alpha=0.2, linewidth=0)
        for axes, name in zip(panels[1:], ("speed", "heading"), strict=True):
            mean, spread = one[f"mean_{name}"], one[f"{name}_spread"]
            axes.plot(step, mean, color=colour)
            axes.fill_between(step, mean - spread, mean + spread, color=colour, alpha=0.2, linewidth=0)
    panels[0].set(ylabel="share of the runs that goes on", ylim=(-0.02, 1.02))
    panels[1].set(ylabel="speed (m/s), mean and spread")
    panels[2].set(ylabel="heading (rad), mean and spread")
    for axes in panels:
        axes.set_xlabel("step")
    figure.legend(title=f"multiple of {dataset.attrs['roughness']}", loc="outside upper center", ncols=6)
    return figure


def draw_line(axes: Axes, dataset: xr.Dataset, name: str) -> None:
    """Draw steps along one coordinate, a colour for each attractor."""
    fates, values = dataset["settles_on"].values, dataset[name].values
    for n, colour in sorted(colours_of(fates).items(), reverse=True):
        there = fates == n
        axes.plot(values[there], dataset["steps"].values[there], ".", color=colour, label=words_of(dataset, n))
    axes.set(xlabel=label(dataset[name].attrs, name), ylabel="steps until that is known")
    axes.legend()


def colours_of(fates: np.ndarray) -> dict[int, str]:
    """Return a colour for each number that occurs, in rising order."""
    return {int(n): COLOURS[int(n) % len(COLOURS)] if n >= 0 else ELSEWHERE[-int(n) - 1] for n in np.unique(fates)}
