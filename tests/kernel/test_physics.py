"""What holds for any body on springs, whatever the numbers."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from legspring.kernel.measure import leg_work
from tests.kernel.bridge import Walk, point_mass, rigid_body, sequence, simulate, units
from tests.oracle.problem import Array, Problem

seeds = st.integers(0, 10**6)
factors = st.floats(0.25, 4.0)
some = settings(max_examples=25, derandomize=True, deadline=None, database=None)
bodies = pytest.mark.parametrize("make", [point_mass, rigid_body])
Make = Callable[[int], Problem]


def spread(problem: Problem) -> Array:
    """Natural sizes of the state."""
    length = max(problem.length)
    return np.array([length, length, problem.speed, problem.speed, 1.0, 1.0 / problem.t_des])


@bodies
@some
@given(seed=seeds)
def test_mirror(make: Make, seed: int) -> None:
    problem = make(seed)
    aside = np.array([-1.0, 1.0])
    mirrored = replace(
        problem,
        hip=problem.hip * aside,
        angle=-problem.angle,
        heading=-problem.heading,
        yaw=-problem.yaw,
        yaw_rate=-problem.yaw_rate,
        previous=problem.displacement * aside,
    )
    walk, mirror = simulate(problem), simulate(mirrored)
    np.testing.assert_array_equal(mirror.times, walk.times)
    assert sequence(mirror.events) == sequence(walk.events)
    np.testing.assert_array_equal(mirror.state(2.0), walk.state(2.0) * [-1, 1, -1, 1, -1, -1])


@bodies
@some
@given(seed=seeds, length=factors, mass=factors, time=factors)
def test_froude_scaling(make: Make, seed: int, length: float, mass: float, time: float) -> None:
    """Animals of other sizes move alike."""
    problem = make(seed)
    speed = length / time
    other = replace(
        problem,
        mass=problem.mass * mass,
        inertia=None if problem.inertia is None else problem.inertia * mass * length**2,
        gravity=problem.gravity * length / time**2,
        t_des=problem.t_des * time,
        v_des=problem.v_des * speed,
        hip=problem.hip * length,
        stiffness=problem.stiffness * mass / time**2,
        length=problem.length * length,
        ldev=problem.ldev * length,
        speed=problem.speed * speed,
        yaw_rate=problem.yaw_rate / time,
        previous=problem.displacement * length,
    )
    walk, scaled = simulate(problem), simulate(other)
    assert sequence(scaled.events) == sequence(walk.events)
    expected = walk.state(2.0) * [length, length, speed, speed, 1.0, 1.0 / time]
    np.testing.assert_allclose(scaled.state(2.0) / spread(other), expected / spread(other), rtol=0, atol=1e-10)


def kinetic_energy(problem: Problem, state: Array) -> float:
    """In J."""
    spin = (problem.inertia or 0.0) * state[5] ** 2
    return float(problem.mass * (state[2:4] @ state[2:4]) + spin) / 2


@bodies
@some
@given(seed=seeds)
def test_work_is_change_of_kinetic_energy(make: Make, seed: int) -> None:
    problem = make(seed)
    walk = simulate(problem)
    for step in (0.0, 1.0):
        begin, end = walk.state(step), walk.state(step + 1.0)
        work = np.sum(leg_work(walk.tape, step, step + 1.0)) * problem.mass / problem.t_des**2
        work -= problem.mass * problem.gravity * np.sin(problem.slope) * (end[1] - begin[1])
        change = kinetic_energy(problem, end) - kinetic_energy(problem, begin)
        assert work == pytest.approx(change, abs=1e-10 * problem.mass * problem.speed**2)


def energies(walk: Walk) -> Array:
    """Kinetic energy and that of the springs at the start of each integrator step, in J."""
    problem, tape = walk.problem, walk.tape
    found = []
    for step in range(len(walk.times) - 1):
        state = walk.si(tape.y[step])[:, 0]
        energy = kinetic_energy(problem, state)
        for leg in np.flatnonzero(tape.down[step]):
            # A passive leg's length does not depend on its age.
            gap, _ = problem.gap(int(leg), state, tape.stance[step, leg, :2, 0], 0.0)
            energy += problem.stiffness[leg] * gap**2 / 2
        found.append(energy)
    return np.array(found)


@bodies
@some
@given(seed=seeds)
def test_passive_legs_on_the_level_keep_energy(make: Make, seed: int) -> None:
    """But for what is lost where a leg is put down anew while its spring is loaded."""
    problem = make(seed)
    walk = simulate(replace(problem, slope=0.0, ldev=np.zeros(6)))
    energy = energies(walk) / (problem.mass * problem.speed**2)
    for step in (0.0, 1.0):
        during = energy[(walk.times[:-1] >= step) & (walk.times[:-1] < step + 1.0)]
        assert len(during) > 3
        np.testing.assert_allclose(during, during[0], rtol=0, atol=1e-10)


@some
@given(seed=seeds)
def test_body_with_hips_at_its_centre_is_a_point_mass(seed: int) -> None:
    problem = replace(rigid_body(seed), hip=np.zeros((6, 2)), yaw=0.0, yaw_rate=0.0)
    walk, point = simulate(problem), simulate(replace(problem, inertia=None))
    assert sequence(walk.events) == sequence(point.events)
    difference = (walk.state(2.0) - point.state(2.0)) / spread(problem)
    np.testing.assert_allclose(difference, 0.0, rtol=0, atol=1e-10)
    assert np.all(walk.state(2.0)[4:] == 0.0)


@some
@given(seed=seeds)
def test_body_that_hardly_turns_is_a_point_mass(seed: int) -> None:
    problem = replace(rigid_body(seed), yaw=0.0, yaw_rate=0.0)
    held = simulate(replace(problem, inertia=None))
    heavy = simulate(replace(problem, inertia=1e12 * (problem.inertia or 0.0)))
    assert sequence(heavy.events) == sequence(held.events)
    difference = (heavy.state(2.0) - held.state(2.0)) / spread(problem)
    np.testing.assert_allclose(difference, 0.0, rtol=0, atol=1e-10)


@bodies
@some
@given(seed=seeds)
def test_constant_push_is_gravity(make: Make, seed: int) -> None:
    problem = make(seed)
    pull = problem.gravity * np.sin(problem.slope) * problem.t_des**2
    push = np.array([[-1.0, 0.0, -pull], [0.7, 0.0, -pull], [5.0, 0.0, -pull]])
    walk, level = simulate(problem), simulate(replace(problem, slope=0.0), push=push)
    difference = (walk.state(2.0) - level.state(2.0)) / spread(problem)
    np.testing.assert_allclose(difference, 0.0, rtol=0, atol=1e-10)


def test_push_in_flight() -> None:
    """A triangle changes the velocity by its area."""
    problem = replace(point_mass(0), stiffness=np.zeros(6), slope=0.0)
    push = np.array([[0.125, 0.0, 0.0], [0.2, 0.03, -0.01], [0.225, 0.0, 0.0]])
    change = simulate(problem, push=push).state(2.0) - simulate(problem).state(2.0)
    impulse = 0.05 * np.array([0.03, -0.01])
    middle = np.mean(push[:, 0])  # of the triangle
    expected = [*(impulse * (2.0 - middle)), *impulse, 0.0, 0.0]
    np.testing.assert_allclose(change / units(problem), expected, rtol=0, atol=1e-16)
