"""Gaits over a grid of slopes and headings, with all their measures, as an xarray.Dataset."""

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from legspring.checks import MOST_STARTS, checked_grid, checked_vector, checked_whole, checked_workers
from legspring.gait import Gait
from legspring.kernel.walker import Floats
from legspring.measures.registry import BY_NAME, OF_RECOVERIES, Measure, mapped, measured
from legspring.measures.robustness import LARGEST_IMPULSE
from legspring.model import Animal
from legspring.parallel import in_threads
from legspring.problem import GaitProblem, check_tuned, tuned
from legspring.progress import progress_bar
from legspring.solve import number_branches, sort, starts_for, zeros

SLOPES_DEG = tuple(float(slope) for slope in range(0, 91, 5))
HEADINGS = tuple(round(0.05 * n, 2) for n in range(10))
IMPULSES = tuple(round(0.1 * n, 1) for n in range(-8, 9))
STARTS = 4
"""Starts for each family in each cell; neighbouring cells give more."""


@dataclass
class Cell:
    """One family at one point of the grid, while the search goes on."""

    place: tuple[int, int]
    problem: GaitProblem
    zeros: Floats
    fresh: Floats

    @classmethod
    def empty(cls, place: tuple[int, int], problem: GaitProblem) -> "Cell":
        """Return a cell of which nothing is known yet."""
        nothing = np.zeros((0, problem.size))
        return cls(place, problem, nothing, nothing)

    def search(self, starts: Floats) -> int:
        """Search from more starts; return the number of steps simulated."""
        known = len(self.zeros)
        self.zeros, _, steps = zeros(self.problem, starts, self.zeros)
        self.fresh = self.zeros[known:]
        return steps


def neighbours(place: tuple[int, int]) -> list[tuple[int, int]]:
    """Return the places around one, some of which may be off the grid."""
    row, column = place
    return [(row - 1, column), (row + 1, column), (row, column - 1), (row, column + 1)]


def _spread(cells: dict[tuple[int, int], Cell], workers: int) -> int:
    """Continue solutions from cell to cell until nothing new turns up; return the number of steps simulated."""
    steps = 0
    while True:
        tasks = []
        for place, cell in cells.items():
            around = [cells[n].fresh for n in neighbours(place) if n in cells]
            starts = np.vstack([np.zeros((0, cell.problem.size)), *around])
            if len(starts):
                tasks.append((cell, starts))
        for cell in cells.values():
            cell.fresh = cell.zeros[:0]
        if not tasks:
            return steps
        steps += sum(in_threads(lambda task: task[0].search(task[1]), tasks, workers))


def find_all(
    animal: Animal,
    slopes_deg: Sequence[float],
    headings: Sequence[float],
    *,
    starts: int = STARTS,
    workers: int | None = None,
    progress: bool = False,
) -> tuple[dict[tuple[int, int], tuple[Gait, ...]], dict[str, int]]:
    """Find the gaits on a grid, by searching in every cell and continuing what is found to the neighbours.

    Returns
    -------
    gaits, effort
        Gaits by (slope index, heading index), numbered; and counts of starts, steps simulated and rejections.
    """
    workers = checked_workers(workers)
    places = [(row, column) for row in range(len(slopes_deg)) for column in range(len(headings))]
    effort = {"starts": 0, "steps": 0, "solutions rejected": 0}
    found: dict[tuple[int, int], list[Gait]] = {place: [] for place in places}
    total = 2 * len(places) * len(animal.families)
    with progress_bar("searching for gaits", total, show=progress) as tick:
        for family in animal.families:
            cells = {
                (row, column): Cell.empty(
                    (row, column), tuned(animal, math.radians(slopes_deg[row]), headings[column], family)
                )
                for row, column in places
            }
            effort["starts"] += starts * len(cells)
            points = in_threads(lambda c: c.search(starts_for(c.problem, starts)), cells.values(), workers, tick)
            effort["steps"] += sum(points) + _spread(cells, workers)
            for cell, (gaits, rejections) in zip(
                cells.values(),
                in_threads(lambda c: sort(c.problem, c.zeros), cells.values(), workers, tick),
                strict=True,
            ):
                found[cell.place] += gaits
                effort["solutions rejected"] += len(rejections)
    return {place: number_branches(gaits) for place, gaits in found.items()}, effort


