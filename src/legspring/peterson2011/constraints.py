"""The thesis's constraints of an optimised gait, and their prices."""

import math

from legspring.constraints import Constraint, Constraints, Price

LEAST, MOST = 0.2, 0.9

TABLE_3_1 = Constraints(
    actuation=(LEAST, MOST),
    phase=(-math.pi / 2, math.pi / 3),
    angle=10.0,
    beside=(0.05, 0.0025),
    digits=10.0,
    prices={
        Constraint.FIXED_POINT: Price(2.0, 2.0),
        Constraint.FIXED_POINT_BESIDE: Price(0.5, 0.5),
        Constraint.PHASE_LATEST: Price(0.0, 0.5, math.pi / 6),
        Constraint.PHASE_EARLIEST: Price(0.5, 0.5, math.pi / 6),
        Constraint.ANGLE_TOUCHDOWN: Price(0.0, 0.05),
        Constraint.ANGLE_LIFTOFF: Price(0.0, 0.05),
        Constraint.ACTUATION_LEAST: Price(30.0, 1.0, LEAST),
        Constraint.ACTUATION_MOST: Price(30.0, 1.0, 1.0 - MOST),
    },
)
"""Section 3.5, Table 3.1."""
