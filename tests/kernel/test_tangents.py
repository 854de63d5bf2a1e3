"""Derivatives in all directions against differences of the oracle in extended precision."""

from collections.abc import Callable

import numpy as np
import pytest
from legspring.layout import ACCURACY, TIGHT

from tests.kernel.bridge import point_mass, rigid_body, scale, simulate, size
from tests.oracle import heyoka_walker
from tests.oracle.problem import Array, Direction, Problem

START: list[Direction] = ["speed", "heading", "Dx", "Dy", "slope"]
YAWING: list[Direction] = ["yaw", "yaw_rate", "turn", "inertia"]
OF_A_LEG = ("phase", "ldev", "length", "stiffness", "angle", "hip_x", "hip_y")


def directions(problem: Problem, seed: int) -> list[Direction]:
    """The start, the body, and every parameter of some leg: over six seeds, of all legs."""
    legs: list[Direction] = [(name, (seed + row) % 6) for row, name in enumerate(OF_A_LEG)]
    return [*START, *legs, ("phase", [0, 3]), *([] if problem.inertia is None else YAWING)]


def differences(problem: Problem, direction: Direction, strides: float, units: Array) -> Array:
    """Derivative of the state along a direction, by natural sizes, from the oracle."""
    step = 3e-4 * size(problem, direction) / problem.scale(direction)
    jacobian, error = heyoka_walker.central_jacobian(problem, [direction], strides, step)
    column, error = (values[:, 0] * size(problem, direction) / units for values in (jacobian, error))
    assert np.max(error) < 1e-11
    return column


@pytest.mark.parametrize("make", [point_mass, rigid_body])
@pytest.mark.parametrize("seed", range(10))
def test_derivatives(make: Callable[[int], Problem], seed: int) -> None:
    problem = make(seed)
    along = directions(problem, seed)
    sizes = np.array([size(problem, direction) for direction in along])
    units = scale(problem, heyoka_walker.simulate(problem))
    walks = [(simulate(problem, 2.0, along, accuracy), 100 * accuracy) for accuracy in (TIGHT, ACCURACY)]
    for time in (1.0, 2.0):
        expected = np.stack([differences(problem, direction, time / 2, units) for direction in along], axis=1)
        for walk, tolerance in walks:
            exact = walk.jet(time)[:, 1:] * sizes / units[:, None]
            np.testing.assert_allclose(exact, expected, rtol=0, atol=tolerance * max(1.0, np.max(np.abs(expected))))


def test_derivatives_do_not_change_the_motion() -> None:
    problem = rigid_body(0)
    plain, walk = simulate(problem), simulate(problem, directions=directions(problem, 0))
    np.testing.assert_array_equal(plain.times, walk.times)
    np.testing.assert_array_equal(plain.tape.y[..., 0], walk.tape.y[..., 0])
