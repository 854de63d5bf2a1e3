"""What yaw changes: the cockroach as a rigid body, its hips where they are. A section of the report."""

import math
from collections import Counter
from collections.abc import Iterator, Mapping

import numpy as np
import xarray as xr

from legspring.atlases import atlas
from legspring.checks import checked_workers
from legspring.gait import Gait
from legspring.mapping import find_all, provenance
from legspring.model import Animal, load_animal
from legspring.parallel import processes
from legspring.peterson2011.claims.evidence import animal_of, exists
from legspring.peterson2011.force_tables import HEADINGS, peak_range, table_cells
from legspring.peterson2011.published import published_forces
from legspring.peterson2011.report import Section
from legspring.peterson2011.tables import LEG_WORDS, Cell, Range, Table
from legspring.peterson2011.walks import straight, walk, with_hips

SLOPES_DEG = (0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0)
"""Those of Tables 6.1-6.3."""
STARTS = 12
"""Starts for each family in each cell of a coarse grid, whose cells are too far apart to help each other."""
BACK_MM = (0.0, 4.0, 7.0, 10.0)
"""By how much all hips are moved back, mm."""
BACK_SLOPES_DEG, BACK_HEADINGS = (0.0, 30.0, 60.0, 90.0), (0.05, 0.15, 0.25)
NEUTRAL = 1e-6
"""A multiplier that is not below 1 by more than this is none of a stable gait; on the level, one is exactly 1."""
UNCERTAINTY = 0.10
"""How well the yaw of animals is known, rad."""
USUAL = (0.10, 0.20)
"""Headings of animals, rad."""


def rigid_cockroach() -> Animal:
    """Return the cockroach that yaws."""
    return load_animal("cockroach_rigid")


def held(workers: int | None = None) -> xr.Dataset:
    """Map the gaits of the rigid cockroach with its yaw held, at the slopes of the tables: what hips do without yaw."""
    animal = rigid_cockroach().replace(yaw="held")
    return atlas(animal, slopes_deg=SLOPES_DEG, impulses=(), starts=STARTS, workers=workers)


def fates(point_mass: xr.Dataset, workers: int | None = None) -> xr.Dataset:
    """Follow gaits of the point mass while its hips move to where they are and its inertia comes from infinity.

    Parameters
    ----------
    point_mass
        Its atlas; only the slopes of the tables and every other heading count.
    workers
        Processes; by default one a core.

    Returns
    -------
    xarray.Dataset
        Over slope_deg, heading and branch: ``reached``, how far the gait could be followed (1: all the way), missing
        where there is none, and ``loss``, why not farther.
    """
    some = point_mass.isel(heading=slice(1, None, 2))
    some = some.isel(slope_deg=np.flatnonzero(np.isin(some["slope_deg"], SLOPES_DEG)))
    dims = ("slope_deg", "heading", "branch")
    reached, loss = xr.full_like(some["speed"], np.nan), xr.full_like(some["family"], "")
    found, rigid = list(gaits_of(some)), rigid_cockroach()
    with processes(checked_workers(workers)) as pool:
        ends = pool.map(pool.call, [(fate, gait, rigid) for _, gait in found])
        for (place, _), end in zip(found, ends, strict=True):
            reached.loc[place], loss.loc[place] = end
    reached.attrs = {"long_name": "how far the gait could be followed", "units": "1"}
    about = {"title": "Gaits of the point mass, followed to the rigid body"}
    return xr.Dataset(
        {"reached": (dims, reached.values, reached.attrs), "loss": (dims, loss.values)},
        {dim: some[dim] for dim in dims},
        provenance(animal_of(point_mass)) | about,
    )


def fate(gait: Gait, rigid: Animal) -> tuple[float, str]:
    """Return how far a gait can be followed on the straight way to another animal, and why not farther."""
    end = walk(gait, straight(gait.animal, rigid))
    return end.places[-1], str(end.loss or "")


