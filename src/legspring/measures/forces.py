"""Peak forces of legs, and of all legs together."""

import numpy as np
from numpy.typing import NDArray

from legspring.kernel.measure import ALL_LEGS, largest_force
from legspring.kernel.walker import Tape
from legspring.setting import Setting

LATERAL, FORE_AFT, MAGNITUDE = 0, 1, 2


def peak_force(setting: Setting, tape: Tape, leg: int, *, steps: int = 2) -> NDArray[np.float64]:
    """Lateral and fore-aft force of a leg on the body of largest magnitude, with its sign, in units of m g.

    Returns
    -------
    ndarray
        ``(2,)``.
    """
    peaks = np.zeros(2)
    for axis in (LATERAL, FORE_AFT):
        high = largest_force(tape, leg, axis, 1.0, 0.0, float(steps))
        low = largest_force(tape, leg, axis, -1.0, 0.0, float(steps))
        peaks[axis] = (high if high >= low else -low) / setting.weight
    return peaks


def peak_magnitude(setting: Setting, tape: Tape, leg: int, *, steps: int = 2) -> float:
    """Largest magnitude of a leg's force, in units of m g."""
    return largest_force(tape, leg, MAGNITUDE, 1.0, 0.0, float(steps)) / setting.weight


def net_force(setting: Setting, tape: Tape, *, steps: int = 1) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Largest and smallest sum of the legs' forces (lateral, fore-aft) over the first steps, in units of m g."""
    high = [largest_force(tape, ALL_LEGS, axis, 1.0, 0.0, float(steps)) for axis in (LATERAL, FORE_AFT)]
    low = [-largest_force(tape, ALL_LEGS, axis, -1.0, 0.0, float(steps)) for axis in (LATERAL, FORE_AFT)]
    return np.array(high) / setting.weight, np.array(low) / setting.weight
