"""Published templates of legged locomotion, put together from a body, legs and rules."""

import math

import numpy as np
import pytest

from legspring.model import Animal, Body, Leg, SpeedLaw, StepLaw
from legspring.returnmap import IntegrationError, Start, complete_map
from legspring.setting import TIGHT, Setting
from legspring.simulation import simulate


def inverted_pendulum(**changes: float) -> Animal:
    """The spring-loaded inverted pendulum in the sagittal plane; its leg comes down 10 degrees off the vertical."""
    leg = Leg(
        name="leg",
        pair="P",
        length=1.0,
        stiffness=100.0,
        angle=math.radians(-170),
        actuation=0.0,
        offset=0.0,
        touchdown="ground",
    )
    animal = Animal(
        name="spring-loaded inverted pendulum",
        body=Body(mass=1.0),
        legs=(leg,),
        families={"push": ("P",)},
        speed_law=SpeedLaw(level=1.0, vertical=1.0),
        step_law=StepLaw(duration=1.0),
        gravity=10.0,
    )
    return animal.replace(**changes)


def lateral_leg_spring(behind: float = 0.002) -> Animal:
    """The passive lateral leg spring of the cockroach, its hip so far behind the centre of mass (m)."""
    left = Leg(
        name="L",
        pair="P",
        hip=(0.0, -behind),
        length=0.017,
        stiffness=1.53,
        angle=math.pi / 4,
        actuation=0.0,
        offset=0.0,
        touchdown="lift-off",
        follows="R",
    )
    return Animal(
        name="lateral leg spring",
        body=Body(mass=2.9e-3, inertia=2.5e-7, yaw="free"),
        legs=(left, left.mirrored("R")),
        families={"push": ("P",)},
        speed_law=SpeedLaw(level=0.51, vertical=0.51),
        step_law=StepLaw(duration=0.04),
    )


def at_touch_down(animal: Animal, height: float, speed: float) -> Start:
    """Start of a step of the inverted pendulum that falls from an apex."""
    fall = height + animal.legs[0].length * math.cos(animal.legs[0].angle)
    down = math.sqrt(2.0 * animal.gravity * fall)
    return Start(math.hypot(speed, down), math.atan2(-speed, -down))


# Apex height 1.182441943200824 m, speed 1.017450873821607 m/s; multipliers 3.89595 and 1.
APEX = 1.182441943200824, 1.017450873821607


def test_inverted_pendulum() -> None:
    animal = inverted_pendulum()
    setting, start = Setting(animal, math.pi / 2, (-1,)), at_touch_down(animal, *APEX)
    state, jacobian = complete_map(setting, 0.0, start, accuracy=TIGHT)
    assert state == pytest.approx([start.speed, start.heading], abs=1e-12)
    # The map from touch-down to touch-down has the multipliers of that from apex to apex.
    assert sorted(np.linalg.eigvals(jacobian)) == pytest.approx([1.0, 3.89595], abs=5e-6)


def test_simulation_of_the_inverted_pendulum() -> None:
    animal = inverted_pendulum()
    start = at_touch_down(animal, *APEX)
    run = simulate(
        animal, slope_deg=90, heading=start.heading, speed=start.speed, phase=[0.0], family="push", strides=2
    )
    height = run.position[:, 1] - run.foot[0, 0, 1]
    assert height.max() == pytest.approx(APEX[0], abs=1e-4)
    assert list(run.event_kind.values) == ["touch-down", "lift-off", "touch-down", "lift-off", "touch-down"][1:]
    assert run.time[-1] == run.event_time[-1]
    # No gravity along the plane: nothing brings the foot back.
    with pytest.raises(IntegrationError, match="no leg touches down any more"):
        simulate(animal, slope_deg=0, heading=start.heading, speed=start.speed, phase=[0.0], family="push")


def gait(animal: Animal, speed: float) -> tuple[Setting, Start]:
    """Find the mirror-symmetric gait of the lateral leg spring by Newton's method."""
    setting, z = Setting(animal, 0.0, (-1,)), np.array([-0.1, 0.1, 0.0])

    def start() -> Start:
        return Start(speed, z[0], yaw=z[1], yaw_rate=z[2] / setting.step_duration)

    for _ in range(30):
        state, jacobian = complete_map(setting, 0.0, start(), accuracy=TIGHT)
        z -= np.linalg.solve(jacobian[1:, 1:] - np.eye(3), state[1:] - z)
    assert state[1:] == pytest.approx(z, abs=1e-11)
    return setting, start()


@pytest.mark.parametrize(("behind", "stable"), [(0.002, True), (-0.002, False)])
def test_lateral_leg_spring(behind: float, stable: bool) -> None:
    setting, start = gait(lateral_leg_spring(behind), 0.51)
    state, jacobian = complete_map(setting, 0.0, start, accuracy=TIGHT)
    assert state[0] == pytest.approx(0.51 * setting.step_duration, rel=1e-12)
    multipliers = np.linalg.eigvals(jacobian @ jacobian)
    by_distance = multipliers[np.argsort(np.abs(multipliers - 1.0))]
    # Energy is kept, and all directions of the plane are alike.
    assert by_distance[:2] == pytest.approx([1.0, 1.0], abs=1e-6)
    assert (np.max(np.abs(by_distance[2:])) < 1.0) == stable
