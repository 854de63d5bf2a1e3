"""Maps of gaits with the best actuation (`legspring.optimal_atlas`), and the best family in each of their cells."""

import hashlib
import json
import math
import os
import shutil
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from pkgutil import resolve_name
from typing import Any, Literal

import numpy as np
import xarray as xr

from legspring.actuated import Map, pair_lengths
from legspring.checks import LARGEST_SEED, checked_choice, checked_grid, checked_whole, checked_workers
from legspring.clusters import on_dask
from legspring.constraints import Constraints, named_constraints
from legspring.exchange import GOALS, KINDS, Case, Pool, known_optima, measures_of
from legspring.files import code_stamp
from legspring.mapping import HEADINGS, IMPULSE, SLOPES_DEG, coordinates, empty_map, fill, provenance
from legspring.measures.registry import BY_NAME
from legspring.measures.robustness import LARGEST_IMPULSE
from legspring.memory import Memory, encoded
from legspring.model import Animal
from legspring.optimisation import METHODS
from legspring.optimum import TIE, Method
from legspring.parallel import processes
from legspring.stores import Layout, Variable, opened, place_of

PLACES = ("slope_deg", "heading")
CELL = ("objective", *PLACES, "family")
WORDS = "<U400"
"""Kind of array that holds words in a store; the longest ones, of constraints that bind, are far shorter."""


def optimal_atlas(
    animal: Animal,
    *,
    slopes_deg: Sequence[float] = SLOPES_DEG,
    headings: Sequence[float] = HEADINGS,
    map: Map = "complete",
    method: Method = "default",
    starts: xr.Dataset | None = None,
    seed: int = 0,
    workers: int | None = None,
    cache: str | os.PathLike[str] | None = None,
    store: str | os.PathLike[str] | None = None,
    cluster: Any = None,
    progress: bool = False,
    constraints: Constraints | str = "peterson2011",
    impulses: Sequence[float] = (),
) -> xr.Dataset:
    """Map the gaits with the best actuation over slope and heading, for each family and for both objectives.

    Parameters
    ----------
    animal
        The animal; its yaw must be held.
    slopes_deg, headings
        The grid, rising: degrees, rad; by default that of `legspring.atlas`.
    map, method
        See `legspring.optimize`. Both methods pass optima on between cells: the default one as further starts, the
        thesis's as the only ones.
    starts
        Another such map over the same grid, from whose optima the default method starts as well.
    seed
        Of the actuations at which the search looks for gaits.
    workers
        Processes; by default one a core.
    cache
        Directory that keeps what was computed, so that a search which was stopped goes on where it was.
    store
        A folder (Zarr) that holds the result, which `legspring.open_sweep` opens; while there is none yet, what was
        computed is kept beside it, unless there is a ``cache``. It is of this grid, and takes no other one later.
    cluster
        Work on Dask (see `legspring.sweep`).
    progress
        Whether to show progress bars.
    constraints
        See `legspring.optimize`.
    impulses
        Sideways impulses to recover from, in units of m v_des; none: no recovery.

    Returns
    -------
    xarray.Dataset
        Over objective, slope_deg, heading, family, leg (pairs of legs), single_leg, axis and impulse; missing where
        there is no gait. Its attribute ``seconds`` counts the time of runs that were stopped, too, as far as their
        work is used.

    Raises
    ------
    ValueError
        For a grid that does not rise, a number out of range, an unknown map, method or constraints, or a store of
        something else, or in use.
    """
    slopes_deg = checked_grid("slopes_deg", slopes_deg, 90.0)
    headings = checked_grid("headings", headings, math.pi / 2)
    seed, count = checked_whole("seed", seed, 0, LARGEST_SEED), checked_workers(workers)
    checked_choice("method", method, METHODS)
    impulses = checked_grid("impulses", impulses, LARGEST_IMPULSE, least=0)
    rules = named_constraints(constraints)
    cases = {
        (row, column, family): Case(animal, slope, heading, family, map, rules, impulses)
        for row, slope in enumerate(slopes_deg)
        for column, heading in enumerate(headings)
        for family in animal.families
    }
    next(iter(cases.values())).objective("stability")  # says what is wrong before any work is done
    dataset = blank_map(animal, slopes_deg, headings, impulses)
    dataset.attrs = provenance(animal) | {
        "title": f"Gaits of {animal.name} with the best actuation over slope and heading",
        "map": map,
        "method": method,
        "seed": seed,
        "constraints": constraints if isinstance(constraints, str) else str(rules),
    }
    known = {} if starts is None else known_optima(cases, starts)

    def searched(directory: Path | None) -> xr.Dataset:
        begin = time.perf_counter()
        memory = None if directory is None else Memory(directory, code_stamp(), KINDS)
        with processes(count) if cluster is None else on_dask(cluster, count) as shared:
            found = resolve_name(METHODS[method][1])(cases, known, seed, Pool(shared, memory, progress))
        families = list(animal.families)
        places = [(GOALS.index(goal), row, column, families.index(family)) for (row, column, family), goal in found]
        fill(dataset, zip(places, found.values(), strict=True))
        dataset.attrs["seconds"] = time.perf_counter() - begin + (memory.spared if memory else 0.0)
        return dataset

    kept = None if cache is None else Path(cache)
    if store is None:
        return searched(kept)
    about = [list(cases.values()), sorted(known.items(), key=str), seed, map, method]
    identity = {"version": code_stamp(), "search": hashlib.sha256(json.dumps(encoded(about)).encode()).hexdigest()}
    return held_in(store, dataset, identity, kept, searched)


