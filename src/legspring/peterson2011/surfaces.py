"""Where the thesis's families of gaits begin and end, as curves over slope and heading. A section of the report."""

import math
from collections.abc import Mapping

import numpy as np
import xarray as xr

from legspring.boundaries import boundary
from legspring.continuation import Continuation, Special
from legspring.following import follow, follow_connected
from legspring.gait import Gait
from legspring.landmarks import Kind
from legspring.model import Animal
from legspring.peterson2011.report import Section
from legspring.peterson2011.tables import Cell, Table
from legspring.planes import Boundary
from legspring.solve import find_gaits

RANGES = ((0.0, 90.0), (0.0, 0.6))
"""Slopes (deg) and headings (rad) within which lines are followed."""
PLACES = ((15.0, 0.2), (40.0, 0.4), (70.0, 0.2))
"""Where gaits are taken from whose curves cross these lines: slope (deg), heading (rad)."""
GAP = (40.0, 0.45)
"""A cell of the thesis's grid in which there is no gait."""
NEAR = 2e-3
"""Distance, in units of 90 deg and of 1 rad, within which lines are one."""


def lines(animal: Animal) -> xr.Dataset:
    """Follow the lines of folds, and those on which a leg has nothing to do, over slope and heading.

    Returns
    -------
    xarray.Dataset
        Over ``line`` and ``point``: ``slope_deg`` and ``heading``, missing beyond the end of a line; over ``line``:
        ``kind``, ``leg``, ``family`` of the gaits along it, and the place of its cusp, ``cusp_slope_deg`` and
        ``cusp_heading``. Attributes: how the two gaits of family B at 40 deg and 0.4 rad hang together.
    """
    found: list[tuple[Boundary, str]] = []
    labels: list[tuple[float, float, str]] = []
    for slope_deg, heading in PLACES:
        gait = find_gaits(animal, slope_deg=slope_deg, heading=heading)[0]
        first = follow(gait, "heading", within=RANGES[1])
        for curve in (first, *follow_connected(first)):
            labels.append((slope_deg, float(np.median(curve.values[curve.valid])), curve.gait.family))
            for special in curve.special:
                if special.kind in (Kind.FOLD, Kind.IDLE) and not any(passes(line, special) for line, _ in found):
                    found.append((boundary(special, "slope_deg", "heading", within=RANGES), curve.gait.family))
    slopes, headings, families = zip(*labels, strict=True)
    words = {"long_name": "where gaits of a family are"}
    return (
        as_dataset(found)
        .assign(
            label_slope_deg=("label", list(slopes), words),
            label_heading=("label", list(headings), words),
            label_family=("label", np.array(families, dtype=object), words),
        )
        .assign_attrs(animal=animal.name, **sheets(animal))
    )


def passes(line: Boundary, special: Special) -> bool:
    """Whether a line of the same kind passes a special point."""
    if (line.kind, line.leg) != (str(special.kind), special.leg):
        return False
    slopes, headings = line.values.T
    # Lines are polygons: between two points as well.
    place = np.array([special.gait.slope_deg / 90.0, special.gait.heading])
    points = np.stack([slopes / 90.0, headings], axis=1)
    starts, ways = points[:-1], np.diff(points, axis=0)
    shares = np.clip(np.sum((place - starts) * ways, axis=1) / np.sum(ways**2, axis=1), 0.0, 1.0)
    return bool(np.min(np.linalg.norm(starts + shares[:, None] * ways - place, axis=1), initial=math.inf) < NEAR)


def as_dataset(found: list[tuple[Boundary, str]]) -> xr.Dataset:
    """Return lines as a dataset, each filled up to the longest."""
    longest = max(len(line) for line, _ in found)
    values = np.full((len(found), longest, 2), math.nan)
    cusps = np.full((len(found), 2), math.nan)
    for n, (line, _) in enumerate(found):
        values[n, : len(line)] = line.values
        for corner in line.special:
            if corner.kind == "cusp":
                cusps[n] = corner.values
    words = {"kind": [one.kind for one, _ in found], "leg": [one.leg for one, _ in found]}
    words["family"] = [family for _, family in found]
    return xr.Dataset(
        {
            "slope_deg": (("line", "point"), values[:, :, 0], {"units": "degrees", "long_name": "slope"}),
            "heading": (("line", "point"), values[:, :, 1], {"units": "rad", "long_name": "heading"}),
            "cusp_slope_deg": ("line", cusps[:, 0], {"units": "degrees", "long_name": "slope of its cusp"}),
            "cusp_heading": ("line", cusps[:, 1], {"units": "rad", "long_name": "heading of its cusp"}),
            **{name: ("line", np.array(some, dtype=object)) for name, some in words.items()},
        },
        attrs={"title": "Lines at which families of gaits end, with the thesis's actuation"},
    )


