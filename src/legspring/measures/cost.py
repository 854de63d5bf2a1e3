"""Transport cost (Eqs. 3.5, 3.6)."""

import numpy as np
from numpy.typing import NDArray

from legspring.kernel.measure import leg_work
from legspring.kernel.walker import Tape
from legspring.layout import System
from legspring.returnmap import step_ends


def work_of_legs(system: System, tape: Tape, *, steps: int = 1) -> NDArray[np.float64]:
    """Positive and negative work of each leg on the body over the first steps, per m g and desired distance.

    Returns
    -------
    ndarray
        ``(L, 2)``, dimensionless; the second column is negative.
    """
    return leg_work(tape, 0.0, step_ends(system, tape)[steps]) / (system.weight * system.step_length * steps)


def transport_cost(work: NDArray[np.float64], *, b1: float = 1.0, b2: float = 1.0) -> float:
    """Weigh positive work (b1) and negative work (b2) into a transport cost (Eq. 3.5).

    With both weights 1 it is Eq. 3.6, whose least possible value is sin(slope) (Eq. 4.1).

    Parameters
    ----------
    work
        ``(L, 2)``, of `work_of_legs`.
    """
    return float(b1 * np.sum(work[:, 0]) - b2 * np.sum(work[:, 1]))
