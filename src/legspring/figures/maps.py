"""Maps of gaits over a grid: one filled cell for each gait, nothing in between."""

import json
import math
from collections.abc import Mapping, Sequence
from string import ascii_lowercase
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path
from matplotlib.transforms import Affine2D
from numpy.typing import NDArray

from legspring.drawing.style import COLUMN, MARKERS, PAGE, diverging, label, new_figure, sequential, styled, units

Floats = NDArray[np.float64]
Limits = tuple[float, float]

NOT_RECOVERED = 100.0
"""What a gait that does not recover is drawn as, in steps."""
NEUTRAL = 1e-6
"""Excess of a multiplier over 1 that does not make a gait unstable: what is conserved has a multiplier of 1."""


class Map(NamedTuple):
    """A map in its axes: its cells, what their colours mean, and what a legend has to explain."""

    axes: Axes
    mesh: QuadMesh
    words: str
    handles: list[Artist]


@styled
def draw_atlas(
    dataset: xr.Dataset,
    name: str,
    *,
    x: str = "slope_deg",
    y: str | None = "heading",
    branch: int = 0,
    limits: Limits | None = None,
    families: bool = True,
    **at: Any,
) -> Figure:
    """Draw a map of one variable of an atlas, or of optimised gaits.

    Parameters
    ----------
    dataset
        Of `legspring.atlas`, or its file opened with xarray; or gaits over another grid in the same form.
    name
        The variable; angles are drawn in degrees.
    x, y
        Dimensions along the axes; without y, the variable is drawn against x, for all branches.
    branch
        Which branch, where there are several.
    limits
        Range of colours; by default that of the data.
    families
        Whether markers show the families.
    **at
        Where the map lies in every further dimension of the variable, as in ``leg="F"`` or ``impulse=0.5``.

    Returns
    -------
    matplotlib.figure.Figure
        Cells without a gait are hatched in gray, unstable gaits in black; gaits that do not recover are crossed.

    Raises
    ------
    ValueError
        For a variable, dimension or place that the atlas does not have.
    """
    figure = new_figure(COLUMN, 0.85 * COLUMN)
    if y is None:
        draw_points(figure.subplots(), dataset, name, x, limits, at)
        return figure
    drawn = draw_map(figure.subplots(), dataset, name, x=x, y=y, limits=limits, families=families, branch=branch, **at)
    add_bar(figure, [drawn])
    add_legend(figure, [drawn])
    return figure


def draw_points(
    axes: Axes, dataset: xr.Dataset, name: str, x: str, limits: Limits | None, at: Mapping[str, Any]
) -> None:
    """Draw a variable against one dimension, a point for each gait; those that are stable are filled."""
    grid, place = slice_at(dataset, name, x, "branch", dict(at))
    values = in_degrees(grid[name]).transpose(x, "branch")
    stable = (grid["max_multiplier"] < 1.0 + 1e-9).transpose(x, "branch").values
    across = np.broadcast_to(grid[x].values[:, None], values.shape)
    for which, words, face in ((stable, "stable", "C0"), (~stable, "unstable", "white")):
        there = which & np.isfinite(values.values)
        if there.any():
            style: dict[str, Any] = {"linestyle": "none", "marker": "o", "color": "C0", "markerfacecolor": face}
            axes.plot(across[there], values.values[there], label=words, **style)
    axes.set(xlabel=label(grid[x].attrs, x), ylabel=label(values.attrs, name), ylim=limits)
    axes.set_title(place)
    axes.legend(frameon=False)


@styled
def draw_panels(
    dataset: xr.Dataset, name: str, places: Sequence[Mapping[str, Any]], *, limits: Limits, families: bool = False
) -> Figure:
    """Draw maps of one variable at several places, two in a row, in colours that one bar explains.

    Parameters
    ----------
    dataset, name, limits, families
        As in `draw_atlas`.
    places
        Where each map lies in the dimensions other than slope and heading.
    """
    figure, grid = panel_grid(len(places))
    maps = [
        draw_map(axes, dataset, name, limits=limits, families=families, **place)
        for axes, place in zip(grid, places, strict=True)
    ]
    add_letters(maps)
    add_bar(figure, maps)
    add_legend(figure, maps)
    return figure


