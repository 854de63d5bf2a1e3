"""Maps of gaits over a grid, of slopes and headings for instance (`legspring.atlas`): sweeps with all measures."""

import logging
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from legspring.asking import check_tuned
from legspring.checks import checked_grid, checked_names, checked_vector, shown
from legspring.kernel.walker import Floats
from legspring.mapping import (
    HEADINGS,
    IMPULSE,
    IMPULSES,
    METHODS,
    SEARCH,
    SLOPES_DEG,
    Grid,
    coordinates,
    empty_map,
    provenance,
)
from legspring.measures.registry import BY_NAME, OF_RECOVERIES, Measure, mapped
from legspring.model import Animal
from legspring.plans import Plan, plan_of
from legspring.stores import block_in
from legspring.sweeping import carried_out

LOG = logging.getLogger("legspring")
ROOM = 24
"""Gaits that there is room for at each place; what is not needed is left out in the end."""
AS_THEY_ARE = {"outcome", "sheet"}
"""Variables that a map has as a sweep has them."""


@dataclass(frozen=True)
class Lacking:
    """A gait that lacks whatever a gait of an animal may lack; it tells measures why they are missing."""

    animal: Animal
    phase_lag: Floats
    gets_on: bool = False
    grazing: float = math.nan
    straight: bool = False
    apex_height: float = math.nan
    friction: float = math.nan


def grid_of(
    animal: Animal,
    over: Mapping[str, Sequence[float]] | None,
    slopes_deg: Sequence[float] | None,
    headings: Sequence[float] | None,
    asked: Mapping[str, Any],
) -> tuple[dict[str, tuple[float, ...]], dict[str, Any]]:
    """Return what a map is over, and what is asked for everywhere, checked.

    Raises
    ------
    ValueError
        If it is no grid, or does not fit the animal at its ends.
    """
    wanted = {name: value for name, value in asked.items() if value is not None and value != ()}
    if over is None:
        check_tuned(animal, "for a map over slope and heading; other maps take over={'slope_deg': [...], ...}")
        over = {
            "slope_deg": SLOPES_DEG if slopes_deg is None else slopes_deg,
            "heading": HEADINGS if headings is None else headings,
        }
    elif slopes_deg is not None or headings is not None:
        raise ValueError("over: must be left out where slopes_deg or headings are given")
    if not isinstance(over, Mapping) or not over:
        raise ValueError(f"over = {shown(over)}: must map parameters to values, as in {{'slope_deg': [0, 10]}}")
    limits, words = {"slope_deg": 90.0, "heading": math.pi / 2}, {"slope_deg": "slopes_deg", "heading": "headings"}
    axes = {
        name: checked_grid(words.get(name, f"over[{shown(name)}]"), values, limits.get(name, math.inf))
        for name, values in over.items()
    }
    if both := [name for name in axes if name in wanted]:
        raise ValueError(f"{both[0]} = {shown(wanted[both[0]])}: must be left out, as it varies")
    grid = Grid(animal, axes, wanted)
    for ends in {tuple(0 for _ in axes), tuple(len(values) - 1 for values in axes.values())}:
        for family in animal.families:
            grid.problems(ends, family)
    return axes, wanted


