"""The hybrid flow: steps of the integrator between touch-downs by the clock and lift-offs by zero force."""

import math

import numpy as np

from legspring.kernel.dop853 import interpolant, step, step_tangents
from legspring.kernel.events import HERE, NONE, arm, next_event
from legspring.kernel.jit import formula, jit, part
from legspring.kernel.length import length, set_law
from legspring.kernel.motion import hip, measure_gaps, rates, tangent_rates, turn
from legspring.kernel.walker import (
    ANGLE,
    DOWN,
    EVALUATIONS,
    EVENT_LOST,
    FOOT_X,
    FOOT_Y,
    GRIP_X,
    GRIP_Y,
    HIP_X,
    HIP_Y,
    LAW,
    LIFTOFF,
    NEXT_STEP,
    OK,
    PUSH_X,
    SIGN,
    SINCE,
    SPRING,
    STEP_TOO_SMALL,
    STIFFNESS,
    TIME,
    TOO_MANY_STEPS,
    TOUCHDOWN,
    VARIED,
    YAW,
    Floats,
    Tape,
    Walker,
    X,
    Y,
)

FIRST_STEP = 0.3
SMALLEST_STEP = 1e-13
MOST_STEPS = 1000
"""Steps between two touch-downs after which an integration gives up."""
MOST_TRIES = 40


@formula
def copy(source: Floats, target: Floats) -> None:
    """Copy an array into another of the same shape; without the temporary copy that a slice assignment makes."""
    for index in np.ndindex(source.shape):
        target[index] = source[index]


@jit
def put_down(s: float, y: Floats, legs: Floats, i: int, stance: Floats, contacts: Floats) -> None:
    """Put leg i down at time s under a body in state y, such that its force is zero (model: foot placement)."""
    yaws = y.shape[0] == 6
    contacts[i, VARIED] = 0.0
    for d in range(legs.shape[2]):
        stance[i, GRIP_X, d] = legs[i, HIP_X, d]
        stance[i, GRIP_Y, d] = legs[i, HIP_Y, d]
        stance[i, SPRING, d] = legs[i, STIFFNESS, d]
        if d > 0 and (legs[i, HIP_X, d] != 0.0 or legs[i, HIP_Y, d] != 0.0 or legs[i, STIFFNESS, d] != 0.0):
            contacts[i, VARIED] = 1.0
    set_law(legs, i, s, stance)
    sine, cosine = math.sin(math.pi * s), math.cos(math.pi * s)
    lean = turn(y)
    hx, hy = hip(legs[i, HIP_X, 0], legs[i, HIP_Y, 0], lean)
    reach = length(stance[i, LAW, 0], stance[i, LAW + 1, 0], stance[i, LAW + 2, 0], sine, cosine)
    angle = legs[i, ANGLE, 0] + (y[YAW, 0] if yaws else 0.0)
    ux, uy = -math.sin(angle), math.cos(angle)
    for d in range(1, legs.shape[2]):
        yaw = y[YAW, d] if yaws else 0.0
        swing = reach * (legs[i, ANGLE, d] + yaw)
        stretch = length(stance[i, LAW, d], stance[i, LAW + 1, d], stance[i, LAW + 2, d], sine, cosine)
        hip_x = lean[0] * legs[i, HIP_X, d] - lean[1] * legs[i, HIP_Y, d] - yaw * hy
        hip_y = lean[1] * legs[i, HIP_X, d] + lean[0] * legs[i, HIP_Y, d] + yaw * hx
        stance[i, FOOT_X, d] = y[X, d] + hip_x + stretch * ux - swing * uy
        stance[i, FOOT_Y, d] = y[Y, d] + hip_y + stretch * uy + swing * ux
    stance[i, FOOT_X, 0] = y[X, 0] + hx + reach * ux
    stance[i, FOOT_Y, 0] = y[Y, 0] + hy + reach * uy
    contacts[i, SINCE] = s
    contacts[i, DOWN] = 1.0
    contacts[i, SIGN] = 0.0


@formula
def record_event(tape: Tape, s: float, leg: int, kind: int, rate: float) -> None:
    """Note a touch-down or lift-off, if there is a tape and room on it."""
    n = tape.counts[1]
    if n < tape.events.shape[0]:
        row = tape.events[n]
        row[0], row[1], row[2], row[3], row[4] = s, leg, kind, tape.counts[0], rate
        tape.counts[1] += 1


@part
def touch_down(s: float, w: Walker, tape: Tape) -> None:
    """Put down the legs whose time has come."""
    for i in range(w.contacts.shape[0]):
        if s >= w.contacts[i, SINCE] + 2.0:
            put_down(s, w.y, w.legs, i, w.stance, w.contacts)
            record_event(tape, s, i, TOUCHDOWN, 0.0)


@part
def lift_off(s: float, leaving: int, w: Walker, tape: Tape) -> None:
    """Lift the leg that is leaving (-1: none), and those whose gap is at zero with it, or a hair past it.

    Their force is zero: the rates stay as they are, but for those of the derivatives, since the force's are not zero.
    """
    lifted = False
    for i in range(w.contacts.shape[0]):
        sign, rate = w.contacts[i, SIGN], w.gaps[0, i, 1]
        gone = i == leaving or sign * w.gaps[0, i, 0] <= 1e-13 * abs(rate)
        if w.contacts[i, DOWN] != 0.0 and sign != 0.0 and gone:
            w.contacts[i, DOWN] = 0.0
            record_event(tape, s, i, LIFTOFF, rate)
            lifted = True
    if lifted and w.y.shape[1] > 1:
        tangent_rates(s, w.y, w.stance, w.contacts, w.body, w.k[0])