def gaits_of(dataset: xr.Dataset) -> Iterator[tuple[dict[str, float], Gait]]:
    """Go through the gaits of an atlas of bodies that do not yaw, and where they are."""
    animal = animal_of(dataset)
    for slope in dataset["slope_deg"].values.tolist():
        for heading in dataset["heading"].values.tolist():
            for branch in dataset["branch"].values.tolist():
                place = {"slope_deg": slope, "heading": heading, "branch": branch}
                one = dataset.sel(place)
                if one["family"].item():
                    yield (
                        place,
                        Gait(
                            animal=animal,
                            slope=math.radians(slope),
                            heading=heading,
                            family=str(one["family"].item()),
                            speed=float(one["speed"]),
                            phase=tuple(one["phase"].values.tolist()),
                            actuation=tuple(one["actuation"].values.tolist()),
                            residual=float(one["residual"]),
                            branch=branch,
                        ),
                    )


def hips_moved_back(workers: int | None = None) -> xr.Dataset:
    """Move all hips of the rigid cockroach back, its feet staying, and count stable gaits on a coarse grid.

    Returns
    -------
    xarray.Dataset
        Over back (mm): ``gaits``, ``cells`` with a gait, ``stable`` cells, and ``least_multiplier``, the smallest of
        the gaits' largest multipliers.
    """
    animal = rigid_cockroach()
    hips = np.array([leg.hip for leg in animal.legs[: len(animal.pairs)]])
    rows = []
    for back in BACK_MM:
        moved = with_hips(animal, hips - [0.0, 1e-3 * back])
        found, _ = find_all(moved, BACK_SLOPES_DEG, BACK_HEADINGS, starts=STARTS, workers=workers)
        largest = [[float(abs(gait.multipliers[0])) for gait in here] for here in found.values()]
        least = [min(here) for here in largest if here]
        stable = sum(number < 1.0 - NEUTRAL for number in least)
        rows.append((sum(map(len, largest)), len(least), stable, min(least, default=math.nan)))
    names = ("gaits", "cells", "stable", "least_multiplier")
    values = np.array(rows, dtype=float)
    return xr.Dataset(
        {name: ("back", values[:, column]) for column, name in enumerate(names)},
        {"back": ("back", list(BACK_MM), {"units": "mm", "long_name": "hips moved back"})},
        provenance(animal) | {"title": "Stability of the rigid cockroach with its hips further back"},
    )


def section(
    point_mass: xr.Dataset, yawing: xr.Dataset, held: xr.Dataset, fates: xr.Dataset, hips: xr.Dataset
) -> Section:
    """Say what yaw changes.

    Parameters
    ----------
    point_mass
        Atlas of the thesis's animal; branch 0 is the published one.
    yawing
        Atlas of `rigid_cockroach`.
    held, fates, hips
        Of `held`, `fates` and `hips_moved_back`.
    """
    bodies = bodies_of(point_mass, held, yawing)
    return Section(
        "A body that yaws",
        [
            _model(yawing),
            _existence(point_mass, yawing, fates),
            _stability(point_mass, yawing, held),
            _hips(yawing, hips),
            _turning(yawing),
            _forces(bodies),
        ],
        tables=[_hips_table(hips), _back_table(force_ranges(bodies)), _outside_table(bodies)],
    )


def bodies_of(point_mass: xr.Dataset, held: xr.Dataset, yawing: xr.Dataset) -> dict[str, xr.Dataset]:
    """Return the gaits whose forces are compared, by what the body is."""
    return {
        "point mass, published": point_mass.isel(branch=[0]),
        "point mass, all gaits": point_mass,
        "hips, yaw held": held,
        "hips and yaw": yawing,
    }


def force_ranges(bodies: Mapping[str, xr.Dataset]) -> xr.Dataset:
    """Return the smallest and the largest peak force at the slopes of the tables, measured and of each body.

    Over leg, axis, slope_deg and extreme; over the headings of the tables, and over all branches.
    """
    ranges = {"measured": published_forces()["experiment"]}
    for name, gaits in bodies.items():
        each = peak_range(gaits)
        ends = [each.sel(extreme="min").min("branch"), each.sel(extreme="max").max("branch")]
        ranges[name] = xr.concat(ends, dim="extreme").assign_coords(extreme=["min", "max"])
    return xr.Dataset(ranges)


def _model(yawing: xr.Dataset) -> str:
    animal = animal_of(yawing)
    inertia = animal.body.inertia or math.nan
    return (
        f"The thesis's animal is a point mass, whose legs all start at its centre. Its appendix has a moment of "
        f"inertia ({inertia:.3g} kg m^2) and hips, for later work. Here they are used: the body yaws, turned by the "
        f"moment of all legs about the centre of mass. Nominal feet, stiffness and actuation (in m) stay those of the "
        f"point mass; legs are shorter by as much as their hips are nearer to the feet."
    )