def sheets(animal: Animal) -> dict[str, float]:
    """Return by how much the two gaits of a cell are missed by the one curve through both, over a fold."""
    both = find_gaits(animal, slope_deg=GAP[0], heading=0.4)
    curve = follow(both[0], "heading", within=RANGES[1])
    met = curve.at(0.4)
    off = [min(abs(one.speed - gait.speed) / gait.speed for one in met) for gait in both]
    return {"gaits_at_0.4": float(len(both)), "missed_by": max(off), "fold_between": fold_of(curve, both[0])}


def fold_of(curve: Continuation, gait: Gait) -> float:
    """Return the heading of the fold nearest above a gait."""
    return min(one.value for one in curve.special if one.kind is Kind.FOLD and one.value > gait.heading)


def section(found: xr.Dataset) -> Section:
    """Write the section.

    Parameters
    ----------
    found
        Of `lines`.
    """
    folds = found.isel(line=(found["kind"] == "fold").values)
    of_b = folds.isel(line=(folds["family"] == "B").values)
    line = of_b.isel(line=int(of_b["cusp_heading"].notnull().values.argmax()))
    known = line["heading"].notnull().values
    slopes, headings = line["slope_deg"].values[known], line["heading"].values[known]
    steep = slopes > float(line["cusp_slope_deg"]) + 2.0
    lowest = int(np.argmin(np.where(steep & (headings > 0.43), headings, math.inf)))
    rows: list[tuple[Cell, ...]] = []
    for n in range(found.sizes["line"]):
        one = found.isel(line=n)
        ends = [float(end(one[name])) for name in ("slope_deg", "heading") for end in (np.nanmin, np.nanmax)]
        rows.append((str(one["kind"].item()), str(one["leg"].item()) or "-", str(one["family"].item()), *ends))
    table = Table(
        "",
        "Lines at which families end, or a leg changes its function.",
        ("kind", "leg", "family", "least_slope_deg", "largest_slope_deg", "least_heading_rad", "largest_heading_rad"),
        tuple(rows),
    )
    about = found.attrs
    return Section(
        "Where families begin and end",
        [
            "A map on a grid shows points; continuation shows the lines at which gaits begin and end. Each line here "
            "is a curve in slope and heading, followed with exact derivatives. Along lines on which a leg has nothing "
            "to do one family goes over into another: that leg pulls on one side of it and pushes on the other. Along "
            "lines of folds two gaits meet, and beyond there are none.",
            f"Why there is no gait at {GAP[0]:g} deg and {GAP[1]:g} rad: the gaits of family B lie below a line of "
            f"folds, which dips to {headings[lowest]:.4f} rad at {slopes[lowest]:.1f} deg. To the left it turns back "
            f"in a cusp at {float(line['cusp_slope_deg']):.4f} deg and {float(line['cusp_heading']):.5f} rad, and ends "
            "where the front legs have nothing to do; there the line of folds of family FB begins.",
            "The two branches of B are two sheets of one surface, which meet in these folds: the one curve through "
            f"the gaits at {GAP[0]:g} deg and 0.4 rad goes up to {about['fold_between']:.10f} rad and comes back as "
            f"the other one, of which it misses the speed by a share of {about['missed_by']:.0e}.",
        ],
        tables=[table],
    )


def names(found: xr.Dataset) -> Mapping[int, str]:
    """Return what each line is, as legends say it."""
    words = {}
    for n in range(found.sizes["line"]):
        kind, leg, family = (str(found[name].values[n]) for name in ("kind", "leg", "family"))
        words[n] = f"folds of {family}" if kind == "fold" else f"{leg[0]} legs idle"
    return words
