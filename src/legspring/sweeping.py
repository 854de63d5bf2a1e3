"""Gaits over anything: grids, lists and samples of parameters, as large as one likes (`legspring.sweep`).

The points are cut into blocks. What a block holds depends on the question alone, and not on other blocks: whoever works
on it, and when, it comes out the same to the last bit.
"""

import hashlib
import json
import math
import os
import platform
import threading
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import asdict, dataclass
from functools import cached_property, lru_cache
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.stats import qmc
from threadpoolctl import threadpool_limits

from legspring.batches import GAIT, MEASURES, NOT_REACHED, OUTCOMES, REASONS, UNSOLVED, Batch, Solved, gait_of
from legspring.candidates import Judge, Trial, box_of
from legspring.checks import (
    LARGEST_SEED,
    MOST_STARTS,
    checked_choice,
    checked_names,
    checked_whole,
    checked_workers,
    shown,
)
from legspring.files import code_stamp
from legspring.gait import Gait
from legspring.kept import gait_as_json, gait_from_json
from legspring.kernel.walker import Floats
from legspring.mapping import Grid, about, coordinates, provenance
from legspring.measures.registry import BY_NAME, Measure, mapped
from legspring.model import Animal
from legspring.parallel import in_threads
from legspring.progress import progress_bar
from legspring.solve import Origin, search_gaits
from legspring.stores import Block, InMemory, Layout, OnDisk, Variable, block_in, opened

if TYPE_CHECKING:
    import xarray as xr

SAMPLINGS = ("grid", "list", "latin", "sobol", "random", "saltelli")
STARTS, BRANCHES = 24, 4
"""Starts of a search at each point; gaits that there is room for."""
FOLLOWED, SEARCHED = 4096, 16
"""Points of a block where gaits are followed, and where they are searched for, at most."""
FEWEST, BLOCKS = 512, 16
"""Points from which on a block is worth its while; blocks that there are to be at least, if so."""
NEIGHBOURS = 2
"""Points around one that it is reached from, for each dimension and side."""
MOST_SEEDS = 27
"""Places of a block, beside the nearest, to which a gait is followed straight if they are not reached otherwise."""
SAME = 1e-6
"""Difference of unknowns of two gaits that are one."""
NO_GAIT, NO_FURTHER, DOUBLE, UNASKABLE = -3, -4, -5, -6
MEANINGS = OUTCOMES | {
    NO_GAIT: "the search has found nothing",
    NO_FURTHER: "no further gait",
    DOUBLE: "the same gait as one of a smaller number",
    UNASKABLE: "there is no such animal, or nothing of the kind can be asked of it",
}
QUICK = tuple(name for name in MEASURES if name in BY_NAME)
"""Measures that are made of arrays; others take some milliseconds for each gait."""
LOCAL = threading.local()


