from math import pi, radians
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from legspring.model import Leg, ModelError

FIELDS: dict[str, Any] = {
    "name": "L",
    "pair": "P",
    "hip": (-0.01, 0.02),
    "length": 0.03,
    "stiffness": 1.5,
    "angle": 0.4,
    "actuation": 0.01,
    "offset": 0.0,
}


def leg(**changes: Any) -> Leg:
    return Leg(**FIELDS | changes)


def test_ldev_is_negative_in_a_leg_that_pushes() -> None:
    assert leg().ldev == -0.01
    assert leg(function="pull").ldev == 0.01


def test_angle_in_degrees() -> None:
    others = {name: value for name, value in FIELDS.items() if name != "angle"}
    assert Leg(**others | {"angle_deg": -55}).angle == radians(-55)
    with pytest.raises(ModelError, match="angle and angle_deg are both given"):
        leg(angle_deg=25)
    for bad in ("25", None, True, 10**400):
        with pytest.raises(ModelError, match="angle_deg = "):
            Leg(**others | {"angle_deg": bad})


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("name", "", "must have at least 1 character"),
        ("hip", (0.0,), r"\[1\] is missing"),
        ("hip", (0.0, float("nan")), r"\[1\] = nan: must be a finite number"),
        ("length", 0.0, "must be greater than 0"),
        ("stiffness", -1.5, "must be greater than 0"),
        ("angle", 25.0, "must be between -pi and pi rad"),
        ("actuation", -0.01, "must be greater than or equal to 0"),
        ("actuation", 0.03, "must be less than the length, 0.03 m"),
        ("function", "kick", "must be 'push' or 'pull'"),
        ("offset", 2.0, "must be less than 2"),
        ("touchdown", "soon", "must be 'clock', 'ground' or 'lift-off'"),
        ("touchdown", "lift-off", "must be given together"),
        ("follows", "R", "must be given together"),
        ("stance", 0.0, "must be greater than 0"),
        ("damping", -1.0, "must be greater than or equal to 0"),
    ],
)
def test_a_bad_value_is_named_with_what_would_be_valid(field: str, value: object, message: str) -> None:
    with pytest.raises(ModelError, match=rf"^Leg .*{field}.*{message}") as caught:
        leg(**{field: value})
    assert "\n" not in str(caught.value)


def test_the_mirror_image_is_on_the_other_side_a_step_later() -> None:
    image = leg().mirrored("R")
    assert image == leg(name="R", hip=(0.01, 0.02), angle=-0.4, offset=1.0)


def test_a_leg_in_the_plane_of_symmetry_keeps_its_positive_zeros() -> None:
    image = leg(hip=(0.0, 0.0), angle=0.0).mirrored("R")
    assert "-0.0" not in repr(image)


@given(
    angle=st.floats(-pi, pi),
    dx=st.floats(-1.0, 1.0),
    offset=st.floats(0.0, 2.0, exclude_max=True),
    function=st.sampled_from(["push", "pull"]),
)
def test_mirrored_twice_is_the_leg_again(angle: float, dx: float, offset: float, function: str) -> None:
    original = leg(angle=angle, hip=(dx, 0.0), offset=offset, function=function)
    image = original.mirrored("R")
    assert image.is_mirror_image_of(original)
    assert original.is_mirror_image_of(image)
    twice = image.mirrored("L")
    assert (twice.angle, twice.hip) == (angle, (dx, 0.0))


def test_a_leg_that_follows_its_image_is_followed_by_it() -> None:
    left = leg(touchdown="lift-off", follows="R")
    right = left.mirrored("R")
    assert (right.follows, right.touchdown) == ("L", "lift-off")
    assert right.is_mirror_image_of(left)
    assert leg(touchdown="lift-off", follows="X").mirrored("R", {"X": "Y"}).follows == "Y"
    with pytest.raises(ModelError, match="follows = 'L': must be another leg"):
        leg(touchdown="lift-off", follows="L")


def test_a_leg_is_not_its_own_mirror_image() -> None:
    assert not leg().is_mirror_image_of(leg())
    assert not leg(function="pull").mirrored("R").is_mirror_image_of(leg())
