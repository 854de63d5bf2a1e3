"""The search for the best actuation over a grid of slopes and headings, in which neighbours help one another."""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
import xarray as xr
from threadpoolctl import threadpool_limits

from legspring.actuated import GOAL, Map, pair_lengths
from legspring.constraints import Constraint, Constraints
from legspring.mapping import neighbours
from legspring.measures.registry import OF_OPTIMA, OF_RECOVERIES, Measure, mapped, measured
from legspring.memory import Memory
from legspring.model import Animal
from legspring.objective import Candidate, Goal, Objective, Penalty, Score
from legspring.optimisation import (
    FIRST_ITERATIONS,
    GAIN,
    End,
    approached,
    are_alike,
    as_good,
    explore,
    finished,
    is_as_good_as_can_be,
    lessen,
    polish,
    rank,
    scan,
    spread_out,
    ties,
    ties_of,
)
from legspring.optimum import TIE, Optimum
from legspring.parallel import Processes
from legspring.progress import progress_bar

GOALS: tuple[Goal, ...] = ("stability", "efficiency")
NODES = 64
"""Actuations at which each cell is searched for gaits; neighbouring cells give more."""
POLISHED = 4
"""Gaits of each cell that are polished."""
KEPT = 4
"""Ends of searches that are remembered for each case and goal."""
ROUNDS = 8
"""Most rounds of passing optima on to neighbours."""
LESS = 0.01
"""Difference of the sum of squared actuations that counts as a gain."""
DOUBT = 0.005
"""Excess of an objective over its neighbours' mean from which on a cell is searched more closely."""
CHUNK = 20
"""Tasks that a process takes at a time."""
KINDS = (End, Score, Candidate, Penalty, Constraint)
"""Kinds of objects, beside numbers, text and arrays, in what a search keeps of itself."""
Spot = tuple[int, int, str]
"""Row (slope) and column (heading) of a cell, and a family."""
T = TypeVar("T")


@dataclass(frozen=True)
class Case:
    """One family in one cell, what is to be small there, and the impulses from which its optima are to recover."""

    animal: Animal
    slope_deg: float
    heading: float
    family: str
    of: Map
    constraints: Constraints
    impulses: tuple[float, ...] = ()

    def objective(self, goal: Goal) -> Objective:
        """Return the objective for a goal."""
        slope, constraints = math.radians(self.slope_deg), self.constraints
        return Objective(self.animal, slope, self.heading, self.family, goal, self.of, constraints=constraints)

    def measured(self, optimum: Optimum) -> dict[str, Any]:
        """Return what a dataset says about an optimum."""
        values = measured((*mapped(optimum.animal), *OF_OPTIMA), optimum)
        return values | (measured(OF_RECOVERIES, optimum.recovery_steps(self.impulses)) if self.impulses else {})


Cases = dict[Spot, Case]
Key = tuple[Spot, Goal]


def approached_from(
    case: Case, goal: Goal, origins: Sequence[tuple[Case, Candidate]], ends: Sequence[End]
) -> list[End]:
    """Search a case from optima of its neighbours (see `legspring.optimisation.approached`); return all ends."""
    found = list(ends)
    for origin, candidate in origins:
        found += approached(case.objective(goal), origin.objective(goal), candidate)
    return sorted(found, key=lambda end: end.score.total)[:KEPT]


def explored(case: Case, seed: int) -> dict[Goal, list[End]]:
    """Search a case for both goals; among the ends are candidates as good as can be, if there are any."""
    objectives = {goal: case.objective(goal) for goal in GOALS}
    candidates = scan(objectives["stability"], seed, NODES)
    found: dict[Goal, list[End]] = {}
    for goal, objective in objectives.items():
        ends = explore(objective, spread_out(rank(objective, candidates), POLISHED))
        if ends and is_as_good_as_can_be(objective, ends[0]):
            scores = [objective(*candidate) for candidate in ties(objective, candidates, ends[0])]
            ends += [End(score, ends[0].reason) for score in scores if score.total < as_good(objective, ends[0])]
        found[goal] = ends
    return found


def improved(case: Case, goal: Goal, starts: Sequence[Candidate], ends: Sequence[End]) -> list[End]:
    """Search a case from what is best in its neighbours, if that is something else; return the ends, the best first."""
    objective = case.objective(goal)
    if ends and is_as_good_as_can_be(objective, ends[0]):
        return list(ends)
    actuations, unknowns = (np.array(rows) for rows in list(zip(*starts, strict=True))[:2])
    solved = objective.actuated.solve(actuations, unknowns)
    near = [s._replace(unknowns=z) for s, z, r in zip(starts, solved.z, solved.residuals, strict=True) if r <= GOAL]
    # Where the neighbour's actuation leads to no gait, its gait may still be near one with another actuation.
    news: list[Candidate] = []
    for start in rank(objective, near) or ([] if ends else starts):
        better = objective.totals(start.point[None])[0] < best_total(ends)
        if better or not any(are_alike(start, other) for other in [*(end.candidate for end in ends), *news]):
            news.append(start)
    return sorted([*ends, *explore(objective, news)], key=lambda end: end.score.total)[:KEPT]


