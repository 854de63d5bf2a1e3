"""Start of a simulation: a walker at the moment of a touch-down."""

import math

import numba

from legspring.kernel.contact import FIRST_STEP, aim, clear, copy, moves, put_down, raise_leg
from legspring.kernel.jit import formula, jit, shared
from legspring.kernel.length import delay_law, law, phase_at
from legspring.kernel.motion import measure_gaps
from legspring.kernel.pack import pack
from legspring.kernel.walker import (
    ACTUATION,
    ALL_PLAIN,
    ANGLE,
    ARM_X,
    ARM_Y,
    BEGUN,
    CLOCK,
    DX,
    DY,
    EVENT_DRIVEN,
    FASTEST,
    FOOT_Y,
    FORCE,
    FORMULA,
    GRAVITY,
    GROUND,
    HEADING,
    HIP_X,
    HIP_Y,
    JET,
    LENGTH,
    LEVEL,
    LEVER,
    MANNER,
    NEXT_STEP,
    NOTHING,
    OFFSET,
    PLAIN,
    ROW,
    SIDE,
    SIDE_VIEW,
    SIGN,
    SINCE,
    SLOWEST,
    SPEED,
    START_YAW,
    START_YAW_RATE,
    STAY,
    STIFFNESS,
    TIME,
    TRIGGER,
    TURN,
    VX,
    VY,
    WALKER,
    WATCHED,
    YAW,
    YAW_RATE,
    Floats,
    Walker,
    X,
    Y,
)


@formula
def set_motion(w: Walker) -> None:
    """Set the state: at the origin, moving with the start's speed in its direction."""
    rows, width = w.y.shape
    start = w.start
    direction = start[HEADING, 0] + (start[START_YAW, 0] if rows == 6 else 0.0)
    sine, cosine, speed = math.sin(direction), math.cos(direction), start[SPEED, 0]
    clear(w.y)
    for d in range(1, width):
        turn = speed * (start[HEADING, d] + (start[START_YAW, d] if rows == 6 else 0.0))
        w.y[VX, d] = -start[SPEED, d] * sine - turn * cosine
        w.y[VY, d] = start[SPEED, d] * cosine - turn * sine
    w.y[VX, 0] = -speed * sine
    w.y[VY, 0] = speed * cosine
    if rows == 6:
        for d in range(width):
            w.y[YAW, d] = start[START_YAW, d]
            w.y[YAW_RATE, d] = start[START_YAW_RATE, d]
    copy(w.y, w.section)
    clear(w.late)


@formula
def place(i: int, w: Walker) -> None:
    """Put leg i down, now or at its time in the last step, in which the body moved evenly, if it may still be down."""
    start, offset = w.start, w.legs[i, OFFSET]
    if offset[0] == 0.0:
        put_down(0.0, w.y, w.legs, i, w.stance, w.contacts)
        if w.legs[i, TRIGGER, 0] == CLOCK and moves(i, w):
            # Its touch-down is still to come, at a time that moves.
            raise_leg(w.legs, i, w.contacts)
            w.contacts[i, SINCE] = -2.0
        return
    ago, old = 2.0 - offset[0], w.ahead
    clear(old)
    for d in range(old.shape[1]):
        # A later touch-down is one further on.
        later = offset[d] if d > 0 else 0.0
        old[X, d] = -ago * start[DX, d] + later * start[DX, 0]
        old[Y, d] = -ago * start[DY, d] + later * start[DY, 0]
        if old.shape[0] == 6:
            old[YAW, d] = start[START_YAW, d] - ago * start[TURN, d] + later * start[TURN, 0]
    put_down(-ago, old, w.legs, i, w.stance, w.contacts)
    delay_law(w.stance, i, offset)
    w.contacts[i, SIGN] = w.contacts[i, SIDE]
    stay = w.legs[i, STAY, 0]
    rested = w.legs[i, TRIGGER, 0] != CLOCK and start[DX, 0] == 0.0 and start[DY, 0] == 0.0
    if rested or (stay != 0.0 and stay <= ago):
        raise_leg(w.legs, i, w.contacts)


@formula
def hold_ready(i: int, w: Walker) -> None:
    """Note where leg i puts its foot down, seen from the body."""
    begun, angle = w.stance[i, BEGUN, 0], w.legs[i, ANGLE, 0]
    length = law(begun, w.stance, i, phase_at(begun))[0]
    w.contacts[i, ARM_X] = w.legs[i, HIP_X, 0] - length * math.sin(angle)
    w.contacts[i, ARM_Y] = w.legs[i, HIP_Y, 0] + length * math.cos(angle)