@jit
def refresh(s: float, w: Walker) -> None:
    """Compute the rates and gaps of the present state."""
    rates(s, w.y, w.stance, w.contacts, w.body, w.clock, w.k[0])
    w.clock[EVALUATIONS] += 1
    if w.y.shape[1] > 1:
        tangent_rates(s, w.y, w.stance, w.contacts, w.body, w.k[0])
    measure_gaps(s, w.y, w.k[0], w.stance, w.contacts, w.gaps[0])


@part
def horizon(s: float, end: float, contacts: Floats, push: Floats) -> float:
    """Time up to which nothing changes by the clock."""
    for i in range(contacts.shape[0]):
        end = min(end, contacts[i, SINCE] + 2.0)
    for j in range(push.shape[0]):
        if push[j, 0] > s:
            end = min(end, push[j, 0])
    return end


@part
def set_push(s: float, push: Floats, clock: Floats) -> None:
    """Set the coefficients of the outside acceleration that holds from s on."""
    for j in range(PUSH_X, clock.size):
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
    rates(s + shift, w.y, w.stance, w.contacts, w.body, w.clock, w.k[13])
    w.clock[EVALUATIONS] += 1
    if w.y.shape[1] > 1:
        tangent_rates(s + shift, w.y, w.stance, w.contacts, w.body, w.k[13])
    slide(w.ahead, shift, w.k[12], w.k[13], w.y)


@formula
def slide(y: Floats, shift: float, f: Floats, g: Floats, out: Floats) -> None:
    """Write y + shift (f + g) / 2 into ``out``."""
    for row in range(y.shape[0]):
        for d in range(y.shape[1]):
            out[row, d] = y[row, d] + 0.5 * shift * (f[row, d] + g[row, d])


@part
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


@part
def try_steps(s: float, h: float, bound: float, w: Walker, scale: float) -> tuple[int, float, float, int]:
    """Try steps until one is accurate and has no event before its end.

    Returns
    -------
    status, size, shift, leg
        How it went, the step's size, the time by which to move its end onto a lift-off, and whose (-1: nobody's).
    """
    for _ in range(MOST_TRIES):
        error = step(s, h, w.y, w.stance, w.contacts, w.body, w.clock, w.k, w.ahead) / scale
        if not error <= 1.0:
            h *= max(0.1, 0.9 * error**-0.125) if error < math.inf else 0.1
            w.clock[NEXT_STEP] = h
            if h < SMALLEST_STEP:
                return STEP_TOO_SMALL, h, 0.0, -1
            continue
        w.clock[NEXT_STEP] = max(w.clock[NEXT_STEP], h * min(5.0, 0.9 * error**-0.125))
        measure_gaps(s + h, w.ahead, w.k[12], w.stance, w.contacts, w.gaps[1])
        kind, where, leg = next_event(s, h, w.contacts, w.gaps)
        if kind == NONE or (kind == HERE and s + h + where > bound):
            return OK, h, 0.0, -1
        if kind == HERE:
            return OK, h, where, leg
        h *= where
    return EVENT_LOST, h, 0.0, -1


@part
def accept(s: float, h: float, shift: float, w: Walker) -> float:
    """Make the end of the step tried last the present; return its time."""
    arm(s, h, w.contacts, w.gaps)
    if shift != 0.0:
        move_end(s + h, shift, w)
        refresh(s + h + shift, w)
    else:
        copy(w.ahead, w.y)
        copy(w.k[12], w.k[0])
        copy(w.gaps[1], w.gaps[0])
    return s + h + shift


@jit
def advance(w: Walker, end: float, scale: float, tape: Tape) -> int:
    """Move the walker on to time ``end``, touch-downs there included.

    Parameters
    ----------
    w
        Changed in place.
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
    steps, leaving = 0, -1
    while True:
        if s >= bound:
            s = bound
            touch_down(s, w, tape)
            set_push(s, w.push, w.clock)
            refresh(s, w)
            bound = horizon(s, end, w.contacts, w.push)
        lift_off(s, leaving, w, tape)
        if s >= end:
            break
        left = bound - s
        status, h, shift, leaving = try_steps(s, left / math.ceil(left / w.clock[NEXT_STEP]), bound, w, scale)
        if status != OK:
            return status
        steps += 1
        if w.y.shape[1] > 1:
            step_tangents(s, h, w)
        if not record_step(s, h, w, tape) or steps > MOST_STEPS * (end - w.clock[TIME] + 1.0):
            return TOO_MANY_STEPS
        last = h == left
        s = accept(s, h, shift, w)
        if last and shift == 0.0:
            s = bound
    w.clock[TIME] = s
    if tape.size.size > 0:
        tape.time[tape.counts[0]] = s
        copy(w.y, tape.y[tape.counts[0]])
    return OK
