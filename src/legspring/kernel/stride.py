"""The hybrid flow: steps of the integrator between touch-downs and lift-offs, by the clock or by an event.

Derivatives are those of the state at a fixed time. Where an event moves with the parameters, the states around it are
first taken along to it (y' += f dt'), what happens there is made to happen at the moving time, and then they are taken
back with the rates that hold after it (y' -= f dt'). Where neither the rates jump nor a leg is put down, nothing comes
of that, and it is left out.
"""

import math

import numba
import numpy as np

from legspring.kernel.dop853 import all_rates, interpolant, step, step_tangents, tangents_at
from legspring.kernel.events import HERE, NONE, arm, next_event
from legspring.kernel.jit import formula, jit, shared
from legspring.kernel.length import delay_law, law, phase_at, set_law
from legspring.kernel.motion import force_changes, hip, measure_gaps, turn
from legspring.kernel.walker import (
    ANGLE,
    ARM_X,
    ARM_Y,
    BEGUN,
    CLOCK,
    DOWN,
    EVENT_DRIVEN,
    EVENT_LOST,
    FALLEN,
    FASTEST,
    FOOT_X,
    FOOT_Y,
    FORCE,
    GRAVITY,
    GRIP_X,
    GRIP_Y,
    GROUND,
    HEIGHT,
    HIP_X,
    HIP_Y,
    LAW,
    LEVEL,
    LEVER,
    LIFTOFF,
    NEXT_STEP,
    NO_TOUCHDOWN,
    NOTHING,
    OFFSET,
    OK,
    PUSH_X,
    PUSH_Y,
    SIDE_VIEW,
    SIGN,
    SINCE,
    SLOWEST,
    SPRING,
    STAY,
    STEP_TOO_SMALL,
    STIFFNESS,
    TAPE,
    TAPE_FULL,
    TIME,
    TOO_MANY_STEPS,
    TOUCHDOWN,
    TRIGGER,
    VY,
    WALKER,
    WATCHED,
    YAW,
    Floats,
    Tape,
    Walker,
    X,
    Y,
)

FIRST_STEP = 0.3
SMALLEST_STEP = 1e-13
"""Steps of the integrator, in the shortest of the motion's own times."""
MOST_STEPS = 1000
"""Steps in the longest of the motion's own times after which an integration gives up."""
MOST_TRIES = 40
LONGEST_STEP = 50.0
"""Times, the longest of the motion's own, after which an animal with a leg down is given up if none touches down."""
NEARLY = 1e-9
"""A gap this much smaller than the legs is zero, when it comes to where it is going."""


@formula
def copy(source: Floats, target: Floats) -> None:
    """Copy an array into another of the same shape; without the temporary copy that a slice assignment makes."""
    for index in np.ndindex(source.shape):
        target[index] = source[index]


@formula
def fill(a: Floats, value: float) -> None:
    """Set all of an array to a number; without a temporary array."""
    for index in np.ndindex(a.shape):
        a[index] = value


@formula
def clear(a: Floats) -> None:
    """Set all of an array to zero."""
    fill(a, 0.0)


@jit
def put_down(s: float, y: Floats, legs: Floats, i: int, stance: Floats, contacts: Floats) -> None:
    """Put leg i down at time s under a body in state y, such that its force is zero."""
    yaws = y.shape[0] == 6
    for d in range(legs.shape[2]):
        stance[i, GRIP_X, d] = legs[i, HIP_X, d]
        stance[i, GRIP_Y, d] = legs[i, HIP_Y, d]
        stance[i, SPRING, d] = legs[i, STIFFNESS, d]
    set_law(legs, i, s, stance)
    sine, cosine = phase_at(s)
    lean = turn(y)
    hx, hy = hip(legs[i, HIP_X, 0], legs[i, HIP_Y, 0], lean)
    numbers = law(s, stance, i, (sine, cosine))
    reach = numbers[0]
    angle = legs[i, ANGLE, 0] + (y[YAW, 0] if yaws else 0.0)
    ux, uy = -math.sin(angle), math.cos(angle)
    for d in range(1, legs.shape[2]):
        yaw = y[YAW, d] if yaws else 0.0
        swing = reach * (legs[i, ANGLE, d] + yaw)
        stretch = numbers[3] * stance[i, LAW, d] + numbers[4] * stance[i, LAW + 1, d]
        stretch += numbers[5] * stance[i, LAW + 2, d]
        hip_x = lean[0] * legs[i, HIP_X, d] - lean[1] * legs[i, HIP_Y, d] - yaw * hy
        hip_y = lean[1] * legs[i, HIP_X, d] + lean[0] * legs[i, HIP_Y, d] + yaw * hx
        stance[i, FOOT_X, d] = y[X, d] + hip_x + stretch * ux - swing * uy
        stance[i, FOOT_Y, d] = y[Y, d] + hip_y + stretch * uy + swing * ux
    stance[i, FOOT_X, 0] = y[X, 0] + hx + reach * ux
    stance[i, FOOT_Y, 0] = y[Y, 0] + hy + reach * uy
    contacts[i, SINCE] = s
    contacts[i, DOWN] = 1.0
    contacts[i, SIGN] = 0.0
    contacts[i, WATCHED] = FORCE if legs[i, STAY, 0] == 0.0 else NOTHING


