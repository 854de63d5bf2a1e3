"""The hybrid flow: steps of the integrator between touch-downs and lift-offs, by the clock or by an event."""

import math

import numba

from legspring.kernel.contact import clear, copy, go_by_clock, go_by_events, refresh, slide_derivatives
from legspring.kernel.dop853 import STAGES, all_rates, interpolant, step, step_tangents
from legspring.kernel.events import HERE, NONE, arm, next_event
from legspring.kernel.jit import formula, jit, shared
from legspring.kernel.motion import measure_gaps
from legspring.kernel.walker import (
    ARM_X,
    ARM_Y,
    CLOCK,
    DOWN,
    EVENT_DRIVEN,
    EVENT_LOST,
    FALLEN,
    FASTEST,
    GRAVITY,
    HEIGHT,
    LEVEL,
    NEXT_STEP,
    NO_TOUCHDOWN,
    OK,
    PUSH_X,
    PUSH_Y,
    SIDE_VIEW,
    SINCE,
    SLOWEST,
    STAY,
    STEP_TOO_SMALL,
    TAPE,
    TAPE_FULL,
    TIME,
    TOO_MANY_STEPS,
    TRIGGER,
    VY,
    WALKER,
    WATCHED,
    Floats,
    Tape,
    Walker,
    Y,
)

SMALLEST_STEP = 1e-13
"""Smallest step of the integrator, in the shortest of the motion's own times."""
MOST_STEPS = 1000
"""Steps in the longest of the motion's own times after which an integration gives up."""
MOST_TIMES = 5.0
"""Of these times, the most that count: a leg that waits for the ground may let the body turn on another for long."""
MOST_TRIES = 40
LONGEST_STEP = 50.0
"""Times, the longest of the motion's own, after which an animal with a leg down is given up if none touches down."""


@formula
def horizon(s: float, end: float, w: Walker) -> float:
    """Time up to which nothing changes by the clock."""
    for i in range(w.contacts.shape[0]):
        if w.legs[i, TRIGGER, 0] == CLOCK:
            end = min(end, w.contacts[i, SINCE] + 2.0)
        if w.legs[i, STAY, 0] != 0.0 and w.contacts[i, DOWN] != 0.0:
            end = min(end, w.contacts[i, SINCE] + w.legs[i, STAY, 0])
    for j in range(w.push.shape[0]):
        if w.push[j, 0] > s:
            end = min(end, w.push[j, 0])
    return end


@formula
def set_push(s: float, push: Floats, clock: Floats) -> None:
    """Set the coefficients of the outside acceleration that holds from s on."""
    for j in range(PUSH_X, PUSH_Y + 2):
        clock[j] = 0.0
    for j in range(push.shape[0] - 1):
        start, stop = push[j, 0], push[j + 1, 0]
        if start <= s < stop:
            for axis in range(2):
                slope = (push[j + 1, 1 + axis] - push[j, 1 + axis]) / (stop - start)
                clock[PUSH_X + 2 * axis] = push[j, 1 + axis] - slope * start
                clock[PUSH_X + 2 * axis + 1] = slope


@jit
def move_end(s: float, shift: float, w: Walker) -> None:
    """Move the end of a step, ``ahead`` at time s, by a tiny time (Heun), and make it the present."""
    slide(w.ahead, shift, w.k[12], w.k[12], w.y)
    all_rates(s + shift, w.y, w, STAGES + 1)
    slide(w.ahead, shift, w.k[12], w.k[13], w.y)


@formula
def slide(y: Floats, shift: float, f: Floats, g: Floats, out: Floats) -> None:
    """Write y + shift (f + g) / 2 into ``out``."""
    for row in range(y.shape[0]):
        for d in range(y.shape[1]):
            out[row, d] = y[row, d] + 0.5 * shift * (f[row, d] + g[row, d])


@formula
def record_step(s: float, h: float, w: Walker, tape: Tape) -> bool:
    """Note a step that is about to be accepted; False if the tape is full."""
    n = tape.counts[0]
    if tape.size.size == 0:
        return True
    if n == tape.size.size:
        return False
    tape.time[n], tape.size[n] = s, h
    copy(w.y, tape.y[n])
    copy(w.stance, tape.stance[n])
    copy(w.contacts[:, DOWN], tape.down[n])
    interpolant(s, h, w, tape.dense[n])
    tape.counts[0] += 1
    return True


@formula
def try_steps(s: float, h: float, bound: float, w: Walker, scale: float) -> tuple[int, float, float, int]:
    """Try steps until one is accurate and has no event before its end.

    Returns
    -------
    status, size, shift, leg
        How it went, the step's size, the time by which to move its end onto an event, and whose (-1: nobody's).
    """
    for _ in range(MOST_TRIES):
        error = step(s, h, w) / scale
        # The eighth root by what takes no call.
        factor = 0.9 / math.sqrt(math.sqrt(math.sqrt(error)))
        if not error <= 1.0:
            h *= max(0.1, factor) if error < math.inf else 0.1
            w.clock[NEXT_STEP] = h
            if h < SMALLEST_STEP * w.clock[FASTEST]:
                return STEP_TOO_SMALL, h, 0.0, -1
            continue
        w.clock[NEXT_STEP] = max(w.clock[NEXT_STEP], h * min(5.0, factor))
        measure_gaps(s + h, w.ahead, w.k[12], w.stance, w.contacts, w.clock, w.gaps[1])
        kind, where, leg = next_event(s, h, w.contacts, w.gaps, w.clock[FASTEST])
        if kind == NONE or (kind == HERE and s + h + where > bound):
            return OK, h, 0.0, -1
        if kind == HERE:
            return OK, h, where, leg
        h *= where
    return EVENT_LOST, h, 0.0, -1


