"""Motions over rough ground and with bad luck: what changes from step to step, for many runs."""

import math

from legspring.kernel.contact import raise_leg
from legspring.kernel.jit import driver, formula, jit
from legspring.kernel.launch import launch
from legspring.kernel.many import take_step
from legspring.kernel.pack import GRAVITATION, SLOPE, STEP_DURATION, pack_directions
from legspring.kernel.settle import FAILS, FALLS, FASTEST, RUNS_AWAY, SLOWEST, STOPS
from legspring.kernel.walker import (
    CLOCK,
    DOWN,
    EVALUATIONS,
    FALLEN,
    GRAVITY,
    GRAVITY_X,
    LEVEL,
    OFFSET,
    OK,
    PHASE,
    SIDE_VIEW,
    SINCE,
    STIFFNESS,
    TIME,
    TRIGGER,
    VX,
    VY,
    YAW,
    Floats,
    Ints,
    Tape,
    Walker,
)

TURNS_BACK, GOES_ON = -8, 0
OF_SLOPE, OF_HEIGHT, OF_STIFFNESS, OF_LEGS = 0, 1, 2, 3
"""Columns of what changes in a step: of the slope (rad), of the height of the ground for the next foot (m), of the
logarithm of the ground's stiffness; then three of each leg: of its phase (rad), by how much later it comes down (step
durations), and whether it misses the ground (1)."""
N_OF_LEG = 3


@formula
def set_ground(w: Walker, p: Floats, level: float, change: Floats) -> None:
    """Incline the ground of a step, and raise it from its level for the next foot."""
    slope, unit = p[SLOPE] + change[OF_SLOPE], p[GRAVITATION] * p[STEP_DURATION] ** 2
    if w.clock[SIDE_VIEW] != 0.0:
        w.body[GRAVITY, 0], w.body[GRAVITY_X, 0] = unit * math.cos(slope), unit * math.sin(slope)
        w.ground[0] = level + change[OF_HEIGHT]
        for i in range(w.contacts.shape[0]):
            w.contacts[i, LEVEL] = w.ground[0]
    else:
        w.body[GRAVITY, 0] = unit * math.sin(slope)


@jit
def set_legs(w: Walker, even: Floats, change: Floats) -> None:
    """Set what legs that come down in a step do otherwise; ``even`` holds their phases and stiffnesses."""
    now = w.clock[TIME]
    for i in range(w.contacts.shape[0]):
        own = OF_LEGS + N_OF_LEG * i
        w.legs[i, PHASE, 0] = even[i, 0] + change[own]
        w.legs[i, STIFFNESS, 0] = even[i, 1] * math.exp(change[OF_STIFFNESS])
        if w.legs[i, TRIGGER, 0] != CLOCK:
            continue
        due = now + (w.legs[i, OFFSET, 0] - now) % 2.0
        if due >= now + 1.0:
            continue
        if change[own + 2] != 0.0:
            if due == now and w.contacts[i, DOWN] != 0.0:
                raise_leg(w.legs, i, w.contacts)
            w.contacts[i, SINCE] = due
        else:
            w.contacts[i, SINCE] = due - 2.0 + change[own + 1]


@formula
def fate_of(w: Walker, status: int, pace: float, out: Floats) -> int:
    """Write speed and heading at the end of a step; return what has become of a motion, or that it goes on."""
    if status != OK:
        return FALLS if status == FALLEN else FAILS
    vx, vy = w.y[VX, 0], w.y[VY, 0]
    yaw = w.y[YAW, 0] if w.y.shape[0] == 6 and w.clock[SIDE_VIEW] == 0.0 else 0.0
    out[0], out[1] = math.hypot(vx, vy) / pace, math.atan2(-vx, vy) - yaw
    ahead = vx if w.clock[SIDE_VIEW] != 0.0 else math.cos(out[1])
    if out[0] > FASTEST:
        return RUNS_AWAY
    if out[0] < SLOWEST:
        return STOPS
    return TURNS_BACK if ahead < 0.0 else GOES_ON


@driver
def wander(
    w: Walker,
    tape: Tape,
    p: Floats,
    changes: Floats,
    pace: float,
    scale: float,
    even: Floats,
    seen: Floats,
    fates: Ints,
    steps: Ints,
) -> None:
    """Run from one start over ground, and with luck, that changes from step to step.

    Parameters
    ----------
    w, tape, scale
        See `legspring.kernel.many.many`.
    p
        ``(1, n)``: all parameters with the start.
    changes
        ``(N, S, 3 + 3 L)``: in each step of each run.
    pace
        The desired speed, m per step duration.
    even
        ``(L, 2)``: room for what legs are without changes.
    seen
        ``(N, S, 2)``: filled with speed, by the desired one, and heading at the end of each step; nan after the last.
    fates, steps
        ``(N,)``: filled with what has become of each run, and in which step.
    """
    none = p[:0]
    pack_directions(none, w)
    for run in range(changes.shape[0]):
        w.clock[EVALUATIONS] = 0.0
        tape.counts[0] = tape.counts[1] = 0
        launch(p[0], none, w)
        for i in range(even.shape[0]):
            even[i, 0], even[i, 1] = w.legs[i, PHASE, 0], w.legs[i, STIFFNESS, 0]
        count, level = changes.shape[1], w.ground[0]
        fates[run], steps[run] = GOES_ON, count
        for step in range(1, count + 1):
            set_ground(w, p[0], level, changes[run, step - 1])
            # Those that land at the start have done so already.
            if step > 1:
                set_legs(w, even, changes[run, step - 1])
            status = take_step(w, step, float(count), scale, tape)
            fate = fate_of(w, status, pace, seen[run, step - 1])
            if fate != GOES_ON:
                fates[run], steps[run] = fate, step
                break
        for i in range(even.shape[0]):
            w.legs[i, PHASE, 0], w.legs[i, STIFFNESS, 0] = even[i, 0], even[i, 1]
