"""Gaits on a grid, by searching in every cell and in those around, or by following; what maps consist of."""

import json
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import partial
from importlib.metadata import version
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from legspring.asking import check_tuned, checked_targets, problems_for
from legspring.checks import (
    checked_workers,
)
from legspring.gait import Gait
from legspring.kernel.walker import Floats
from legspring.layout import slope_for, unit_and_words
from legspring.measures.registry import BY_NAME, Measure
from legspring.model import Animal
from legspring.netting import Group, Net, Place
from legspring.parallel import in_threads
from legspring.problem import TARGETS, GaitProblem
from legspring.progress import progress_bar
from legspring.solve import Rejection, is_among, number_branches, sort, without_doubles, zeros
from legspring.starts import spread, starts_for

SLOPES_DEG = tuple(float(slope) for slope in range(0, 91, 5))
HEADINGS = tuple(round(0.05 * n, 2) for n in range(10))
IMPULSE = {"units": "m v_des", "long_name": "sideways impulse"}
IMPULSES = tuple(round(0.1 * n, 1) for n in range(-8, 9))
STARTS, YAWING_STARTS, MORE_STARTS = 8, 16, 24
"""Starts for each family in each cell; where the body yaws; and where nothing is known of where gaits lie.

Neighbours give more; with these, blocks of a few cells find what the whole grid does.
"""
SEARCH, FOLLOW = "search", "follow"
METHODS = (SEARCH, FOLLOW)
SEEDS, SEED_STARTS = 5, 96
"""Cells that are searched for gaits to be followed, and starts there."""

SHEET = {"long_name": "sheet of gaits that hang together without a fold; -1: not known"}


@dataclass(frozen=True)
class Grid:
    """What gaits are looked for at each place of a grid.

    Attributes
    ----------
    animal
        The animal.
    over
        What varies, with its values, rising: ``slope_deg``, what gaits are asked for, or parameters of the animal.
    asked
        What is the same everywhere: slope_deg, targets, ``free`` and ``mirrored``, as in `search_gaits`.
    """

    animal: Animal
    over: Mapping[str, tuple[float, ...]]
    asked: Mapping[str, Any] = field(default_factory=dict)

    @property
    def places(self) -> list[Place]:
        """All places, row by row."""
        return list(product(*(range(len(values)) for values in self.over.values())))

    def at(self, place: Place) -> tuple[Animal, dict[str, Any]]:
        """Return the animal at a place, and what is asked for there."""
        values = {name: self.over[name][n] for name, n in zip(self.over, place, strict=True)}
        asked = {name: value for name, value in values.items() if name in ("slope_deg", *TARGETS)}
        changed = {name: value for name, value in values.items() if name not in asked}
        animal = self.animal.replace(**changed) if changed else self.animal
        return animal, {**self.asked, **asked}

    def can_be_asked(self, place: Place) -> bool:
        """Whether there is such an animal at a place, of which gaits of the kind can be asked."""
        try:
            for family in self.animal.families:
                self.problems(place, family)
        except ValueError:
            return False
        return True

    def problems(self, place: Place, family: str) -> list[GaitProblem]:
        """Return the problems whose solutions are the gaits of one family at a place."""
        animal, asked = self.at(place)
        slope = slope_for(animal, None, asked.pop("slope_deg", None))
        free, mirrored = asked.pop("free", ()), asked.pop("mirrored", None)
        return problems_for(animal, slope, family, checked_targets(asked), free, None, mirrored)


@dataclass
class Cell:
    """One problem at one point of the grid, while the search goes on."""

    place: Place
    problem: GaitProblem
    zeros: Floats
    fresh: Floats

    @classmethod
    def known(cls, place: Place, problem: GaitProblem, zeros: Floats) -> "Cell":
        """Return a cell of which some solutions are known, or none."""
        return cls(place, problem, zeros, zeros[:0])

    def search(self, starts: Floats) -> int:
        """Search from more starts; return the number of steps simulated."""
        known = len(self.zeros)
        self.zeros, _, steps = zeros(self.problem, starts, self.zeros)
        self.fresh = self.zeros[known:]
        return steps


def neighbours(place: Place) -> list[Place]:
    """Return the places around one, some of which may be off the grid."""
    ways = [(axis, step) for axis in range(len(place)) for step in (-1, 1)]
    return [(*place[:axis], place[axis] + step, *place[axis + 1 :]) for axis, step in ways]


def _spread(cells: dict[Place, Cell], workers: int) -> int:
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


