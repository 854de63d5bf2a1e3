"""Dynamic similarity: gaits of another size are the same gaits."""

import math
from typing import Any

import numpy as np
import pytest

import legspring as ls
from tests.places import place_of

LENGTH, MASS = 4.0, 50.0
each = pytest.mark.parametrize("name", ls.presets())


@each
def test_gaits_of_another_size_are_the_same(name: str) -> None:
    animal = ls.load_animal(name)
    large = animal.scale(length=LENGTH, mass=MASS)
    time = math.sqrt(LENGTH)
    ours, others = (ls.find_gaits(one, **place_of(animal)) for one in (animal, large))
    assert len(ours) == len(others) > 0
    for gait, other in zip(ours[:2], others[:2], strict=True):
        assert other.speed == pytest.approx(time * gait.speed, rel=1e-7)
        assert other.step_duration == pytest.approx(time * gait.step_duration, rel=1e-8)
        assert np.allclose(other.phase, gait.phase, atol=1e-7)
        assert np.allclose(np.abs(other.multipliers), np.abs(gait.multipliers), atol=1e-5)
        assert other.energy == pytest.approx(MASS * LENGTH * gait.energy, rel=1e-6)
        assert np.allclose(other.peak_force, gait.peak_force, atol=1e-6)
        if "transport_cost" not in gait.missing:
            assert other.transport_cost == pytest.approx(gait.transport_cost, rel=1e-6, abs=1e-8)


def test_back_to_the_size_it_had() -> None:
    for name in ls.presets():
        animal = ls.load_animal(name)
        again = animal.scale(length=4.0, mass=8.0).scale(length=0.25, mass=0.125)
        for before, after in zip(animal.legs, again.legs, strict=True):
            for field in ("length", "stiffness", "actuation", "damping"):
                assert getattr(after, field) == pytest.approx(getattr(before, field), rel=1e-12)
        assert again.desired_speed(0.0 if animal.sagittal else math.radians(animal.speed_law.domain_deg[0])) > 0.0


def test_formulas_are_scaled_with_their_numbers() -> None:
    leg = ls.cockroach().replace(length_law="0.004 + l0 - 0.002*sin(pi*t + phi)*ldev/0.016")
    large = leg.scale(length=2.0)
    start: dict[str, Any] = {"slope_deg": 10, "heading": 0.15, "phase": (0.7, 0.9, -0.5), "family": "A", "strides": 0.5}
    small, big = (
        ls.simulate(one, speed=speed, **start) for one, speed in ((leg, 0.35), (large, 0.35 * math.sqrt(2.0)))
    )
    np.testing.assert_allclose(big["position"], 2.0 * small["position"], atol=1e-9)


@pytest.mark.parametrize("factor", [0.0, -1.0, math.nan, math.inf, "2", True])
def test_factors_that_are_none(factor: Any) -> None:
    with pytest.raises(ls.ModelError, match=r"length = .*: must be (a (finite )?number|greater than 0)"):
        ls.cockroach().scale(length=factor)
