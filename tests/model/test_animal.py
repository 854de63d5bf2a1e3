import json
import pickle
from math import radians
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from legspring.model import Animal, Leg, ModelError, cockroach, load_animal

ROACH = cockroach()
NAMES = ("FL", "MR", "BL", "FR", "ML", "BR")

# Values that a leg of any pair may have, so that one alone can be replaced.
LEG_VALUES = {
    "hip": st.tuples(st.floats(-0.01, 0.01), st.floats(-0.02, 0.02)),
    "length": st.floats(0.02, 0.1),
    "stiffness": st.floats(0.1, 10.0),
    "angle": st.floats(-3.0, 3.0),
    "actuation": st.floats(0.0, 0.015),
    "function": st.sampled_from(["push", "pull"]),
}


def by_name(animal: Animal) -> dict[str, Leg]:
    return {leg.name: leg for leg in animal.legs}


def test_pairs_come_from_the_legs() -> None:
    assert tuple(leg.name for leg in ROACH.legs) == NAMES
    assert ROACH.pairs == ("F", "M", "B")
    assert ROACH.pair_of == (0, 1, 2, 0, 1, 2)
    assert ROACH.actuation == (0.016, 0.013, 0.0095)


def test_a_family_says_which_pairs_push() -> None:
    assert {family: ROACH.functions(family) for family in ROACH.families} == {
        "A": (-1, -1, -1),
        "FB": (-1, 1, -1),
        "MB": (1, -1, -1),
        "B": (1, 1, -1),
    }
    with pytest.raises(ModelError, match=r"^family = 'F': must be one of A, FB, MB, B$"):
        ROACH.functions("F")


def test_animals_are_values() -> None:
    other = ROACH.replace(mass=3e-3)
    assert other != ROACH
    assert other.replace(mass=ROACH.body.mass) == ROACH
    assert {ROACH, other, other.replace(mass=2.5e-3)} == {ROACH, other}
    assert pickle.loads(pickle.dumps(ROACH)) == ROACH
    assert hash(pickle.loads(pickle.dumps(ROACH))) == hash(ROACH)
    assert Animal(**json.loads(ROACH.model_dump_json())) == ROACH


def test_nothing_of_an_animal_can_be_changed() -> None:
    with pytest.raises(ValueError, match="frozen"):
        ROACH.gravity = 1.6
    with pytest.raises(TypeError):
        ROACH.families["C"] = ("F",)  # type: ignore[index]


def test_replace_reaches_the_body_and_the_animal() -> None:
    other = ROACH.replace(name="other", gravity=1.6, mass=3e-3, yaw="free")
    assert (other.name, other.gravity, other.body.mass, other.body.yaw) == ("other", 1.6, 3e-3, "free")
    assert other.legs == ROACH.legs
    assert (ROACH.name, ROACH.body.mass) == ("cockroach", 2.5e-3)


@given(data=st.data(), field=st.sampled_from(sorted(LEG_VALUES)))
def test_replace_takes_one_value_for_all_pairs_or_one_for_each(data: st.DataObject, field: str) -> None:
    values = data.draw(st.tuples(*[LEG_VALUES[field]] * 3))
    start = ROACH.replace(length=0.05, actuation=0.01)
    each, same = (by_name(start.replace(**{field: value})) for value in (values, values[0]))
    assert [getattr(each[name], field) for name in NAMES[:3]] == list(values)
    assert [getattr(same[name], field) for name in NAMES[:3]] == [values[0]] * 3
    for first, second in zip(NAMES[:3], NAMES[3:], strict=True):
        assert each[second] == each[first].mirrored(second)


def test_angles_and_hips_are_those_of_the_leg_put_down_first() -> None:
    legs = by_name(ROACH.replace(angle_deg=(30, -60, 130), hip=[(-0.003, 0.01), (0.004, 0), (-0.005, -0.01)]))
    assert [legs[name].angle for name in NAMES] == list(map(radians, (30, -60, 130, -30, 60, -130)))
    assert [legs[name].hip[0] for name in NAMES] == [-0.003, 0.004, -0.005, 0.003, -0.004, 0.005]
    assert [legs[name].hip[1] for name in NAMES] == [0.01, 0, -0.01] * 2


def test_replace_takes_numpy_values() -> None:
    hips = np.array([[-0.003, 0.01], [0.004, 0.0], [-0.005, -0.01]])
    expected = ROACH.replace(actuation=(0.01, 0.011, 0.012), hip=hips.tolist(), mass=0.5, speed_law=0.3)
    changes: dict[str, Any] = {
        "actuation": np.array([0.01, 0.011, 0.012]),
        "hip": hips,
        "mass": np.float64(0.5),
    }
    assert ROACH.replace(**changes, speed_law=np.float64(0.3)) == expected