def panel_grid(count: int) -> tuple[Figure, list[Axes]]:
    """Return a figure as wide as a page, and its panels, two in a row, on the same axes."""
    rows = math.ceil(count / 2)
    figure = new_figure(PAGE, 0.37 * PAGE * rows)
    grid = list(figure.subplots(rows, 2, sharex=True, sharey=True, squeeze=False).flat)
    for axes in grid[count:]:
        axes.remove()
    return figure, grid[:count]


def draw_map(
    axes: Axes,
    dataset: xr.Dataset,
    name: str,
    *,
    x: str = "slope_deg",
    y: str = "heading",
    limits: Limits | None = None,
    families: bool = True,
    title: str | None = None,
    **at: Any,
) -> Map:
    """Draw a map into axes, without its colour bar; see `draw_atlas`."""
    grid, place = slice_at(dataset, name, x, y, at)
    values = in_degrees(grid[name])
    lost = np.zeros(values.shape, dtype=bool)
    if name == "recovery_steps" and "recovered" in grid:
        lost = grid["recovered"].values == 0.0
        values = values.where(~lost, NOT_RECOVERED)
    if values.size == 0:
        raise ValueError(f"{name}: the atlas has no {' or '.join(dim for dim in (x, y) if values.sizes[dim] == 0)}")
    mesh = fill_cells(axes, values, limits)
    axes.set(xlabel=label(grid[x].attrs, x), ylabel=label(grid[y].attrs, y))
    axes.set_title(title if title is not None else place)
    handles = hatch_unstable(axes, grid, x, y)
    # Large enough to show around the marker of the family.
    handles += mark(axes, grid, x, y, lost, "x", meaning="not recovered", size=8.0)
    if families and "family" in grid.data_vars:
        for marker, family in zip(MARKERS, family_order(dataset), strict=False):
            handles += mark(axes, grid, x, y, grid["family"].values == family, marker, meaning=family)
    axes.label_outer()
    handles += empty(axes) if bool(values.isnull().any()) else []
    return Map(axes, mesh, label(values.attrs), handles)


def slice_at(dataset: xr.Dataset, name: str, x: str, y: str, at: dict[str, Any]) -> tuple[xr.Dataset, str]:
    """Cut the plane of a map out of an atlas, y down and x across, and describe where it lies."""
    numbers = [str(variable) for variable, array in dataset.data_vars.items() if array.dtype.kind == "f"]
    if name not in numbers:
        raise ValueError(f"name = {name!r}: must be one of {', '.join(numbers)}")
    dims = [str(dim) for dim in dataset[name].dims]
    if unknown := [dim for dim in (x, y, *at) if dim not in dims and dim != "branch"]:
        raise ValueError(f"{name} has no dimension {unknown[0]!r}: must be one of {', '.join(dims)}")
    grid, places = dataset, []
    for dim in dims:
        if dim in (x, y):
            continue
        grid = grid.sel({dim: find(dataset[dim], at.get(dim))})
        if dim != "branch" or at[dim]:
            unit = units(dataset[dim].attrs.get("units", ""))
            places.append(f"{dim} {grid[dim].item()} {unit}".strip().replace("_aft", "-aft"))
    kept = [variable for variable, array in grid.data_vars.items() if set(array.dims) == {x, y}]
    return grid[kept].transpose(y, x), ", ".join(places)


def find(coordinate: xr.DataArray, value: Any) -> Any:
    """Return the value as the coordinate has it, whatever rounding has done to it."""
    values = coordinate.values
    rounded = isinstance(value, int | float) and values.dtype.kind in "if"
    same = np.isclose(values, value) if rounded else values == value
    if not np.any(same):
        offered = ", ".join(map(str, values.tolist())) or "nothing, as the atlas has none"
        raise ValueError(f"{coordinate.name} = {value!r}: must be one of {offered}")
    return values[same][0]


def in_degrees(array: xr.DataArray) -> xr.DataArray:
    """Return angles in degrees, and all else as it is."""
    if array.attrs.get("units") != "rad":
        return array
    return (array * (180.0 / math.pi)).assign_attrs(array.attrs | {"units": "deg"})


def fill_cells(axes: Axes, values: xr.DataArray, limits: Limits | None) -> QuadMesh:
    """Fill the cells of a plane with colours, each centred on its point."""
    y, x = (edges(values[dim].values) for dim in values.dims)
    if limits is None:
        limits = value_range([values.values])
        if limits[0] < 0.0 < limits[1]:
            limits = (-max(-limits[0], limits[1]), max(-limits[0], limits[1]))
    colours = diverging(*limits) if limits[0] < 0.0 < limits[1] else sequential()
    return axes.pcolormesh(x, y, values.values, cmap=colours, vmin=limits[0], vmax=limits[1], rasterized=True)


