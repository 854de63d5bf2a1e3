"""Gaits of the cockroach that yaws, step by step against the oracle."""

import numpy as np
import pytest

from legspring import Gait
from tests.conftest import Cells
from tests.oracle import heyoka_walker
from tests.oracle.problem import Problem

CELLS = [(0.0, 0.05), (0.0, 0.3), (30.0, 0.15), (60.0, 0.15), (90.0, 0.45)]


def problem_of(gait: Gait) -> Problem:
    """Ask the oracle about a gait: its animal, as it is in the file, and its start."""
    animal, functions = gait.animal, gait.animal.functions(gait.family)
    pair = list(animal.pair_of)
    function = np.array(functions, dtype=float)[pair]
    return Problem(
        mass=animal.body.mass,
        inertia=animal.body.inertia,
        gravity=animal.gravity,
        slope=gait.slope,
        t_des=animal.step_duration(gait.slope),
        v_des=animal.desired_speed(gait.slope),
        hip=np.array([leg.hip for leg in animal.legs]),
        stiffness=np.array([leg.stiffness for leg in animal.legs]),
        length=np.array([leg.length for leg in animal.legs]),
        ldev=function * np.array(gait.actuation)[pair],
        phase=np.array(gait.phase)[pair],
        angle=np.array([leg.angle for leg in animal.legs]),
        function=function,
        offset=np.array([leg.offset for leg in animal.legs]),
        speed=gait.speed,
        heading=gait.heading,
        yaw=gait.yaw,
        yaw_rate=gait.yaw_rate,
    )


@pytest.mark.parametrize("cell", CELLS)
def test_gaits_of_the_rigid_cockroach(cell: tuple[float, float], rigid_map: Cells) -> None:
    assert rigid_map[cell]
    for gait in rigid_map[cell]:
        problem = problem_of(gait)
        run = heyoka_walker.simulate(problem, 1.0)
        step = problem.v_des * problem.t_des
        start, middle, end = run.states / [step, step, problem.v_des, problem.v_des, 1.0, 1.0 / problem.t_des]
        ahead = np.array([0.0, 1.0, 0.0, 0.0, 0.0, 0.0])
        # What is off after the first step grows in the second one, where the gait is unstable.
        tolerances = 1e-10, 1e-10 * max(1.0, abs(gait.multipliers[0]))
        np.testing.assert_allclose(middle, start * [1, 1, -1, 1, -1, -1] + ahead, rtol=0, atol=tolerances[0])
        np.testing.assert_allclose(end, start + 2.0 * ahead, rtol=0, atol=tolerances[1])
        ours = gait.stride.states[:3] / [step, step, problem.v_des, problem.v_des, 1.0, 1.0 / problem.t_des]
        np.testing.assert_allclose(ours[:2], [start, middle], rtol=0, atol=tolerances[0])
        np.testing.assert_allclose(ours[2], end, rtol=0, atol=tolerances[1])
        times = {event.leg: event.t / problem.t_des for event in run.liftoffs}
        assert gait.liftoff == pytest.approx([times[leg] for leg in gait.first_legs], abs=1e-9)
        assert run.transport_cost(1) == pytest.approx(gait.transport_cost, rel=1e-8)
