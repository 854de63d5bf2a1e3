"""Gaits of animals whose legs are not tuned to a speed, and what is measured of them."""

import math

import numpy as np
import pytest

import legspring as ls
from legspring import Gait, load_animal
from legspring.model import ModelError
from tests.places import place_of

OWN = [name for name in ls.presets() if not load_animal(name).tuned]
each = pytest.mark.parametrize("name", OWN)


def first_gait(name: str) -> Gait:
    animal = load_animal(name)
    return ls.find_gaits(animal, **place_of(animal))[0]


@each
def test_a_stride_ends_as_it_began(name: str) -> None:
    gait = first_gait(name)
    states = gait.stride.states
    assert len(states) == 1 + gait.system.steps_per_stride
    scale = gait.system.desired_speed
    np.testing.assert_allclose(states[-1, 2:4], states[0, 2:4], rtol=0, atol=1e-9 * scale)
    np.testing.assert_allclose(states[-1, 4:5], states[0, 4:5], rtol=0, atol=1e-9)
    np.testing.assert_allclose(states[-1, 5:], states[0, 5:], rtol=0, atol=1e-8)
    ends, tape = gait.stride.step_ends, gait.stride.tape
    duration = gait.step_duration / gait.system.step_duration
    assert ends == pytest.approx(duration * np.arange(len(states)), abs=1e-9)
    assert ends[-1] == pytest.approx(tape.time[tape.counts[0]], rel=1e-15)


@each
def test_energy_over_a_step(name: str) -> None:
    """The body's kinetic energy returns: what legs do is the weight lifted."""
    gait = first_gait(name)
    steps = gait.system.period
    lifted = gait.stride.states[steps, 1] / steps * math.sin(gait.slope) / gait.distance
    assert np.sum(gait.work) == pytest.approx(lifted, abs=1e-8)
    assert gait.transport_cost >= lifted - 1e-8


@each
def test_what_is_conserved_is_a_multiplier_of_one(name: str) -> None:
    gait = first_gait(name)
    assert np.sum(np.abs(gait.multipliers - 1.0) < 1e-6) == len(gait.conserved)
    assert math.isnan(gait.reduced_eigenvalue)


@each
def test_forces_over_a_stride(name: str) -> None:
    gait = first_gait(name)
    run = gait.simulate(strides=1)
    force = run["force"].values
    for pair, leg in enumerate(gait.first_legs):
        sampled = np.max(np.abs(force[:, leg]), axis=0)
        # Between samples a force that lasts for less of a stride grows by more.
        rough = 2e-3 if gait.duty_factor[leg] > 0.2 else 3e-2
        np.testing.assert_allclose(np.abs(gait.peak_force[pair]), sampled, rtol=rough, atol=1e-6)
    high, low = gait.net_force
    net = force[: 100 * gait.system.period + 1].sum(axis=1)
    rough = (5e-3 if np.min(gait.duty_factor) > 0.2 else 3e-2) * np.max(np.abs(net))
    np.testing.assert_allclose(high, net.max(axis=0), rtol=0, atol=rough)
    np.testing.assert_allclose(low, net.min(axis=0), rtol=0, atol=rough)


@each
def test_events_of_a_stride(name: str) -> None:
    """Each leg touches down and lifts off once."""
    gait = first_gait(name)
    kinds = [f"{leg.name} {kind}" for leg in gait.animal.legs for kind in ("touch-down", "lift-off")]
    assert sorted(gait.events) == sorted(kinds)
    assert np.all((gait.liftoff > 0.0) & (gait.liftoff < 2.0))


def test_lift_offs_by_the_clock_do_not_graze() -> None:
    gait = first_gait("climbing_template")
    assert math.isnan(gait.grazing) and not gait.grazes


def test_steps_that_are_all_alike_make_strides_of_one() -> None:
    gait = first_gait("spring_loaded_inverted_pendulum")
    run = gait.simulate(strides=3)
    assert run["time"].values[-1] == pytest.approx(3.0 * gait.step_duration, rel=1e-9)
    with pytest.raises(ValueError, match=r"strides = 0.5: must be a whole number, up to 2000$"):
        gait.simulate(strides=0.5)


