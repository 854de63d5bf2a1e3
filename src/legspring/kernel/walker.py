"""The arrays that the kernel works on.

Units are metres and step durations: time is ``s = t / t_des``, so that the clock's events stay at fixed times
when t_des itself is varied, velocities are in m per step duration, and a leg's stiffness is ``k t_des^2 / m``.

Every array that can depend on a parameter is a *jet*: its last axis holds the value (0) and its derivatives in any
number of directions (1, 2, ...). The caller chooses the directions by the jets that it passes in; with a last
axis of length one there are none.
"""

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from legspring.kernel.jit import typeof

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Rows of a body jet.
GRAVITY, GYRATION, GRAVITY_X = 0, 1, 2
N_BODY = 3
# Rows of a start jet.
SPEED, HEADING, DX, DY, START_YAW, START_YAW_RATE, TURN = range(7)
N_START = 7
# Rows of a leg's parameters; the last three have no derivatives.
HIP_X, HIP_Y, STIFFNESS, LENGTH, ACTUATION, PHASE, ANGLE, DAMPING, STAY, OFFSET = range(10)
LEG_DX, LEG_DY, LEG_TURN, TRIGGER, FORMULA, MEMORY = range(10, 16)
N_VARIED, N_LEG = 13, 16
# The same rows, of a leg that does not go by the clock.
PLACE_X, PLACE_Y, AGE = LEG_DX, LEG_DY, LEG_TURN
# What is known of a leg that is not put down at the start by its offset: that it was put down before, and the body has
# moved evenly since, as the start says; the same, with a memory of its own; that it is up; that it is put down as well.
EVEN, OWN, UP, NOW = 0.0, 1.0, -1.0, 2.0
# What makes a leg touch down; from 1 on: the lift-off of the leg with this number, counted from 1.
CLOCK, GROUND = 0, -1
# Rows of a state; a body whose yaw is held has the first four only.
X, Y, VX, VY, YAW, YAW_RATE = 0, 1, 2, 3, 4, 5
# Rows of a stance: all that the force of a leg depends on while its foot stays where it is. From LAW on three
# coefficients of the length law (see `length`) and the time of touch-down; the damper's constant; and in what manner
# the force comes about, without derivatives: PLAIN, DAMPED, or above that the address of a length law's formula.
FOOT_X, FOOT_Y, GRIP_X, GRIP_Y, SPRING, LAW, BEGUN, DAMPER, MANNER = 0, 1, 2, 3, 4, 5, 8, 9, 10
N_STANCE = 11
PLAIN, DAMPED = 0.0, 1.0

# Columns of the contacts.
SIDE, SINCE, DOWN, SIGN, WATCHED, ARM_X, ARM_Y, LEVEL = range(8)
N_CONTACT = 8
# What is watched of a leg: nothing, when its force is zero, or when the height of its foot is.
NOTHING, FORCE, HEIGHT = 0.0, 1.0, 2.0
# Entries of the clock; the push is the outside acceleration now, as x0 + x1 s and y0 + y1 s.
TIME, NEXT_STEP, EVALUATIONS, LEVER, PUSH_X, PUSH_Y, EVENT_DRIVEN, ALL_PLAIN = 0, 1, 2, 3, 4, 6, 8, 9
SIDE_VIEW, FASTEST, SLOWEST = 10, 11, 12
N_CLOCK = 13

TOUCHDOWN, LIFTOFF = 0, 1

OK, STEP_TOO_SMALL, TOO_MANY_STEPS, EVENT_LOST, NO_TOUCHDOWN, TAPE_FULL, FALLEN = 0, 1, 2, 3, 4, 5, 6
"""Endings of an integration."""