def atlas(
    animal: Animal,
    *,
    slopes_deg: Sequence[float] = SLOPES_DEG,
    headings: Sequence[float] = HEADINGS,
    actuation: ArrayLike | None = None,
    impulses: Sequence[float] = IMPULSES,
    starts: int = STARTS,
    workers: int | None = None,
    progress: bool = False,
) -> xr.Dataset:
    """Map the gaits of an animal over slope and heading.

    Parameters
    ----------
    animal
        The animal.
    slopes_deg, headings
        The grid, rising: degrees, rad; by default 0 to 90 deg and 0 to 0.45 rad.
    actuation
        Magnitudes for each pair of legs, m; by default the animal's.
    impulses
        Sideways impulses to recover from, in units of m v_des; none: no recovery.
    starts
        Starts of the search for each family in each cell.
    workers
        Threads; by default one a core.
    progress
        Whether to show a progress bar.

    Returns
    -------
    xarray.Dataset
        Over slope_deg, heading, branch, leg (pairs of legs), single_leg, axis and impulse; missing where there is no
        gait. Its variables are those of ``legspring.measures.registry``.

    Raises
    ------
    ValueError
        For a grid that does not rise, or a number out of range.
    """
    slopes_deg = checked_grid("slopes_deg", slopes_deg, 90.0)
    headings = checked_grid("headings", headings, math.pi / 2)
    impulses = checked_grid("impulses", impulses, LARGEST_IMPULSE, least=0)
    starts, workers = checked_whole("starts", starts, 1, MOST_STARTS), checked_workers(workers)
    if actuation is not None:
        animal = animal.replace(actuation=checked_vector("actuation", actuation, len(animal.pairs)).tolist())
    check_tuned(animal, "for a map over slope and heading")
    found, effort = find_all(animal, slopes_deg, headings, starts=starts, workers=workers, progress=progress)
    gaits = [((*place, gait.branch), gait) for place, here in found.items() for gait in here]

    def values_of(gait: Gait) -> dict[str, Any]:
        return measured(mapped(animal), gait) | measured(OF_RECOVERIES, gait.recovery_steps(impulses))

    with progress_bar("measuring gaits", len(gaits), show=progress) as tick:
        all_values = in_threads(lambda item: values_of(item[1]), gaits, workers, tick)
    branches = 1 + max((gait.branch for _, gait in gaits), default=0)
    coords = coordinates(animal, slopes_deg, headings)
    coords["branch"] = ("branch", np.arange(branches), BY_NAME["branch"].attributes)
    coords["impulse"] = ("impulse", list(impulses), {"units": "m v_des", "long_name": "sideways impulse"})
    dataset = empty_map((*mapped(animal), *OF_RECOVERIES), ("slope_deg", "heading", "branch"), coords)
    fill(dataset, [(place, values) for (place, _), values in zip(gaits, all_values, strict=True)])
    return dataset.assign_attrs(provenance(animal, effort))


def coordinates(animal: Animal, slopes_deg: Sequence[float], headings: Sequence[float]) -> dict[str, tuple[Any, ...]]:
    """Return the coordinates that all maps have."""
    return {
        "slope_deg": ("slope_deg", list(slopes_deg), BY_NAME["slope_deg"].attributes),
        "heading": ("heading", list(headings), BY_NAME["heading"].attributes),
        "leg": ("leg", list(animal.pairs), {"long_name": "pair of legs"}),
        "single_leg": ("single_leg", [leg.name for leg in animal.legs], {"long_name": "leg"}),
        "axis": ("axis", ["lateral", "fore_aft"], {"long_name": "direction of a force"}),
    }


def empty_map(measures: Sequence[Measure], cell: tuple[str, ...], coords: Mapping[str, tuple[Any, ...]]) -> xr.Dataset:
    """Return a dataset of measures in which all is missing: nan, or an empty word.

    Parameters
    ----------
    measures
        Its variables; what is a coordinate is none.
    cell
        Dimensions that say which gait is meant; those of a measure follow.
    coords
        The coordinates, each as (dimension, values, attributes).
    """
    variables = {}
    for measure in measures:
        if measure.name in coords:
            continue
        dims = (*cell, *measure.dimensions)
        shape = [len(coords[dim][1]) for dim in dims]
        values = np.full(shape, np.nan) if measure.unit else np.full(shape, "", dtype=object)
        variables[measure.name] = (dims, values, measure.attributes)
    return xr.Dataset(variables, coords=coords)


def fill(dataset: xr.Dataset, known: Iterable[tuple[tuple[int, ...], Mapping[str, Any]]]) -> None:
    """Write what is known of gaits into their places in a map."""
    arrays = {str(name): variable.values for name, variable in dataset.data_vars.items()}
    for place, values in known:
        for name, array in arrays.items():
            array[place] = values[name]


def provenance(animal: Animal, effort: dict[str, int]) -> dict[str, Any]:
    """Say what a map shows and where it comes from: the attributes of its dataset."""
    return {
        "title": f"Gaits of {animal.name} over slope and heading",
        "animal": animal.name,
        "parameters": json.dumps(animal.model_dump(mode="json")),
        "source": f"legspring {version('legspring')}",
        "references": animal.source,
        "history": f"{datetime.now(UTC):%Y-%m-%d %H:%M:%S} UTC: computed",
    } | ({"search": ", ".join(f"{count} {what}" for what, count in effort.items())} if effort else {})