def _existence(point_mass: xr.Dataset, yawing: xr.Dataset, fates: xr.Dataset) -> str:
    there, before = exists(yawing), exists(point_mass)
    families = Counter(yawing["family"].values[there.values].tolist())
    names = ", ".join(f"{families[name]} {name}" for name in animal_of(yawing).families if families[name])
    followed = fates["reached"].notnull()
    losses = Counter(fates["loss"].values[followed.values].tolist())
    arrived = losses.pop("", 0)
    text = (
        f"The search finds {int(there.sum())} gaits in {int(there.any('branch').sum())} of "
        f"{there.isel(branch=0).size} cells ({names}); of the point mass there are {int(before.sum())} in "
        f"{int(before.any('branch').sum())}. Of {int(followed.sum())} gaits of the point mass that were followed while "
        f"its hips moved from the centre to their places and 1/inertia grew from 0, {arrived} arrived."
    )
    if losses:
        reasons = "; ".join(f"{count}: {reason}" for reason, count in losses.most_common())
        text += f" The others ended on the way ({reasons})."
    return text


def _stable(gaits: xr.Dataset) -> xr.DataArray:
    return gaits["max_multiplier"] < 1.0 - NEUTRAL


def _stability(point_mass: xr.Dataset, yawing: xr.Dataset, held: xr.Dataset) -> str:
    text = "; ".join(
        f"{words}, {int(_stable(gaits).sum())} of {int(exists(gaits).sum())}"
        for words, gaits in (
            ("of the point mass", point_mass),
            ("with hips and the yaw held (slopes of Tables 6.1 to 6.3)", held),
            ("with hips and yaw", yawing),
        )
    )
    multiplier = yawing["max_multiplier"]
    return (
        f"By the complete map, which for a body that yaws has yaw, yaw rate and the turn over the last step among its "
        f"variables, stable gaits are: {text}. The largest multiplier of the gaits that yaw is "
        f"{float(multiplier.median()):.2f} in the median and {float(multiplier.min()):.3f} at least: the legs' clock "
        f"alone does not keep this body on its course."
    )


def _hips(yawing: xr.Dataset, hips: xr.Dataset) -> str:
    best = hips.isel(back=int(np.argmax(hips["stable"].values)))
    if float(best["stable"]) == 0.0:
        return "Moving all hips back, the feet staying where they are, makes no gait stable."
    middle = 1e3 * float(np.mean([leg.hip[1] for leg in animal_of(yawing).legs]))
    return (
        f"Much depends on where the hips are. On average they are {middle:g} mm before the centre of mass. Moved back "
        f"by {float(best['back']):g} mm, the feet staying where they are, {int(best['stable'])} of "
        f"{int(best['cells'])} cells with a gait have a stable one, though nothing else has changed. Moving "
        f"them less or more makes fewer stable."
    )


def _turning(yawing: xr.Dataset) -> str:
    usual = yawing.sel(heading=slice(USUAL[0] - 1e-9, USUAL[1] + 1e-9))
    yaw, moment = usual["yaw_amplitude"], 1e6 * usual["peak_moment"]
    within = int((yaw < UNCERTAINTY).sum())
    every = yawing["yaw_amplitude"].stack(gait=("slope_deg", "heading", "branch"))
    widest = every.isel(gait=int(np.nanargmax(every.values)))
    return (
        f"At headings of {USUAL[0]:.2f} to {USUAL[1]:.2f} rad, the body yaws by {_range(yaw)} rad to either side, "
        f"{float(yaw.median()):.3f} in the median, under moments with peaks of {_range(moment, 0)} micronewton metres. "
        f"In {within} of {int(exists(usual).sum())} of these gaits it is less than {UNCERTAINTY:.2f} rad, to which the "
        f"yaw of animals is known: measurements would hardly show it. The largest amplitude of "
        f"all is {float(widest):.2f} rad, at {float(widest['slope_deg']):g} deg and "
        f"{float(widest['heading']):g} rad."
    )


def _range(values: xr.DataArray, digits: int = 3) -> str:
    return f"{float(values.min()):.{digits}f} to {float(values.max()):.{digits}f}"


