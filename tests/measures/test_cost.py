"""Transport cost."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import legspring as ls
from tests.conftest import Cells


def test_work_of_the_legs_lifts_the_body(thesis_map: Cells) -> None:
    # In a gait the body's kinetic energy returns, so that legs and gravity balance over a step (Eq. 4.1).
    for (slope, _), gaits in thesis_map.items():
        for gait in gaits:
            assert np.sum(gait.work) == pytest.approx(math.sin(math.radians(slope)), abs=2e-9)
            assert gait.transport_cost >= math.sin(math.radians(slope)) - 1e-9


def test_weights(thesis_map: Cells) -> None:
    gait = thesis_map[0, 0.15][0]

    def cost(b1: float, b2: float) -> float:
        return replace(gait, animal=gait.animal.replace(work_weights=(b1, b2))).transport_cost

    assert cost(1.0, 0.0) == pytest.approx(np.sum(gait.work[:, 0]))
    assert cost(0.0, 1.0) == pytest.approx(-np.sum(gait.work[:, 1]))
    assert cost(4.0, 0.25) == pytest.approx(4.0 * cost(1.0, 0.0) + 0.25 * cost(0.0, 1.0))
    assert cost(1.0, 1.0) == gait.transport_cost > 0.2
    # On the level, positive and negative work are the same.
    assert cost(1.0, 0.0) == pytest.approx(cost(0.0, 1.0), abs=1e-9)


@pytest.mark.parametrize("weights", [(-1.0, 1.0), (1.0,), (1.0, math.nan), "1,1"])
def test_weights_that_are_none(roach: ls.Animal, weights: Any) -> None:
    with pytest.raises(ls.ModelError, match="work_weights"):
        roach.replace(work_weights=weights)


def test_optimal_gaits_cost_what_their_work_weighs(roach: ls.Animal) -> None:
    heavy = roach.replace(work_weights=(2.0, 0.5))
    best = ls.optimize(heavy, slope_deg=45, heading=0.15, family="B", objective="efficiency")
    assert best is not None
    # No leg of it does negative work.
    assert best.value == pytest.approx(2.0 * math.sin(math.radians(45)), abs=1e-3)
    assert best.transport_cost == pytest.approx(best.value)
