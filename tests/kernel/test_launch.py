"""The start of a simulation, with legs that touch down at any time."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from legspring.kernel.measure import leg_work
from tests.kernel.bridge import point_mass, rigid_body, simulate
from tests.oracle.problem import Problem

OFFSET = np.array([0.0, 0.25, 2 / 3, 1.0, 4 / 3, 1.9])
Make = Callable[[int], Problem]
bodies = pytest.mark.parametrize("make", [point_mass, rigid_body])


@bodies
@pytest.mark.parametrize("seed", range(5))
def test_feet_of_the_start(make: Make, seed: int) -> None:
    """The legs of the last steps were put down by a body that moved and turned evenly."""
    problem = replace(make(seed), offset=OFFSET, turn=0.1 if make is rigid_body else None)
    walk = simulate(problem, 0.2)
    turn = 2.0 * problem.yaw if problem.turn is None else problem.turn
    for leg, offset in enumerate(OFFSET):
        ago = 0.0 if offset == 0.0 else 2.0 - offset
        before = np.array([*(-ago * problem.displacement), 0.0, 0.0, problem.yaw - ago * turn, 0.0])
        foot = problem.foot(leg, before)
        np.testing.assert_allclose(walk.tape.stance[0, leg, :2, 0], foot, rtol=0, atol=1e-16)
        gap, _ = problem.gap(leg, problem.start, foot, ago)
        assert abs(gap) > 1e-6 or offset == 0.0
        assert walk.tape.down[0, leg] == (offset == 0.0 or gap * problem.function[leg] > 0.0)


@bodies
@pytest.mark.parametrize("seed", range(5))
def test_touch_downs_at_any_time(make: Make, seed: int) -> None:
    problem = replace(make(seed), offset=OFFSET)
    walk = simulate(problem, 4.0)
    touchdowns = [event for event in walk.events if event.kind == "touchdown"]
    times = [event.t / problem.t_des for event in touchdowns]
    np.testing.assert_allclose(times, [*OFFSET[1:], *(OFFSET + 2.0)], rtol=1e-15)
    assert [event.leg for event in touchdowns] == [1, 2, 3, 4, 5, 0, 1, 2, 3, 4, 5]
    for event in touchdowns:
        np.testing.assert_allclose(event.foot, problem.foot(event.leg, event.state), rtol=0, atol=1e-16)
        gap, _ = problem.gap(event.leg, event.state, event.foot, 0.0)
        assert abs(gap) < 1e-16

    begin, end = walk.state(0.0), walk.state(4.0)
    work = np.sum(leg_work(walk.tape, 0.0, 4.0)) / problem.t_des**2
    work -= problem.gravity * np.sin(problem.slope) * (end[1] - begin[1])
    spin = (problem.inertia or 0.0) / problem.mass
    energies = [(state[2:4] @ state[2:4] + spin * state[5] ** 2) / 2 for state in (begin, end)]
    assert work == pytest.approx(energies[1] - energies[0], abs=1e-10 * problem.speed**2)
