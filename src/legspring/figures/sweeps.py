"""Figures of sweeps: maps, lines, parallel coordinates; and of what measures vary with."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from legspring.checks import shown
from legspring.drawing.style import COLOURS, COLUMN, PAGE, label, new_figure, sequential, styled, units
from legspring.figures.maps import edges, find, in_degrees

NOWHERE = "0.88"
"""Colour of places without a gait."""
LEVEL = 1e-6
"""Relative change of a measure below which it is level."""
MOST_LINES = 2000
"""Samples that are drawn as parallel coordinates."""


@styled
def draw_sweep(
    dataset: xr.Dataset, name: str, *, x: str | None = None, y: str | None = None, branch: int = 0, **at: Any
) -> Figure:
    """Draw a measure of a sweep: over two axes as a map, over one as lines, of samples as parallel coordinates.

    Parameters
    ----------
    dataset
        Of `legspring.sweep`, or its store or file opened with xarray.
    name
        The measure; angles are drawn in degrees.
    x, y
        Which axes of a grid; by default the first two, or the only one.
    branch
        Which gait, of a map or of samples; lines are drawn of all.
    **at
        Where along every further dimension, as in ``leg="F"``; of a grid's axes, by default in the middle.

    Raises
    ------
    ValueError
        For another dataset, or a name, axis or place that it does not have.
    """
    if "outcome" not in dataset or name not in dataset:
        raise ValueError(f"name = {shown(name)}: must be a measure of a dataset of legspring.sweep")
    if branch not in dataset["branch"].values:
        raise ValueError(f"branch = {shown(branch)}: must be one of {', '.join(map(str, dataset['branch'].values))}")
    axes_names = [str(dim) for dim in dataset["outcome"].dims if dim not in ("branch", "point")]
    if "point" in dataset["outcome"].dims:
        return _draw_parallel(dataset, name, branch, at)
    x = x or axes_names[0]
    y = y or next((one for one in axes_names if one != x), None)
    for one in (x, y) if y else (x,):
        if one not in axes_names:
            raise ValueError(f"x, y = {shown(one)}: must be of {', '.join(axes_names)}")
    if x == y:
        raise ValueError(f"x, y = {shown(x)}: must be two axes")
    places = {one: dataset[one].values[dataset.sizes[one] // 2] for one in axes_names if one not in (x, y)} | at
    here, words = _at(dataset, name, places)
    if y is None:
        return _draw_lines(here, name, x, words)
    figure = new_figure(COLUMN, 0.85 * COLUMN)
    axes = figure.subplots()
    values = in_degrees(here[name].sel(branch=branch)).transpose(y, x)
    axes.set_facecolor(NOWHERE)
    mesh = axes.pcolormesh(edges(here[x].values), edges(here[y].values), values.values, cmap=sequential())
    figure.colorbar(mesh, ax=axes, label=label(values.attrs, name))
    axes.set(xlabel=label(here[x].attrs, x), ylabel=label(here[y].attrs, y), title=words)
    if not np.isfinite(values.values).all():
        figure.legend(handles=[Patch(color=NOWHERE, label="no such gait")], loc="outside lower center")
    return figure


def _at(dataset: xr.Dataset, name: str, places: dict[str, Any]) -> tuple[xr.Dataset, str]:
    """Return a measure at some places, and words for these."""
    here, words = dataset[[name, "max_multiplier"] if "max_multiplier" in dataset else [name]], []
    for dim in dataset[name].dims:
        if str(dim) in ("leg", "single_leg", "axis", "sign", "multiplier", "part") and str(dim) not in places:
            raise ValueError(f"{dim} is missing: must be one of {', '.join(map(str, dataset[dim].values))}")
    for dim, value in places.items():
        if dim not in here.dims:
            raise ValueError(f"{dim} = {shown(value)}: must be a dimension of {name}")
        found = find(here[dim], value)
        here = here.sel({dim: found})
        words.append(f"{dim} {found:.4g}" if isinstance(found, float) else f"{dim} {found}")
    return here, ", ".join(words)


def _draw_lines(here: xr.Dataset, name: str, x: str, words: str) -> Figure:
    """Draw a measure along one axis, a line for each gait, unstable ones dashed."""
    figure = new_figure(COLUMN, 0.7 * COLUMN)
    axes: Axes = figure.subplots()
    values = in_degrees(here[name]).transpose(x, "branch")
    across = here[x].values
    for n, number in enumerate(here["branch"].values.tolist()):
        column, colour = values.sel(branch=number).values, COLOURS[n % len(COLOURS)]
        if not np.isfinite(column).any():
            continue
        axes.plot(across, column, "--", color=colour, linewidth=1.0)
        if "max_multiplier" in here:
            stable = here["max_multiplier"].sel(branch=number).values < 1.0
            axes.plot(across, np.where(stable, column, np.nan), color=colour, linewidth=1.6)
        axes.plot([], [], color=colour, label=f"gait {number}")
    axes.set(xlabel=label(here[x].attrs, x), ylabel=label(values.attrs, name), title=words)
    known = values.values[np.isfinite(values.values)]
    if len(known) and np.ptp(known) < LEVEL * np.max(np.abs(known)):
        # Digits of rounding are nothing to be looked at.
        axes.set_ylim(*(known.mean() + 0.05 * np.abs(known).max() * np.array([-1.0, 1.0])).tolist())
    axes.legend(title="dashed: unstable" if "max_multiplier" in here else None)
    return figure


def _draw_parallel(dataset: xr.Dataset, name: str, branch: int, places: dict[str, Any]) -> Figure:
    """Draw samples as lines from axis to axis, coloured by a measure."""
    here, words = _at(dataset, name, places)
    values = in_degrees(here[name].sel(branch=branch))
    names = [str(one) for one, series in dataset.coords.items() if series.dims == ("point",) and one != "point"]
    rows = np.flatnonzero(np.isfinite(values.values))[:MOST_LINES]
    if not len(rows):
        raise ValueError(f"branch = {branch}: must have gaits to be drawn")
    columns = [*(dataset[one].values[rows] for one in names), values.values[rows]]
    low, high = np.array([[column.min(), column.max()] for column in columns]).T
    shares = (np.array(columns).T - low) / np.where(high > low, high - low, 1.0)
    figure = new_figure(PAGE, 0.42 * PAGE)
    axes: Axes = figure.subplots()
    order = np.argsort(values.values[rows], kind="stable")
    lines = np.stack([np.broadcast_to(np.arange(len(columns)), shares.shape), shares], axis=-1)[order]
    drawn = LineCollection(list(lines), array=values.values[rows][order], cmap=sequential(), linewidths=0.7, alpha=0.7)
    axes.add_collection(drawn)
    figure.colorbar(drawn, ax=axes, label=label(values.attrs, name))
    own = [*(dataset[one].attrs for one in names), values.attrs]
    marks = [units(str(about.get("units", "1"))) for about in own]
    titles = [one if mark == "1" else f"{one}\n({mark})" for one, mark in zip([*names, name], marks, strict=True)]
    axes.set_xticks(range(len(columns)), titles, fontsize="small")
    axes.set(xlim=(-0.1, len(columns) - 0.9), ylim=(-0.02, 1.02), yticks=[], title=words)
    axes.spines[:].set_visible(False)
    for n, (least, most) in enumerate(zip(low, high, strict=True)):
        axes.axvline(n, color="0.3", linewidth=0.8)
        for height, text, side in ((0.0, least, "top"), (1.0, most, "bottom")):
            axes.annotate(f"{text:.4g}", (n, height), (3, 0), textcoords="offset points", fontsize="x-small", va=side)
    return figure


@styled
def draw_sobol(indices: xr.Dataset) -> Figure:
    """Draw which share of a measure's variance comes from which parameter, with confidence intervals.

    Parameters
    ----------
    indices
        Of `legspring.sobol_indices`.

    Raises
    ------
    ValueError
        For something else.
    """
    if not {"first_order", "total_order"} <= set(map(str, indices.data_vars)):
        raise ValueError(f"indices = {shown(type(indices).__name__)}: must be of legspring.sobol_indices")
    names = indices["parameter"].values.tolist()
    figure = new_figure(COLUMN, 0.6 * COLUMN)
    axes: Axes = figure.subplots()
    for n, (kind, words) in enumerate((("first_order", "by itself"), ("total_order", "with others"))):
        place, values = np.arange(len(names)) + 0.36 * (n - 0.5), indices[kind].values
        off = np.abs(np.array([indices[f"{kind}_low"].values, indices[f"{kind}_high"].values]) - values)
        axes.bar(place, values, 0.34, yerr=off, color=COLOURS[n], label=words, capsize=2, error_kw={"linewidth": 0.8})
    axes.set_xticks(range(len(names)), names)
    axes.set(ylabel=f"share of the variance of\n{str(indices.attrs['measure']).replace('_', ' ')}")
    axes.axhline(0.0, color="0.3", linewidth=0.8)
    axes.legend()
    return figure
