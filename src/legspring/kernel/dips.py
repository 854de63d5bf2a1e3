"""How near to zero a leg's gap comes without reaching it: its force in stance, or the height of its foot in swing."""

import math

from legspring.kernel.dop853 import interpolate
from legspring.kernel.events import WINDOW
from legspring.kernel.jit import driver, jit
from legspring.kernel.length import phase_at
from legspring.kernel.measure import GOLDEN, SAMPLES, step_span
from legspring.kernel.motion import height_rates, leg_force, turn
from legspring.kernel.walker import BEGUN, CLOCK, GROUND, TRIGGER, Tape, Walker


@jit
def gap_at(tape: Tape, n: int, x: float, i: int, w: Walker) -> float:
    """Return the size of leg i's force (per mass), or the height of its foot, at the fraction x of step n."""
    y = w.room
    interpolate(tape.y[n], tape.dense[n], x, y)
    s = tape.time[n] + x * tape.size[n]
    if tape.down[n, i] != 0.0:
        return abs(leg_force(s, y, tape.stance[n], i, turn(y), phase_at(s))[5])
    return height_rates(y, y, w.contacts, i, turn(y))[0]


@jit
def is_watched(tape: Tape, n: int, i: int, w: Walker) -> bool:
    """Whether what leg i's gap does in step n decides on what it does next."""
    if tape.down[n, i] == 0.0:
        return w.legs[i, TRIGGER, 0] == GROUND
    ignored = WINDOW if w.legs[i, TRIGGER, 0] == CLOCK else 0.0
    return tape.time[n] >= tape.stance[n, i, BEGUN, 0] + ignored


@jit
def bottom(tape: Tape, n: int, x: float, i: int, w: Walker) -> float:
    """Return the least gap of leg i near the fraction x of step n (golden section)."""
    a, b = max(x - 1.0 / SAMPLES, 0.0), min(x + 1.0 / SAMPLES, step_span(tape, n))
    for _ in range(40):
        c, d = b - GOLDEN * (b - a), a + GOLDEN * (b - a)
        if gap_at(tape, n, c, i, w) < gap_at(tape, n, d, i, w):
            b = d
        else:
            a = c
    return gap_at(tape, n, 0.5 * (a + b), i, w)


@driver
def least_dip(w: Walker, tape: Tape, i: int, down: float) -> float:
    """Return the least of the minima of leg i's force in stance (``down`` 1), or of the height of its foot (0).

    Parameters
    ----------
    w, tape
        What was simulated, and by whom.
    i, down
        Which leg; whether its stances are meant.

    Returns
    -------
    float
        In m per step duration squared, or m; nan where there is no such minimum.
    """
    least, before, falls, step, where = math.nan, math.inf, False, 0, 0.0
    for n in range(tape.counts[0]):
        if tape.down[n, i] != down or not is_watched(tape, n, i, w):
            before, falls = math.inf, False
            continue
        for sample in range(SAMPLES + 1):
            x = step_span(tape, n) * sample / SAMPLES
            here = gap_at(tape, n, x, i, w)
            if falls and here > before:
                found = min(bottom(tape, step, where, i, w), bottom(tape, n, x, i, w))
                if found > 0.0 and not found >= least:
                    least = found
            if here != before:
                falls, step, where = here < before < math.inf, n, x
            before = here
    return least
