"""The integrator: order of its steps, and the interpolant between their ends."""

from collections.abc import Callable

import numpy as np
import pytest

from legspring.kernel import dop853
from tests.kernel.bridge import Walk, callable_here, point_mass, rigid_body, simulate
from tests.oracle.problem import Array, Direction, Problem

interpolate, step = callable_here(dop853.interpolate), callable_here(dop853.step)
bodies = pytest.mark.parametrize("make", [point_mass, rigid_body])


def equal_steps(problem: Problem, steps: int) -> Array:
    """State after equal steps over half the time between two touch-downs, all legs staying as they are."""
    begin, h = 0.02, 0.5 / steps
    walker = simulate(problem, begin).walker
    for index in range(steps):
        now = begin + index * h
        step(now, h, walker)
        walker.y[:], walker.k[0] = walker.ahead, walker.k[12]
    return walker.y[:, 0].copy()


@bodies
def test_steps_are_of_order_eight(make: Callable[[int], Problem]) -> None:
    problem = make(1)
    exact = equal_steps(problem, 50)
    errors = [np.max(np.abs(equal_steps(problem, steps) - exact)) for steps in (4, 8)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(8.0, abs=0.3)


def between(walk: Walk, time: float) -> Array:
    """State jet at any time, by the interpolant."""
    index = int(np.searchsorted(walk.times, time, side="right")) - 1
    y = np.zeros_like(walk.tape.y[0])
    fraction = (time - walk.times[index]) / walk.tape.size[index]
    interpolate(walk.tape.y[index], walk.tape.dense[index], fraction, y)
    return y


@bodies
@pytest.mark.parametrize("seed", range(4))
def test_interpolant_is_the_motion_and_its_derivatives(make: Callable[[int], Problem], seed: int) -> None:
    problem = make(seed)
    along: list[Direction] = ["heading", "Dy", ("phase", 0), ("ldev", 3)]
    sizes = np.array([1.0, *(problem.scale(direction) for direction in along)])
    walk = simulate(problem, directions=along)
    natural = np.array([*[max(problem.length)] * 2, *[problem.speed * problem.t_des] * 2, 1.0, 1.0])
    for time in np.random.default_rng(seed).uniform(0.0, 2.0, 20):
        expected = simulate(problem, time, along).walker.y
        difference = (between(walk, time) - expected) * sizes / natural[: len(expected), None]
        np.testing.assert_allclose(difference[:, 0], 0.0, rtol=0, atol=1e-10)
        np.testing.assert_allclose(difference[:, 1:], 0.0, rtol=0, atol=1e-8)


@bodies
def test_interpolant_ends_where_the_next_step_begins(make: Callable[[int], Problem]) -> None:
    walk = simulate(make(0))
    for index, time in enumerate(walk.times[1:]):
        end = between(walk, np.nextafter(time, 0.0))
        np.testing.assert_allclose(end, walk.tape.y[index + 1], rtol=1e-12, atol=1e-15)