class Walker(NamedTuple):
    """A body on springy legs at one moment: parameters, state, and room to compute in.

    Attributes
    ----------
    body
        ``(3, C)``: gravity along -y, ``g sin(slope) t_des^2`` as seen from above and ``g cos(slope) t_des^2`` from the
        side; ``m / I`` (0 where the yaw is held); and gravity along -x, ``g sin(slope) t_des^2`` from the side, else 0.
    legs
        ``(L, 16, C)``: hip x and y, stiffness, nominal length, actuation (signed), phase, placement angle, damping
        (``c t_des / m``); step durations from touch-down to lift-off, or 0: until its force is zero; offset (time of
        the first touch-down, from 0 to below 2; then every 2); of a leg that was put down before the start and has a
        memory of its own, displacement of the centre of mass (x, y) and change of yaw since then or, if it does not go
        by the clock, place of the foot seen from the centre of mass (x, y) and time since then; what makes it touch
        down (see `CLOCK`); address of a length law's formula (see `legspring.kernel.written`), or 0; what is known of
        the time before the start (see `EVEN`).
    start
        ``(7, C)``: speed, heading relative to the body, displacement of the centre of mass over the last step (x, y),
        yaw, yaw rate, and change of yaw over the last step. Of the legs that do not go by the clock none was down
        before if there was no displacement, (0, 0).
    push
        ``(P, 3)``: knots (time, x, y) of an acceleration from outside, linear in between, zero elsewhere.
    contacts
        ``(L, 8)``: side (-1: the leg pushes, +1: it pulls), time of the last touch-down, whether the leg is down
        (1 or 0), the sign of its gap since the end of the ignored window (0 before), what is watched of it (see
        `NOTHING`), from the centre of mass to the foot held ready (x, y, seen from the body), and the height of the
        ground. The gap of a leg in stance is its force by its stiffness, ``|r| - l`` where there is no damper; that of
        a leg which waits for the ground is the height of its foot above it.
    clock
        ``(13,)``: time, step size to try next, evaluations of the right-hand side so far, the length that makes an
        error of the yaw one of a position, the push now, whether no leg touches down by the clock, whether the
        manner of all legs is plain, whether a leg touches down on the ground; and the shortest and the longest of the
        motion's own times (see `legspring.kernel.launch.set_natural_times`), by which what is short or long is judged.
    y
        ``(n, C)``: x, y, their rates and, where the body yaws, the yaw and its rate.
    stance
        ``(L, 11, C)``: foot x and y, hip x and y, stiffness, the three coefficients of the length law, time of
        touch-down, damper, manner.
    k, ahead, room, gaps
        Room for the rates at the stages of a step ``(16, n, C)``, the state at its end and inside ``(n, C)``, and
        each leg's gap with its first two rates at its start and end ``(2, L, 3)``.
    phases
        ``(2, 12)``: sine and cosine of pi times the times of the stages of a step, but the first.
    struts
        ``(16, L, 7)``: plain legs in stance at these stages, for the derivatives: direction from hip to foot (x, y),
        hip seen from the centre of mass (x, y), gap, and stiffness across and, less that across, along the leg.
    ground, delay, lag
        ``(C,)``: height of the ground, and derivatives of the times of an event and of the end of the last step.
    section, late
        ``(n, C)``: state at the start of the last step; what the touch-downs at its end, if their times move, do to the
        derivatives.
    places
        ``(L, 3, C)``: x, y and yaw of the body at the last touch-down of each leg.
    apex
        ``(C,)``: from the side, the largest height above the ground in flight; nan where there is none.
    flat_y, flat_k, flat_ahead
        The same memory as ``y``, ``k`` and ``ahead``, with the last two axes made one.
    """

    body: Floats
    legs: Floats
    start: Floats
    push: Floats
    contacts: Floats
    clock: Floats
    y: Floats
    stance: Floats
    k: Floats
    ahead: Floats
    room: Floats
    gaps: Floats
    phases: Floats
    struts: Floats
    ground: Floats
    delay: Floats
    lag: Floats
    section: Floats
    late: Floats
    places: Floats
    apex: Floats
    flat_y: Floats
    flat_k: Floats
    flat_ahead: Floats


