"""What sweeps cost: gaits followed and searched for, on one thread and two, on Dask, beside a few by SciPy."""

import resource
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.figures import Figure
from benchmarks.survival import scipy_start
from legspring.fronts import pareto
from legspring.model import cockroach
from legspring.solve import find_gaits
from legspring.sweeping import sweep

SIDE, MILLION = 200, 1000
"""Values along each of two axes; of a million gaits, which is measured by `python -m benchmarks.sweeps`."""
STRIDES = 13.0
"""That SciPy needs for a gait: three iterations of half a stride with four differences, a Jacobian, three to look."""
SEARCHED = 6


def axes(side: int) -> dict[str, Any]:
    """Return a grid on which the gait is everywhere."""
    return {"slope_deg": np.linspace(40.0, 60.0, side), "F.stiffness": np.linspace(1.3, 1.8, side)}


def timed(work: Callable[[], object]) -> float:
    """Return how long something takes, s."""
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def measure(quick: bool) -> list[Figure]:
    """Time all of it, once compiled."""
    animal, side = cockroach(), SIDE // 8 if quick else SIDE
    gaits = find_gaits(animal, slope_deg=45.0, heading=0.15)
    gait, grid = gaits[0], axes(side)
    sweep(animal, {"slope_deg": [44.0, 45.0]}, gaits=gait)
    alone, both = (timed(lambda n=n: sweep(animal, grid, gaits=gait, workers=n)) for n in (1, 2))  # type: ignore[misc]
    count, by_scipy = side**2, scipy_start(gait, STRIDES) * side**2
    detail = {"one_thread": count / alone, "times_faster_than_scipy": by_scipy / both}
    figures = [Figure("gaits followed, with all multipliers", count / both, "/s", detail=detail)]
    points = {name: values[:: len(values) // SEARCHED] for name, values in axes(SEARCHED * 10).items()}
    seconds = timed(lambda: sweep(animal, points, heading=0.15, workers=2))
    found = len(points["slope_deg"]) * len(points["F.stiffness"])
    figures.append(Figure("points searched for all gaits", found / seconds, "/s"))
    if not quick:
        figures.append(Figure("gaits followed on a local cluster of Dask", count / on_dask(animal, grid, gait), "/s"))
    ranges = {f"{pair}.stiffness": (0.5, 2.5) for pair in animal.pairs}
    level = find_gaits(animal, slope_deg=10.0, heading=0.15)[0]
    tried = 96 if quick else 480
    seconds = timed(
        lambda: pareto(level, ranges, minimize=["stability", "transport_cost"], evaluations=tried, refine=False)
    )
    figures.append(Figure("gaits tried by a global search for a front", tried / seconds, "/s"))
    return figures


def on_dask(animal: Any, grid: dict[str, Any], gait: Any) -> float:
    """Return how long a sweep takes on a cluster of two processes that are there already and have compiled."""
    from distributed import Client, LocalCluster

    with (
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        sweep(animal, axes(40), gaits=gait, cluster=client)
        return timed(lambda: sweep(animal, grid, gaits=gait, cluster=client))


if __name__ == "__main__":
    side = int(sys.argv[1]) if len(sys.argv) > 1 else MILLION
    roach = cockroach()
    one = find_gaits(roach, slope_deg=45.0, heading=0.15)[0]
    sweep(roach, {"slope_deg": [44.0, 45.0]}, gaits=one)
    with tempfile.TemporaryDirectory() as folder:
        seconds = timed(lambda: sweep(roach, axes(side), gaits=one, store=Path(folder) / "runs.zarr", progress=True))
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{side**2} gaits: {seconds:.1f} s, {side**2 / seconds:.0f} a second, at most {memory:.0f} MiB")
