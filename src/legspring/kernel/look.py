"""A quick look at candidates for gaits: their conditions, how stances begin and end, their Jacobian, their work."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from legspring.kernel.jit import driver, formula
from legspring.kernel.launch import HEADING, SPEED, launch
from legspring.kernel.measure import leg_work
from legspring.kernel.newton import conditions
from legspring.kernel.stride import advance, copy
from legspring.kernel.walker import (
    ACTUATION,
    ANGLE,
    DOWN,
    LIFTOFF,
    OFFSET,
    OK,
    PHASE,
    SIDE,
    TAPE_FULL,
    VX,
    VY,
    Floats,
    Ints,
    Tape,
    Walker,
    X,
    Y,
    new_tape,
    new_walker,
)

ENDS, STRIDE, STEP, WORK = 0, 1, 2, 3
"""What to look for besides the ends of stances: the Jacobian of a stride's map or a step's, or the work of a step."""


@formula
def liftoffs(tape: Tape, legs: Ints, out: Floats) -> None:
    """Write time of lift-off, and rate of ``|r| - l`` there, of legs put down at time 0: ``(P, 2)``, nan if none."""
    for row in range(legs.size):
        out[row, 0] = out[row, 1] = math.nan
    for n in range(tape.counts[1] - 1, -1, -1):
        for row in range(legs.size):
            if tape.events[n, 1] == legs[row] and tape.events[n, 2] == LIFTOFF and 0.0 < tape.events[n, 0] < 2.0:
                out[row, 0], out[row, 1] = tape.events[n, 0], tape.events[n, 4]


@formula
def map_jacobian(y: Floats, unit: float, mirror: float, out: Floats) -> None:
    """Write the Jacobian of the map of speed, heading and, if there is room, the displacement; lengths in units."""
    vx, vy = y[VX, 0], y[VY, 0]
    speed = math.hypot(vx, vy)
    n = out.shape[0]
    for d in range(n):
        scale = 1.0 if d == 1 else unit
        out[0, d] = (vx * y[VX, d + 1] + vy * y[VY, d + 1]) / speed * scale / unit
        out[1, d] = mirror * (vx * y[VY, d + 1] - vy * y[VX, d + 1]) / speed**2 * scale
        if n == 4:
            out[2, d], out[3, d] = mirror * y[X, d + 1] * scale / unit, y[Y, d + 1] * scale / unit


@formula
def place(w: Walker, start: Floats, pair: Ints, lengths: Floats, stride: float, point: Floats) -> None:
    """Put a candidate's actuation, speed and phases into a walker, and launch it."""
    pairs = lengths.size
    for i in range(pair.size):
        w.legs[i, ACTUATION, 0] = w.contacts[i, SIDE] * point[pair[i]] * lengths[pair[i]]
        w.legs[i, PHASE, 0] = point[pairs + 1 + pair[i]]
    start[SPEED, 0] = point[pairs] * stride
    launch(w, start)


@formula
def write_angles(
    w: Walker,
    first: Ints,
    lengths: Floats,
    heading: float,
    stride: float,
    rate: float,
    p: Floats,
    ends: Floats,
    out: Floats,
) -> None:
    """Write the angles, in degrees, between length and force-free length against time where stances begin and end.

    Both rates are known from the candidate at touch-down, and differ by the gap's rate at lift-off. The sign is such
    that the angle is positive where the leg begins, and ends, with the force of its function.
    """
    pairs = first.size
    for n in range(pairs):
        i = first[n]
        side, phase = w.contacts[i, SIDE], p[pairs + 1 + n]
        swing = -math.pi * side * p[n] * lengths[n] * rate
        down, up = swing * math.cos(phase), swing * math.cos(math.pi * ends[n, 0] + phase)
        approach = -p[pairs] * stride * math.cos(w.legs[i, ANGLE, 0] - heading) * rate
        out[n, 0] = side * math.degrees(math.atan(approach) - math.atan(down))
        out[n, 1] = -side * math.degrees(math.atan(up + ends[n, 1] * rate) - math.atan(up))


@formula
def fulfils(w: Walker, down: Floats, first: Ints, pair: Ints, ends: Floats) -> bool:
    """Whether legs lift off as their function wants, and those down at the start are those that lift off late."""
    for n in range(first.size):
        if not ends[n, 1] * w.contacts[first[n], SIDE] < 0.0:
            return False
    for i in range(pair.size):
        if w.contacts[i, OFFSET] != 0.0 and (ends[pair[i], 0] > 1.0) != (down[i] != 0.0):
            return False
    return True


