"""Touch-downs and lift-offs: what happens to a leg, to those that follow it, and to the derivatives of the state.

Derivatives are those of the state at a fixed time. Where an event moves with the parameters, the states around it are
first taken along to it (y' += f dt'), what happens there is made to happen at the moving time, and then they are taken
back with the rates that hold after it (y' -= f dt'). Where neither the rates jump nor a leg is put down, nothing comes
of that, and it is left out.
"""

import math

import numpy as np

from legspring.kernel.dop853 import all_rates, tangents_at
from legspring.kernel.jit import formula, jit
from legspring.kernel.length import delay_law, law, phase_at, set_law
from legspring.kernel.motion import force_changes, hip, measure_gaps, turn
from legspring.kernel.walker import (
    ANGLE,
    BEGUN,
    CLOCK,
    DOWN,
    EVENT_DRIVEN,
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
    LEVER,
    LIFTOFF,
    NEXT_STEP,
    NOTHING,
    OFFSET,
    SIDE_VIEW,
    SIGN,
    SINCE,
    SPRING,
    STAY,
    STIFFNESS,
    TOUCHDOWN,
    TRIGGER,
    VY,
    WATCHED,
    YAW,
    Floats,
    Tape,
    Walker,
    X,
    Y,
)

FIRST_STEP = 0.3
"""First step of the integrator after an event, in the shortest of the motion's own times."""
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
def put_down(s: float, y: Floats, legs: Floats, i: int, stance: Floats, contacts: Floats, place: Floats) -> None:
    """Put leg i down at time s under a body in state y, such that its force is zero; note the body's place."""
    yaws = y.shape[0] == 6
    for d in range(legs.shape[2]):
        place[0, d], place[1, d] = y[X, d], y[Y, d]
        if yaws:
            place[2, d] = y[YAW, d]
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
        put_down(s, w.y, w.legs, i, w.stance, w.contacts, w.places[i])
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
    put_down(s, w.y, w.legs, i, w.stance, w.contacts, w.places[i])
    delay_law(w.stance, i, w.delay)
    record_event(tape, s, i, TOUCHDOWN, 0.0)
    w.clock[NEXT_STEP] = min(w.clock[NEXT_STEP], FIRST_STEP * w.clock[FASTEST])
    return w.clock[EVENT_DRIVEN] != 0.0 and w.legs[i, OFFSET, 0] in (0.0, 1.0)


@formula
def note_apex(w: Walker) -> None:
    """From the side: note the height to which a body that has just left the ground will rise, if it is the largest."""
    if w.clock[SIDE_VIEW] == 0.0 or w.body[GRAVITY, 0] <= 0.0 or w.y[VY, 0] <= 0.0:
        return
    for i in range(w.contacts.shape[0]):
        if w.contacts[i, DOWN] != 0.0:
            return
    climb = w.y[VY, 0] / w.body[GRAVITY, 0]
    height = w.y[Y, 0] - w.ground[0] + 0.5 * climb * w.y[VY, 0]
    if w.apex[0] >= height:
        return
    w.apex[0] = height
    for d in range(1, w.apex.size):
        w.apex[d] = w.y[Y, d] - w.ground[d] + climb * (w.y[VY, d] - 0.5 * climb * w.body[GRAVITY, d])


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
    note_apex(w)
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
    put_down(s, w.y, w.legs, i, w.stance, w.contacts, w.places[i])
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
                put_down(s, w.y, w.legs, i, w.stance, w.contacts, w.places[i])
            if s > 0.0:
                record_event(tape, s, i, TOUCHDOWN, 0.0)
    return ends


@formula
def is_quiet(i: int, w: Walker) -> bool:
    """Whether nothing but the derivatives' rates changes when leg i lifts off by zero force."""
    quiet = w.contacts[i, DOWN] != 0.0 and w.clock[SIDE_VIEW] == 0.0
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