def lessened(case: Case, goal: Goal, starts: Sequence[Candidate], ends: Sequence[End]) -> list[End]:
    """Look for a smaller actuation than the first end's, from starts that are unlike it, as good as the best end."""
    best = min(ends, key=lambda end: end.score.total)
    # One that is itself no smaller seldom leads to one that is.
    less = [start for start in starts if float(np.sum(start.actuation**2)) < ends[0].effort]
    news = [start for start in less if not are_alike(start, ends[0].candidate)]
    return [lessen(case.objective(goal), ends[0], best, news), *ends[1:]]


def settled(case: Case, goal: Goal, ends: Sequence[End]) -> list[End]:
    """Look for a smaller actuation from all of a case's own ends; put it before them."""
    objective = case.objective(goal)
    return [lessen(objective, ends[0], ends[0], ties_of(objective, ends)), *ends]


def polished_again(case: Case, goal: Goal, ends: Sequence[End]) -> list[End]:
    """Polish the gait of least actuation, from which there may be a way on; if there is, look for the least again."""
    objective = case.objective(goal)
    best = min(ends, key=lambda end: end.score.total)
    if is_as_good_as_can_be(objective, best):
        return list(ends)
    news = polish(objective, ends[0].candidate, iterations=FIRST_ITERATIONS)
    if news is None or news.score.total > best.score.total - GAIN:
        return list(ends)
    found = explore(objective, [news.candidate])
    return settled(case, goal, sorted([*ends, *found], key=lambda end: end.score.total))


def doubtful(cases: Cases, ends: dict[Key, list[End]]) -> list[Key]:
    """Return the cases whose objective stands out from that of their neighbours, or has none to compare with."""
    found = []
    for (row, column, family), goal in [key for key, here in ends.items() if here]:
        around = [
            [best_total(ends.get(((row + n * i, column + n * j, family), goal), [])) for n in (-1, 1)]
            for i, j in ((1, 0), (0, 1))
        ]
        here = best_total(ends[(row, column, family), goal])
        excess = here - min(sum(pair) / 2.0 for pair in around)
        objective = cases[row, column, family].objective(goal)
        sure = is_as_good_as_can_be(objective, ends[(row, column, family), goal][0])
        if not sure and not -math.inf < excess < DOUBT:
            found.append(((row, column, family), goal))
    return found


def origins_of(cases: Cases, ends: dict[Key, list[End]], spot: Spot, goal: Goal) -> list[tuple[Case, Candidate]]:
    """Return the neighbours of a case that have an optimum, with it."""
    row, column, family = spot
    around: list[Spot] = [(near[0], near[1], family) for near in neighbours((row, column))]
    return [(cases[near], ends[near, goal][0].candidate) for near in around if ends.get((near, goal))]


def measured_end(case: Case, goal: Goal, end: End) -> dict[str, Any] | None:
    """Return what a dataset says about the end of a search; None if that is no gait after all."""
    optimum = finished(case.objective(goal), end, "default")
    return None if optimum is None else case.measured(optimum)


def measures_of(animal: Animal, impulses: Sequence[float]) -> tuple[Measure, ...]:
    """Return all that a map says of an optimum."""
    return (*mapped(animal), *OF_OPTIMA, *(OF_RECOVERIES if impulses else ()))


def best_total(ends: Sequence[End]) -> float:
    """Return the least objective reached."""
    return min((end.score.total for end in ends), default=math.inf)


def pass_on(
    cases: Cases,
    ends: dict[Key, list[End]],
    search: Callable[[Case, Goal, Sequence[Candidate], Sequence[End]], list[End]],
    count: int,
    gain: Callable[[Sequence[End], Sequence[End]], bool],
    pool: "Pool",
    *,
    fresh: set[Key] | None = None,
) -> None:
    """Start searches from the first ends of neighbouring cells (all, or fresh ones), until there is no gain."""
    fresh = {key for key, found in ends.items() if found} if fresh is None else fresh
    for _ in range(ROUNDS):
        tasks, keys = [], []
        for (row, column, family), case in cases.items():
            for goal in GOALS:
                key = ((row, column, family), goal)
                around = [((*near, family), goal) for near in neighbours((row, column))]
                starts = [end.candidate for near in around if near in fresh for end in ends[near][:count]]
                if starts and key in ends:
                    keys.append(key)
                    tasks.append((case, goal, starts, ends[key]))
        found = dict(zip(keys, pool.run(search, tasks), strict=True))
        fresh = {key for key in keys if found[key] and gain(ends[key], found[key])}
        ends |= found
        if not fresh:
            return


def is_better(before: Sequence[End], after: Sequence[End]) -> bool:
    """Whether the objective has become smaller."""
    return best_total(after) < best_total(before) - 0.3 * TIE


