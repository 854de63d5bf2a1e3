"""Table 3.1."""

import numpy as np
import pytest

from legspring.constraints import LIMITS, Constraint
from legspring.kernel.walker import Floats
from legspring.peterson2011.constraints import TABLE_3_1

CLEAR = np.full((3, 2), 20.0)


def amounts(u: Floats, phases: Floats, angles: Floats) -> dict[tuple[Constraint, int], float]:
    """Return the penalties, by constraint and pair."""
    found = TABLE_3_1.penalties(TABLE_3_1.excess(u, phases, angles, signed=False))
    return {(LIMITS[rule], pair): found[pair, rule] for pair, rule in np.argwhere(found > 0.0).tolist()}


def test_penalties() -> None:
    half, none = np.full(3, 0.5), np.zeros(3)
    assert amounts(half, none, CLEAR) == {}
    assert amounts(np.array([0.1, 0.95, 0.5]), none, CLEAR) == pytest.approx(
        {(Constraint.ACTUATION_LEAST, 0): 30.5, (Constraint.ACTUATION_MOST, 1): 30.5}
    )
    assert amounts(half, np.radians([75.0, 59.9, -120.0]), CLEAR) == pytest.approx(
        {(Constraint.PHASE_LATEST, 0): 0.25, (Constraint.PHASE_EARLIEST, 2): 1.0}
    )
    assert amounts(half, none, np.array([[10.1, -9], [-20, 20], [-1, 20]])) == pytest.approx(
        {(Constraint.ANGLE_LIFTOFF, 0): 0.05, (Constraint.ANGLE_TOUCHDOWN, 2): 0.45}
    )


def test_distance_from_a_fixed_point() -> None:
    for squares, far in ((1e-12, 0.0), (0.0, 0.0), (1e-8, 2.0)):
        assert TABLE_3_1.missing(Constraint.FIXED_POINT, squares) == pytest.approx(2.0 + 2.0 * far)
        assert TABLE_3_1.missing(Constraint.FIXED_POINT_BESIDE, squares) == pytest.approx(0.5 + 0.5 * far)


def test_heading_beside() -> None:
    assert [TABLE_3_1.heading_beside(heading) for heading in (0.02, -0.02, 0.0, 0.15, -0.4)] == pytest.approx(
        [0.0225, -0.0225, 0.0025, 0.1575, -0.42]
    )