@formula
def accept(s: float, h: float, shift: float, w: Walker) -> float:
    """Make the end of the step tried last the present; return its time."""
    arm(s, h, w.contacts, w.gaps)
    if shift != 0.0:
        move_end(s + h, shift, w)
        refresh(s + h + shift, w)
    else:
        copy(w.flat_ahead, w.flat_y)
        copy(w.flat_k[12], w.flat_k[0])
        if w.y.shape[1] > 1:
            copy(w.struts[12], w.struts[0])
        copy(w.gaps[1], w.gaps[0])
    return s + h + shift


@formula
def resume(w: Walker) -> None:
    """Take the derivatives to where the motion goes on: at a fixed time, after touch-downs that end a step."""
    for row in range(w.y.shape[0]):
        for d in range(1, w.y.shape[1]):
            w.y[row, d] += w.late[row, d]
    if w.clock[EVENT_DRIVEN] != 0.0 and w.clock[TIME] > 0.0:
        slide_derivatives(w.lag, -1.0, w)
        for d in range(w.lag.size):
            w.lag[d] = 0.0


@formula
def time_to_fall(w: Walker) -> float:
    """Longest time after which a foot held ready has come to the ground if all legs are in the air; inf if never."""
    g, lowest, waits = w.body[GRAVITY, 0], math.inf, False
    for i in range(w.contacts.shape[0]):
        if w.contacts[i, DOWN] != 0.0:
            return 0.0
        if w.contacts[i, WATCHED] == HEIGHT:
            waits = True
            # A foot that turns with the body is at the ground before its hip's circle is below it.
            lowest = min(lowest, w.contacts[i, LEVEL] - math.hypot(w.contacts[i, ARM_X], w.contacts[i, ARM_Y]))
    if not waits:
        return math.inf
    if g <= 0.0 and w.y[VY, 0] >= 0.0:
        # Only a body that turns can still bring a foot down.
        return 0.0 if w.y.shape[0] == 6 else math.inf
    drop, fall = max(w.y[Y, 0] - lowest, 0.0), -w.y[VY, 0]
    return drop / fall if g <= 0.0 else (math.sqrt(fall * fall + 2.0 * g * drop) - fall) / g


@formula
def has_fallen(w: Walker) -> bool:
    """Whether the centre of mass is below the ground on which legs touch down."""
    return w.clock[SIDE_VIEW] != 0.0 and w.body[GRAVITY, 0] > 0.0 and w.y[Y, 0] < w.ground[0]


@shared(numba.int64, WALKER, numba.float64, numba.float64, TAPE)
def advance(w: Walker, end: float, scale: float, tape: Tape) -> int:
    """Move the walker on to time ``end``, touch-downs there included.

    Where no leg goes by the clock: move it on to the end of the step, which is the next touch-down of a leg whose
    offset is 0 or 1. The derivatives of the state are then those of the state at that touch-down, whose time varies.

    Parameters
    ----------
    w
        Changed in place.
    end
        Time where to stop. Where no leg goes by the clock a touch-down must come before that; there is no such limit in
        the air, where a foot either comes to the ground or never does, which is said at once.
    scale
        Largest estimated error of a step, m.
    tape
        Filled, unless it has no room at all.

    Returns
    -------
    int
        ``OK`` or the reason to stop.
    """
    s = bound = w.clock[TIME]
    steps, leaving, ends = 0, -1, False
    most = MOST_STEPS * min((end - s) / w.clock[SLOWEST] + 1.0, MOST_TIMES)
    resume(w)
    while True:
        if s >= bound:
            s = bound
            clear(w.late)
            ends = go_by_clock(s, w, tape)
            set_push(s, w.push, w.clock)
            refresh(s, w)
            bound = horizon(s, end, w)
        happened, touched = go_by_events(s, leaving, w, tape)
        if w.clock[EVENT_DRIVEN] != 0.0:
            fall = time_to_fall(w)
            if fall == math.inf and not (ends or touched):
                w.clock[TIME] = s
                return NO_TOUCHDOWN
            end = max(end, s + 2.0 * fall)
        if happened or w.clock[EVENT_DRIVEN] != 0.0:
            bound = horizon(s, end, w)
        if tape.counts[1] > tape.events.shape[0]:
            return TAPE_FULL
        if ends or touched or s >= end:
            break
        left = bound - s
        status, h, shift, leaving = try_steps(s, left / math.ceil(left / w.clock[NEXT_STEP]), bound, w, scale)
        if status != OK:
            return status
        steps += 1
        if w.y.shape[1] > 1:
            step_tangents(s, h, w)
        if not record_step(s, h, w, tape):
            return TAPE_FULL
        if not steps <= most:
            return TOO_MANY_STEPS
        last = h == left
        s = accept(s, h, shift, w)
        if last and shift == 0.0:
            s = bound
        if has_fallen(w):
            w.clock[TIME] = s
            return FALLEN
    w.clock[TIME] = s
    if w.clock[EVENT_DRIVEN] != 0.0:
        slide_derivatives(w.lag, 1.0, w)
    # A step ends before the touch-downs that begin the next one.
    for row in range(w.y.shape[0]):
        for d in range(1, w.y.shape[1]):
            w.y[row, d] -= w.late[row, d]
    if tape.size.size > 0:
        tape.time[tape.counts[0]] = s
        copy(w.y, tape.y[tape.counts[0]])
    return OK if ends or touched or w.clock[EVENT_DRIVEN] == 0.0 else NO_TOUCHDOWN
