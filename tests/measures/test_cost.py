"""Transport cost."""

import math

import numpy as np
import pytest

from legspring.measures.cost import transport_cost
from tests.conftest import Cells


def test_work_of_the_legs_lifts_the_body(thesis_map: Cells) -> None:
    # In a gait the body's kinetic energy returns, so that legs and gravity balance over a step (Eq. 4.1).
    for (slope, _), gaits in thesis_map.items():
        for gait in gaits:
            assert np.sum(gait.work) == pytest.approx(math.sin(math.radians(slope)), abs=2e-9)
            assert gait.transport_cost >= math.sin(math.radians(slope)) - 1e-9


def test_weights(thesis_map: Cells) -> None:
    gait = thesis_map[0, 0.15][0]
    positive, negative = transport_cost(gait.work, b2=0.0), transport_cost(gait.work, b1=0.0)
    assert positive == pytest.approx(np.sum(gait.work[:, 0]))
    assert negative == pytest.approx(-np.sum(gait.work[:, 1]))
    assert positive + negative == pytest.approx(gait.transport_cost)
    assert positive == pytest.approx(negative, abs=1e-9)
    assert negative > 0.1