@jit
def prepare_events(w: Walker) -> None:
    """Lay the ground under the first leg that is put down now, and hold ready the feet that wait for it."""
    clear(w.delay)
    clear(w.lag)
    for i in range(w.contacts.shape[0] - 1, -1, -1):
        if w.legs[i, OFFSET, 0] == 0.0:
            copy(w.stance[i, FOOT_Y], w.ground)
    for i in range(w.contacts.shape[0]):
        w.contacts[i, LEVEL] = w.ground[0]
        if w.legs[i, TRIGGER, 0] == GROUND:
            hold_ready(i, w)
    measure_gaps(0.0, w.y, w.k[0], w.stance, w.contacts, w.clock, w.gaps[0])
    for i in range(w.contacts.shape[0]):
        if w.contacts[i, WATCHED] != NOTHING and w.contacts[i, SIGN] == 0.0 and w.legs[i, TRIGGER, 0] != CLOCK:
            aim(i, w)


@formula
def has_clock(w: Walker) -> bool:
    """Whether anything that a leg does is a matter of the clock."""
    for i in range(w.legs.shape[0]):
        if w.legs[i, TRIGGER, 0] == CLOCK or w.legs[i, STAY, 0] != 0.0:
            return True
        if w.legs[i, ACTUATION, 0] != 0.0 or w.legs[i, FORMULA, 0] != 0.0:
            return True
    return False


@formula
def set_natural_times(w: Walker, speed: float) -> None:
    """Set the shortest and longest of the motion's own times: a step duration, if anything goes by the clock.

    Else the unit of time is arbitrary, and these are that in which the body moves by the length of a leg, that in which
    it falls as far, and that in which it would swing on one leg (its period, where it counts as long).
    """
    shortest, longest = math.inf, 0.0
    for i in range(w.legs.shape[0]):
        length, stiffness, fall = w.legs[i, LENGTH, 0], w.legs[i, STIFFNESS, 0], abs(w.body[GRAVITY, 0])
        if speed > 0.0:
            shortest, longest = min(shortest, length / speed), max(longest, length / speed)
        if fall > 0.0:
            shortest, longest = min(shortest, math.sqrt(length / fall)), max(longest, math.sqrt(length / fall))
        if stiffness > 0.0:
            swing = 1.0 / math.sqrt(stiffness)
            shortest, longest = min(shortest, swing), max(longest, 2.0 * math.pi * swing)
    if has_clock(w) or not 0.0 < shortest <= longest < math.inf:
        shortest = longest = 1.0
    w.clock[FASTEST], w.clock[SLOWEST] = shortest, longest


@shared(numba.void, ROW, JET, WALKER)
def launch(p: Floats, along: Floats, w: Walker) -> None:
    """Set a walker to the start of a step.

    Parameters
    ----------
    p, along
        Parameters and directions (see `pack`).
    w
        Changed in place; what `legspring.kernel.pack.pack_directions` writes is there already.
    """
    pack(p, along, w)
    set_motion(w)
    w.clock[TIME] = 0.0
    # With three leg lengths a body that yaws comes out as accurate as one that does not.
    w.clock[LEVER] = 0.0
    for i in range(w.legs.shape[0]):
        w.clock[LEVER] = max(w.clock[LEVER], 3.0 * w.legs[i, LENGTH, 0])
    w.clock[EVENT_DRIVEN] = w.clock[ALL_PLAIN] = 1.0
    w.clock[SIDE_VIEW] = 0.0
    set_natural_times(w, w.start[SPEED, 0])
    w.clock[NEXT_STEP] = FIRST_STEP * w.clock[FASTEST]
    events = False
    for i in range(w.contacts.shape[0]):
        place(i, w)
        if w.stance[i, MANNER, 0] != PLAIN:
            w.clock[ALL_PLAIN] = 0.0
        if w.legs[i, TRIGGER, 0] == GROUND:
            w.clock[SIDE_VIEW] = 1.0
        if w.legs[i, TRIGGER, 0] == CLOCK:
            w.clock[EVENT_DRIVEN] = 0.0
        else:
            events = True
    measure_gaps(0.0, w.y, w.k[0], w.stance, w.contacts, w.clock, w.gaps[0])
    for i in range(w.contacts.shape[0]):
        # A leg that the clock lifts stands until then, whatever its force.
        if w.contacts[i, WATCHED] == FORCE and w.contacts[i, SIGN] * w.gaps[0, i, 0] < 0.0:
            raise_leg(w.legs, i, w.contacts)
    if events:
        prepare_events(w)
