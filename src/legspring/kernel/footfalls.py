"""What each leg does in some steps, for many rows of parameters: when it stands, and how it begins and ends."""

import math

import numpy as np

from legspring.kernel.contact import fill
from legspring.kernel.dop853 import interpolate
from legspring.kernel.jit import driver, formula, jit
from legspring.kernel.launch import launch
from legspring.kernel.length import Pair, law, phase_at
from legspring.kernel.many import take_step
from legspring.kernel.measure import rates_of, step_span, write_work
from legspring.kernel.motion import turn
from legspring.kernel.pack import MASS, STEP_DURATION, pack_directions
from legspring.kernel.walker import (
    BEGUN,
    DAMPED,
    DOWN,
    EVALUATIONS,
    FOOT_X,
    FOOT_Y,
    LIFTOFF,
    MANNER,
    OK,
    SIDE,
    TAPE_FULL,
    TIME,
    VY,
    YAW_RATE,
    Floats,
    Ints,
    Tape,
    Walker,
    X,
    Y,
)

TOUCH, STANCE, LEAVING, PEAK, STARTING, OLD, OVER, LANDING = range(8)
"""Of each leg: time of its first touch-down, time from there to lift-off, rate of its gap then, largest force by the
mass, rate of its gap right after touch-down (> 0 where that makes its force what it should be), whether it is down at
the start, whether it turned over, rate at which its foot came down, held ready. Times in step durations; nan for what
does not happen."""
N_FOOTFALL = 8
LOOKS = 4
"""Looks at the forces in each step of the integrator."""


def blank_footfalls(count: int, legs: int) -> Floats:
    """Return room for what so many simulations tell of so many legs: ``(N, L, 8)``."""
    return np.full((count, legs, N_FOOTFALL), math.nan)


@formula
def read_events(tape: Tape, lands: Floats, end: float, out: Floats) -> None:
    """Write when legs are put down and how long they stand; what lifts off first was put down a stride before."""
    for i in range(out.shape[0]):
        out[i, TOUCH] = 0.0 if lands[i] != 0.0 else math.nan
    for n in range(tape.counts[1]):
        i = int(tape.events[n, 1])
        if tape.events[n, 2] != LIFTOFF and not out[i, TOUCH] >= 0.0:
            out[i, TOUCH] = tape.events[n, 0]
    for n in range(tape.counts[1]):
        i, time = int(tape.events[n, 1]), tape.events[n, 0]
        if tape.events[n, 2] == LIFTOFF and 0.0 < time <= end:
            lasts = (time - out[i, TOUCH]) % end
            if lasts == 0.0:
                lasts = end
            if not out[i, STANCE] <= lasts:
                out[i, STANCE], out[i, LEAVING] = lasts, tape.events[n, 4]


@jit
def read_legs(tape: Tape, w: Walker, lands: Floats, out: Floats) -> None:
    """Write how forces begin, how large they get, and whether legs turn over."""
    y = w.room
    out[:, PEAK], out[:, OVER] = 0.0, 0.0
    for n in range(tape.counts[0]):
        for look in range(LOOKS + 1):
            share = step_span(tape, n) * look / LOOKS
            interpolate(tape.y[n], tape.dense[n], share, y)
            s = tape.time[n] + share * tape.size[n]
            lean, phase = turn(y), phase_at(s)
            for i in range(out.shape[0]):
                if tape.down[n, i] == 0.0:
                    continue
                force, rate = rates_of(tape, n, s, i, lean, phase, y)
                out[i, PEAK] = max(out[i, PEAK], abs(force))
                if look == 0:
                    read_leg(tape, w, lands, n, i, s, rate, phase, out)


@jit
def read_leg(
    tape: Tape, w: Walker, lands: Floats, n: int, i: int, s: float, rate: float, phase: Pair, out: Floats
) -> None:
    """Write whether a leg turns over at the beginning of a step of the integrator, and how it begins if it does."""
    y = w.room
    x, h = tape.stance[n, i, FOOT_X, 0] - tape.y[n, X, 0], tape.stance[n, i, FOOT_Y, 0] - tape.y[n, Y, 0]
    if n > 0 and tape.down[n - 1, i] != 0.0:
        old_x = tape.stance[n - 1, i, FOOT_X, 0] - tape.y[n - 1, X, 0]
        old_y = tape.stance[n - 1, i, FOOT_Y, 0] - tape.y[n - 1, Y, 0]
        if x * old_x + h * old_y < 0.0:
            out[i, OVER] = 1.0
    if s != tape.stance[n, i, BEGUN, 0] or (n == 0 and lands[i] == 0.0):
        return
    if not abs(out[i, LANDING]) >= 0.0:
        # The foot is held where it is as seen from the body, which turns about its centre.
        spin = y[YAW_RATE, 0] if y.shape[0] == 6 else 0.0
        out[i, LANDING] = y[VY, 0] + spin * x
    if tape.stance[n, i, MANNER, 0] != DAMPED and not abs(out[i, STARTING]) >= 0.0:
        out[i, STARTING] = w.contacts[i, SIDE] * (rate - law(s, tape.stance[n], i, phase)[1])


@driver
def footfalls(
    w: Walker,
    tape: Tape,
    p: Floats,
    steps: int,
    scale: float,
    lands: Floats,
    status: Ints,
    times: Floats,
    out: Floats,
    work: Floats,
) -> None:
    """Simulate so many steps from each row of parameters, and see what each leg does.

    Parameters
    ----------
    w, tape
        Room to work in; a simulation that needs more is given up with ``TAPE_FULL``.
    p
        ``(N, n)``.
    steps, scale
        See `legspring.kernel.many.many`.
    lands
        ``(L,)``: which legs are put down as the first step begins.
    status, times
        ``(N,)``: filled with how it went, and how long it took.
    out
        ``(N, L, 8)``: filled, where it was nan.
    work
        ``(N, L, 2)``: positive and negative work of each leg in the first step, J; or none, for no work.
    """
    none = p[:0]
    pack_directions(none, w)
    for row in range(p.shape[0]):
        tape.counts[0] = tape.counts[1] = 0
        w.clock[EVALUATIONS] = 0.0
        fill(out[row], math.nan)
        launch(p[row], none, w)
        for i in range(out.shape[1]):
            out[row, i, OLD] = w.contacts[i, DOWN]
        status[row], first = OK, 0.0
        for step in range(1, steps + 1):
            status[row] = take_step(w, step, float(steps), scale, tape)
            if status[row] != OK:
                break
            if step == 1:
                first = w.clock[TIME]
        times[row] = w.clock[TIME]
        if status[row] == OK and tape.counts[1] <= tape.events.shape[0]:
            read_events(tape, lands, w.clock[TIME], out[row])
            read_legs(tape, w, lands, out[row])
            if work.shape[0] > 0:
                write_work(tape, 0.0, first, w.room, w.struts, work[row])
                work[row] *= p[row, MASS] / p[row, STEP_DURATION] ** 2
        elif status[row] == OK:
            status[row] = TAPE_FULL
