"""Gaits as the solutions that they are, and the kernel's search for them."""

from collections.abc import Callable

import numpy as np
from legspring.layout import System
from numpy.typing import NDArray

from legspring.gait import Gait
from legspring.kernel.newton import find_zeros, new_problem
from legspring.solve import MOST_ITERATIONS

Floats = NDArray[np.float64]
Solve = Callable[[Floats], tuple[NDArray[np.int64], int]]


def unknowns(gait: Gait) -> Floats:
    """Return a point mass's gait as a solution: speed in units of v_des, phases."""
    return np.array([gait.speed / gait.system.desired_speed, *gait.phase])


def difference(a: Floats, b: Floats) -> float:
    """Largest difference of two solutions, the phases' modulo 2 pi."""
    gap = a - b
    gap[1:] = (gap[1:] + np.pi) % (2.0 * np.pi) - np.pi
    return float(np.max(np.abs(gap)))


def solver(system: System, heading: float, accuracy: float, goal: float) -> Solve:
    """Return what solves the conditions of a gait from each row of an array, in place.

    It returns how each search ended, and the number of steps simulated.
    """
    stride, scale = system.step_length, system.error_scale(accuracy)
    w, start = new_problem(
        system.body,
        system.legs(np.zeros(len(system.actuation))),
        system.side,
        system.offset,
        system.pair,
        heading,
        stride,
        system.rows,
    )

    def solve(z: Floats) -> tuple[NDArray[np.int64], int]:
        magnitudes = np.tile(system.actuation, (len(z), 1))
        endings, *_, steps = find_zeros(w, start, system.pair, stride, magnitudes, z, scale, goal, MOST_ITERATIONS)
        return endings, steps

    return solve