@pytest.mark.parametrize("name", [name for name in OWN if load_animal(name).conservative])
def test_an_animal_that_keeps_its_energy_does_not_recover(name: str) -> None:
    with pytest.raises(ValueError, match=f"^animal = '{name}': must have legs that do work, or lose some"):
        first_gait(name).recover(0.1)


def test_what_gaits_with_headings_of_their_own_do_not_take() -> None:
    animal = load_animal("lateral_leg_spring")
    with pytest.raises(ModelError, match=r"slope = 10 deg: must be 0 deg$"):
        ls.find_gaits(animal, slope_deg=10)
    with pytest.raises(ValueError, match="must have actuated legs whose phases are not given for a map over slope"):
        ls.atlas(animal, slopes_deg=[0], headings=[0.1])
    with pytest.raises(ValueError, match="must have legs with an actuation for it to be optimised"):
        ls.optimize(animal, slope_deg=0, heading=0.1)


def test_starts_of_what_is_tuned_name_all() -> None:
    roach = ls.cockroach()
    with pytest.raises(ValueError, match=r"^family is missing: must be one of A, FB, MB, B$"):
        ls.simulate(roach, slope_deg=0, heading=0.1, speed=0.3, phase=[0.0, 0.0, 0.0])
    with pytest.raises(ValueError, match=r"^phase is missing: must be an angle in rad for each of F, M, B$"):
        ls.simulate(roach, slope_deg=0, heading=0.1, speed=0.3, family="A")


@pytest.fixture(scope="module")
def driven() -> Gait:
    """Of a lateral leg spring whose legs do work by a clock of their own, in steps that end at touch-downs."""
    animal = load_animal("lateral_leg_spring")
    animal = animal.replace(damping=0.005, actuation=0.003, phase=0.0, length_law="l0 - ldev*t")
    (gait,) = ls.find_gaits(animal, starts=24)
    return gait


def test_legs_with_a_clock_keep_their_unit_of_time(driven: Gait) -> None:
    states, ends = driven.stride.states, driven.stride.step_ends
    np.testing.assert_allclose(states[2, 2:5], states[0, 2:5], rtol=0, atol=1e-9)
    assert driven.animal.step_law.duration == load_animal("lateral_leg_spring").step_law.duration
    assert ends[2] == pytest.approx(2.0 * ends[1]) and abs(ends[1] - 1.0) > 1e-3
    assert driven.mean_speed == pytest.approx(driven.distance / (ends[1] * driven.system.step_duration))
    assert np.sum(driven.work) == pytest.approx(0.0, abs=1e-8)


@pytest.mark.parametrize("impulse", [0.05, -0.03])
def test_recovery_is_as_quick_as_the_multipliers_say(driven: Gait, impulse: float) -> None:
    """On the level, where all directions are alike: it does not count that the push has turned the path."""
    recovery = driven.recover(impulse)
    last_strides = recovery.distance[100] / recovery.distance[80]
    neutral, slowest = np.abs(driven.multipliers[:2])
    assert neutral == pytest.approx(1.0, abs=1e-9)
    assert last_strides == pytest.approx(slowest**10, rel=1e-3)
    assert recovery.recovered


def test_a_push_is_over_before_anything_is_back() -> None:
    """It begins after an eighth of the gait's own step, whatever the unit of time, and ends in that or a later one."""
    damped = load_animal("lateral_leg_spring").replace(speed_law=0.3, damping=0.01)
    found = []
    for unit in (0.05, 0.4, 2.0):
        gait = ls.find_gaits(damped.replace(step_law=unit), slope_deg=-5.0)[0]
        found.append((gait.recover(0.3).steps, gait.recover(0.3).distance[1]))
    assert all(distance > 1e-3 for _, distance in found)
    assert [steps for steps, _ in found] == [found[0][0]] * 3
    assert [distance for _, distance in found] == pytest.approx([found[0][1]] * 3, rel=1e-6)