def value_range(arrays: Sequence[Floats]) -> Limits:
    """Return the least and the greatest of all numbers, or 0 and 1 if there are none."""
    known = np.concatenate([array[np.isfinite(array)] for array in arrays])
    return (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)


def add_letters(maps: Sequence[Map]) -> None:
    """Put a), b), ... before the maps' titles."""
    for letter, drawn in zip(ascii_lowercase, maps, strict=False):
        drawn.axes.set_title(f"{letter}) {drawn.axes.get_title()}")


def add_bar(figure: Figure, maps: Sequence[Map]) -> None:
    """Add one colour bar for maps in the same colours; it is pointed where values lie beyond it."""
    first, limits = maps[0], maps[0].mesh.get_clim()
    low, high = value_range([np.ma.filled(np.ma.asarray(drawn.mesh.get_array()), np.nan) for drawn in maps])
    beyond = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
    extend = beyond[low < limits[0], high > limits[1]]
    figure.colorbar(first.mesh, ax=[drawn.axes for drawn in maps], label=first.words, extend=extend, pad=0.02)


def edges(centres: Floats) -> Floats:
    """Return the borders of cells around their centres."""
    if len(centres) == 1:
        half = 0.05 * max(abs(float(centres[0])), 1.0)
        return np.array([centres[0] - half, centres[0] + half])
    middles = 0.5 * (centres[1:] + centres[:-1])
    return np.concatenate([[2.0 * centres[0] - middles[0]], middles, [2.0 * centres[-1] - middles[-1]]])


def mark(
    axes: Axes,
    grid: xr.Dataset,
    x: str,
    y: str,
    where: NDArray[np.bool_],
    marker: str,
    *,
    meaning: str,
    size: float | None = None,
) -> list[Artist]:
    """Put a marker into some cells; return the legend's entry for it, if there are any."""
    rows, columns = np.nonzero(where)
    if not len(rows):
        return []
    return [
        *axes.plot(
            grid[x].values[columns],
            grid[y].values[rows],
            linestyle="none",
            marker=marker,
            color="black",
            markerfacecolor="white",
            markeredgewidth=0.6,
            markersize=size,
            label=meaning,
        )
    ]


def hatch_unstable(axes: Axes, grid: xr.Dataset, x: str, y: str) -> list[Artist]:
    """Hatch the cells whose gaits are unstable by the complete map; return the legend's entry, if there are any."""
    if "max_multiplier" not in grid:
        return []
    rows, columns = np.nonzero(grid["max_multiplier"].values > 1.0 + NEUTRAL)
    if not len(rows):
        return []
    across, up = edges(grid[x].values), edges(grid[y].values)
    cells = [
        Path.unit_rectangle().transformed(Affine2D.from_values(*corner))
        for corner in (
            (across[column + 1] - across[column], 0.0, 0.0, up[row + 1] - up[row], across[column], up[row])
            for row, column in zip(rows, columns, strict=True)
        )
    ]
    look: dict[str, Any] = {"facecolor": "none", "edgecolor": "black", "linewidth": 0.0, "hatch": "xxxx"}
    axes.add_patch(PathPatch(Path.make_compound_path(*cells), **look))
    return [Patch(label="unstable", **look)]


def empty(axes: Axes) -> list[Artist]:
    """Hatch the ground that shows where there is no cell; return the legend's entry for it."""
    look: dict[str, Any] = {"facecolor": "white", "edgecolor": "0.7", "hatch": "/////"}
    axes.patch.set(**look)
    return [Patch(label="no gait", linewidth=0.4, **look)]


def family_order(dataset: xr.Dataset) -> list[str]:
    """Return the families' labels as the animal has them, or sorted if the atlas does not say."""
    found = {str(family) for family in np.unique(dataset["family"].values.astype(str))} - {""}
    known = json.loads(dataset.attrs.get("parameters", "{}")).get("families", {})
    return [*known, *sorted(found - set(known))]


def add_legend(figure: Figure, maps: Sequence[Map]) -> None:
    """Explain each kind of marker once, above the maps."""
    unique = {str(handle.get_label()): handle for drawn in maps for handle in drawn.handles}
    if unique:
        figure.legend(
            handles=list(unique.values()),
            loc="outside upper center",
            ncols=len(unique),
            handletextpad=0.3,
            columnspacing=1.2,
        )
