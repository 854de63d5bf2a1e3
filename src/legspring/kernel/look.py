"""A quick look at candidates for gaits: how stances end, what perturbations become, what the legs' work is."""

import math

import numpy as np

from legspring.kernel.jit import driver, part
from legspring.kernel.launch import SPEED, launch
from legspring.kernel.measure import leg_work
from legspring.kernel.stride import advance
from legspring.kernel.walker import (
    ACTUATION,
    DOWN,
    LIFTOFF,
    OK,
    PHASE,
    VX,
    VY,
    Floats,
    Ints,
    Tape,
    X,
    Y,
    new_tape,
    new_walker,
)

ENDS, STRIDE, STEP, WORK = 0, 1, 2, 3
"""What to look for besides the ends of stances: the Jacobian of a stride's map or a step's, or the work of a step."""


@part
def liftoffs(tape: Tape, legs: Ints, out: Floats) -> None:
    """Write time of lift-off, and rate of ``|r| - l`` there, of legs put down at time 0: ``(P, 2)``, nan if none."""
    out[:] = np.nan
    for n in range(tape.counts[1] - 1, -1, -1):
        for row in range(legs.size):
            if tape.events[n, 1] == legs[row] and tape.events[n, 2] == LIFTOFF and 0.0 < tape.events[n, 0] < 2.0:
                out[row, 0], out[row, 1] = tape.events[n, 0], tape.events[n, 4]


@part
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


@driver
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
    scale: float,
    points: Floats,
    what: int,
) -> tuple[Floats, Floats, Floats, Floats]:
    """Simulate a stride from each of some candidates, of a body whose yaw is held.

    Parameters
    ----------
    body, legs, side, offset, start
        See `legspring.kernel.run.run`; the directions of the jets are those of the map.
    pair, first, lengths
        Pair of each leg; first leg and nominal length (m) of each pair.
    stride
        Desired displacement of a step, m: the unit of lengths.
    scale
        Largest error estimate of an integration step, m.
    points
        ``(N, 2 P + 1)``: actuation in units of the nominal lengths, speed, phases.
    what
        One of ``ENDS, STRIDE, STEP, WORK``.

    Returns
    -------
    ends, down, jacobians, work
        ``(N, P, 2)``: time of lift-off of each pair's first leg, and rate of ``|r| - l`` then; ``(N, L)``: whether legs
        are down at the start (1 or 0); ``(N, n, n)``; ``(N,)``: sum of the magnitudes of positive and negative work of
        the legs in a step, per mass. All nan where a stride cannot be simulated.
    """
    size, pairs, n = points.shape[0], lengths.size, start.shape[1] - 1
    ends, jacobians = np.full((size, pairs, 2), np.nan), np.full((size, n, n), np.nan)
    work, down = np.full(size, np.nan), np.full((size, pair.size), np.nan)
    w = new_walker(body, legs, side, offset, np.zeros((0, 3)), 4)
    tape = new_tape(180 if what == WORK else 0, 60, 0, w)
    for row in range(size):
        for i in range(pair.size):
            legs[i, ACTUATION, 0] = side[i] * points[row, pair[i]] * lengths[pair[i]]
            legs[i, PHASE, 0] = points[row, pairs + 1 + pair[i]]
        start[SPEED, 0] = points[row, pairs] * stride
        tape.counts[:] = 0
        launch(w, start)
        down[row] = w.contacts[:, DOWN]
        if advance(w, 1.0, scale, tape) != OK:
            continue
        if what == STEP:
            map_jacobian(w.y, stride, -1.0, jacobians[row])
        if advance(w, 2.0, scale, tape) != OK:
            continue
        if what == STRIDE:
            map_jacobian(w.y, stride, 1.0, jacobians[row])
        if what == WORK:
            work[row] = np.sum(np.abs(leg_work(tape, 0.0, 1.0)))
        liftoffs(tape, first, ends[row])
    return ends, down, jacobians, work
