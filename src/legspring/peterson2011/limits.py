"""Where optimised gaits cease to exist, as lines over slope and heading: Figure 5.1 with lines in place of dots."""

from collections.abc import Iterator

import numpy as np
import xarray as xr
from threadpoolctl import threadpool_limits

from legspring.exchange import candidate_of
from legspring.kernel.walker import Floats
from legspring.model import Animal
from legspring.objective import Objective
from legspring.optimisation import FIRST_ITERATIONS, polish
from legspring.parallel import processes

HALVINGS = 5
"""Halvings of the way from a cell with a gait to its neighbour without one."""
AXES = ("slope_deg", "heading")
Point = tuple[float, float]
"""Slope (deg) and heading (rad)."""


def limits(animal: Animal, optima: xr.Dataset, workers: int) -> xr.Dataset:
    """Find out where, between a cell with an optimised gait and its neighbour without one, it ceases to exist.

    Parameters
    ----------
    animal
        Whose gaits they are.
    optima
        Of `legspring.optima.optimal_atlas`.
    workers
        Processes.

    Returns
    -------
    xarray.Dataset
        ``limit`` over objective, family, slope_deg, heading and axis: the slope (deg), or heading (rad), between that
        of the cell and the next one along the axis; missing where there are gaits in both, or in none. ``exists`` over
        all but axis: whether the cell has a gait.
    """
    optima = optima.transpose("objective", "family", *AXES, ...)
    there, cells = np.isfinite(optima["speed"].values), ("objective", "family", *AXES)
    values = np.full((*there.shape, len(AXES)), np.nan)
    places, tasks = [], []
    for axis, name in enumerate(AXES):
        changes = np.argwhere(np.diff(there, axis=2 + axis) != 0)
        for place in map(tuple, changes.tolist()):
            step = np.eye(4, dtype=int)[2 + axis]
            ends = [place, tuple(place + step)]
            inside, outside = ends if there[place] else ends[::-1]
            places.append((*place, axis))
            beyond = float(optima[name].values[outside[2 + axis]])
            tasks.append((last_place, animal, optima.isel(dict(zip(cells, inside, strict=True))), name, beyond))
    with processes(workers) as pool:
        for place, found in zip(places, pool.map(pool.call, tasks), strict=True):
            values[place] = found
    coords = {name: optima[name] for name in cells} | {"axis": list(AXES)}
    words = {"long_name": "where optimised gaits cease to exist, along an axis"}
    whether = {"long_name": "whether there is an optimised gait"}
    return xr.Dataset({"limit": ((*cells, "axis"), values, words), "exists": (cells, there, whether)}, coords)


def last_place(animal: Animal, optimum: xr.Dataset, name: str, beyond: float) -> float:
    """Return how far along an axis an optimum can be followed towards a cell that has none."""
    here = {axis: float(optimum[axis]) for axis in AXES}
    family, goal = (str(optimum[word].item()) for word in ("family", "objective"))
    objective = Objective(animal, np.radians(here["slope_deg"]), here["heading"], family, goal, "reduced")  # type: ignore[arg-type]
    candidate, low, high = candidate_of(optimum, animal), here[name], float(beyond)
    with threadpool_limits(1):
        for _ in range(HALVINGS):
            there = here | {name: 0.5 * (low + high)}
            halt = objective.at(np.radians(there["slope_deg"]), there["heading"])
            end = polish(halt, candidate, iterations=FIRST_ITERATIONS)
            if end is None:
                high = there[name]
            else:
                low, candidate = there[name], end.candidate
    return 0.5 * (low + high)


def outline(found: xr.Dataset) -> Iterator[tuple[Point, Point]]:
    """Return the pieces of the line around the cells of one family that have a gait, for one objective.

    Parameters
    ----------
    found
        Of `limits`, over slope_deg, heading and axis.
    """
    slopes, headings = (found[name].values for name in AXES)
    limit: Floats = found["limit"].transpose(*AXES, "axis").values
    for row in range(len(slopes) - 1):
        for column in range(len(headings) - 1):
            # Around the square between four cells: where its sides are crossed, in order.
            crossed: list[Point | None] = [
                (limit[row, column, 0], headings[column]),
                (slopes[row + 1], limit[row + 1, column, 1]),
                (limit[row, column + 1, 0], headings[column + 1]),
                (slopes[row], limit[row, column, 1]),
            ]
            points = [point for point in crossed if point is not None and not np.isnan(point).any()]
            yield from zip(points[::2], points[1::2], strict=True)


def crossings(found: xr.Dataset) -> list[tuple[Point, Point]]:
    """Return the places where gaits of one family cease to exist, each with the cell beside it that has one."""
    slopes, headings = (found[name].values for name in AXES)
    limit, there = found["limit"].transpose(*AXES, "axis").values, found["exists"].transpose(*AXES).values
    places = []
    for row, column, axis in np.argwhere(np.isfinite(limit)).tolist():
        inside = (row, column) if there[row, column] else (row + (axis == 0), column + (axis == 1))
        place = [slopes[row], headings[column]]
        place[axis] = limit[row, column, axis]
        places.append(((place[0], place[1]), (slopes[inside[0]], headings[inside[1]])))
    return places