def blank_map(
    animal: Animal, slopes_deg: Sequence[float], headings: Sequence[float], impulses: Sequence[float]
) -> xr.Dataset:
    """Return a map in which all is missing."""
    coords = coordinates(animal, {"slope_deg": slopes_deg, "heading": headings})
    coords["objective"] = ("objective", list(GOALS), {"long_name": "what is minimised"})
    coords["family"] = ("family", list(animal.families), BY_NAME["family"].attributes)
    if impulses:
        coords["impulse"] = ("impulse", list(impulses), IMPULSE)
    return empty_map(measures_of(animal, impulses), CELL, coords)


def held_in(
    store: str | os.PathLike[str],
    blank: xr.Dataset,
    identity: Mapping[str, str],
    cache: Path | None,
    searched: Callable[[Path | None], xr.Dataset],
) -> xr.Dataset:
    """Return the map that a store holds, which is searched for if it does not yet."""
    store = place_of(store)
    beside = store.with_name(f".{store.name}.search")
    with opened(store, layout_of(blank), identity) as result:
        todo = result.missing()
        if todo:
            dataset = searched(cache or beside).transpose(*PLACES, ...)
            for block in todo:
                part = dataset.isel(dict(zip(PLACES, result.layout.where(block), strict=True)))
                result.write(block, {str(name): variable.values for name, variable in part.data_vars.items()})
        shutil.rmtree(beside, ignore_errors=True)
        found = result.dataset().load().transpose(*CELL, ...)
    return xr.merge([blank.drop_vars(blank.data_vars), found[list(blank.data_vars)].map(as_words)]).assign_attrs(
        found.attrs
    )


def as_words(variable: xr.DataArray) -> xr.DataArray:
    """Return words as other datasets have them."""
    return variable.astype(object) if variable.dtype.kind in "UT" else variable


def layout_of(blank: xr.Dataset) -> Layout:
    """Return what the store of a map consists of, of which all places are one block."""
    variables = {}
    for name, variable in blank.transpose(*PLACES, ...).data_vars.items():
        words = variable.dtype.kind == "O"
        fill_with = "" if words else math.nan
        dims, about = tuple(map(str, variable.dims)), variable.attrs
        variables[str(name)] = Variable(dims, variable.shape, WORDS if words else "float64", fill_with, about)
    coords = {str(name): (name, one.values, one.attrs) for name, one in blank.coords.items()}
    sizes = {name: blank.sizes[name] for name in PLACES}
    return Layout(sizes, tuple(sizes.values()), variables, coords, blank.attrs)


def select(optima: xr.Dataset, by: Literal["penalised", "value"] = "penalised") -> xr.Dataset:
    """Choose the best family in each cell: the best objective; among those as good, the cheaper, the less actuated.

    Parameters
    ----------
    optima
        Of `optimal_atlas`.
    by
        The objective with its penalties, or without them.

    Returns
    -------
    xarray.Dataset
        The same without the dimension family, which becomes a variable, empty where there is no gait.
    """
    lengths = pair_lengths(Animal.model_validate_json(str(optima.attrs["parameters"])))
    rest = np.isfinite(optima["penalised"].values)
    effort = np.sum((optima["actuation"].values / lengths) ** 2, axis=-1)
    for values, tie in ((optima[by].values, TIE), (optima["transport_cost"].values, TIE), (effort, 0.0)):
        least = np.min(np.where(rest, values, np.inf), axis=-1, keepdims=True)
        rest &= values <= least + tie
    axis = optima["penalised"].dims.index("family")
    index = xr.DataArray(np.argmax(rest, axis=axis), dims=[dim for dim in optima["penalised"].dims if dim != "family"])
    chosen = optima.isel(family=index)
    there = xr.DataArray(rest.any(axis=axis), dims=index.dims)
    labels = np.where(there, chosen["family"].values, "").astype(object)
    attributes = {"long_name": "family that was selected"}
    return chosen.drop_vars("family").assign(family=(index.dims, labels, attributes))
