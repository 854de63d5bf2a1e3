"""Gaits with the best actuation over a grid of slopes and headings, as an xarray.Dataset."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from joblib import Memory, Parallel, delayed

from legspring.kernel.jit import FINGERPRINT
from legspring.model import Animal
from legspring.objective import Goal, Objective
from legspring.optimisation import (
    TIE,
    Candidate,
    End,
    Method,
    Optimum,
    explore,
    finished,
    is_as_good_as_can_be,
    nelder_mead,
    polish,
    rank,
    scan,
    settle,
    spread_out,
)
from legspring.progress import progress_bar
from legspring.sweep import (
    DIMENSIONS,
    HEADINGS,
    LONG_NAMES,
    SLOPES_DEG,
    checked_grid,
    checked_workers,
    measured,
    neighbours,
    provenance,
)
from legspring.trial import GOAL, Map

GOALS: tuple[Goal, ...] = ("stability", "efficiency")
NODES = 64
"""Actuations at which each cell is searched for gaits; neighbouring cells give more."""
POLISHED = 4
"""Gaits of each cell that are polished."""
KEPT = 4
"""Ends of searches that are remembered for each case and goal."""
ROUNDS = 8
"""Most rounds of passing optima on to neighbours."""
Place = tuple[int, int]


@dataclass(frozen=True)
class Case:
    """One family in one cell, and what is to be small there."""

    animal: Animal
    slope_deg: float
    heading: float
    family: str
    of: Map

    def objective(self, goal: Goal) -> Objective:
        """Return the objective for a goal."""
        return Objective(self.animal, math.radians(self.slope_deg), self.heading, self.family, goal, self.of)


def explored(case: Case, seed: int) -> dict[Goal, list[End]]:
    """Search a case for both goals."""
    objectives = {goal: case.objective(goal) for goal in GOALS}
    candidates = scan(objectives["stability"].trial, seed, NODES)
    return {
        goal: explore(objective, spread_out(rank(objective, candidates), POLISHED))
        for goal, objective in objectives.items()
    }


def improved(case: Case, goal: Goal, starts: Sequence[Candidate], ends: Sequence[End]) -> list[End]:
    """Search a case from what is best in its neighbours, where that is something else; return the ends, the best first."""
    objective = case.objective(goal)
    if ends and is_as_good_as_can_be(objective, ends[0]):
        return list(ends)
    solved = objective.trial.solve(np.array([u for u, _ in starts]), np.array([z for _, z in starts]))
    near = [(u, z) for (u, _), z, r in zip(starts, solved.z, solved.residuals, strict=True) if r <= GOAL]
    known = [end.candidate for end in ends]
    # Where the neighbour's actuation leads to no gait, its gait may still be near one with another actuation.
    news = spread_out([*known, *(rank(objective, near) or ([] if known else starts))], len(known) + len(starts))
    news = [start for start in news if not any(start is old for old in known)]
    return sorted([*ends, *explore(objective, news)], key=lambda end: end.score.total)[:KEPT]


def settled(case: Case, goal: Goal, ends: Sequence[End], starts: Sequence[Candidate]) -> Optimum | None:
    """Take the least actuation among those as good as the best; starts are what neighbours have taken."""
    objective = case.objective(goal)
    return settle(objective, ends, starts)


def best_total(ends: Sequence[End]) -> float:
    """Return the least objective reached."""
    return min((end.score.total for end in ends), default=math.inf)


def pass_on(
    cases: dict[tuple[Place, str], Case], ends: dict[tuple[Place, str, Goal], list[End]], run: Callable[..., Any]
) -> None:
    """Start searches from the best of neighbouring cells, until nothing gets better."""
    fresh = {key for key, found in ends.items() if found}
    for _ in range(ROUNDS):
        tasks = []
        for (place, family), case in cases.items():
            for goal in GOALS:
                key = (place, family, goal)
                around = [(n, family, goal) for n in neighbours(place)]
                starts = [ends[near][0].candidate for near in around if near in fresh]
                if starts:
                    tasks.append((key, (case, goal, starts, ends[key])))
        fresh = set()
        for (key, _), found in zip(tasks, run(improved, [task for _, task in tasks]), strict=True):
            if found and best_total(found) < best_total(ends[key]) - 0.3 * TIE:
                fresh.add(key)
            ends[key] = found
        if not fresh:
            break
