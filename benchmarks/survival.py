"""What basins, pushes and rough ground cost, beside as much of them by SciPy as there is time for."""

import time
from dataclasses import replace

import numpy as np

from benchmarks.figures import Figure
from benchmarks.subjects import Subject
from legspring.basins import basin
from legspring.gait import Gait
from legspring.model import cockroach
from legspring.pushing import pushes
from legspring.roughness import rough
from legspring.solve import find_gaits
from tests.oracle.scipy_walker import simulate

GRID, RUNS, STRIDES = 200, 10_000, 100
PLACES = ((45.0, 0.15), (15.0, 0.2))
"""Slope (deg) and heading (rad) of a gait that attracts soon, and of one that takes four times as long."""
FEW = 5
"""Starts that SciPy is given."""
TOLERANCE = 1e-10


def measure(quick: bool) -> list[Figure]:
    """Time all of it, once compiled."""
    animal, side = cockroach(), GRID // 4 if quick else GRID
    gaits = [find_gaits(animal, slope_deg=slope, heading=heading)[0] for slope, heading in PLACES]
    gait = gaits[-1]
    basin(gait, {"speed": [0.2, 0.3]})
    rough(gait, {"slope_deg": 1.0}, runs=2, strides=1)
    figures = [basin_figure(one, side, quick) for one in gaits]
    begin = time.perf_counter()
    pushes(gait)
    figures.append(Figure("pushes in 24 directions at 16 moments", time.perf_counter() - begin, "s"))
    count = RUNS // 20 if quick else RUNS
    begin = time.perf_counter()
    rough(gait, {"slope_deg": 5.0, "phase": 0.05}, runs=count, strides=STRIDES)
    seconds = time.perf_counter() - begin
    by_scipy = scipy_start(gait, float(STRIDES)) * count
    figures.append(
        Figure(
            f"{count} runs of {STRIDES} strides over rough ground",
            seconds,
            "s",
            must=None if quick else 60.0,
            aim=None if quick else 60.0,
            detail={"times_faster_than_scipy": by_scipy / seconds},
        )
    )
    return figures


def basin_figure(gait: Gait, side: int, quick: bool) -> Figure:
    """Time a basin over speed and heading."""
    axes = {"speed": np.linspace(0.1, 1.0, side), "heading": np.linspace(-1.5, 1.5, side)}
    begin = time.perf_counter()
    steps = float(basin(gait, axes)["steps"].mean())
    seconds = time.perf_counter() - begin
    by_scipy = scipy_start(gait, steps / 2.0) * side**2
    must = None if quick else 10.0
    detail = {"mean_steps": steps, "times_faster_than_scipy": by_scipy / seconds}
    return Figure(f"basin of {side} x {side} starts, {gait.slope_deg:g} deg", seconds, "s", must, must, detail=detail)


def scipy_start(gait: Gait, strides: float) -> float:
    """Return how long SciPy takes for so many strides from one start."""
    problem = Subject("", gait.system, gait.point).problem()
    whole = max(1, round(strides))
    begin = time.perf_counter()
    for factor in np.linspace(0.8, 1.2, FEW):
        simulate(
            replace(problem, speed=float(factor) * problem.speed), float(whole), rtol=TOLERANCE, atol=1e-2 * TOLERANCE
        )
    return (time.perf_counter() - begin) / FEW * strides / whole
