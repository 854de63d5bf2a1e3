"""What a gait costs that is next to a known one: every gait of the grid from the same branch in a cell beside it."""

from collections.abc import Callable
from functools import partial
from statistics import median

import numpy as np

from benchmarks.figures import Figure, together
from legspring.asking import tuned
from legspring.gait import Gait
from legspring.kernel.newton import CONVERGED
from legspring.kernel.walker import Floats
from legspring.layout import ACCURACY
from legspring.mapping import HEADINGS, SLOPES_DEG, find_all
from legspring.model import cockroach
from legspring.problem import GaitProblem
from legspring.solve import GOAL, solve, sort, zeros

SAME = 1e-6


def measure(quick: bool) -> list[Figure]:
    """Time the search, bare, and with all that makes a checked gait of it."""
    animal = cockroach()
    found, _ = find_all(animal, SLOPES_DEG, HEADINGS)
    times: dict[str, list[float]] = {"solve": [], "gait": []}
    steps, there, pairs = [], 0, 0
    for (row, column), gaits in found.items():
        for beside in ((row - 1, column), (row, column - 1)):
            for gait in gaits[:: 3 if quick else 1]:
                near = [other for other in found.get(beside, ()) if (other.family, other.branch) == identity(gait)]
                if not near:
                    continue
                problem = tuned(animal, gait.slope, gait.heading, gait.family)
                begin = problem.z_of(near[0])[None]
                solved = solve(problem, begin, ACCURACY, GOAL)
                pairs += 1
                if solved.endings[0] != CONVERGED or difference(problem, solved.z[0], problem.z_of(gait)) > SAME:
                    continue
                there += 1
                steps.append(solved.steps)
                works: dict[str, Callable[[], object]] = {
                    "solve": partial(solve, problem, begin, ACCURACY, GOAL),
                    "gait": partial(whole_gait, problem, begin),
                }
                for name, time in together(works, 3).items():
                    times[name].append(1e6 * time)
    detail = {
        "pairs_of_cells": pairs,
        "led_to_the_known_gait": there,
        "steps_simulated": median(steps),
        "90_percent_us": float(np.quantile(times["solve"], 0.9)),
    }
    return [
        Figure("gait from a neighbour", median(times["solve"]), "us", 400.0, 100.0, detail=detail),
        Figure("gait from a neighbour, refined and checked", median(times["gait"]), "us"),
    ]


def identity(gait: Gait) -> tuple[str, int]:
    """Return what a gait has in common with its continuation in the next cell."""
    return gait.family, gait.branch


def difference(problem: GaitProblem, a: Floats, b: Floats) -> float:
    """Largest difference of two solutions, angles modulo 2 pi."""
    return float(np.max(np.abs(problem.wrapped(a - b))))


def whole_gait(problem: GaitProblem, begin: Floats) -> None:
    """Do what a search does with a start: solve roughly, then to the last digits, and check that it is a gait."""
    sort(problem, zeros(problem, begin)[0])
