"""When legs are down: duty factors and phase lags."""

import math

import numpy as np

from legspring.kernel.walker import TOUCHDOWN, Floats, Tape
from legspring.layout import System
from legspring.returnmap import step_ends

SAME = 1e-9
"""Share of a stride below which two touch-downs are at one time."""


def duty_factor(tape: Tape) -> Floats:
    """Share of a tape's time in which each leg is in stance.

    What counts is that a leg is down, whenever it was put down: before the tape begins, or anew while still down.

    Returns
    -------
    ndarray
        ``(L,)``, from 0 to 1.
    """
    steps = int(tape.counts[0])
    time = tape.time[: steps + 1]
    share: Floats = np.diff(time) @ tape.down[:steps] / (time[-1] - time[0])
    return share


def phase_lag(system: System, tape: Tape) -> Floats:
    """Time of each leg's first touch-down on a tape after that of the first leg, as a share of the tape's time.

    Returns
    -------
    ndarray
        ``(L,)``, from 0 to below 1; nan for a leg that is not put down.
    """
    # Legs of offset 0 are put down as the tape begins, which is no event on it.
    first = np.where(system.offset == 0.0, 0.0, math.nan)
    for time, leg, kind in tape.events[: tape.counts[1], :3]:
        if kind == TOUCHDOWN and math.isnan(first[int(leg)]):
            first[int(leg)] = time
    lag = (first - first[0]) / step_ends(system, tape)[-1] % 1.0
    return np.where(1.0 - lag < SAME, 0.0, lag)