def _forces(bodies: Mapping[str, xr.Dataset]) -> str:
    measured = published_forces()["experiment"].sel(leg="B", axis="lateral")
    back = {name: table_cells(gaits)["peak_force"].sel(leg="B", axis="lateral") for name, gaits in bodies.items()}
    ranges = "; ".join(f"{_range(force, 2)} ({name})" for name, force in back.items())
    far = {name: float(outside(gaits).sel(leg="B", axis="lateral")) for name, gaits in bodies.items()}
    misses = "; ".join(f"{miss:.2f} ({name})" for name, miss in far.items())
    text = (
        f"Does the back legs' lateral force come nearer to the measured one? Measured it is {_range(measured, 2)} m g "
        f"over all slopes, computed {ranges}. On average it misses the range that was measured at its slope by "
        f"{misses}. "
    )
    lowest = min(float(force.min()) for force in back.values())
    if lowest > 0.0:
        text += (
            "It never changes its sign: a back leg that pushes can only push inwards, with its foot on its own side, "
            "wherever its hip is. "
        )
    changes = {
        "where the hips are": far["point mass, published"] - far["hips, yaw held"],
        "the yaw": far["hips, yaw held"] - far["hips and yaw"],
    }
    parts = (f"{what} makes it {abs(by):.2f} {'nearer' if by > 0.0 else 'farther'}" for what, by in changes.items())
    text += f"Against the published gaits, {'; then '.join(parts)}. "
    front = {name: float(outside(gaits).sel(leg="F", axis="lateral")) for name, gaits in bodies.items()}
    change = front["hips and yaw"] - front["point mass, published"]
    return text + (
        f"The front legs' lateral force {'pays for it' if change > 0.0 else 'gains as well'}: it misses by "
        f"{front['hips and yaw']:.2f} instead of {front['point mass, published']:.2f}."
    )


def outside(gaits: xr.Dataset) -> xr.DataArray:
    """Return by how much peak forces miss the range measured at their slope, on average over gaits: by leg and axis."""
    peaks, measured = table_cells(gaits)["peak_force"], published_forces()["experiment"]
    low, high = measured.sel(extreme="min", drop=True), measured.sel(extreme="max", drop=True)
    return abs(peaks - peaks.clip(low, high)).mean(["slope_deg", "heading", "branch"])


def _hips_table(hips: xr.Dataset) -> Table:
    names = ("back", "gaits", "cells", "stable", "least_multiplier")
    return Table(
        "",
        "The rigid cockroach with all hips moved back, its feet staying where they are: gaits, cells with a gait (of "
        f"{len(BACK_SLOPES_DEG) * len(BACK_HEADINGS)}) and with a stable one, and the smallest of the gaits' largest "
        "multipliers.",
        ("moved_back_mm", "gaits", "cells", "stable_cells", "least_multiplier"),
        tuple(zip(*(hips[name].values.tolist() for name in names), strict=True)),
    )


def _back_table(ranges: xr.Dataset) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for slope in SLOPES_DEG:
        cells = (
            Range(*map(float, force.sel(leg="B", axis="lateral", slope_deg=slope, extreme=["min", "max"])))
            for force in ranges.values()
        )
        rows.append((slope, *cells))
    return Table(
        "",
        "Peak lateral force of the back legs in units of m g, positive towards the other side: smallest to largest "
        f"over headings of {HEADINGS[0]:.2f} to {HEADINGS[1]:.2f} rad.",
        ("slope_deg", *(str(name).replace(" ", "_") for name in ranges)),
        tuple(rows),
    )


def _outside_table(bodies: Mapping[str, xr.Dataset]) -> Table:
    misses = {name: outside(gaits) for name, gaits in bodies.items()}
    rows: list[tuple[Cell, ...]] = [
        (
            f"{LEG_WORDS[leg]}, {axis.replace('_', '-')}",
            *(float(miss.sel(leg=leg, axis=axis)) for miss in misses.values()),
        )
        for leg in ("F", "B")
        for axis in ("lateral", "fore_aft")
    ]
    return Table(
        "",
        "By how much peak forces miss the range measured at their slope, in units of m g, on average over all gaits "
        f"at headings of {HEADINGS[0]:.2f} to {HEADINGS[1]:.2f} rad.",
        ("force", *(name.replace(" ", "_") for name in misses)),
        tuple(rows),
    )