def conditions_at(
    body: Floats,
    legs: Floats,
    side: Floats,
    offset: Floats,
    pair: Ints,
    lengths: Floats,
    start: Floats,
    stride: float,
    scale: float,
    points: Floats,
) -> tuple[Floats, Floats]:
    """Return what is left of the conditions of a gait for candidates, and its derivatives.

    Parameters
    ----------
    body, legs, side, offset, pair, lengths, start, stride, scale, points
        See `look`.

    Returns
    -------
    residuals, jacobians
        ``(N, 4)``, ``(N, 4, D)`` in the jets' directions; nan where a step cannot be simulated.
    """
    size = points.shape[0]
    residuals, jacobians = np.full((size, 4), np.nan), np.full((size, 4, start.shape[1] - 1), np.nan)
    w = new_walker(body, legs, side, offset, np.zeros((0, 3)), 4)
    tape = new_tape(0, 0, 0, w)
    look_after_a_step(w, tape, pair, lengths, start.copy(), stride, scale, points, residuals, jacobians)
    return residuals, jacobians


@driver
def look_after_a_step(
    w: Walker,
    tape: Tape,
    pair: Ints,
    lengths: Floats,
    start: Floats,
    stride: float,
    scale: float,
    points: Floats,
    residuals: Floats,
    jacobians: Floats,
) -> None:
    """Do the same with a walker, a tape and room for the results."""
    for row in range(points.shape[0]):
        place(w, start, pair, lengths, stride, points[row])
        if advance(w, 1.0, scale, tape) == OK:
            conditions(w.y, start, stride, residuals[row], jacobians[row])


def look(
    body: Floats,
    legs: Floats,
    side: Floats,
    offset: Floats,
    pair: Ints,
    first: Ints,
    lengths: Floats,
    start: Floats,
    stride: float,
    rate: float,
    scale: float,
    points: Floats,
    what: int,
) -> tuple[Floats, NDArray[np.bool_], Floats, Floats]:
    """Simulate a stride from each of some candidates, of a body whose yaw is held.

    Parameters
    ----------
    body, legs, side, offset, start
        See `legspring.kernel.run.run`; the directions of the jets are those of the map.
    pair, first, lengths
        Pair of each leg; first leg and nominal length (m) of each pair.
    stride
        Desired displacement of a step, m: the unit of lengths.
    rate
        Step durations a second.
    scale
        Largest error estimate of an integration step, m.
    points
        ``(N, 2 P + 1)``: actuation in units of the nominal lengths, speed, phases.
    what
        One of ``ENDS, STRIDE, STEP, WORK``.

    Returns
    -------
    angles, is_gait, jacobians, work
        ``(N, P, 2)`` (see `write_angles`); ``(N,)`` (see `fulfils`); ``(N, n, n)``; ``(N,)``: sum of the magnitudes of
        positive and negative work of the legs in a step, per mass. Nan or False where a stride cannot be simulated.
    """
    size, pairs, n = points.shape[0], lengths.size, start.shape[1] - 1
    out = Sight(
        np.full((size, pairs, 2), np.nan),
        np.zeros(size, np.bool_),
        np.full((size, n, n), np.nan),
        np.full(size, np.nan),
        np.full((pairs, 2), np.nan),
        np.zeros(pair.size),
    )
    w = new_walker(body, legs, side, offset, np.zeros((0, 3)), 4)
    room, full = 60, True
    while full:
        tape = new_tape(3 * room if what == WORK else 0, room, 0, w)
        full = look_along_a_stride(w, tape, pair, first, lengths, start.copy(), stride, rate, scale, points, what, out)
        room *= 2
    return out.angles, out.is_gait, out.jacobians, out.work


class Sight(NamedTuple):
    """What `look` returns, and ends of stances and legs down at the start of one candidate."""

    angles: Floats
    is_gait: NDArray[np.bool_]
    jacobians: Floats
    work: Floats
    ends: Floats
    down: Floats


@driver
def look_along_a_stride(
    w: Walker,
    tape: Tape,
    pair: Ints,
    first: Ints,
    lengths: Floats,
    start: Floats,
    stride: float,
    rate: float,
    scale: float,
    points: Floats,
    what: int,
    out: Sight,
) -> bool:
    """Do what `look` does with a walker, a tape and room for the results; return whether the tape was too short."""
    for row in range(points.shape[0]):
        tape.counts[0] = tape.counts[1] = 0
        place(w, start, pair, lengths, stride, points[row])
        copy(w.contacts[:, DOWN], out.down)
        status = advance(w, 1.0, scale, tape)
        if status == OK and what == STEP:
            map_jacobian(w.y, stride, -1.0, out.jacobians[row])
        if status == OK:
            status = advance(w, 2.0, scale, tape)
        if status == TAPE_FULL:
            return True
        if status != OK:
            continue
        if what == STRIDE:
            map_jacobian(w.y, stride, 1.0, out.jacobians[row])
        if what == WORK:
            out.work[row] = np.sum(np.abs(leg_work(tape, 0.0, 1.0)))
        liftoffs(tape, first, out.ends)
        write_angles(w, first, lengths, start[HEADING, 0], stride, rate, points[row], out.ends, out.angles[row])
        out.is_gait[row] = fulfils(w, out.down, first, pair, out.ends)
    return False
