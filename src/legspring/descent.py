"""Downhill from a gait in several criteria at once, along derivatives, within a box."""

import math

import numpy as np
from scipy.optimize import minimize

from legspring.candidates import Judge, Trial
from legspring.kernel.walker import Floats

RADIUS, SMALLEST = 0.2, 0.01
"""Half width, by the box's, of the part of it that is searched at once; and that at which a search ends."""
ROUNDS, ITERATIONS = 6, 8
PRECISION, GAIN = 1e-4, 1e-3
"""Of each search; and the gain, by the criteria's sizes, for which it is worth to go on."""
THOROUGH = 4
"""By how much longer, and for how much less gain, the ends of a front are searched for."""


class Lost(Exception):
    """There is no gait where a search would look, or one without derivatives."""


class Search:
    """A search around one gait: the criteria as functions of the place, each gait followed from the best so far.

    Parameters
    ----------
    judge, start
        What judges; where it begins.
    target, weights
        The largest of (value - target) / weight is to be small; criteria of infinite weight do not count. None: what is
        beyond bounds is to be small instead.
    """

    def __init__(self, judge: Judge, start: Trial, target: Floats, weights: Floats | None) -> None:
        self.judge, self.best = judge, start
        count, limits = len(judge.criteria), len(start.excess)
        self.held = np.array([not one.smooth for one in judge.criteria])
        self.restores = weights is None
        self.target = np.concatenate([target, np.zeros(limits)])
        own = np.full(count, np.inf) if weights is None else np.where(self.held, np.inf, weights)
        self.weights = np.concatenate([own, judge.sizes if weights is None else np.full(limits, np.inf)])
        self.counts = np.isfinite(self.weights)
        self.trial, self.slopes = start, judge.slopes(start)

    def merit(self, trial: Trial) -> float:
        """Return what is to be small."""
        return float(np.max(((trial.numbers - self.target) / self.weights)[self.counts]))

    def allows(self, trial: Trial) -> bool:
        """Whether something is kept to that must be: all bounds, if they are not what it is about; and what is held."""
        worse = trial.values[self.held] > self.best.values[self.held]
        return self.restores or (trial.keeps and not worse.any())

    def at(self, place: Floats) -> Trial:
        """Look at a place."""
        if not np.array_equal(place, self.trial.place):
            gait = self.judge.followed(self.best, place)
            if gait is None or gait.invalid() is not None:
                raise Lost
            self.trial, self.slopes = self.judge.judged(place.copy(), self.best.start, gait), None
            if not np.all(np.isfinite(self.trial.numbers)):
                raise Lost
            if self.allows(self.trial) and self.merit(self.trial) < self.merit(self.best):
                self.best = self.trial
        return self.trial

    def rates(self, place: Floats) -> Floats:
        """Return the derivatives there, ``(M + C, D)``."""
        trial = self.at(place)
        if self.slopes is None:
            self.slopes = self.judge.slopes(trial)
        if self.slopes is None:
            raise Lost
        return self.slopes

    def around(self, radius: float) -> None:
        """Search the part of the box around the best gait."""
        centre, size = self.best.place, len(self.best.place)
        low, high = np.maximum(centre - radius, 0.0), np.minimum(centre + radius, 1.0)
        weights, target, count = self.weights[self.counts], self.target[self.counts], len(self.judge.criteria)

        def clipped(x: Floats) -> Floats:
            # SLSQP may leave a bound by a rounding error.
            return np.clip(x[:size], low, high)

        def margins(x: Floats) -> Floats:
            numbers = self.at(clipped(x)).numbers
            room = x[size] - (numbers[self.counts] - target) / weights
            return room if self.restores else np.concatenate([room, -numbers[count:]])

        def margins_by(x: Floats) -> Floats:
            by = self.rates(clipped(x))
            rows = np.hstack([-by[self.counts] / weights[:, None], np.ones((len(weights), 1))])
            rest = np.hstack([-by[count:], np.zeros((len(by) - count, 1))])
            return rows if self.restores else np.vstack([rows, rest])

        direction = np.append(np.zeros(size), 1.0)
        minimize(
            lambda x: float(x[size]),
            np.append(centre, self.merit(self.best)),
            jac=lambda x: direction,
            method="SLSQP",
            bounds=[*zip(low.tolist(), high.tolist(), strict=True), (None, None)],
            constraints=[{"type": "ineq", "fun": margins, "jac": margins_by}],
            options={"maxiter": ITERATIONS, "ftol": PRECISION},
        )


def descended(judge: Judge, start: Trial, target: Floats, weights: Floats | None) -> Trial | None:
    """Return the best gait that a search downhill from one that keeps all bounds finds; None if there is no better.

    What has no derivatives is held: it must not become worse. One criterion alone is searched thoroughly. Without
    weights, the search is for one that keeps the bounds.
    """
    search, radius = Search(judge, start, target, weights), RADIUS
    effort = THOROUGH if np.sum(search.counts) == 1 else 1
    if not search.counts.any() or search.slopes is None:
        return None
    for _ in range(effort * ROUNDS):
        before = search.merit(search.best)
        try:
            search.around(radius)
        except Lost:
            radius *= 0.5
        if not search.merit(search.best) < before - GAIN / effort**2:
            radius *= 0.25
        if radius < SMALLEST / effort**2 or (search.restores and search.best.keeps):
            break
        search.trial, search.slopes = search.best, None
    return search.best if math.isfinite(search.merit(search.best)) and search.best is not start else None