@dataclass(frozen=True)
class Plan:
    """What is asked of which points: all that a block depends on, as text.

    Attributes
    ----------
    animal, gaits
        JSON: the animal; the gaits that are followed, none where gaits are searched for.
    names, values
        What varies; the values of each: along its axis of a grid, or of each point.
    grid
        Whether points are a grid.
    asked, starts, branches
        What gaits are asked for everywhere, as JSON; starts of a search; room for gaits.
    measures
        What is said of them.
    low, high
        Ranges within which gaits are followed.
    width
        Points of a block along each dimension; None for what seems best.
    """

    animal: str
    gaits: tuple[str, ...]
    names: tuple[str, ...]
    values: tuple[tuple[float, ...], ...]
    grid: bool
    asked: str
    starts: int
    branches: int
    measures: tuple[str, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    width: tuple[int, ...] | None = None

    @cached_property
    def sizes(self) -> dict[str, int]:
        """Points along each of their dimensions."""
        if self.grid:
            return {name: len(values) for name, values in zip(self.names, self.values, strict=True)}
        return {"point": len(self.values[0])}

    @cached_property
    def block(self) -> tuple[int, ...]:
        """Points of a block along each dimension: about as many one way as the other."""
        if self.width is not None:
            return self.width
        sizes = list(self.sizes.values())
        most = min(FOLLOWED, max(FEWEST, math.prod(sizes) // BLOCKS)) if self.gaits else SEARCHED
        widths, left = [1] * len(sizes), float(most)
        for n, axis in enumerate(sorted(range(len(sizes)), key=lambda axis: sizes[axis])):
            widths[axis] = max(1, min(sizes[axis], round(left ** (1.0 / (len(sizes) - n)))))
            left = max(1.0, left / widths[axis])
        return tuple(widths)

    def points(self, where: tuple[slice, ...]) -> Floats:
        """Return the values at some points, ``(M, D)``."""
        if not self.grid:
            return np.array([values[where[0]] for values in self.values]).T
        axes = [np.array(values)[part] for values, part in zip(self.values, where, strict=True)]
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))

    @cached_property
    def about(self) -> tuple[Measure, ...]:
        """What is said of gaits."""
        return tuple(BY_NAME[name] for name in self.measures)


def sweep(
    animal: Animal,
    over: Mapping[str, Any],
    *,
    samples: int | None = None,
    sampling: str = "grid",
    seed: int = 0,
    gaits: Gait | Sequence[Gait] | None = None,
    measures: Sequence[str] | None = None,
    slope_deg: float | None = None,
    heading: float | None = None,
    speed: float | None = None,
    mean_speed: float | None = None,
    energy: float | None = None,
    apex_height: float | None = None,
    lateral_drift: float | None = None,
    free: Sequence[str] = (),
    mirrored: bool | None = None,
    starts: int = STARTS,
    branches: int = BRANCHES,
    store: str | os.PathLike[str] | None = None,
    workers: int | None = None,
    cluster: Any = None,
    progress: bool = False,
) -> "xr.Dataset":
    """Find and measure gaits over any parameters: on a grid, at listed points, or at samples.

    At each point all gaits are searched for; or, given some gaits, each of them is followed there from where it is,
    which is some hundred times faster, and keeps its number. See :ref:`numerics-sweeps`.

    Parameters
    ----------
    animal
        The animal.
    over
        What varies (see `legspring.parameters`; ``slope_deg`` and what gaits are asked for among them), with the values
        along each axis of a grid; with the values of each point for a list; or with a range, (low, high), for samples.
    samples, sampling, seed
        How many points, and how they lie: ``"grid"``, ``"list"``, or samples: ``"latin"`` (hypercube), ``"sobol"``,
        ``"random"``, or ``"saltelli"``: so many base points, a power of two, with those that `legspring.sobol_indices`
        needs in addition, for each parameter as many again, and twice.
    gaits
        Gaits to be followed to all points, for instance by `legspring.find_gaits`; they are asked for as they were,
        and their numbers are the order in which they are given.
    measures
        What is to be said of each gait: names of measures; by default those that are known of many gaits at once
        (`legspring.sweeping.QUICK`). Others take milliseconds for each gait. Multipliers are always there.
    slope_deg, heading, speed, mean_speed, energy, apex_height, lateral_drift, free, mirrored
        What gaits are asked for everywhere, where they are searched for (see `legspring.search_gaits`).
    starts, branches
        Of the search at each point, for each family; and for how many gaits there is room.
    store
        A folder (Zarr) that the result is written to, block by block. Whatever ends the program, the same call goes on
        where it was; and one with more values after those of an axis adds them. Without, all is kept in memory.
    workers
        Threads, or processes of a local cluster; by default one a core.
    cluster
        Work on Dask: ``"local"``, the address of a scheduler, as in ``"tcp://10.0.0.1:8786"``, or a
        ``distributed.Client``. The result is the same.
    progress
        Whether to show a progress bar, with points a second and the time left.

    Returns
    -------
    xarray.Dataset
        Over the grid, or over ``point``, and ``branch``: the measures, and ``outcome``, what became of a gait there (0:
        it is one; its attributes say what other numbers mean). Measures of what is no gait are missing. With a store
        only what is looked at is read; the folder may be opened by `legspring.open_sweep` at any time, also while
        the work goes on.

    Raises
    ------
    ValueError
        For unknown names, values that are none or do not fit, or a store of something else, or in use.

    Examples
    --------
    >>> import legspring as ls
    >>> roach = ls.cockroach()
    >>> gait = ls.find_gaits(roach, slope_deg=45, heading=0.15)[0]
    >>> found = ls.sweep(roach, {"slope_deg": [40, 45, 50], "F.stiffness": [1.4, 1.5]}, gaits=gait)
    >>> found["max_multiplier"].dims, int((found["outcome"] == 0).sum())
    (('slope_deg', 'F.stiffness', 'branch'), 6)
    """
    asked = {"slope_deg": slope_deg, "heading": heading, "speed": speed, "mean_speed": mean_speed, "energy": energy}
    asked |= {"apex_height": apex_height, "lateral_drift": lateral_drift, "mirrored": mirrored}
    wanted: dict[str, Any] = {name: value for name, value in asked.items() if value is not None}
    if free:
        wanted["free"] = list(checked_names("free", free))
    some = () if gaits is None else (gaits,) if isinstance(gaits, Gait) else gaits
    if not isinstance(some, Sequence) or not all(isinstance(gait, Gait) for gait in some):
        raise ValueError(f"gaits = {shown(gaits)}: must be a gait, or several")
    points, grid = checked_over(over, samples, sampling, seed), sampling == "grid"
    plan = plan_of(animal, points, grid, some, wanted, measures, starts, branches, block_in(store))
    threads = checked_workers(workers)
    chance = {"seed": seed, "samples": samples} if samples is not None else {}
    layout = layout_of(plan, animal, {"sampling": sampling} | chance)
    # Points may be added: which there are, coordinates say; and blocks are as they were made.
    parts = {name: value for name, value in asdict(plan).items() if name not in ("values", "low", "high", "width")}
    identity = json.loads(json.dumps({"version": code_stamp(), "sampling": sampling, **parts}))
    begin = time.perf_counter()
    with nullcontext(InMemory(layout)) if store is None else opened(store, layout, identity) as result:
        todo = result.missing()
        total = sum(map(layout.count, todo))
        with progress_bar("sweeping", total, show=progress, rate="points") as tick:
            run(plan, layout, todo, result, threads, cluster, tick)
        found = result.dataset()
    if store is None:
        found.attrs["seconds"] = time.perf_counter() - begin
    return found


def run(
    plan: Plan,
    layout: Layout,
    todo: Sequence[Block],
    result: InMemory | OnDisk,
    workers: int,
    cluster: Any,
    tick: Callable[[int], None],
) -> None:
    """Work on blocks, here or on a cluster, and write each as soon as it is done."""
    if cluster is not None:
        from legspring.clusters import on_cluster

        on_cluster(cluster, workers, plan, layout, todo, result, tick)
        return

    def work(block: Block) -> None:
        result.write(block, shaped(layout, block, block_of(plan, layout.where(block))))
        tick(layout.count(block))

    in_threads(work, todo, workers)


def shaped(layout: Layout, block: Block, values: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the arrays of a block, whose first axis counts its points, in the form that the whole has."""
    shape = tuple(part.stop - part.start for part in layout.where(block))
    return {name: array.reshape(*shape, *array.shape[1:]) for name, array in values.items()}


def fates_of(found: "xr.Dataset") -> list[str]:
    """Say what became of the places without a gait, a line for each outcome."""
    about, values = found["outcome"].attrs, found["outcome"].values
    words = dict(
        zip(np.atleast_1d(about["flag_values"]).tolist(), str(about["flag_meanings"]).split("; "), strict=True)
    )
    counts = Counter(values.ravel().tolist())
    return [f"{count}: {words[one]}" for one, count in counts.most_common() if one not in (GAIT, NO_FURTHER)]


# What is asked --------------------------------------------------------------------------------------------------


def checked_over(
    over: Mapping[str, Any], samples: int | None, sampling: str, seed: int
) -> dict[str, tuple[float, ...]]:
    """Return what varies, with its values: along each axis, or of each point.

    Raises
    ------
    ValueError
        For what is none.
    """
    checked_choice("sampling", sampling, SAMPLINGS)
    if not isinstance(over, Mapping) or not over:
        raise ValueError(f"over = {shown(over)}: must map parameters to values, as in {{'slope_deg': [0, 10]}}")
    found: dict[str, tuple[float, ...]] = {}
    for name, values in over.items():
        key = f"over[{shown(name)}]"
        numbers = numbers_of(values)
        if numbers.ndim != 1 or not len(numbers) or not np.all(np.isfinite(numbers)):
            raise ValueError(f"{key} = {shown(values)}: must be finite numbers")
        if sampling == "grid" and np.any(np.diff(numbers) <= 0.0):
            raise ValueError(f"{key} = {shown(values)}: must be rising numbers")
        found[str(name)] = tuple(numbers.tolist())
    if sampling in ("grid", "list"):
        if samples is not None:
            raise ValueError(f"samples = {shown(samples)}: must be left out for a {sampling}")
        if sampling == "list" and len({len(values) for values in found.values()}) > 1:
            raise ValueError("over: must have as many values of each parameter, one for each point of the list")
        return found
    if samples is None:
        raise ValueError(f"samples is missing: must be how many points, for sampling = {sampling!r}")
    count, luck = checked_whole("samples", samples, 1, 100_000_000), checked_whole("seed", seed, 0, LARGEST_SEED)
    for name, values in found.items():
        if len(values) != 2 or not values[0] < values[1]:
            raise ValueError(f"over[{shown(name)}] = {shown(over[name])}: must be a range, (low, high)")
    if sampling == "saltelli" and count & (count - 1):
        raise ValueError(f"samples = {count}: must be a power of two, for sampling = 'saltelli'")
    low, high = np.array(list(found.values())).T
    shares = sampled(sampling, count, len(found), luck)
    return {name: tuple(column) for name, column in zip(found, (low + shares * (high - low)).T.tolist(), strict=True)}


def numbers_of(values: Any) -> Floats:
    """Return values as an array; one without any if they are no numbers."""
    try:
        array = np.asarray(values)
    except ValueError:
        return np.zeros(0)
    return array.astype(float) if array.dtype.kind in "iuf" else np.zeros(0)


def sampled(sampling: str, count: int, size: int, seed: int) -> Floats:
    """Return points of the unit cube, ``(count, size)``, or more for Sobol indices."""
    if sampling == "random":
        return np.random.default_rng(seed).random((count, size))
    if sampling == "saltelli":
        first, second = np.split(qmc.Sobol(2 * size, rng=seed).random_base2(round(math.log2(count))), 2, axis=1)
        mixed = [np.where(np.arange(size) == n, second, first) for n in range(size)]
        return np.vstack([first, second, *mixed])
    if sampling == "latin":
        return qmc.LatinHypercube(size, rng=seed).random(count)
    # A power of two is what the sequence is made for.
    return qmc.Sobol(size, rng=seed).random_base2(max(0, math.ceil(math.log2(count))))[:count]


def plan_of(
    animal: Animal,
    over: Mapping[str, tuple[float, ...]],
    grid: bool,
    gaits: Sequence[Gait],
    asked: Mapping[str, Any],
    measures: Sequence[str] | None,
    starts: int,
    branches: int,
    width: tuple[int, ...] | None,
) -> Plan:
    """Return what is asked, checked.

    Raises
    ------
    ValueError
        If it does not fit the animal, or together.
    """
    known = ["heading", *(one.name for one in mapped(animal) if one.unit)]
    names = tuple(n for n in QUICK if n in known) if measures is None else checked_names("measures", measures)
    if bad := [name for name in names if name not in known]:
        raise ValueError(f"measures = {shown(bad[0])}: must be one of {', '.join(known)}")
    names = tuple(name for name in names if name not in over)
    if both := [name for name in over if name in asked]:
        raise ValueError(f"{both[0]} = {shown(asked[both[0]])}: must be left out, as it varies")
    low, high = ([end(values) for values in over.values()] for end in (min, max))
    room = checked_whole("branches", branches, 1, 100)
    if gaits:
        for gait in gaits:
            own_animal = gait.origin.problem.system.animal if isinstance(gait.origin, Origin) else gait.animal
            if animal not in (gait.animal, own_animal):
                raise ValueError(f"animal = {animal.name!r}: must be the one whose gaits are followed")
        if asked:
            raise ValueError(f"{next(iter(asked))}: must be left out: gaits that are followed were asked for theirs")
        room = len(gaits)
        # The gaits must be within; what lies outside of the points is followed through.
        own = [[value_within(gait, name) for gait in gaits] for name in over]
        low = [min(least, *some) for least, some in zip(low, own, strict=True)]
        high = [max(most, *some) for most, some in zip(high, own, strict=True)]
        high = [b if b > a else a + 1e-6 * (abs(a) or 1.0) for a, b in zip(low, high, strict=True)]
        box_of(gaits, dict(zip(over, zip(low, high, strict=True), strict=True)))
    else:
        start = Grid(animal, dict(over) if grid else {name: values[:1] for name, values in over.items()}, dict(asked))
        for family in animal.families:
            start.problems(tuple(0 for _ in over), family)
    return Plan(
        animal.model_dump_json(),
        tuple(gait_as_json(gait) for gait in gaits),
        tuple(over),
        tuple(over.values()),
        grid,
        json.dumps(dict(asked)),
        checked_whole("starts", starts, 1, MOST_STARTS),
        room,
        names,
        tuple(low),
        tuple(high),
        width,
    )


def value_within(gait: Gait, name: str) -> float:
    """Return the value that a gait has of something that varies."""
    from legspring.measures.sensitivity import checked, value_of

    return value_of(gait, checked(gait, name))


def layout_of(plan: Plan, animal: Animal, more: Mapping[str, Any]) -> Layout:
    """Return what the result of a plan consists of."""
    sizes, dims = plan.sizes, (*plan.sizes, "branch")
    shape, own = (*sizes.values(), plan.branches), coordinates(animal, {})
    coords: dict[str, tuple[Any, ...]] = {}
    for name, values in zip(plan.names, plan.values, strict=True):
        coords[name] = (name if plan.grid else "point", np.array(values), about(name))
    coords["branch"] = ("branch", np.arange(plan.branches), {"long_name": "number of the gait"})
    variables = {}
    lengths = {name: len(values) for name, (_, values, *_) in own.items()}
    for one in plan.about:
        whole = (*shape, *(lengths[dim] for dim in one.dimensions))
        variables[one.name] = Variable((*dims, *one.dimensions), whole, "float64", math.nan, one.attributes)
        coords |= {dim: own[dim] for dim in one.dimensions}
    k = multipliers_of(plan)
    coords["part"] = ("part", ["real", "imaginary"], {})
    variables["multipliers"] = Variable(
        (*dims, "multiplier", "part"),
        (*shape, k, 2),
        "float64",
        math.nan,
        {"long_name": "Floquet multipliers of a stride, largest first", "units": "1"},
    )
    labels = families_of(plan)
    flags = {"flag_values": list(range(len(labels))), "flag_meanings": ", ".join(labels)}
    variables["family"] = Variable(dims, shape, "int16", -1, {"long_name": "pairs of legs that push"} | flags)
    flags = {"flag_values": list(MEANINGS), "flag_meanings": "; ".join(MEANINGS.values())}
    variables["outcome"] = Variable(dims, shape, "int16", UNSOLVED, {"long_name": "what became of a gait"} | flags)
    attrs = (
        provenance(animal, {}, list(plan.names))
        | dict(more)
        | {
            "method": "followed from the given gaits" if plan.gaits else "searched for at each point",
            "machine": f"{platform.machine()}, {platform.system()}, Python {platform.python_version()}",
            "settings": json.dumps({"asked": json.loads(plan.asked), "starts": plan.starts, "measures": plan.measures}),
            "given_gaits": json.dumps(plan.gaits),
        }
    )
    return Layout(sizes, plan.block, variables, coords, attrs)


def multipliers_of(plan: Plan) -> int:
    """Return for how many multipliers there is room."""
    if plan.gaits:
        return max(len(gait_from_json(text).multipliers) for text in plan.gaits)
    animal = Animal.model_validate_json(plan.animal)
    return (2 if animal.body.yaw == "held" else 4) + 3 * len(animal.legs)


# What a block holds ---------------------------------------------------------------------------------------------


def block_of(plan: Plan, where: tuple[slice, ...]) -> dict[str, np.ndarray]:
    """Return all that is said of the points of a block, ``(M, branch, ...)``; it depends on nothing else."""
    with threadpool_limits(1):
        points = plan.points(where)
        blank = blank_of(plan, len(points))
        if not plan.gaits:
            for row, values in enumerate(points):
                search_at(plan, values, row, blank)
            return blank
        shape = tuple(part.stop - part.start for part in where) if plan.grid else None
        starts = list[Floats]()
        for number, batch in enumerate(batches_of(plan)):
            follow = follow_to if isinstance(batch, Batch) else follow_alone
            starts.append(follow(plan, batch, points, shape, number, blank))  # type: ignore[arg-type]
            mark_doubles(blank, starts, number)
        return blank


def blank_of(plan: Plan, count: int) -> dict[str, np.ndarray]:
    """Return room for what is said of so many points."""
    layout = layout_of(plan, Animal.model_validate_json(plan.animal), {})
    first = len(plan.sizes)
    return {
        name: np.full((count, *variable.shape[first:]), variable.fill, dtype=variable.dtype)
        for name, variable in layout.variables.items()
    }


def batches_of(plan: Plan) -> list[Batch | Judge]:
    """Return the gaits that are followed, as this thread has them; each for itself if its conditions are not plain."""
    key = hashlib.sha256(json.dumps([plan.gaits, plan.names, plan.low, plan.high]).encode()).hexdigest()
    known: dict[str, list[Batch | Judge]] = LOCAL.__dict__.setdefault("batches", {})
    if key not in known:
        known.clear()
        gaits = [gait_from_json(text) for text in plan.gaits]
        box = box_of(gaits, dict(zip(plan.names, zip(plan.low, plan.high, strict=True), strict=True)))
        known[key] = [
            Batch(gait, box) if Batch.is_plain(gait, box) else Judge(box, (gait,), (), np.zeros(0)) for gait in gaits
        ]
    return known[key]


def follow_to(
    plan: Plan,
    batch: Batch,
    points: Floats,
    shape: tuple[int, ...] | None,
    number: int,
    out: dict[str, np.ndarray],
) -> Floats:
    """Follow a gait to the points of a block, and write what is said of it there; return its parameters, ``(M, n)``."""
    places = (points - batch.box.low) / (batch.box.high - batch.box.low)
    found = reached(batch, places, shape)
    out["outcome"][:, number] = NOT_REACHED
    rows, starts = np.flatnonzero(found.there), np.full((len(points), len(batch.problem.base)), np.nan)
    if not len(rows):
        return starts
    seen = batch.measured(places[rows], found.rows(rows))
    outcome = seen.outcomes.copy()
    out["outcome"][rows, number] = outcome
    good = outcome == GAIT
    out["family"][rows[good], number] = families_of(plan).index(batch.gait.family)
    for one in plan.about:
        if one.name in MEASURES:
            out[one.name][rows[good], number] = seen[one.name][good]
    values = seen.multipliers[good]
    out["multipliers"][rows[good], number, : values.shape[1]] = np.stack([values.real, values.imag], axis=-1)
    others = [one for one in plan.about if one.name not in MEASURES]
    for row in np.flatnonzero(good).tolist() if others else []:
        gait = gait_of(batch, places[rows[row]], seen.p[row])
        for one in others:
            out[one.name][rows[row], number] = one.of(gait)
    starts[rows] = seen.p
    return starts


def follow_alone(
    plan: Plan,
    judge: Judge,
    points: Floats,
    shape: tuple[int, ...] | None,
    number: int,
    out: dict[str, np.ndarray],
) -> Floats:
    """Do the same for a gait whose conditions are not the same everywhere: one point after the other."""
    places = (points - judge.box.low) / (judge.box.high - judge.box.low)
    around, known = neighbours_of(places, shape), dict[int, Trial]()
    start = judge.first()[0]
    seed = int(np.argmin(np.max(np.abs(places - start.place), axis=1)))
    ways = [(start, seed)]
    while ways:
        trial, row = ways.pop(0)
        if row in known:
            continue
        gait = judge.followed(trial, places[row], strict=True)
        if gait is None:
            continue
        known[row] = Trial(places[row], 0, gait)
        ways += [(known[row], other) for other in around[row] if other not in known]
    out["outcome"][:, number] = NOT_REACHED
    for row, trial in known.items():
        assert trial.gait is not None
        wrong = trial.gait.invalid()
        out["outcome"][row, number] = GAIT if wrong is None else 1 + REASONS.index(wrong[0])
        if wrong is None:
            tell(plan, trial.gait, row, number, out)
    starts = np.full((len(points), len(judge.starts[0].point)), np.nan)
    for row, trial in known.items():
        assert trial.gait is not None
        starts[row] = trial.gait.point
    return starts


def tell(plan: Plan, gait: Gait, row: int, number: int, out: dict[str, np.ndarray]) -> None:
    """Write what is said of a gait."""
    out["family"][row, number] = families_of(plan).index(gait.family)
    for one in plan.about:
        out[one.name][row, number] = one.of(gait)
    values = gait.multipliers
    out["multipliers"][row, number, : len(values)] = np.stack([values.real, values.imag], axis=-1)


def families_of(plan: Plan) -> list[str]:
    """Return the labels of the families that there may be."""
    own = list(_creature(plan.animal).families)
    return own + [family for family in (gait_from_json(text).family for text in plan.gaits) if family not in own]


def mark_doubles(out: dict[str, np.ndarray], starts: Sequence[Floats], number: int) -> None:
    """Say where a gait is the same as one of a smaller number, and take back what is said of it.

    ``starts`` has the parameters of each gait at each point, ``(M, n)``, nan where there is none.
    """
    for other in range(number):
        if starts[other].shape != starts[number].shape:
            continue
        off, size = np.abs(starts[number] - starts[other]), np.abs(starts[number]) + np.abs(starts[other])
        # What is infinite is so in both.
        alike = np.all((off <= SAME * size + SAME) | np.isinf(size), axis=1) & (out["outcome"][:, number] == GAIT)
        rows = np.flatnonzero(alike & (out["outcome"][:, other] == GAIT))
        for name, array in out.items():
            array[rows, number] = DOUBLE if name == "outcome" else -1 if name == "family" else np.nan


def reached(batch: Batch, places: Floats, shape: tuple[int, ...] | None) -> Solved:
    """Follow a gait to all places of a block that can be reached, many at once.

    From a first place to some that are far apart, from these to those in between, and so on; last from neighbour to
    neighbour, around what cannot be reached straight.
    """
    count = len(places)
    known = batch.nowhere(count)
    for seed in seeds_of(places, batch.here):
        if known.there[seed]:
            continue
        first = batch.first(places[seed])
        if not first.there[0]:
            continue
        known.put(np.array([seed]), first)
        for rows in levels_of(places, shape, seed):
            todo = rows[~known.there[rows]]
            if len(todo):
                begun = np.flatnonzero(known.there)
                near = begun[np.asarray(cKDTree(places[begun]).query(places[todo])[1])]
                known.put(todo, batch.advanced(known.rows(near), places[near], places[todo]))
        spread_out(batch, places, neighbours_of(places, shape), known)
    return known


def seeds_of(places: Floats, here: Floats) -> list[int]:
    """Return places to which a gait is followed straight: the nearest one, and those at corners, edges and middle."""
    low, high = places.min(axis=0), places.max(axis=0)
    shares = [spot for spot in product((0.0, 0.5, 1.0), repeat=places.shape[1])][:MOST_SEEDS]
    aims = [here, *(low + np.array(spot) * (high - low) for spot in shares)]
    width = np.where(high > low, high - low, 1.0)
    return list(dict.fromkeys(int(np.argmin(np.max(np.abs(places - aim) / width, axis=1))) for aim in aims))


def levels_of(places: Floats, shape: tuple[int, ...] | None, seed: int) -> list[NDArray[np.intp]]:
    """Return places in groups, each of which lies between those of the groups before; without the seed."""
    count = len(places)
    if shape is None:
        others = np.random.default_rng(0).permutation(np.delete(np.arange(count), seed))
        ends = [4**n for n in range(1, 16) if 4**n < count]
        return np.split(others, ends)
    index = np.array(np.unravel_index(np.arange(count), shape))
    off, found, taken = index - index[:, seed, None], list[NDArray[np.intp]](), np.arange(count) == seed
    for power in range(max(shape).bit_length(), -1, -1):
        rows = np.flatnonzero(np.all(off % 2**power == 0, axis=0) & ~taken)
        taken[rows] = True
        found.append(rows)
    return found


def spread_out(batch: Batch, places: Floats, around: Sequence[Sequence[int]], known: Solved) -> None:
    """Go on from all that is known to the places beside, until nothing new is reached."""
    fresh = np.flatnonzero(known.there)
    while len(fresh):
        pairs = np.array([(one, two) for one in fresh.tolist() for two in around[one] if not known.there[two]])
        if not len(pairs):
            return
        # Of several ways to a place, the first is taken; another one may be tried in the next round.
        _, kept = np.unique(pairs[:, 1], return_index=True)
        here, there = pairs[np.sort(kept)].T
        found = batch.advanced(known.rows(here), places[here], places[there])
        known.put(there, found)
        fresh = there[found.there]


def neighbours_of(places: Floats, shape: tuple[int, ...] | None) -> list[list[int]]:
    """Return the places next to each place: on a grid those beside it, else the nearest."""
    count = len(places)
    if shape is None:
        near = min(count, 1 + 2 * NEIGHBOURS * places.shape[1])
        index = cKDTree(places).query(places, near)[1].reshape(count, near)
        around: list[list[int]] = [[] for _ in range(count)]
        for one, others in enumerate(index.tolist()):
            for other in others:
                if other != one:
                    around[one].append(other)
                    around[other].append(one)
        return [list(dict.fromkeys(some)) for some in around]
    numbers, found = np.arange(count).reshape(shape), [list[int]() for _ in range(count)]
    for axis in range(len(shape)):
        low, high = (np.moveaxis(numbers, axis, 0)[part].ravel() for part in (slice(None, -1), slice(1, None)))
        for one, other in zip(low.tolist(), high.tolist(), strict=True):
            found[one].append(other)
            found[other].append(one)
    return found


def search_at(plan: Plan, values: Floats, row: int, out: dict[str, np.ndarray]) -> None:
    """Search for all gaits at a point, and write what is said of them."""
    animal, asked = _creature(plan.animal), json.loads(plan.asked)
    over = {name: (value,) for name, value in zip(plan.names, values.tolist(), strict=True)}
    try:
        own, wanted = Grid(animal, over, asked).at(tuple(0 for _ in over))
        search = search_gaits(own, starts=plan.starts, **wanted)
    except ValueError:
        out["outcome"][row] = UNASKABLE
        return
    out["outcome"][row] = NO_FURTHER
    if not search.gaits:
        reasons = Counter(rejection.reason for rejection in search.rejections).most_common(1)
        out["outcome"][row, 0] = 1 + REASONS.index(reasons[0][0]) if reasons else NO_GAIT
    for number, gait in enumerate(search.gaits[: plan.branches]):
        out["outcome"][row, number] = GAIT
        tell(plan, gait, row, number, out)


@lru_cache(maxsize=4)
def _creature(text: str) -> Animal:
    return Animal.model_validate_json(text)
