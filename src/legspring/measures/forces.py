"""Peak forces of legs, and of all legs together."""

import numpy as np
from numpy.typing import NDArray

from legspring.kernel.measure import ALL_LEGS, largest_force
from legspring.kernel.walker import Tape
from legspring.layout import System
from legspring.returnmap import step_ends

LATERAL, FORE_AFT, MAGNITUDE = 0, 1, 2


def peak_force(system: System, tape: Tape, leg: int) -> NDArray[np.float64]:
    """Lateral and fore-aft force of a leg on the body of largest magnitude on a tape, with its sign, in units of m g.

    Returns
    -------
    ndarray
        ``(2,)``.
    """
    peaks, end = np.zeros(2), step_ends(system, tape)[-1]
    for axis in (LATERAL, FORE_AFT):
        high = largest_force(tape, leg, axis, 1.0, 0.0, end)
        low = largest_force(tape, leg, axis, -1.0, 0.0, end)
        peaks[axis] = (high if high >= low else -low) / system.weight
    return peaks


def peak_magnitude(system: System, tape: Tape, leg: int) -> float:
    """Largest magnitude of a leg's force on a tape, in units of m g."""
    return largest_force(tape, leg, MAGNITUDE, 1.0, 0.0, step_ends(system, tape)[-1]) / system.weight


def net_force(system: System, tape: Tape, *, steps: int = 1) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Largest and smallest sum of the legs' forces (lateral, fore-aft) over the first steps, in units of m g."""
    end = step_ends(system, tape)[steps]
    high = [largest_force(tape, ALL_LEGS, axis, 1.0, 0.0, end) for axis in (LATERAL, FORE_AFT)]
    low = [0.0 - largest_force(tape, ALL_LEGS, axis, -1.0, 0.0, end) for axis in (LATERAL, FORE_AFT)]
    return np.array(high) / system.weight, np.array(low) / system.weight