@formula
def record_event(tape: Tape, s: float, leg: int, kind: int, rate: float) -> None:
    """Note a touch-down or lift-off, if there is a tape; where it has no room left, only count it."""
    n = tape.counts[1]
    if n < tape.events.shape[0]:
        row = tape.events[n]
        row[0], row[1], row[2], row[3], row[4] = s, leg, kind, tape.counts[0], rate
    if tape.events.shape[0] > 0:
        tape.counts[1] += 1


@jit
def refresh(s: float, w: Walker) -> None:
    """Compute the rates and gaps of the present state."""
    all_rates(s, w.y, w, 0)
    measure_gaps(s, w.y, w.k[0], w.stance, w.contacts, w.clock, w.gaps[0])


@formula
def raise_leg(legs: Floats, i: int, contacts: Floats) -> None:
    """Take leg i off the ground."""
    contacts[i, DOWN] = 0.0
    contacts[i, SIGN] = 0.0
    contacts[i, WATCHED] = HEIGHT if legs[i, TRIGGER, 0] == GROUND else NOTHING


@formula
def aim(i: int, w: Walker) -> None:
    """Set the sign that a gap leaves zero with, or has, after an event."""
    gap, rate = w.gaps[0, i, 0], w.gaps[0, i, 1]
    w.contacts[i, SIGN] = math.copysign(1.0, gap if abs(gap) > NEARLY * w.clock[LEVER] else rate)


@jit
def slide_derivatives(delay: Floats, sign: float, w: Walker) -> None:
    """Take the derivatives of the state along to a time that moves, or (sign -1) back from there."""
    for row in range(w.y.shape[0]):
        for d in range(1, delay.size):
            w.y[row, d] += sign * delay[d] * w.k[0, row, 0]


@jit
def set_delay(s: float, i: int, w: Walker) -> None:
    """Write the derivatives of the time s of leg i's event into ``delay``: those of its gap by the gap's rate."""
    if w.contacts[i, DOWN] == 0.0:
        # Where the foot would be: the leg is about to be put down anyway.
        put_down(s, w.y, w.legs, i, w.stance, w.contacts)
        for d in range(1, w.delay.size):
            w.delay[d] = (w.ground[d] - w.stance[i, FOOT_Y, d]) / w.gaps[0, i, 1]
        w.contacts[i, DOWN] = 0.0
    elif w.legs[i, STAY, 0] != 0.0:
        for d in range(1, w.delay.size):
            w.delay[d] = w.stance[i, BEGUN, d] + w.legs[i, STAY, d]
    else:
        force_changes(s, w.y, w.stance, i, w.delay)
        for d in range(1, w.delay.size):
            w.delay[d] /= -w.stance[i, SPRING, 0] * w.gaps[0, i, 1]


@jit
def land(s: float, i: int, w: Walker, tape: Tape) -> bool:
    """Put leg i down at an event at time s; return whether a step ends with that."""
    put_down(s, w.y, w.legs, i, w.stance, w.contacts)
    delay_law(w.stance, i, w.delay)
    record_event(tape, s, i, TOUCHDOWN, 0.0)
    w.clock[NEXT_STEP] = min(w.clock[NEXT_STEP], FIRST_STEP * w.clock[FASTEST])
    return w.clock[EVENT_DRIVEN] != 0.0 and w.legs[i, OFFSET, 0] in (0.0, 1.0)


@jit
def happen(s: float, i: int, w: Walker, tape: Tape) -> bool:
    """Let leg i touch down, or lift off and its followers touch down; return whether a step ends with that."""
    set_delay(s, i, w)
    slide_derivatives(w.delay, 1.0, w)
    ends = False
    if w.contacts[i, DOWN] == 0.0:
        ends = land(s, i, w, tape)
    else:
        record_event(tape, s, i, LIFTOFF, w.gaps[0, i, 1] if w.contacts[i, WATCHED] != NOTHING else 0.0)
        raise_leg(w.legs, i, w.contacts)
        for j in range(w.contacts.shape[0]):
            if w.legs[j, TRIGGER, 0] == i + 1:
                ends |= land(s, j, w, tape)
    refresh(s, w)
    slide_derivatives(w.delay, -1.0, w)
    refresh(s, w)
    for j in range(w.contacts.shape[0]):
        if w.contacts[j, WATCHED] != NOTHING and w.contacts[j, SIGN] == 0.0 and w.legs[j, TRIGGER, 0] != CLOCK:
            aim(j, w)
    if ends:
        copy(w.delay, w.lag)
    return ends


