"""The friction that feet need."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import legspring as ls
from legspring import Animal
from legspring.flow import Flow, Samples


def test_a_runner_needs_the_friction_of_its_angle_of_attack() -> None:
    """The leg is flattest as it touches down, and as it lifts off, by symmetry."""
    animal = ls.load_animal("spring_loaded_inverted_pendulum")
    for gait in ls.find_gaits(animal):
        assert gait.friction == pytest.approx(abs(math.tan(math.pi - animal.legs[0].angle)), rel=1e-6)


def test_feet_seen_from_above_share_the_weight(roach: Animal) -> None:
    for slope_deg in (0.0, 45.0):
        gait = ls.find_gaits(roach, slope_deg=slope_deg, heading=0.15)[0]
        net = np.hypot(*gait.simulate(1)["force"].sum("leg").values.T)
        assert gait.friction == pytest.approx(net.max() / math.cos(math.radians(slope_deg)), rel=1e-3)
        assert gait.friction >= net.max() / math.cos(math.radians(slope_deg)) - 1e-9
        # Whoever stays on a slope needs its tangent at least, in the mean.
        assert gait.friction > math.tan(math.radians(slope_deg))


def test_on_a_wall_no_friction_would_do(roach: Animal) -> None:
    gait = ls.find_gaits(roach, slope_deg=90, heading=0.0)[0]
    assert math.isnan(gait.friction) and gait.missing["friction"] == "nothing presses feet onto a wall"


def test_a_leg_that_pulls_at_the_ground_slips_on_any(monkeypatch: pytest.MonkeyPatch) -> None:
    (gait, *_) = ls.find_gaits(ls.load_animal("walker"))
    assert math.isfinite(gait.friction)
    own = Flow.samples

    def pulling(self: Flow, *arguments: Any) -> Samples:
        seen = own(self, *arguments)
        return seen._replace(force=-seen.force)

    monkeypatch.setattr(Flow, "samples", pulling)
    again = replace(gait)
    assert math.isnan(again.friction) and again.missing["friction"] == "a leg pulls at the ground"
