"""Curves of the cockroach's gaits as one would reasonably follow them with SciPy: differences for all derivatives."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.subjects import Subject
from legspring.gait import Gait
from tests.oracle.problem import Problem
from tests.oracle.scipy_walker import simulate

Floats = NDArray[np.float64]
Conditions = Callable[[Floats], Floats]

TOLERANCE = 1e-11
SOLVED, MOST_CORRECTIONS = 1e-9, 8
DIFFERENCE, COARSE = 1e-6, 1e-4
"""Differences that derivatives are made of; and those of differences."""


def start_of(gait: Gait) -> Floats:
    """Return speed by the desired one, phases, slope and heading of a gait."""
    phases = [gait.point[gait.system.place(leg, "phase")] for leg in gait.animal.first_legs]
    return np.array([gait.speed / gait.system.desired_speed, *phases, gait.slope, gait.heading])


def conditions_of(gait: Gait) -> Conditions:
    """Return the four conditions of a gait as a function of speed, phases, slope and heading."""
    problem, animal = Subject("", gait.system, gait.point).problem(), gait.animal
    pair = np.array(gait.system.pair)

    def conditions(x: Floats) -> Floats:
        slope, heading = float(x[-2]), float(x[-1])
        v_des, t_des = animal.desired_speed(slope), animal.step_duration(slope)
        there = replace(problem, slope=slope, heading=heading, v_des=v_des, t_des=t_des)
        return missed(replace(there, speed=float(x[0]) * v_des, phase=x[1:-2][pair]))

    return conditions


def missed(problem: Problem) -> Floats:
    """Return by how much a step is not the mirror image of the one before."""
    x, y, vx, vy = simulate(problem, 0.5, rtol=TOLERANCE, atol=1e-2 * TOLERANCE).state[:4]
    speed, heading = math.hypot(vx, vy), math.atan2(-vx, vy)
    length = problem.v_des * problem.t_des
    return np.array([(speed - problem.speed) / problem.v_des, heading + problem.heading, x / length, y / length - 1.0])


def jacobian(function: Callable[[Floats], Floats], x: Floats, columns: Sequence[int], size: float) -> Floats:
    """Return derivatives along some coordinates, by forward differences."""
    here, found = function(x), []
    for n in columns:
        beside = x.copy()
        beside[n] += size
        found.append((function(beside) - here) / size)
    return np.array(found).T


def fold_of(conditions: Conditions) -> Conditions:
    """Return the conditions with one more: they are singular, but for slope and heading."""

    def with_fold(x: Floats) -> Floats:
        by = jacobian(conditions, x, range(len(x) - 2), DIFFERENCE)
        return np.append(conditions(x), np.linalg.det(by))

    return with_fold


def followed(function: Conditions, x: Floats, columns: Sequence[int], count: int, step: float, size: float) -> Floats:
    """Follow a curve for so many points by pseudo-arclength; ``(count, n)``.

    Parameters
    ----------
    function, x
        What is zero along it, and its first point.
    columns
        Coordinates that vary, one more than conditions.
    count, step
        How many points, and how far apart.
    size
        Of the differences.
    """
    found, tangent = [], np.zeros(len(columns))
    tangent[-1] = -1.0
    for _ in range(count):
        by = jacobian(function, x, columns, size)
        tangent = np.linalg.solve(np.vstack([by, tangent]), np.append(np.zeros(len(by)), 1.0))
        tangent /= np.linalg.norm(tangent)
        guess = x.copy()
        guess[list(columns)] += step * tangent
        x = corrected(function, guess, columns, tangent, size)
        found.append(x)
    return np.array(found)


def corrected(function: Conditions, guess: Floats, columns: Sequence[int], tangent: Floats, size: float) -> Floats:
    """Return the point of a curve in the plane through a guess.

    Raises
    ------
    ArithmeticError
        If there is none.
    """
    x, some = guess.copy(), list(columns)
    for _ in range(MOST_CORRECTIONS):
        left = np.append(function(x), (x - guess)[some] @ tangent)
        if np.max(np.abs(left)) < (SOLVED if size < COARSE else 1e-2 * size):
            return x
        by = jacobian(function, x, columns, size)
        x[some] -= np.linalg.solve(np.vstack([by, tangent]), left)
    raise ArithmeticError("SciPy's curve was lost")
