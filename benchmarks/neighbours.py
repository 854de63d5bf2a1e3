"""What a gait costs that is next to a known one: every gait of the grid from the same branch in a cell beside it."""

from collections.abc import Callable
from functools import partial
from statistics import median

import numpy as np
from legspring.layout import ACCURACY

from benchmarks.figures import Figure, together
from benchmarks.searches import Floats, Solve, difference, solver, unknowns
from legspring.gait import Gait
from legspring.kernel.newton import CONVERGED
from legspring.model import cockroach
from legspring.solve import GOAL, Problem
from legspring.sweep import HEADINGS, SLOPES_DEG, find_all

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
                begin, solve = unknowns(near[0])[None], solver(gait.system, gait.heading, ACCURACY, GOAL)
                z = begin.copy()
                endings, taken = solve(z)
                pairs += 1
                if endings[0] != CONVERGED or difference(z[0], unknowns(gait)) > SAME:
                    continue
                there += 1
                steps.append(taken)
                problem = Problem(animal, gait.slope, gait.heading, gait.family, None)
                works: dict[str, Callable[[], object]] = {
                    "solve": partial(solve_again, solve, begin),
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


def solve_again(solve: Solve, begin: Floats) -> None:
    """Solve from a start that is kept."""
    solve(begin.copy())


def whole_gait(problem: Problem, begin: Floats) -> None:
    """Do what a search does with a start: solve roughly, then to the last digits, and check that it is a gait."""
    problem.sort(problem.zeros(begin)[0])
