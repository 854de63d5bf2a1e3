"""What is believed to be a gait has repeated itself; what only fulfils some conditions is refused, with a reason."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import legspring as ls
from legspring import Animal, Gait, load_animal
from legspring.asking import problem_for
from legspring.flow import flow
from legspring.gait import Invalid
from legspring.layout import PLACES
from legspring.model import Body, Leg
from legspring.repetition import departure, departures, moment
from tests.oracle.animals import START, states_of
from tests.places import place_of

SLIP = "spring_loaded_inverted_pendulum"
PASSIVE = ["lateral_leg_spring", "lateral_leg_spring_point", "hexapod"]


def gait_of(name: str) -> Gait:
    animal = load_animal(name)
    return ls.find_gaits(animal, **place_of(animal))[0]


def seen_from_the_side(legs: tuple[Leg, ...], pitch: str = "held") -> Animal:
    """Return the inverted pendulum with other legs."""
    pairs = tuple(dict.fromkeys(leg.pair for leg in legs))
    body = Body(mass=80.0, inertia=5.0, yaw=pitch)  # type: ignore[arg-type]
    return Animal(**dict(load_animal(SLIP)) | {"legs": legs, "families": {"P": pairs}, "body": body})


def ground_leg(name: str, pair: str, **changes: Any) -> Leg:
    leg: dict[str, Any] = {
        "length": 1.0,
        "angle_deg": -158.0,
        "actuation": 0.0,
        "stiffness": 20e3,
        "touchdown": "ground",
        "offset": 0.0,
    }
    return Leg(name=name, pair=pair, **leg | changes)


@pytest.mark.parametrize("slope_deg", [10.0, -3.0])
@pytest.mark.parametrize("name", PASSIVE)
def test_passive_legs_have_no_gaits_on_a_slope(name: str, slope_deg: float) -> None:
    """Each stride gains m g times its rise: nothing that gets on can repeat itself."""
    animal = load_animal(name).replace(speed_law=0.51)
    assert ls.find_gaits(animal, slope_deg=slope_deg, starts=24) == []


def test_but_they_may_hop_where_they_are() -> None:
    """Facing downhill, gravity gives back what it takes: by the oracle alone, too, two strides repeat themselves."""
    animal = load_animal("lateral_leg_spring").replace(speed_law=0.3)
    gait = ls.find_gaits(animal, slope_deg=-12.0)[0]
    assert gait.speed == pytest.approx(0.1184, abs=1e-4) and not gait.gets_on
    system = gait.system
    start = dict(zip(START, gait.point.tolist(), strict=False))
    states = states_of(animal, gait.slope, gait.family, start, dict.fromkeys(("L", "R"), 0.0), 4)[:, :6]
    speed = system.desired_speed
    scale = np.array([system.step_length, system.step_length, speed, speed, 1.0, 1.0 / system.step_duration])
    for state in states[[2, 4]]:
        np.testing.assert_allclose(state / scale, states[0] / scale, rtol=0, atol=1e-9)


@pytest.mark.parametrize("slope_deg", [2.7e-15, 1e-9, 1e-7, 1e-5])
@pytest.mark.parametrize("name", PASSIVE)
def test_nearly_level_ground(name: str, slope_deg: float) -> None:
    """The gaits of the level, or none; but never one for each start, at whatever speed."""
    animal = load_animal(name).replace(speed_law=0.51)
    search = ls.search_gaits(animal, slope_deg=slope_deg, starts=12)
    if slope_deg < 1e-8:
        (gait,) = search.gaits
        assert gait.heading == pytest.approx(gait_of(name).heading, abs=1e-7) and "energy" in gait.conserved
    else:
        assert not search.gaits
        assert {r.reason for r in search.rejections} <= {Invalid.NOT_ISOLATED, Invalid.UNCONFIRMED, Invalid.WRONG_SIGN}


def test_a_step_in_which_nothing_happens_is_no_gait() -> None:
    search = ls.search_gaits(load_animal("single_leg").replace(step_law=1e-12), slope_deg=45, starts=12)
    assert not search.gaits


def test_a_body_that_nothing_turns_has_one_gait_and_not_a_continuum() -> None:
    pitching = load_animal(SLIP).replace(yaw="free", inertia=5.0)
    gaits, expected = ls.find_gaits(pitching, starts=32), ls.find_gaits(load_animal(SLIP), starts=32)
    assert [g.heading for g in gaits] == pytest.approx([g.heading for g in expected], abs=1e-9)
    for gait in gaits:
        assert gait.conserved == ("energy", "yaw_rate", "yaw")
        assert np.sum(np.abs(gait.multipliers - 1.0) < 1e-6) == 3


@pytest.mark.parametrize("name", PASSIVE)
def test_what_is_conserved_on_the_level_is_not_on_a_slope(name: str) -> None:
    """A solution for which the speed is not asked to come back is refused, and the reason names the speeds."""
    level = gait_of(name)
    animal = load_animal(name).replace(speed_law=0.51)
    sloping = replace(level, animal=animal, slope=math.radians(10.0))
    assert "energy" in level.conserved and "energy" not in sloping.conserved
    assert sloping.invalid() is not None
    assert problem_for(animal, sloping.slope, "P").unknowns[0] == "speed"
    found = departure(sloping.system, sloping.point, 1.0)
    assert found is not None and found.amount > 0.01 and found.what.startswith("after 1 step")


def test_feet_that_float_are_no_gait() -> None:
    """Two legs that are both put down at the start, wherever the ground is, and only one of which lands later."""
    legs = ground_leg("A", "A", hip=(0.2, 0.0)), ground_leg("B", "B", hip=(-0.2, 0.0))
    search = ls.search_gaits(seen_from_the_side(legs, "free"), starts=12)
    assert not search.gaits
    reasons = {rejection.reason for rejection in search.rejections}
    assert Invalid.DEPARTS in reasons
    assert "the motion does not repeat itself (after 1 step B is up, which was not so at the start" in search.summary()


def test_legs_in_mirror_image_seen_from_the_side() -> None:
    legs = ground_leg("L", "T"), ground_leg("R", "T", angle_deg=158.0, offset=1.0)
    search = ls.search_gaits(seen_from_the_side(legs), starts=200)
    # Both come down at one time, on either side; a step is not the image of the one before.
    assert search.gaits
    for gait in search.gaits:
        assert list(gait.system.lands) == [True, True] and not gait.mirrored and gait.system.period == 2


@pytest.mark.parametrize("name", ls.presets())
def test_gaits_of_presets_repeat_themselves(name: str) -> None:
    gait = gait_of(name)
    assert departure(gait.system, gait.point, abs(gait.multipliers[0])) is None


@pytest.mark.parametrize("name", ls.presets())
def test_what_is_a_little_off_does_not(name: str) -> None:
    """A speed that is off by 1e-4; where energy is conserved a heading, as there are gaits at other speeds."""
    gait = gait_of(name)
    change: dict[str, Any] = (
        {"heading": gait.heading + 1e-4} if gait.conserved else {"speed": gait.speed * (1.0 + 1e-4)}
    )
    found = departure(gait.system, replace(gait, **change).point, 1.0)
    assert found is not None and 1e-8 < found.amount < 1e-2
    assert "the velocity is" in found.what


@pytest.mark.parametrize(
    ("field", "words"),
    [
        ("velocity", "the velocity is ("),
        ("yaw", "the yaw is off by 0.01 rad"),
        ("yaw_rate", "the yaw rate is off by"),
        ("down", "R is down, which was not so at the start"),
        ("feet", "the foot of L is"),
        ("height", "the height is off by 0.01 m"),
        ("depths", "the foot of L is 0.01 m off the ground"),
        ("energy", "the kinetic and spring energy is off by a share of"),
    ],
)
def test_every_part_of_the_state_counts(field: str, words: str) -> None:
    gait = gait_of("lateral_leg_spring")
    first = moment(flow(gait.system, gait.point, steps=0))
    value = getattr(first, field)
    now = first._replace(**{field: ~value if field == "down" else value + 0.01})
    found = next(found for found in departures(gait.system, first, now) if found.amount > 1e-8)
    assert found.what.startswith(words)


def test_a_whole_turn_is_none() -> None:
    """Somersaults come back: the yaw counts up to whole turns."""
    gait = gait_of("climbing_template")
    turned = gait.point.copy()
    turned[PLACES["yaw"]] += 2.0 * math.pi
    assert departure(gait.system, turned, abs(gait.multipliers[0])) is None


def test_how_far_small_departures_may_have_grown() -> None:
    gait = gait_of(SLIP)
    off = replace(gait, heading=gait.heading + 1e-7).point
    assert departure(gait.system, off, 1.0) is not None
    assert departure(gait.system, off, 30.0) is None
    # However unstable, a departure that can be seen is one.
    far = replace(gait, heading=gait.heading + 1e-2).point
    assert departure(gait.system, far, 1e9) is not None
    assert departure(gait.system, far, math.nan) is not None


def test_unstable_gaits_are_gaits() -> None:
    unstable, stable = ls.find_gaits(load_animal(SLIP))
    assert abs(unstable.multipliers[0]) > 1.7 and abs(stable.multipliers[0]) < 1.0 + 1e-9


def test_a_leg_that_is_about_to_lift_off_may_be_up_or_down() -> None:
    (one,) = ls.find_gaits(load_animal("lateral_leg_spring"))
    same = {"hip": (0.0, -0.002), "angle_deg": (45.0, 45.0, 45.0), "offset": 0.0}
    (gait,) = ls.find_gaits(load_animal("hexapod").replace(step_law=one.step_duration, **same))
    assert gait.liftoff == pytest.approx(np.ones(3), abs=1e-7)


def test_a_gait_belongs_to_the_animal_that_was_asked_about() -> None:
    for name in ls.presets():
        assert gait_of(name).animal == load_animal(name)


def test_a_length_that_is_constant_by_a_formula_is_as_passive_as_any() -> None:
    spring = load_animal("lateral_leg_spring")
    (expected,) = ls.find_gaits(spring)
    same = spring.replace(length_law="l0 + 0*phi")
    assert same.conservative and not spring.replace(length_law="l0 - ldev*t").conservative
    (gait,) = ls.find_gaits(same)
    assert gait.conserved == ("energy", "direction")
    assert gait.heading == pytest.approx(expected.heading, abs=1e-9)