class Found(NamedTuple):
    """What was found on a grid.

    Attributes
    ----------
    gaits
        By place, numbered; of places at which nothing of the kind can be asked, nothing is said.
    effort
        Counts of starts, steps simulated and so on.
    sheets
        Of each gait, by place and branch, if known.
    rejections
        Solutions that are no gaits, by place.
    alone
        How many gaits there are at a place that the search has found, and no curve; where gaits were followed.
    """

    gaits: dict[Place, tuple[Gait, ...]]
    effort: dict[str, int]
    sheets: dict[tuple[Place, int], int]
    rejections: dict[Place, list[Rejection]]
    alone: Mapping[Place, int]


def find_on(
    grid: Grid,
    *,
    method: str = SEARCH,
    starts: int | None = None,
    workers: int | None = None,
    progress: bool = False,
) -> Found:
    """Find the gaits on a grid: by searching in every cell and continuing what is found to the neighbours.

    Or, first, by following a few along all lines of the grid (see `legspring.netting`); then the search looks for what
    no curve reaches.
    """
    workers = checked_workers(workers)
    starts = starts_for_each(grid.animal) if starts is None else starts
    effort = {"starts": 0, "steps": 0, "solutions rejected": 0}
    places = grid.places if method == FOLLOW else [place for place in grid.places if grid.can_be_asked(place)]
    problems = {family: {place: grid.problems(place, family) for place in places} for family in grid.animal.families}
    rejections: dict[Place, list[Rejection]] = {place: [] for place in places}
    groups = {key: some for each in problems.values() for key, some in by_contacts(each).items()}
    net = Net(grid.over, groups)
    if method == FOLLOW:
        begin(net, grid)
        with progress_bar("following gaits", 1, show=progress) as tick:
            net.spread()
            tick(1)
        effort["steps"] += net.looks
    total = 2 * sum(len(some) for some in groups.values())
    gaits: dict[Group, dict[Place, list[Gait]]] = {}
    with progress_bar("searching for gaits", total, show=progress) as tick:
        for key, some in groups.items():
            cells = {place: Cell.known(place, problem, net.zeros(key, place)) for place, problem in some.items()}
            effort["starts"] += starts * len(cells)
            points = in_threads(lambda c: c.search(starts_for(c.problem, starts)), cells.values(), workers, tick)
            effort["steps"] += sum(points) + _spread(cells, workers)
            sorted_out = in_threads(lambda c: sort(c.problem, c.zeros), cells.values(), workers, tick)
            gaits[key] = {place: one for place, (one, _) in zip(cells, sorted_out, strict=True)}
            for place, (_, some_rejected) in zip(cells, sorted_out, strict=True):
                rejections[place] += some_rejected
    effort["solutions rejected"] = sum(map(len, rejections.values()))
    alone = follow_further(net, gaits) if method == FOLLOW else {}
    effort |= {"gaits by search alone": sum(alone.values())} if method == FOLLOW else {}
    found: dict[Place, list[Gait]] = {place: [] for place in places}
    for family, each in problems.items():
        for place, several in each.items():
            here = [gait for key, some in gaits.items() if key[0] == family for gait in some.get(place, [])]
            found[place] += without_doubles(here, several) if len(several) > 1 or several[0].system.contacts else here
    numbered = {place: number_branches(here) for place, here in found.items()}
    return Found(numbered, effort, sheets_of(net, numbered) if method == FOLLOW else {}, rejections, alone)


def follow_further(net: Net, gaits: dict[Group, dict[Place, list[Gait]]]) -> Mapping[Place, int]:
    """Follow what only the search has found, add what that leads to, and return how many there were at each place."""
    alone = [
        (key, place, gait)
        for key, some in gaits.items()
        for place, here in some.items()
        for gait in here
        if net.sheet_of(gait, place) is None
    ]
    before = len(net.knots)
    for key, place, gait in alone:
        net.add(key, place, net.problems[key][place].z_of(gait))
    own = len(net.knots)
    net.spread()
    for knot in net.knots[own:] if own > before else []:
        problem, here = net.problems[knot.group][knot.place], gaits[knot.group][knot.place]
        if not is_among(problem, knot.z, np.array([problem.z_of(gait) for gait in here]).reshape(-1, problem.size)):
            here += sort(problem, knot.z[None])[0]
    return Counter(place for _, place, _ in alone)


