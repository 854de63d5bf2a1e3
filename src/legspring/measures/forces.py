"""Peak forces of legs, and of all legs together; and the friction that their feet need."""

import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from legspring.flow import Flow
from legspring.kernel.measure import ALL_LEGS, largest_force

LATERAL, FORE_AFT, MAGNITUDE = 0, 1, 2
SHARES = np.array([1e-9, 0.25, 0.5, 0.75, 1.0 - 1e-9])
"""Places within a step of the integrator at which the direction of a leg is looked at."""
PULL = 1e-6
"""Force, in units of m g, from which on a leg pulls at the ground."""


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


def needed_friction(run: Flow) -> float:
    """Coefficient of friction that feet need in a simulation; nan where no friction would do.

    From the side each foot for itself, whose force has the direction of its leg. From above only all feet together: the
    largest force along the slope by the weight that presses them onto it.
    """
    system, tape = run.system, run.tape
    if not system.animal.sagittal:
        pressing = math.cos(system.slope)
        along = largest_force(tape, ALL_LEGS, MAGNITUDE, 1.0, 0.0, run.step_ends[-1]) / run.weight
        return along / pressing if pressing > PULL else math.nan
    count = int(tape.counts[0])
    size = np.diff(tape.time[: count + 1])
    times = (tape.time[:count, None] + SHARES * size[:, None]).ravel()
    index = np.repeat(np.arange(count), len(SHARES))
    seen = run.samples(times, index)
    if np.any(seen.down & (seen.force > PULL)):
        return math.nan
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = np.where(seen.down, np.abs(seen.legs[..., 0] / seen.legs[..., 1]), 0.0)
    sample, leg = np.unravel_index(int(np.argmax(ratios)), ratios.shape)
    step = index[sample : sample + 1]

    def ratio(time: float) -> float:
        x, y = run.samples(np.array([time]), step).legs[0, leg]
        return abs(float(x / y))

    first, last = times[index == step][[0, -1]]
    refined = minimize_scalar(lambda time: -ratio(time), bounds=(first, last), method="bounded")
    return max(float(ratios[sample, leg]), -float(refined.fun))
