from typing import Any

import pytest

from legspring.model import Body, ModelError


def test_a_point_mass_needs_only_a_mass() -> None:
    body = Body(mass=2.5e-3)
    assert (body.mass, body.inertia, body.yaw) == (2.5e-3, None, "held")


def test_free_yaw_needs_inertia() -> None:
    assert Body(mass=1.0, inertia=0.1, yaw="free").yaw == "free"
    with pytest.raises(ModelError, match="yaw = 'free' needs an inertia"):
        Body(mass=1.0, yaw="free")


@pytest.mark.parametrize("mass", [0.0, -1.0, float("nan"), float("inf"), True, "0.1", None, 10**400])
def test_mass_is_a_positive_finite_number(mass: Any) -> None:
    with pytest.raises(ModelError, match=r"^Body: mass = .*: must be") as caught:
        Body(mass=mass)
    assert "\n" not in str(caught.value)


def test_all_that_is_wrong_is_named_in_one_line() -> None:
    fields: dict[str, Any] = {"inertia": -1.0, "weight": 2.0}
    with pytest.raises(ModelError) as caught:
        Body(**fields)
    assert str(caught.value) == (
        "Body: mass is missing; inertia = -1.0: must be greater than 0; "
        "weight is unknown: must be among mass, inertia, yaw"
    )


def test_bodies_are_equal_and_hashed_by_value() -> None:
    assert {Body(mass=1.0), Body(mass=1), Body(mass=1.0, yaw="held")} == {Body(mass=1.0)}
