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
    AGE,
    ALL_PLAIN,
    ANGLE,
    ARM_X,
    ARM_Y,
    BEGUN,
    CLOCK,
    DX,
    DY,
    EVEN,
    EVENT_DRIVEN,
    FASTEST,
    FOOT_X,
    FOOT_Y,
    FORCE,
    FORMULA,
    GRAVITY,
    GRAVITY_X,
    GROUND,
    HEADING,
    HIP_X,
    HIP_Y,
    JET,
    LEG_DX,
    LEG_DY,
    LEG_TURN,
    LENGTH,
    LEVEL,
    LEVER,
    MANNER,
    MEMORY,
    NEXT_STEP,
    NOTHING,
    NOW,
    OFFSET,
    OWN,
    PLACE_X,
    PLACE_Y,
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
    UP,
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
    """Put leg i down, now or at its time before the start, if it may still be down."""
    offset, known = w.legs[i, OFFSET], w.legs[i, MEMORY, 0]
    if offset[0] == 0.0 or known == NOW:
        put_down(0.0, w.y, w.legs, i, w.stance, w.contacts, w.places[i])
        if w.legs[i, TRIGGER, 0] == CLOCK and moves(i, w):
            # Its touch-down is still to come, at a time that moves.
            raise_leg(w.legs, i, w.contacts)
            w.contacts[i, SINCE] = -2.0
        return
    ago = 2.0 - offset[0]
    if w.legs[i, TRIGGER, 0] != CLOCK and known == OWN:
        ago = w.legs[i, AGE, 0]
    recall(i, ago, w)
    put_down(-ago, w.ahead, w.legs, i, w.stance, w.contacts, w.places[i])
    delay_law(w.stance, i, w.delay)
    w.contacts[i, SIGN] = w.contacts[i, SIDE]
    stay = w.legs[i, STAY, 0]
    rested = w.legs[i, TRIGGER, 0] != CLOCK and known == EVEN and w.start[DX, 0] == 0.0 and w.start[DY, 0] == 0.0
    if rested or known == UP or (stay != 0.0 and stay <= ago):
        raise_leg(w.legs, i, w.contacts)
    elif w.legs[i, TRIGGER, 0] != CLOCK and known == OWN:
        for d in range(w.ground.size):
            w.stance[i, FOOT_X, d] = w.legs[i, PLACE_X, d]
            w.stance[i, FOOT_Y, d] = w.ground[d] if w.clock[SIDE_VIEW] != 0.0 else w.legs[i, PLACE_Y, d]


@formula
def recall(i: int, ago: float, w: Walker) -> None:
    """Write the state of the body when leg i was put down into ``ahead``; derivatives of that time into ``delay``."""
    start, leg, old, own = w.start, w.legs[i], w.ahead, w.legs[i, MEMORY, 0] == OWN
    clear(old)
    by_clock = leg[TRIGGER, 0] == CLOCK
    for d in range(old.shape[1]):
        w.delay[d] = leg[OFFSET, d] if by_clock or not own else -leg[AGE, d]
        # A later touch-down is one further on, where the body has moved evenly.
        later = leg[OFFSET, d] if d > 0 else 0.0
        old[X, d] = -leg[LEG_DX, d] if own else later * start[DX, 0] - ago * start[DX, d]
        old[Y, d] = -leg[LEG_DY, d] if own else later * start[DY, 0] - ago * start[DY, d]
        if old.shape[0] == 6:
            turned = leg[LEG_TURN, d] if own and by_clock else ago * start[TURN, d] - later * start[TURN, 0]
            old[YAW, d] = start[START_YAW, d] - turned


@formula
def hold_ready(i: int, w: Walker) -> None:
    """Note where leg i puts its foot down, seen from the body."""
    begun, angle = w.stance[i, BEGUN, 0], w.legs[i, ANGLE, 0]
    length = law(begun, w.stance, i, phase_at(begun))[0]
    w.contacts[i, ARM_X] = w.legs[i, HIP_X, 0] - length * math.sin(angle)
    w.contacts[i, ARM_Y] = w.legs[i, HIP_Y, 0] + length * math.cos(angle)


@jit
def place_legs(w: Walker) -> None:
    """Put the legs down that are so at the start: first those that land now, under the first of which is the ground."""
    clear(w.ground)
    for i in range(w.contacts.shape[0] - 1, -1, -1):
        if w.legs[i, OFFSET, 0] == 0.0:
            place(i, w)
            copy(w.stance[i, FOOT_Y], w.ground)
    for i in range(w.contacts.shape[0]):
        if w.legs[i, OFFSET, 0] != 0.0:
            place(i, w)
    clear(w.delay)
    clear(w.lag)


@jit
def prepare_events(w: Walker) -> None:
    """Hold ready the feet that wait for the ground."""
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
        length, stiffness = w.legs[i, LENGTH, 0], w.legs[i, STIFFNESS, 0]
        fall = math.hypot(w.body[GRAVITY, 0], w.body[GRAVITY_X, 0])
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
    w.apex[0] = math.nan
    set_natural_times(w, w.start[SPEED, 0])
    w.clock[NEXT_STEP] = FIRST_STEP * w.clock[FASTEST]
    events = False
    place_legs(w)
    for i in range(w.contacts.shape[0]):
        if w.stance[i, MANNER, 0] != PLAIN:
            w.clock[ALL_PLAIN] = 0.0
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
