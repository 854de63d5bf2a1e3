"""Peak forces of legs, and of all legs together."""

import numpy as np
from numpy.typing import NDArray

from legspring.flow import Flow
from legspring.kernel.measure import ALL_LEGS, largest_force

LATERAL, FORE_AFT, MAGNITUDE = 0, 1, 2


def peak_force(run: Flow, leg: int) -> NDArray[np.float64]:
    """Lateral and fore-aft force of largest magnitude of a leg on the body, with its sign, in units of m g.

    Returns
    -------
    ndarray
        ``(2,)``.
    """
    peaks, end = np.zeros(2), run.step_ends[-1]
    for axis in (LATERAL, FORE_AFT):
        high = largest_force(run.tape, leg, axis, 1.0, 0.0, end)
        low = largest_force(run.tape, leg, axis, -1.0, 0.0, end)
        peaks[axis] = (high if high >= low else -low) / run.weight
    return peaks


def peak_magnitude(run: Flow, leg: int) -> float:
    """Largest magnitude of a leg's force in a simulation, in units of m g."""
    return largest_force(run.tape, leg, MAGNITUDE, 1.0, 0.0, run.step_ends[-1]) / run.weight


def net_force(run: Flow, *, steps: int = 1) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Largest and smallest sum of the legs' forces (lateral, fore-aft) over the first steps, in units of m g."""
    end = run.step_ends[steps]
    high = [largest_force(run.tape, ALL_LEGS, axis, 1.0, 0.0, end) for axis in (LATERAL, FORE_AFT)]
    low = [0.0 - largest_force(run.tape, ALL_LEGS, axis, -1.0, 0.0, end) for axis in (LATERAL, FORE_AFT)]
    return np.array(high) / run.weight, np.array(low) / run.weight
