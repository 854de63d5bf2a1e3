"""Tables 6.1-6.3: peak forces from our own data beside those measured and printed, and how many numbers agree."""

import math

import numpy as np
import xarray as xr

from legspring.peterson2011.published import published_forces
from legspring.peterson2011.tables import LEG_WORDS, Cell, Range, Table

OBJECTIVES = ("stability", "efficiency")
HEADINGS = (0.05, 0.40)
"""Range of headings over which Tables 6.1-6.3 take the smallest and the largest force, rad."""
CLEAR = 0.055
"""Difference of forces that asks for an explanation, in units of m g: 0.05, and what was lost in rounding."""


def force_ranges(atlas: xr.Dataset, selected: xr.Dataset, nelder_mead: xr.Dataset | None = None) -> xr.Dataset:
    """Return the numbers of Tables 6.1-6.3, ours beside the thesis's.

    Parameters
    ----------
    atlas
        Gaits with fixed actuation; branch 0 counts.
    selected
        Gaits of the best family of each cell, for each objective.
    nelder_mead
        The same, by the thesis's method.

    Returns
    -------
    xarray.Dataset
        Over leg, axis, slope_deg and extreme (see `legspring.peterson2011.published`): ``experiment``, ``model``,
        ``model_thesis``, and for each objective such as stability ``stability``, ``stability_nelder_mead`` and
        ``stability_thesis``; missing where there is no gait.
    """
    published = published_forces()
    columns = {
        "experiment": published["experiment"],
        "model": peak_range(atlas.sel(branch=0)),
        "model_thesis": published["model"],
    }
    for objective in OBJECTIVES:
        columns[objective] = peak_range(selected.sel(objective=objective))
        if nelder_mead is not None:
            columns[f"{objective}_nelder_mead"] = peak_range(nelder_mead.sel(objective=objective))
        columns[f"{objective}_thesis"] = published[objective]
    return xr.Dataset(columns)


def peak_range(gaits: xr.Dataset) -> xr.DataArray:
    """Return the smallest and the largest peak force over the headings of the tables, at their slopes."""
    peaks = table_cells(gaits)["peak_force"]
    both = xr.concat([peaks.min("heading"), peaks.max("heading")], dim="extreme").assign_coords(extreme=["min", "max"])
    return both.transpose("leg", "axis", "slope_deg", ..., "extreme").reset_coords(drop=True)


def table_cells(gaits: xr.Dataset) -> xr.Dataset:
    """Return the gaits at the slopes and headings of Tables 6.1-6.3; missing where the grid does not have them."""
    heading = gaits["heading"]
    inside = gaits.isel(heading=np.flatnonzero((heading > HEADINGS[0] - 1e-9) & (heading < HEADINGS[1] + 1e-9)))
    return inside.reindex(slope_deg=published_forces()["slope_deg"].values, method="nearest", tolerance=1e-9)


def peak_ranges(selected: xr.Dataset) -> xr.Dataset:
    """Return the numbers of Tables 6.1-6.3 for gaits of the best families, for either objective (see `peak_range`)."""
    return xr.Dataset({name: peak_range(selected.sel(objective=name)) for name in OBJECTIVES})


def agreement_table(ranges: xr.Dataset, starts: xr.Dataset | None = None) -> Table:
    """Return how many numbers of Tables 6.1-6.3 are the thesis's, and by how much the others differ.

    Parameters
    ----------
    ranges
        Of `force_ranges`.
    starts
        Of `peak_ranges`, over ``start`` as well: by the thesis's method from several other starts.
    """
    rows: list[tuple[Cell, ...]] = [("fixed", "", *_agreement(ranges["model"], ranges["model_thesis"]))]
    for objective in OBJECTIVES:
        thesis = ranges[f"{objective}_thesis"]
        rows.append((objective, "best gaits", *_agreement(ranges[objective], thesis)))
        if f"{objective}_nelder_mead" in ranges:
            words = "the thesis's method, run again"
            rows.append((objective, words, *_agreement(ranges[f"{objective}_nelder_mead"], thesis)))
        for number in [] if starts is None else starts["start"].values.tolist():
            again = starts[objective].sel(start=number) if starts is not None else thesis
            rows.append((objective, f"the same from another start, {number}", *_agreement(again, thesis)))
        if starts is not None:
            away = abs(starts[objective] - thesis)
            nearest = starts[objective].isel(start=away.fillna(np.inf).argmin("start"))
            rows.append((objective, "nearest of all other starts", *_agreement(nearest, thesis)))
    return Table(
        "6.agreement",
        f"Numbers of Tables 6.1 to 6.3 that are the thesis's to {CLEAR:g} m g, and the differences. The thesis's "
        "method ends at other gaits from other starts, and its starts are not known.",
        ("actuation", "by", "numbers", "agree", "median_difference", "largest_difference"),
        tuple(rows),
    )


def _agreement(ours: xr.DataArray, thesis: xr.DataArray) -> tuple[float, ...]:
    away = abs(ours - thesis).values
    away = away[np.isfinite(away)]
    agree = float(np.sum(away <= CLEAR))
    spread = (float(np.median(away)), float(np.max(away))) if away.size else (math.nan, math.nan)
    return (float(away.size), agree, *spread)


def error_table(ranges: xr.Dataset) -> Table:
    """Return how far forces are from those measured on animals: the root of the mean of squares, in m g.

    Parameters
    ----------
    ranges
        Of `force_ranges`.
    """
    rows: list[tuple[Cell, ...]] = []
    for name in (str(name) for name in ranges.data_vars if name != "experiment"):
        away = (ranges[name] - ranges["experiment"]) ** 2
        each = [math.sqrt(float(away.sel(leg=leg).mean())) for leg in ranges["leg"].values]
        words = name.replace("model", "fixed").replace("_thesis", ", as printed")
        rows.append((words.replace("_nelder_mead", ", by the thesis's method"), math.sqrt(float(away.mean())), *each))
    legs = [LEG_WORDS[str(leg)] for leg in ranges["leg"].values]
    return Table(
        "6.errors",
        "Distance of forces from those measured: root of the mean of squares in m g, over both directions, all slopes "
        "with measurements, and both ends of the ranges of Tables 6.1 to 6.3.",
        ("actuation", "all_legs", *(f"{leg}_legs" for leg in legs)),
        tuple(rows),
    )


def force_tables(ranges: xr.Dataset) -> tuple[Table, ...]:
    """Return Tables 6.1-6.3, one for each pair of legs, of what `force_ranges` has found."""
    names = [str(name) for name in ranges.data_vars]
    tables = []
    for number, leg in enumerate(ranges["leg"].values, start=1):
        rows: list[tuple[Cell, ...]] = []
        for axis in ranges["axis"].values:
            for slope in ranges["slope_deg"].values:
                here = ranges.sel(leg=leg, axis=axis, slope_deg=slope)
                cells = (Range(*map(float, here[name].sel(extreme=["min", "max"]))) for name in names)
                rows.append((str(axis).replace("_", "-"), float(slope), *cells))
        caption = (
            f"Peak forces of {LEG_WORDS[str(leg)]} legs in units of m g: smallest to largest over headings of "
            f"{HEADINGS[0]:.2f} to {HEADINGS[1]:.2f} rad."
        )
        tables.append(Table(f"6.{number}", caption, ("direction", "slope_deg", *names), tuple(rows)))
    return tuple(tables)