class Tape(NamedTuple):
    """What happened, step by step; of length zero where nobody asks.

    Attributes
    ----------
    counts
        ``(2,)``: number of steps and of events.
    time, size
        ``(M + 1,)``, ``(M,)``: start and size of each step. A step that ends at an event may end a hair before or
        after its size says; the start of the next one is exact.
    y
        ``(M + 1, n, C)``: state at the start of each step, and at the end.
    dense
        ``(M, 7, n, C)``: coefficients of the interpolant.
    stance, down
        ``(M, L, 11, C)``, ``(M, L)``: the legs during each step, and whether they are down (1 or 0).
    events
        ``(E, 5)``: time, leg, kind, step that it precedes, and, at lift-off by zero force, the rate of the gap.
    """

    counts: Ints
    time: Floats
    size: Floats
    y: Floats
    dense: Floats
    stance: Floats
    down: Floats
    events: Floats


FEWEST_DIRECTIONS = 4
"""Jets have room for as many at least, or for none: four at a time are faster than one."""


def new_walker(
    side: Floats, trigger: Floats, law: Floats, memory: Floats, push: Floats, rows: int, directions: int
) -> Walker:
    """Return a walker with its numbers still to be packed; ``rows`` is 4 where the yaw is held, else 6."""
    n_legs, width = len(side), 1 + (max(directions, FEWEST_DIRECTIONS) if directions else 0)
    legs, contacts = np.zeros((n_legs, N_LEG, width)), np.zeros((n_legs, N_CONTACT))
    legs[:, TRIGGER, 0], legs[:, FORMULA, 0], legs[:, MEMORY, 0], contacts[:, SIDE] = trigger, law, memory, side
    clock = np.zeros(N_CLOCK)
    clock[SIDE_VIEW] = float(GROUND in trigger.tolist())
    y, k = np.zeros((rows, width)), np.zeros((16, rows, width))
    ahead, room = np.zeros((rows, width)), np.zeros((rows, width))
    return Walker(
        np.zeros((N_BODY, width)),
        legs,
        np.zeros((N_START, width)),
        push,
        contacts,
        clock,
        y,
        np.zeros((n_legs, N_STANCE, width)),
        k,
        ahead,
        room,
        np.zeros((2, n_legs, 3)),
        np.zeros((2, 12)),
        np.zeros((16, n_legs, 7)),
        np.zeros(width),
        np.zeros(width),
        np.zeros(width),
        np.zeros((rows, width)),
        np.zeros((rows, width)),
        np.zeros((n_legs, 3, width)),
        np.zeros(width),
        y.reshape(-1),
        k.reshape(16, -1),
        ahead.reshape(-1),
    )


def new_tape(steps: int, events: int, w: Walker) -> Tape:
    """Return an empty tape for so many steps and events (none: they are not recorded)."""
    n_legs, _, width = w.legs.shape
    if not steps and not events:
        return no_tape(n_legs, w.y.shape[0], width)
    return blank_tape(steps, events, n_legs, w.y.shape[0], width)


@cache
def no_tape(n_legs: int, rows: int, width: int) -> Tape:
    """Return a tape without any room, on which nothing is ever written."""
    return blank_tape(0, 0, n_legs, rows, width)


def blank_tape(steps: int, events: int, n_legs: int, rows: int, width: int) -> Tape:
    """Return an empty tape."""
    return Tape(
        np.zeros(2, np.int64),
        np.zeros(steps + 1),
        np.zeros(steps),
        np.zeros((steps + 1, rows, width)),
        np.zeros((steps, 7, rows, width)),
        np.zeros((steps, n_legs, N_STANCE, width)),
        np.zeros((steps, n_legs)),
        np.zeros((events, 5)),
    )


_none = np.zeros(1)
_example = new_walker(_none, _none, _none, _none, np.zeros((1, 3)), 4, 0)
WALKER: Any = typeof(_example)
"""Numba's type of all walkers."""
TAPE: Any = typeof(new_tape(1, 1, _example))
ROW, JET, JETS = typeof(_example.clock), typeof(_example.y), typeof(_example.k)
