"""Work and forces along a tape."""

from collections.abc import Callable

import numpy as np
import pytest
from legspring.layout import ACCURACY, TIGHT

from legspring.kernel import dop853
from legspring.kernel.measure import ALL_LEGS, largest_force, leg_work
from tests.kernel.bridge import Walk, callable_here, point_mass, rigid_body, scale, simulate
from tests.oracle import heyoka_walker
from tests.oracle.problem import Array, Problem

interpolate = callable_here(dop853.interpolate)
bodies = pytest.mark.parametrize("make", [point_mass, rigid_body])
SAMPLES = 60


def force(walk: Walk, step: int, leg: int, states: Array, ages: Array) -> Array:
    """Force of a leg at many moments of an integrator step, in N."""
    problem = walk.problem
    sine, cosine = np.sin(states[:, 4]), np.cos(states[:, 4])
    hip_x, hip_y = problem.hip[leg]
    hips = states[:, :2] + np.stack([cosine * hip_x - sine * hip_y, sine * hip_x + cosine * hip_y], axis=1)
    r = walk.tape.stance[step, leg, :2, 0] - hips
    length = np.hypot(*r.T)
    free = problem.length[leg] - problem.ldev[leg] * np.sin(np.pi * ages + problem.phase[leg])
    return np.asarray((problem.stiffness[leg] * (length - free) / length)[:, None] * r)


def sampled_forces(walk: Walk) -> Array:
    """Force (x, y, magnitude) of each leg, and of all together, at many moments; shape (moments, legs + 1, 3)."""
    problem, tape = walk.problem, walk.tape
    found = []
    for step, (begin, end) in enumerate(zip(walk.times, walk.times[1:], strict=False)):
        fractions = np.linspace(0.0, (end - begin) / tape.size[step], SAMPLES)
        y, states = np.zeros_like(tape.y[0]), []
        for fraction in fractions:
            interpolate(tape.y[step], tape.dense[step], fraction, y)
            states.append(walk.si(y)[:, 0])
        forces = np.zeros((SAMPLES, problem.n_legs + 1, 2))
        for leg in np.flatnonzero(tape.down[step]):
            since = problem.offset[leg] + 2.0 * np.floor((begin - problem.offset[leg]) / 2.0)
            ages = begin + fractions * tape.size[step] - since
            forces[:, leg] = force(walk, step, int(leg), np.array(states), ages)
        forces[:, -1] = np.sum(forces, axis=1)
        found.append(np.concatenate([forces, np.hypot(*forces.T).T[..., None]], axis=2))
    return np.concatenate(found)


@bodies
@pytest.mark.parametrize("accuracy", [TIGHT, ACCURACY])
@pytest.mark.parametrize("seed", range(10))
def test_largest_force(make: Callable[[int], Problem], seed: int, accuracy: float) -> None:
    problem = make(seed)
    walk = simulate(problem, accuracy=accuracy)
    forces = sampled_forces(walk) * problem.t_des**2 / problem.mass
    unit = np.max(np.abs(forces))
    for column, leg in enumerate([*range(problem.n_legs), ALL_LEGS]):
        for axis, sign in ((0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0), (2, 1.0)):
            sampled = np.max(sign * forces[:, column, axis])
            largest = largest_force(walk.tape, leg, axis, sign, 0.0, 2.0)
            assert -1e-14 < (largest - sampled) / unit < 1e-4


def test_a_leg_in_swing_bears_nothing() -> None:
    problem = point_mass(0)
    walk = simulate(problem)
    lifted = np.flatnonzero(~heyoka_walker.simulate(problem).down_at_start & (problem.offset > 0))
    assert len(lifted) > 0
    for leg in lifted:
        assert largest_force(walk.tape, int(leg), 2, 1.0, 0.0, 1.0) == 0.0
        assert largest_force(walk.tape, int(leg), 2, 1.0, 0.0, 2.0) > 0.0


@bodies
def test_leg_work(make: Callable[[int], Problem]) -> None:
    """Two changes of a power's sign close together may be missed: their parts are small then, and their sum right."""
    parts, sums = [], []
    for seed in range(100):
        problem = make(seed)
        walk, run = simulate(problem), heyoka_walker.simulate(problem)
        unit = scale(problem, run)[2] ** 2
        for step in range(2):
            work = leg_work(walk.tape, step, step + 1.0) / problem.t_des**2 / unit
            expected = np.stack([run.work_positive[step], run.work_negative[step]], axis=1) / problem.mass / unit
            parts.append(np.max(np.abs(work - expected)))
            sums.append(np.max(np.abs(np.sum(work - expected, axis=1))))
    assert np.max(sums) < 1e-11
    assert np.quantile(parts, 0.97) < 1e-11
    assert np.max(parts) < 1e-8