def test_a_plain_number_is_a_constant_law() -> None:
    other = ROACH.replace(speed_law=0.3, step_law=0.05)
    for slope_deg in (-90, 0, 37, 90):
        assert other.desired_speed(radians(slope_deg)) == 0.3
        assert other.step_duration(radians(slope_deg)) == 0.05


def test_a_pair_may_have_one_leg() -> None:
    alone = ROACH.replace(legs=ROACH.legs[:1], families={"push": ("F",), "pull": ()})
    assert alone.pairs == ("F",)
    assert (alone.functions("push"), alone.functions("pull")) == ((-1,), (1,))
    assert alone.replace(angle=0.1).legs[0].angle == 0.1


def test_no_changes_are_no_change() -> None:
    assert ROACH.replace() == ROACH


def mirrored_wrongly(**changes: Any) -> tuple[Leg, ...]:
    return (*ROACH.legs[:5], ROACH.legs[5].model_copy(update=changes))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"colour": 3, "mass": 1.0},
            "cannot replace colour: must be among name, summary, source, body, .* mass, .* angle_deg",
        ),
        ({"mass": -1}, "Body: mass = -1: must be greater than 0"),
        ({"stiffness": (1.5, 1.5, -1)}, "Leg 'BL': stiffness = -1: must be greater than 0"),
        (
            {"stiffness": (1.5, 1.5)},
            r"stiffness = \(1.5, 1.5\): must be one value, or one for each pair \(F, M, B\)",
        ),
        ({"hip": [(0, 0), 0, (0, 0)]}, "Leg 'FL': hip = "),
        ({"angle": 25}, "angle = 25: must be between -pi and pi rad"),
        ({"angle": 0.1, "angle_deg": 5}, "angle and angle_deg are both given"),
        ({"actuation": 0.02}, "Leg 'BL': actuation = 0.02: must be less than the length"),
        ({"gravity": 0}, "gravity = 0: must be greater than 0"),
        ({"body": 3}, "body = 3: must be"),
        ({"speed_law": -0.3}, "speed_law: SpeedLaw: level = -0.3: must be greater than 0"),
        (
            {"step_law": {"points": [[0.3, 3], [0.5, 9]]}},
            "stride frequency at 0.2 m/s = 0 Hz|frequency at 0.2 m/s = -",
        ),
        ({"legs": ()}, "legs are missing"),
        ({"legs": ROACH.legs + ROACH.legs}, "legs named FL, .* BR occur more than once"),
        (
            {"legs": (*ROACH.legs, ROACH.legs[0].mirrored("X"))},
            "pair 'F' has legs FL, FR, X: must be one or two",
        ),
        ({"families": {}}, "families are missing"),
        ({"families": {"A": ("F", "X")}}, "family 'A' = .*: must be distinct pairs out of F, M, B"),
        ({"families": {"A": ("F", "F")}}, "family 'A' = .*: must be distinct pairs out of F, M, B"),
        ({"families": {"A": ("F", "M"), "Z": ("M", "F")}}, "should differ in the pairs that push"),
    ],
)
def test_a_change_that_cannot_be_is_refused_in_one_line(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ModelError, match=message) as caught:
        ROACH.replace(**changes)
    assert "\n" not in str(caught.value)


def test_rules_must_fit_together() -> None:
    follower = ROACH.replace(touchdown="lift-off", follows=("FR", "ML", "BR"))
    assert [leg.follows for leg in follower.legs] == ["FR", "ML", "BR", "FL", "MR", "BL"]
    with pytest.raises(ModelError, match=r"leg 'FL': follows = 'X': must be one of FL, MR, BL, FR, ML, BR"):
        ROACH.replace(touchdown="lift-off", follows="X")
    with pytest.raises(ModelError, match="no leg has offset 0"):
        ROACH.replace(touchdown="ground", offset=0.5)


def test_an_animal_with_all_rules_survives_a_file() -> None:
    other = ROACH.replace(damping=0.01, stance=(1, 0.5, 0.7), length_law="l0 - ldev*cos(pi*t)", touchdown="ground")
    assert Animal(**json.loads(other.model_dump_json())) == other


@pytest.mark.parametrize("change", [{"stiffness": 2.0}, {"angle": 2.0}, {"offset": 0.0}, {"damping": 0.1}])
def test_legs_that_are_no_mirror_images(change: dict[str, float]) -> None:
    odd = ROACH.replace(legs=mirrored_wrongly(**change))
    assert ROACH.mirrored and ROACH.odd_pair is None
    assert not odd.mirrored and odd.odd_pair == "B"


def test_a_desired_speed_is_for_the_same_slopes_as_before() -> None:
    climber = load_animal("climbing_template").replace(desired_speed=4.0)
    assert (climber.speed_law.level, climber.speed_law.domain_deg) == (4.0, (90.0, 90.0))
    assert cockroach().replace(desired_speed=0.2).desired_speed(1.0) == 0.2
