"""Duty factors and phase lags."""

import numpy as np
import pytest

import legspring as ls
from legspring import load_animal
from legspring.flow import flow
from legspring.layout import System
from legspring.measures.footfalls import phase_lag
from tests.conftest import Cells


def test_tripods_go_by_turns(thesis_map: Cells) -> None:
    gaits = [gait for here in thesis_map.values() for gait in here]
    beyond = 0
    for gait in gaits:
        np.testing.assert_allclose(gait.phase_lag, [0.0, 0.0, 0.0, 0.5, 0.5, 0.5], rtol=0, atol=1e-12)
        # A leg is down from its touch-down to its lift-off; that of the step before is the image of one of this.
        np.testing.assert_allclose(gait.duty_factor, np.tile(gait.liftoff / 2.0, 2), rtol=0, atol=1e-9)
        beyond += bool(np.any(gait.liftoff > 1.0))
    assert beyond > 10


@pytest.mark.parametrize("name", ["lateral_leg_spring", "lateral_leg_spring_point"])
def test_legs_that_follow_one_another_share_a_stride(name: str) -> None:
    gait = ls.find_gaits(load_animal(name))[0]
    assert gait.duty_factor == pytest.approx([0.5, 0.5])
    assert gait.phase_lag == pytest.approx([0.0, 0.5])


def test_a_runner_is_down_until_its_lift_off() -> None:
    for gait in ls.find_gaits(load_animal("spring_loaded_inverted_pendulum")):
        run = gait.simulate(strides=1)
        lift_off, touch_down = run["event_time"].values
        assert run["event_kind"].values.tolist() == ["lift-off", "touch-down"]
        assert gait.duty_factor == pytest.approx([lift_off / touch_down])
        assert gait.duty_factor == pytest.approx([run["stance"].values[:, 0].mean()], abs=0.01)
        assert gait.phase_lag == [0.0]


def test_two_legs_at_once() -> None:
    """Which of them lands first is rounding; at once is no lag, and not nearly a whole stride."""
    one = load_animal("spring_loaded_inverted_pendulum").replace(stiffness=10e3)
    other = one.legs[0].model_copy(update={"name": "R", "pair": "R"})
    two = one.replace(legs=(*one.legs, other), families={"P": ("L", "R")})
    gait = ls.find_gaits(two)[0]
    alone = ls.find_gaits(load_animal("spring_loaded_inverted_pendulum"))[0]
    assert gait.phase_lag.tolist() == [0.0, 0.0]
    assert gait.duty_factor == pytest.approx(np.repeat(alone.duty_factor, 2), rel=1e-6)


@pytest.mark.parametrize(("stance", "share"), [(0.3, 0.15), (1.5, 0.75), (3.0, 1.0)])
def test_stances_by_the_clock_of_any_length(stance: float, share: float) -> None:
    """One of more than a stride lasts until the leg is put down anew, and so all the time."""
    animal = load_animal("climbing_template").replace(stance=stance)
    system = System(animal, np.pi / 2, "P")
    run = flow(system, system.point(speed=0.2, heading=0.0), steps=2, record=True)
    assert run.duty_factor == pytest.approx([share, share])
    assert phase_lag(run) == pytest.approx([0.0, 0.5])


def test_lags_are_relative_to_the_first_leg() -> None:
    animal = load_animal("single_leg")
    left, right = animal.legs
    swapped = animal.replace(legs=(right, left))
    third = animal.replace(legs=[leg.model_copy(update={"offset": leg.offset + 0.4}) for leg in animal.legs])
    for other, lags in ((swapped, [0.0, 0.5]), (third, [0.0, 0.5])):
        system = System(other, 0.5, "P")
        run = flow(system, system.point(speed=0.3, heading=0.1), steps=2, record=True)
        assert phase_lag(run) == pytest.approx(lags)