def is_less(before: Sequence[End], after: Sequence[End]) -> bool:
    """Whether the actuation has become smaller."""
    return after[0].effort < before[0].effort - LESS


def look_closer(cases: Cases, ends: dict[Key, list[End]], pool: "Pool") -> None:
    """Search the cases that stand out by way of what lies between them and their neighbours; pass on what is found."""
    doubts = doubtful(cases, ends)
    tasks = [(cases[spot], goal, origins_of(cases, ends, spot, goal), ends[spot, goal]) for spot, goal in doubts]
    found = dict(zip(doubts, pool.run(approached_from, tasks, "searching more closely"), strict=True))
    fresh = {key for key in doubts if is_better(ends[key], found[key])}
    ends |= found
    pass_on(cases, ends, improved, 2, is_better, pool, fresh=fresh)


def search(cases: Cases, known: dict[Key, Candidate], seed: int, pool: "Pool") -> dict[Key, dict[str, Any]]:
    """Find the best of each case, starting from what is known as well."""
    found = pool.run(explored, [(case, seed) for case in cases.values()], "searching for the best actuations")
    ends = {(spot, goal): here[goal] for spot, here in zip(cases, found, strict=True) for goal in GOALS}
    tasks = [(cases[spot], goal, [start], ends[spot, goal]) for (spot, goal), start in known.items()]
    ends |= dict(zip(known, pool.run(improved, tasks), strict=True))
    pass_on(cases, ends, improved, 2, is_better, pool)
    look_closer(cases, ends, pool)
    keys = [key for key, here in ends.items() if here]
    least = pool.run(settled, [(cases[spot], goal, ends[spot, goal]) for spot, goal in keys], "least actuations")
    ends = dict(zip(keys, least, strict=True))
    pass_on(cases, ends, lessened, 1, is_less, pool)
    again = pool.run(polished_again, [(cases[spot], goal, ends[spot, goal]) for spot, goal in keys])
    ends = dict(zip(keys, again, strict=True))
    values = pool.run(
        measured_end, [(cases[spot], goal, ends[spot, goal][0]) for spot, goal in keys], "measuring gaits"
    )
    return {key: value for key, value in zip(keys, values, strict=True) if value is not None}


def known_optima(cases: Cases, optima: xr.Dataset) -> dict[Key, Candidate]:
    """Return the actuation and unknowns of each case that a map has."""
    found: dict[Key, Candidate] = {}
    for spot, case in cases.items():
        here = optima.sel(slope_deg=case.slope_deg, heading=case.heading, family=case.family)
        for goal in GOALS:
            one = here.sel(objective=goal)
            if np.isfinite(one["speed"]):
                found[spot, goal] = candidate_of(one, case.animal)
    return found


def candidate_of(gait: xr.Dataset, animal: Animal) -> Candidate:
    """Return the actuation, in units of nominal lengths, and the unknowns of a gait that a map has."""
    desired = animal.desired_speed(math.radians(float(gait["slope_deg"])))
    z = np.concatenate([[float(gait["speed"]) / desired], gait["phase"].values])
    return Candidate(gait["actuation"].values / pair_lengths(animal), z)


def in_chunk(function: Callable[..., Any], tasks: Sequence[tuple[Any, ...]]) -> list[Any]:
    """Work on some tasks."""
    # Matrices are tiny: threads would only get in each other's way, and round differently.
    with threadpool_limits(1):
        return [function(*task) for task in tasks]


class Pool:
    """Processes that share work, and remember on disk what they have done.

    Parameters
    ----------
    processes
        Who works.
    memory
        What is done already, so that a search which was stopped goes on where it was; None to keep nothing.
    progress
        Whether to show progress.
    """

    def __init__(self, processes: Processes, memory: Memory | None, progress: bool) -> None:
        self.processes, self.memory, self.progress = processes, memory, progress

    def run(
        self, function: Callable[..., T], tasks: Sequence[tuple[Any, ...]], words: str = "", chunk: int = CHUNK
    ) -> list[T]:
        """Call a function with each of some tuples of arguments."""
        size = max(1, min(chunk, len(tasks) // (4 * self.processes.count)))
        chunks = [(function, tasks[n : n + size]) for n in range(0, len(tasks), size)]
        out: list[T] = []
        with progress_bar(words, len(tasks), show=self.progress and bool(words)) as tick:
            for results in self.processes.map(self._work, chunks):
                out += results
                tick(len(results))
        return out

    def _work(self, function: Callable[..., T], tasks: Sequence[tuple[Any, ...]]) -> list[T]:
        """Return what is remembered of some tasks, or is found out now."""
        if self.memory is None:
            return self.processes.call(in_chunk, function, tasks)
        key = self.memory.key(function.__qualname__, list(tasks))
        found: list[T] | None = self.memory.get(key)
        if found is None:
            start = time.perf_counter()
            found = self.processes.call(in_chunk, function, tasks)
            self.memory.put(key, found, (time.perf_counter() - start) / self.processes.count)
        return found
