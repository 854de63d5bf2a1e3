"""Gaits over anything: grids, lists and samples of parameters, as large as one likes (`legspring.sweep`).

The points are cut into blocks. What a block holds depends on the question alone, and not on other blocks: whoever works
on it, and when, it comes out the same to the last bit.
"""

import json
import os
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from legspring.batches import GAIT
from legspring.blocks import block_of
from legspring.checks import checked_names, checked_workers, shown
from legspring.files import code_stamp
from legspring.gait import Gait
from legspring.mapping import FOLLOW
from legspring.model import Animal
from legspring.parallel import in_threads
from legspring.plans import BRANCHES, NO_FURTHER, Plan, checked_over, layout_of, plan_of
from legspring.progress import progress_bar
from legspring.stores import Block, InMemory, Layout, OnDisk, block_in, opened

if TYPE_CHECKING:
    import xarray as xr


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
    impulses: Sequence[float] = (),
    starts: int | None = None,
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
        (``legspring.plans.QUICK``). Others take milliseconds for each gait. Multipliers are always there.
    slope_deg, heading, speed, mean_speed, energy, apex_height, lateral_drift, free, mirrored
        What gaits are asked for everywhere, where they are searched for (see `legspring.search_gaits`).
    impulses
        Sideways impulses to recover from, in units of m v_des; none: no recovery.
    starts, branches
        Of the search at each point, for each family, by default 8 or 16 on a grid, where neighbours give more, else 24;
        and for how many gaits there is room.
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
        it is one; its attributes say what other numbers mean); and ``found``, how many gaits there are at each point.
        Measures of what is no gait are missing. With a store only what is looked at is read; the folder may be opened
        by `legspring.open_sweep` at any time, also while the work goes on.

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
    plan = plan_of(animal, points, grid, some, wanted, measures, starts, branches, block_in(store), impulses)
    chance = {"seed": seed, "samples": samples} if samples is not None else {}
    return carried_out(plan, {"sampling": sampling} | chance, store, workers, cluster, progress)


def carried_out(
    plan: Plan,
    more: Mapping[str, Any],
    store: str | os.PathLike[str] | None,
    workers: int | None,
    cluster: Any,
    progress: bool,
) -> "xr.Dataset":
    """Carry out a plan, of whose result ``more`` is said; see `sweep`."""
    threads, layout = checked_workers(workers), layout_of(plan, more)
    # Points may be added, unless all are one block: which there are, coordinates say; and blocks are as they were made.
    loose = {"values", "low", "high", "width"} if plan.method != FOLLOW else {"width"}
    parts = {name: value for name, value in asdict(plan).items() if name not in loose}
    identity = json.loads(json.dumps({"version": code_stamp(), "sampling": more["sampling"], **parts}))
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
        result.write(block, layout.shaped(block, block_of(plan.part(layout.where(block)))))
        tick(layout.count(block))

    in_threads(work, todo, workers)


def fates_of(found: "xr.Dataset") -> list[str]:
    """Say what became of the places without a gait, a line for each outcome."""
    about, values = found["outcome"].attrs, found["outcome"].values
    words = dict(
        zip(np.atleast_1d(about["flag_values"]).tolist(), str(about["flag_meanings"]).split("; "), strict=True)
    )
    counts = Counter(values.ravel().tolist())
    left = int(np.sum(np.maximum(found["found"].values - values.shape[-1], 0)))
    more = [f"{left}: further gaits, for which there is no room among the branches"] if left else []
    return [f"{count}: {words[one]}" for one, count in counts.most_common() if one not in (GAIT, NO_FURTHER)] + more
