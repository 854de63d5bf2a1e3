"""What curves of gaits cost, boundaries, and a map by following; beside curves by SciPy (`benchmarks.scipy_curves`)."""

import time
from collections.abc import Callable
from functools import partial
from statistics import median

from benchmarks.figures import Figure, together
from benchmarks.scipy_curves import COARSE, DIFFERENCE, TOLERANCE, conditions_of, fold_of, followed, start_of
from benchmarks.strides import scipy_scalar
from benchmarks.subjects import point_masses
from legspring.boundaries import boundary
from legspring.continuation import Continuation
from legspring.following import follow
from legspring.gait import Gait
from legspring.landmarks import Kind
from legspring.mapping import FOLLOW, HEADINGS, SEARCH, SLOPES_DEG, Grid, find_on
from legspring.model import cockroach
from legspring.solve import find_gaits

PLACES = ((15.0, 0.2), (45.0, 0.15), (70.0, 0.2))
ALONG = (("heading", (0.0, 0.7)), ("slope_deg", (-30.0, 90.0)), ("F.stiffness", (0.5, 6.0)))
DIRECTIONS = 5
"""Derivatives that a step of a search takes; by differences each is a step more."""
BY_SCIPY = {"curves": 6, "boundary": 2}
"""How many points SciPy is given, at the step that is usual here."""
STEP = 0.05


def curves(gaits: list[Gait]) -> list[Continuation]:
    """Follow some gaits along some parameters."""
    return [follow(gait, name, within=limits) for gait in gaits for name, limits in ALONG]


def measure(quick: bool) -> list[Figure]:
    """Time all of it in turn."""
    animal, rounds = cockroach(), 1 if quick else 3
    gaits = [find_gaits(animal, slope_deg=slope, heading=heading)[0] for slope, heading in PLACES[: 1 if quick else 3]]
    steep = follow(find_gaits(animal, slope_deg=40, heading=0.4)[0], "heading", to=0.6)
    fold = next(one for one in steep.special if one.kind is Kind.FOLD)
    fine = partial(smooth, gaits[-1])
    found = curves(gaits)
    points = sum(map(len, found))
    line = boundary(fold, "slope_deg", "heading", within=((0.0, 90.0), (0.0, 0.7)))
    problem = point_masses()[0].problem()
    works: dict[str, Callable[[], object]] = {
        "curves": partial(curves, gaits),
        "smooth": fine,
        "boundary": partial(boundary, fold, "slope_deg", "heading", within=((0.0, 90.0), (0.0, 0.7))),
        "stride": partial(scipy_scalar, problem, TOLERANCE),
    }
    times = together(works, rounds)
    smooth_points = len(fine())
    step = 0.5 * times["stride"]
    point, on_fold = (scipy_seconds(gait, folds, quick) for gait, folds in ((gaits[0], False), (fold.gait, True)))
    maps = {method: wall(partial(find_on, grid(animal), method=method)) for method in (SEARCH, FOLLOW)}
    figures = [
        Figure(
            "points of a smooth curve in a second, all looked at",
            smooth_points / times["smooth"],
            "1/s",
            3000.0,
            3000.0,
            more_is_better=True,
            detail={"points": smooth_points},
        ),
        Figure(
            "points of curves in a second, ends and special points located",
            points / times["curves"],
            "1/s",
            detail={
                "points": points,
                "curves": len(found),
                "scipy_s_a_point": point,
                "times_faster_than_scipy": point * points / times["curves"],
            },
        ),
        Figure(
            "200 points of a boundary (folds)",
            200.0 * times["boundary"] / len(line),
            "s",
            detail={
                "points": len(line),
                "scipy_s_a_point": on_fold,
                "times_faster_than_scipy": on_fold * len(line) / times["boundary"],
            },
        ),
    ]
    for method, (seconds, effort) in maps.items():
        detail = effort | {"times_faster_than_scipy": effort["steps"] * (1 + DIRECTIONS) * step / seconds}
        figures.append(Figure(f"all gaits of the thesis's grid, by {method}", seconds, "s", detail=detail))
    return figures


def smooth(gait: Gait) -> Continuation:
    """Follow a gait in short steps where nothing happens, up to the vertical."""
    return follow(gait, "slope_deg", to=90.0, longest_step=2e-3)


def scipy_seconds(gait: Gait, folds: bool, quick: bool) -> float:
    """Return how long SciPy takes for a point of the curve of a gait along the heading, or of its line of folds.

    Special points and validity are left out.
    """
    count = 1 if quick else BY_SCIPY["boundary" if folds else "curves"]
    conditions, columns = conditions_of(gait), [0, 1, 2, 3, *([4] if folds else []), 5]
    function, size = (fold_of(conditions), COARSE) if folds else (conditions, DIFFERENCE)
    begin = time.perf_counter()
    followed(function, start_of(gait), columns, count, STEP, size)
    return (time.perf_counter() - begin) / count


def grid(animal: object) -> Grid:
    """Return the thesis's grid."""
    return Grid(animal, {"slope_deg": SLOPES_DEG, "heading": HEADINGS})  # type: ignore[arg-type]


def wall(work: Callable[[], object]) -> tuple[float, dict[str, int]]:
    """Return how long a search takes by the clock, the median of three, and its effort."""
    times, effort = [], {}
    for _ in range(3):
        begin = time.perf_counter()
        effort = work().effort  # type: ignore[attr-defined]
        times.append(time.perf_counter() - begin)
    return median(times), effort