def atlas(
    animal: Animal,
    *,
    slopes_deg: Sequence[float] | None = None,
    headings: Sequence[float] | None = None,
    over: Mapping[str, Sequence[float]] | None = None,
    actuation: ArrayLike | None = None,
    slope_deg: float | None = None,
    heading: float | None = None,
    speed: float | None = None,
    mean_speed: float | None = None,
    energy: float | None = None,
    apex_height: float | None = None,
    lateral_drift: float | None = None,
    free: Sequence[str] = (),
    mirrored: bool | None = None,
    impulses: Sequence[float] = IMPULSES,
    method: str = SEARCH,
    starts: int | None = None,
    store: str | os.PathLike[str] | None = None,
    workers: int | None = None,
    cluster: Any = None,
    progress: bool = False,
) -> xr.Dataset:
    """Map the gaits of an animal over slope and heading, or over any parameters.

    Parameters
    ----------
    animal
        The animal.
    slopes_deg, headings
        The grid, rising: degrees, rad; by default, for an animal that is tuned to its desired speed, 0 to 90 deg and 0
        to 0.45 rad.
    over
        Another grid: the values, rising, of ``slope_deg``, of targets such as ``energy``, or of parameters of the
        animal (see `legspring.parameters`), as in ``{"slope_deg": [0, 10], "F.stiffness": [1.0, 1.5]}``.
    actuation
        Magnitudes for each pair of legs, m; by default the animal's.
    slope_deg, heading, speed, mean_speed, energy, apex_height, lateral_drift, free, mirrored
        What gaits are asked for everywhere (see `search_gaits`).
    impulses
        Sideways impulses to recover from, in units of m v_des; none: no recovery.
    method
        ``"search"``: in every cell, from some starts and from what is found in the cells around. ``"follow"``: a few
        gaits are followed along all lines of the grid, past folds and to other families, before that; so gaits have an
        identity across cells, their ``sheet``.
    starts
        Starts of the search for each family (and set of contacts) in each cell; by default 8 for an animal that is
        tuned to its desired speed, 16 if its body yaws, else 24.
    store
        A folder (Zarr) that keeps what is done, block by block; whatever ends the program, the same call goes on where
        it was (see `legspring.sweep`).
    workers
        Threads, or processes of a local cluster; by default one a core.
    cluster
        Work on Dask (see `legspring.sweep`).
    progress
        Whether to show a progress bar.

    Returns
    -------
    xarray.Dataset
        Over slope_deg and heading, or what the grid is over, then branch, leg (pairs of legs), single_leg, axis and
        impulse; missing where there is no gait, or no such measure, of which the attribute ``missing`` says why. Its
        variables are those of ``legspring.measures.registry``, the parameters that were let go by ``free``, and
        ``outcome``, what became of the search (its attributes say what the numbers mean).

    Raises
    ------
    ValueError
        For a grid that does not rise, an unknown parameter, or a number out of range.
    """
    if method not in METHODS:
        raise ValueError(f"method = {shown(method)}: must be one of {', '.join(METHODS)}")
    if actuation is not None:
        animal = animal.replace(actuation=checked_vector("actuation", actuation, len(animal.pairs)).tolist())
    asked = {"slope_deg": slope_deg, "heading": heading, "speed": speed, "mean_speed": mean_speed, "energy": energy}
    asked |= {"apex_height": apex_height, "lateral_drift": lateral_drift, "mirrored": mirrored}
    axes, wanted = grid_of(animal, over, slopes_deg, headings, asked | {"free": list(checked_names("free", free))})
    numbers = [one.name for one in mapped(animal) if one.unit]
    width = block_in(store)
    plan = plan_of(animal, axes, True, (), wanted, numbers, starts, ROOM, width, impulses, method)
    return map_of(plan, carried_out(plan, {"sampling": "grid"}, store, workers, cluster, progress))


def map_of(plan: Plan, found: xr.Dataset) -> xr.Dataset:
    """Return a sweep as a map: with words for families, and no more branches than there are gaits."""
    animal, most = plan.creature, int(np.max(found["found"]))
    if most > ROOM:
        LOG.warning("there is room for %d gaits at a place; ls.sweep takes branches=%d", ROOM, most)
    found = found.isel(branch=slice(0, max(1, most))).load()
    coords = coordinates(animal, dict(zip(plan.names, plan.values, strict=True)))
    coords["branch"] = ("branch", found["branch"].values, BY_NAME["branch"].attributes)
    coords["impulse"] = ("impulse", list(plan.impulses), IMPULSE)
    dataset = empty_map((*mapped(animal), *plan.freed, *OF_RECOVERIES), (*plan.names, "branch"), coords)
    labels = np.array(["", *plan.families], dtype=object)
    for name, variable in dataset.data_vars.items():
        if name == "family":
            variable[...] = labels[found["family"].values + 1]
        elif name in found:
            variable[...] = found[name].values
    for name in AS_THEY_ARE & set(found):
        dataset[name] = found[name]
    say_what_is_missing(dataset, animal)
    words = f"{plan.starts} starts for each family at each place, {int(found['rejected'].sum())} solutions rejected"
    if "alone" in found:
        words += f", {int(found['alone'].sum())} gaits by search alone"
    kept = {name: found.attrs[name] for name in ("machine", "settings", "seconds") if name in found.attrs}
    return dataset.assign_attrs(provenance(animal, list(plan.names)) | kept | {"search": words})


def say_what_is_missing(dataset: xr.Dataset, animal: Animal) -> None:
    """Write into the variables' attributes why gaits do not have them."""
    there = dataset["family"].values != ""
    for one in mapped(animal):
        if one.name not in dataset.data_vars or not one.unit:
            continue
        lacks = np.isnan(dataset[one.name].values[there])
        rows = np.unique(lacks.reshape(len(lacks), -1), axis=0) if lacks.size else lacks
        reasons = {why for row in rows if np.any(row) and (why := reason(one, animal, row))}
        if reasons:
            dataset[one.name].attrs["missing"] = "; ".join(sorted(reasons))
    if np.isnan(dataset["recovered"].values[there]).any():
        for one in OF_RECOVERIES:
            dataset[one.name].attrs["missing"] = "the animal keeps its energy, and what a push gives it"


def reason(measure: Measure, animal: Animal, lacks: NDArray[np.bool_]) -> str | None:
    """Say why a gait of an animal has not all numbers of a measure."""
    legs = lacks if measure.dimensions == ("single_leg",) else np.zeros(len(animal.legs), dtype=bool)
    return measure.missing(Lacking(animal, np.where(legs, math.nan, 0.0)))
