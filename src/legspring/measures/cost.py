"""Transport cost (Eqs. 3.5, 3.6)."""

import numpy as np

from legspring.flow import Flow
from legspring.kernel.measure import leg_work
from legspring.kernel.walker import Floats


def work_of_legs(run: Flow, *, steps: int = 1) -> Floats:
    """Positive and negative work of each leg on the body over the first steps, per m g and desired distance.

    Returns
    -------
    ndarray
        ``(L, 2)``, dimensionless; the second column is negative.
    """
    return leg_work(run.tape, 0.0, run.step_ends[steps]) / (run.weight * run.system.step_length * steps)


def weighed(work: Floats, weights: tuple[float, float]) -> Floats:
    """Weigh positive and negative work of all legs, ``(..., L, 2)``, by b1 and b2 (Eq. 3.5).

    With both weights 1 it is Eq. 3.6, whose least possible value is sin(slope) (Eq. 4.1).
    """
    b1, b2 = weights
    cost: Floats = np.sum(work, axis=-2) @ np.array([b1, -b2])
    return cost
