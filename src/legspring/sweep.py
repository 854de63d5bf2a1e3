"""Gaits over a grid of slopes and headings, with all their measures, as an xarray.Dataset."""

import json
import math
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, TypeVar

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

import legspring
from legspring.checks import MOST_STARTS, checked_grid, checked_vector, checked_whole, checked_workers
from legspring.gait import Gait
from legspring.kernel.walker import Floats
from legspring.measures.robustness import LARGEST_IMPULSE
from legspring.model import Animal
from legspring.problem import GaitProblem, check_tuned, tuned
from legspring.progress import progress_bar
from legspring.solve import number_branches, sort, starts_for, zeros

T = TypeVar("T")
R = TypeVar("R")

SLOPES_DEG = tuple(float(slope) for slope in range(0, 91, 5))
HEADINGS = tuple(round(0.05 * n, 2) for n in range(10))
IMPULSES = tuple(round(0.1 * n, 1) for n in range(-8, 9))
STARTS = 4
"""Starts for each family in each cell; neighbouring cells give more."""

LONG_NAMES = {
    "family": ("", "pairs of legs that push"),
    "speed": ("m/s", "initial speed of a step"),
    "phase": ("rad", "phase of the actuation"),
    "actuation": ("m", "magnitude of the actuation"),
    "liftoff": ("t_des", "time from touch-down to lift-off"),
    "reduced_eigenvalue": ("1", "largest eigenvalue magnitude of the reduced map (thesis)"),
    "max_multiplier": ("1", "largest magnitude of a Floquet multiplier of a stride (complete map)"),
    "transport_cost": ("1", "transport cost (Eq. 3.6)"),
    "peak_force": ("m g", "peak force of a leg on the body"),
    "net_force_max": ("m g", "largest sum of the forces of all legs"),
    "net_force_min": ("m g", "smallest sum of the forces of all legs"),
    "grazing": ("m/s", "smallest rate at which a leg passes through zero force at lift-off"),
    "residual": ("1", "largest scaled condition left"),
    "recovery_steps": ("1", "steps to recover from an impulse"),
    "recovered": ("1", "whether the gait came back after an impulse (0 or 1)"),
}

YAW_NAMES = {
    "yaw": ("rad", "yaw at the start of a step"),
    "yaw_rate": ("rad/s", "yaw rate at the start of a step"),
    "yaw_amplitude": ("rad", "largest yaw to either side"),
    "peak_moment": ("N m", "largest moment of all legs about the centre of mass"),
}
"""What is said in addition where the body yaws."""


def names_of(animal: Animal) -> dict[str, tuple[str, str]]:
    """Return units and words of what a map says of each gait, by name."""
    return LONG_NAMES | (YAW_NAMES if animal.body.yaw == "free" else {})


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


def _parallel(work: Callable[[T], R], items: Iterable[T], workers: int, tick: Callable[[int], None]) -> list[R]:
    """Map over threads: the kernel runs without Python's lock."""
    results = []
    with ThreadPoolExecutor(workers) as pool:
        for result in pool.map(work, items):
            results.append(result)
            tick(1)
    return results


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
        steps += sum(_parallel(lambda task: task[0].search(task[1]), tasks, workers, lambda _: None))


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
            points = _parallel(lambda c: c.search(starts_for(c.problem, starts)), cells.values(), workers, tick)
            effort["steps"] += sum(points) + _spread(cells, workers)
            for cell, (gaits, rejections) in zip(
                cells.values(),
                _parallel(lambda c: sort(c.problem, c.zeros), cells.values(), workers, tick),
                strict=True,
            ):
                found[cell.place] += gaits
                effort["solutions rejected"] += len(rejections)
    return {place: number_branches(gaits) for place, gaits in found.items()}, effort


