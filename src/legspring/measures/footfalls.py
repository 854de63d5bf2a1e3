"""When legs are put down."""

import math

import numpy as np

from legspring.flow import Flow
from legspring.kernel.walker import Floats

SAME = 1e-9
"""Share of a stride below which two touch-downs are at one time."""


def phase_lag(run: Flow) -> Floats:
    """Time of each leg's first touch-down in a recorded stride after that of the first leg, as a share of its time.

    Returns
    -------
    ndarray
        ``(L,)``, from 0 to below 1; nan for a leg that is not put down.
    """
    first = touchdowns(run)
    lag = (first - first[0]) / run.times[-1] % 1.0
    return np.where(1.0 - lag < SAME, 0.0, lag)


def touchdowns(run: Flow) -> Floats:
    """Time of each leg's first touch-down in a recorded stride, s: ``(L,)``, nan for a leg that is not put down."""
    # What is put down as the stride begins is no event of it.
    first, events = np.where(run.system.lands, 0.0, math.nan), run.events
    for time, leg, lifts in zip(events.time, events.leg, events.lifts, strict=True):
        if not lifts and math.isnan(first[leg]):
            first[leg] = time
    return first