def begin(net: Net, grid: Grid) -> None:
    """Search in a few cells, for as long as there are families of which nothing is known."""
    low, high = np.zeros(len(grid.over)), np.array([len(values) - 1.0 for values in grid.over.values()])
    seeds = [tuple(int(n) for n in np.round(point)) for point in spread(SEEDS, low, high)]
    missing = {key[0] for key in net.problems}
    for place in seeds:
        for key, some in net.problems.items():
            if key[0] not in missing:
                continue
            problem = some[place]
            for gait in sort(problem, zeros(problem, starts_for(problem, SEED_STARTS))[0])[0]:
                net.add(key, place, problem.z_of(gait))
                missing.discard(key[0])


def sheets_of(net: Net, found: Mapping[Place, Sequence[Gait]]) -> dict[tuple[Place, int], int]:
    """Return the number of the sheet of each gait that was followed, counted from 0."""
    numbers: dict[int, int] = {}
    sheets: dict[tuple[Place, int], int] = {}
    for place, gaits in found.items():
        for gait in gaits:
            number = net.sheet_of(gait, place)
            if number is not None:
                sheets[place, gait.branch] = numbers.setdefault(number, len(numbers))
    return sheets


def starts_for_each(animal: Animal) -> int:
    """Return how many starts there are in each cell, unless somebody says."""
    if not animal.tuned:
        return MORE_STARTS
    return YAWING_STARTS if animal.body.yaw == "free" else STARTS


def by_contacts(each: Mapping[Place, Sequence[GaitProblem]]) -> dict[Group, dict[Place, GaitProblem]]:
    """Sort the problems of all places by the feet that may be down, and by whether steps mirror one another."""
    groups: dict[Group, dict[Place, GaitProblem]] = {}
    for place, some in each.items():
        for problem in some:
            system = problem.system
            groups.setdefault((system.family, system.contacts, system.symmetric), {})[place] = problem
    return groups


def find_all(
    animal: Animal,
    slopes_deg: Sequence[float],
    headings: Sequence[float],
    *,
    method: str = SEARCH,
    starts: int | None = None,
    workers: int | None = None,
    progress: bool = False,
) -> tuple[dict[Place, tuple[Gait, ...]], dict[str, int]]:
    """Find the gaits over slopes and headings (see `find_on`)."""
    check_tuned(animal, "for a map over slope and heading")
    grid = Grid(animal, {"slope_deg": tuple(slopes_deg), "heading": tuple(headings)})
    return find_on(grid, method=method, starts=starts, workers=workers, progress=progress)[:2]


def about(name: str) -> dict[str, str]:
    """Return unit and words of what a map is over."""
    if name in BY_NAME:
        return BY_NAME[name].attributes
    unit, words = unit_and_words(name)
    return {"units": unit, "long_name": words}


def freed(names: Sequence[str]) -> tuple[Measure, ...]:
    """Return what a map says of parameters that were let go, beside what it says of every gait."""

    def value(name: str, gait: Gait) -> float:
        return gait.freed[name]

    others = (name for name in names if name not in BY_NAME and not name.endswith(".phase"))
    return tuple(Measure(name, *unit_and_words(name), (), partial(value, name)) for name in others)


def coordinates(animal: Animal, over: Mapping[str, Sequence[float]]) -> dict[str, tuple[Any, ...]]:
    """Return the coordinates that all maps have, and those that this one is over."""
    axes = ["horizontal", "vertical"] if animal.sagittal else ["lateral", "fore_aft"]
    return {
        **{name: (name, list(values), about(name)) for name, values in over.items()},
        "leg": ("leg", list(animal.pairs), {"long_name": "pair of legs"}),
        "single_leg": ("single_leg", [leg.name for leg in animal.legs], {"long_name": "leg"}),
        "axis": ("axis", axes, {"long_name": "direction of a force"}),
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


def provenance(animal: Animal, over: Sequence[str] = ("slope_deg", "heading")) -> dict[str, Any]:
    """Say what a map shows and where it comes from: the attributes of its dataset."""
    words = " and ".join({"slope_deg": "slope"}.get(name, name) for name in over)
    return {
        "title": f"Gaits of {animal.name} over {words}",
        "animal": animal.name,
        "parameters": json.dumps(animal.model_dump(mode="json")),
        "animal_toml": animal.to_toml(),
        "source": f"legspring {version('legspring')}",
        "references": animal.source,
        "history": f"{datetime.now(UTC):%Y-%m-%d %H:%M:%S} UTC: computed",
    }