def measured(gait: Gait, impulses: Sequence[float]) -> dict[str, Any]:
    """Return all of a gait's measures under the names that they have in an atlas."""
    high, low = gait.net_force
    recovery = gait.recovery_steps(impulses)
    turning = {name: getattr(gait, name) for name in YAW_NAMES} if gait.animal.body.yaw == "free" else {}
    return turning | {
        "family": gait.family,
        "speed": gait.speed,
        "phase": gait.phase,
        "actuation": gait.actuation,
        "liftoff": gait.liftoff,
        "reduced_eigenvalue": gait.reduced_eigenvalue,
        "max_multiplier": abs(gait.multipliers[0]),
        "transport_cost": gait.transport_cost,
        "peak_force": gait.peak_force,
        "net_force_max": high,
        "net_force_min": low,
        "grazing": gait.grazing,
        "residual": gait.residual,
        "recovery_steps": recovery,
        "recovered": np.isfinite(recovery).astype(float),
    }


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
        Over slope_deg, heading, branch, leg, axis and impulse; missing where there is no gait. Where the body yaws,
        `YAW_NAMES` are among its variables.

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
    gaits = [(place, gait) for place, here in found.items() for gait in here]
    with progress_bar("measuring gaits", len(gaits), show=progress) as tick:
        values = _parallel(lambda item: measured(item[1], impulses), gaits, workers, tick)
    branches = 1 + max((gait.branch for _, gait in gaits), default=0)
    coords = coordinates(animal, slopes_deg, headings)
    coords["branch"] = ("branch", np.arange(branches), {"long_name": "branch, by the phase of the hindmost legs"})
    coords["impulse"] = ("impulse", list(impulses), {"units": "m v_des", "long_name": "sideways impulse"})
    dataset = xr.Dataset(_empty(names_of(animal), coords), coords=coords, attrs=provenance(animal, effort))
    for ((row, column), gait), value in zip(gaits, values, strict=True):
        for name, number in value.items():
            dataset[name].values[row, column, gait.branch] = number
    return dataset


def coordinates(animal: Animal, slopes_deg: Sequence[float], headings: Sequence[float]) -> dict[str, tuple[Any, ...]]:
    """Return the coordinates that all maps have."""
    return {
        "slope_deg": ("slope_deg", list(slopes_deg), {"units": "degrees", "long_name": "slope"}),
        "heading": ("heading", list(headings), {"units": "rad", "long_name": "initial heading"}),
        "leg": ("leg", list(animal.pairs), {"long_name": "pair of legs"}),
        "axis": ("axis", ["lateral", "fore_aft"], {"long_name": "direction of a force"}),
    }


DIMENSIONS = {
    "phase": ("leg",),
    "actuation": ("leg",),
    "liftoff": ("leg",),
    "peak_force": ("leg", "axis"),
    "net_force_max": ("axis",),
    "net_force_min": ("axis",),
    "recovery_steps": ("impulse",),
    "recovered": ("impulse",),
}


def _empty(names: dict[str, tuple[str, str]], coords: dict[str, tuple[Any, ...]]) -> dict[str, tuple[Any, ...]]:
    """Return the atlas's variables, all missing."""
    variables = {}
    for name, (units, long_name) in names.items():
        dims = ("slope_deg", "heading", "branch", *DIMENSIONS.get(name, ()))
        shape = [len(coords[dim][1]) for dim in dims]
        values = np.full(shape, "", dtype=object) if name == "family" else np.full(shape, np.nan)
        attributes = {"long_name": long_name} | ({"units": units} if units else {})
        variables[name] = (dims, values, attributes)
    return variables


def provenance(animal: Animal, effort: dict[str, int]) -> dict[str, Any]:
    """Say what a map shows and where it comes from: the attributes of its dataset."""
    return {
        "title": f"Gaits of {animal.name} over slope and heading",
        "animal": animal.name,
        "parameters": json.dumps(animal.model_dump(mode="json")),
        "source": f"legspring {legspring.__version__}",
        "references": animal.source,
        "history": f"{datetime.now(UTC):%Y-%m-%d %H:%M:%S} UTC: computed",
    } | ({"search": ", ".join(f"{count} {what}" for what, count in effort.items())} if effort else {})