@formula
def moves(i: int, w: Walker) -> bool:
    """Whether the time at which the clock puts leg i down has derivatives."""
    total = 0.0
    for d in range(1, w.legs.shape[2]):
        total += abs(w.legs[i, OFFSET, d])
    return total > 0.0


@formula
def add_to_late(sign: float, w: Walker) -> None:
    """Add the derivatives of the state, or take them away."""
    for row in range(w.y.shape[0]):
        for d in range(1, w.y.shape[1]):
            w.late[row, d] += sign * w.y[row, d]


@jit
def put_down_late(s: float, i: int, w: Walker) -> None:
    """Put leg i down by the clock at a time s that moves, and remember what that does to the derivatives."""
    refresh(s, w)
    add_to_late(-1.0, w)
    slide_derivatives(w.legs[i, OFFSET], 1.0, w)
    put_down(s, w.y, w.legs, i, w.stance, w.contacts)
    delay_law(w.stance, i, w.legs[i, OFFSET])
    refresh(s, w)
    slide_derivatives(w.legs[i, OFFSET], -1.0, w)
    add_to_late(1.0, w)


@formula
def go_by_clock(s: float, w: Walker, tape: Tape) -> bool:
    """Lift and put down the legs whose time has come; return whether a step ends with that.

    Legs that the clock lifts right when it puts them down anew are not lifted.
    """
    ends = False
    for i in range(w.contacts.shape[0]):
        stay = w.legs[i, STAY, 0]
        if stay != 0.0 and w.contacts[i, DOWN] != 0.0 and s >= w.contacts[i, SINCE] + stay:
            ends |= happen(s, i, w, tape)
    for i in range(w.contacts.shape[0]):
        if w.legs[i, TRIGGER, 0] == CLOCK and s >= w.contacts[i, SINCE] + 2.0:
            if moves(i, w):
                put_down_late(s, i, w)
            else:
                put_down(s, w.y, w.legs, i, w.stance, w.contacts)
            if s > 0.0:
                record_event(tape, s, i, TOUCHDOWN, 0.0)
    return ends


@formula
def is_quiet(i: int, w: Walker) -> bool:
    """Whether nothing but the derivatives' rates changes when leg i lifts off by zero force."""
    quiet = w.contacts[i, DOWN] != 0.0 and w.legs[i, TRIGGER, 0] != GROUND
    for j in range(w.contacts.shape[0]):
        quiet &= w.legs[j, TRIGGER, 0] != i + 1
    return quiet


@formula
def go_by_events(s: float, leaving: int, w: Walker, tape: Tape) -> tuple[bool, bool]:
    """Let happen what is due: to the leg that is leaving (-1: none), and to those whose gap is at zero with it.

    Where a leg just lifts off, its force is zero: the rates stay as they are, but for those of the derivatives, since
    the force's are not zero.

    Returns
    -------
    happened, ends
        Whether a leg has touched down or may do so now, and whether a step ends with that.
    """
    lifted = happened = ends = False
    for i in range(w.contacts.shape[0]):
        if w.contacts[i, WATCHED] == NOTHING or w.contacts[i, SIGN] == 0.0:
            continue
        sign, rate = w.contacts[i, SIGN], w.gaps[0, i, 1]
        if i != leaving and (sign * w.gaps[0, i, 0] > 1e-13 * w.clock[FASTEST] * abs(rate) or sign * rate >= 0.0):
            continue
        if is_quiet(i, w):
            raise_leg(w.legs, i, w.contacts)
            record_event(tape, s, i, LIFTOFF, rate)
            lifted = True
        elif w.contacts[i, DOWN] == 0.0 and sign < 0.0:
            # A foot that was held below the ground has come up.
            w.contacts[i, SIGN] = 1.0
        else:
            ends |= happen(s, i, w, tape)
            happened = True
    if lifted and w.y.shape[1] > 1:
        tangents_at(s, phase_at(s), w.y, w, 0)
    return happened, ends


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
    all_rates(s + shift, w.y, w, 13)
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
    most = MOST_STEPS * ((end - s) / w.clock[SLOWEST] + 1.0)
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
