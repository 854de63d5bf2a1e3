"""The thesis's search for the best actuation: Nelder and Mead's method on the penalised objective, along chains."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.optimize import minimize

from legspring.exchange import GOALS, NODES, Case, Cases, Key, Pool, Spot
from legspring.kernel.walker import Floats
from legspring.objective import Candidate, Goal, Objective
from legspring.optimisation import End, finished, rank, scan
from legspring.optimum import Optimum

MATLAB = {"xatol": 1e-4, "fatol": 1e-4, "maxiter": 600, "maxfev": 600}
"""What MATLAB's fminsearch stops at by default, for three variables; actuations in m."""


def search(objective: Objective, seed: int) -> Optimum | None:
    """Search one family in one cell as the thesis does, from the best candidate.

    For efficiency it goes by way of the most stable gait.
    """
    stability = objective.like("stability", "reduced")
    starts = rank(stability, scan(objective, seed))
    if not starts:
        return None
    end = nelder_mead(stability, starts[0])
    if end.score.total >= objective.constraints.no_gait:
        return None
    if objective.goal == "efficiency" or objective.of != "reduced":
        end = nelder_mead(objective, end.candidate)
    objective.evaluations += stability.evaluations
    return finished(objective, end, "nelder-mead")


def nelder_mead(objective: Objective, start: Candidate) -> End:
    """Minimise the penalised objective by Nelder and Mead's method, with the defaults of MATLAB's fminsearch.

    Every evaluation searches for its gait from that of the best one so far.
    """
    lengths, (actuation, near, _) = objective.actuated.lengths, start
    best = objective(actuation, near)

    def total(magnitudes: Floats) -> float:
        nonlocal best
        score = objective(magnitudes / lengths, near if best.unknowns is None else best.unknowns)
        if score.unknowns is not None and (best.unknowns is None or score.total < best.total):
            best = score
        return score.total

    found = minimize(total, actuation * lengths, method="Nelder-Mead", options=MATLAB)
    return End(best, "converged" if found.success else "limit of evaluations reached")


def chained(cases: Sequence[Case], seed: int) -> list[dict[Goal, dict[str, Any]]]:
    """Find optima along rising slopes as the thesis does: each from its neighbour's, the first from a start.

    The chain ends where a search finds no gait. Where the thesis's starts were is not known.

    Parameters
    ----------
    cases
        Of one heading and family.
    seed
        With 0, the start is the best of many gaits in the middle of the slopes; else any gait that is worth having, at
        any slope.
    """
    out: list[dict[Goal, dict[str, Any]]] = [{} for _ in cases]
    middle, rng = len(cases) // 2, np.random.default_rng(seed)
    order = rng.permutation(len(cases)) if seed else sorted(range(len(cases)), key=lambda n: abs(n - middle))
    for first in map(int, order):
        objective = cases[first].objective("stability")
        starts = rank(objective, scan(objective, seed, NODES), objective.constraints.no_gait)
        if starts:
            start = [starts[int(rng.integers(len(starts)))] if seed else starts[0]]
            break
    else:
        return out
    for way in (range(first, len(cases)), range(first - 1, -1, -1)):
        candidate = start[0]
        for n in way:
            stability = cases[n].objective("stability")
            end = nelder_mead(stability, candidate)
            if end.score.total >= stability.constraints.no_gait:
                break
            candidate = end.candidate
            start = start if n != first else [candidate]
            for goal in GOALS:
                objective = cases[n].objective(goal)
                last = end if goal == "stability" else nelder_mead(objective, candidate)
                optimum = finished(objective, last, "nelder-mead")
                if optimum is not None:
                    out[n][goal] = cases[n].measured(optimum)
    return out


def search_map(cases: Cases, known: object, seed: int, pool: Pool) -> dict[Key, dict[str, Any]]:
    """Find the best of each case by the thesis's method, which starts from nothing that is known."""
    chains: dict[tuple[int, str], list[Spot]] = {}
    for row, column, family in cases:
        chains.setdefault((column, family), []).append((row, column, family))
    tasks = [([cases[spot] for spot in chain], seed) for chain in chains.values()]
    found = pool.run(chained, tasks, "searching as the thesis does", chunk=1)
    return {
        (spot, goal): values
        for chain, here in zip(chains.values(), found, strict=True)
        for spot, goals in zip(chain, here, strict=True)
        for goal, values in goals.items()
    }
