"""Newton's method, with the exact Jacobian, for the conditions of a gait (Eqs. 3.1-3.4)."""

import math

import numpy as np

from legspring.kernel.jit import driver, formula, jit
from legspring.kernel.launch import DX, DY, HEADING, N_START, SPEED, START_YAW, START_YAW_RATE, TURN, launch
from legspring.kernel.stride import advance
from legspring.kernel.walker import (
    OK,
    PHASE,
    VX,
    VY,
    YAW,
    YAW_RATE,
    Floats,
    Ints,
    Walker,
    X,
    Y,
    new_tape,
    new_walker,
)

CONVERGED, STALLED, SINGULAR, OUT_OF_RANGE, OUT_OF_STEPS, BROKEN = 0, 1, 2, 3, 4, 5
"""Endings of a search."""
SLOWEST, FASTEST = 0.05, 5.0
"""Range of the initial speed, in units of the desired one."""
LONGEST_MOVE = 0.6
"""Largest change of an unknown in one iteration."""
MOST_HALVINGS = 6


@driver
def new_problem(
    body: Floats, legs: Floats, side: Floats, offset: Floats, pair: Ints, heading: float, stride: float, rows: int
) -> tuple[Walker, Floats]:
    """Return a walker and a start whose directions are the unknowns of a gait.

    The unknowns are the initial speed in units of the desired one, the phase of each pair of legs and, where the
    body yaws, yaw and yaw rate. ``stride`` is the desired displacement of a step, v_des t_des.
    """
    n_pairs = pair.max() + 1
    width = 2 + n_pairs + (2 if rows == 6 else 0)
    leg_jet = np.zeros((legs.shape[0], legs.shape[1], width))
    body_jet = np.zeros((body.size, width))
    start = np.zeros((N_START, width))
    leg_jet[:, :, 0] = legs
    body_jet[:, 0] = body
    start[HEADING, 0] = heading
    start[DX, 0] = 0.0
    start[DY, 0] = stride
    start[SPEED, 1] = stride
    for i in range(pair.size):
        leg_jet[i, PHASE, 2 + pair[i]] = 1.0
    if rows == 6:
        start[START_YAW, width - 2] = 1.0
        start[TURN, width - 2] = 2.0
        start[START_YAW_RATE, width - 1] = 1.0
    return new_walker(body_jet, leg_jet, side, offset, np.zeros((0, 3)), rows), start


@formula
def set_unknowns(w: Walker, start: Floats, pair: Ints, stride: float, z: Floats) -> None:
    """Put the unknowns into a problem."""
    start[SPEED, 0] = z[0] * stride
    for i in range(pair.size):
        w.legs[i, PHASE, 0] = z[1 + pair[i]]
    if w.y.shape[0] == 6:
        start[START_YAW, 0] = z[z.size - 2]
        start[TURN, 0] = 2.0 * z[z.size - 2]
        start[START_YAW_RATE, 0] = z[z.size - 1]


@jit
def conditions(y: Floats, start: Floats, stride: float, residual: Floats, jacobian: Floats) -> None:
    """Write the conditions of a gait after one step, and their derivatives.

    In this order: speed and heading (mirrored) as at the start, desired progress, no sideways displacement; for a
    body that yaws, yaw and yaw rate mirrored. Each is scaled by v_des, 1 rad, v_des, v_des t_des, 1 rad, 1 rad/t_des.
    """
    vx, vy = y[VX, 0], y[VY, 0]
    speed = math.hypot(vx, vy)
    yaws = y.shape[0] == 6
    residual[0] = (speed - start[SPEED, 0]) / stride
    residual[1] = math.atan2(-vx, vy) + start[HEADING, 0]
    residual[2] = y[Y, 0] / stride - 1.0
    residual[3] = y[X, 0] / stride
    for d in range(1, y.shape[1]):
        jacobian[0, d - 1] = ((vx * y[VX, d] + vy * y[VY, d]) / speed - start[SPEED, d]) / stride
        jacobian[1, d - 1] = (vx * y[VY, d] - vy * y[VX, d]) / speed**2 + start[HEADING, d]
        jacobian[2, d - 1] = y[Y, d] / stride
        jacobian[3, d - 1] = y[X, d] / stride
    if yaws:
        residual[1] -= y[YAW, 0]
        residual[4] = y[YAW, 0] + start[START_YAW, 0]
        residual[5] = y[YAW_RATE, 0] + start[START_YAW_RATE, 0]
        for d in range(1, y.shape[1]):
            jacobian[1, d - 1] -= y[YAW, d]
            jacobian[4, d - 1] = y[YAW, d] + start[START_YAW, d]
            jacobian[5, d - 1] = y[YAW_RATE, d] + start[START_YAW_RATE, d]


@jit
def solve(a: Floats, b: Floats) -> bool:
    """Solve a x = b in place by Gauss's elimination with row exchange; False if a is singular."""
    n = b.size
    for c in range(n):
        best = c
        for r in range(c + 1, n):
            if abs(a[r, c]) > abs(a[best, c]):
                best = r
        if not abs(a[best, c]) > 1e-14:
            return False
        for j in range(n):
            a[c, j], a[best, j] = a[best, j], a[c, j]
        b[c], b[best] = b[best], b[c]
        for r in range(c + 1, n):
            factor = a[r, c] / a[c, c]
            b[r] -= factor * b[c]
            for j in range(c, n):
                a[r, j] -= factor * a[c, j]
    for c in range(n - 1, -1, -1):
        for j in range(c + 1, n):
            b[c] -= a[c, j] * b[j]
        b[c] /= a[c, c]
    return True


@formula
def largest(r: Floats) -> float:
    """Largest magnitude in an array."""
    most = 0.0
    for value in r:
        most = max(most, abs(value))
    return most


@formula
def deflation(z: Floats, move: Floats, known: Floats, n_known: int) -> float:
    """Factor that bends Newton's move away from solutions known already.

    For the conditions multiplied by the product of (1 + 1/|z - z_j|^2), whose zeros are the others only, Newton's
    move is the same but for a factor (Farrell, Birkisson and Funke 2015, SIAM J. Sci. Comput. 37, A2026).
    """
    slope = 0.0
    for j in range(n_known):
        square = along = 0.0
        for e in range(z.size):
            gap = z[e] - known[j, e]
            if 0 < e <= 3:
                gap -= 2.0 * math.pi * round(gap / (2.0 * math.pi))
            square += gap * gap
            along += gap * move[e]
        slope -= 2.0 * along / (square * (square + 1.0))
    factor = 1.0 / (1.0 + slope) if slope != -1.0 else 1.0
    return factor


@driver
def find_zero(
    w: Walker,
    start: Floats,
    pair: Ints,
    stride: float,
    z: Floats,
    known: Floats,
    n_known: int,
    scale: float,
    goal: float,
    iterations: int,
) -> tuple[int, float, int]:
    """Move the unknowns ``z``, in place, to a gait's conditions.

    Parameters
    ----------
    w, start
        Of `new_problem`.
    known, n_known
        Solutions to stay away from, one a row.
    scale
        Error of an integration step, m.
    goal
        Largest residual to be reached.
    iterations
        Most iterations.

    Returns
    -------
    ending, residual, steps
        How it ended, the largest residual, and the number of steps simulated.
    """
    n = z.size
    tape = new_tape(0, 0, w)
    residual, move, trial = np.zeros(n), np.zeros(n), np.zeros(n)
    jacobian = np.zeros((n, n))
    trial[:] = z
    worst, steps, factor, cut = math.inf, 0, 1.0, 0
    for _ in range(iterations):
        set_unknowns(w, start, pair, stride, trial)
        launch(w, start)
        steps += 1
        if advance(w, 1.0, scale, tape) != OK:
            return BROKEN, worst, steps
        conditions(w.y, start, stride, residual, jacobian)
        size = largest(residual)
        if not size < math.inf:
            return BROKEN, worst, steps
        if n_known == 0 and size > 1.5 * worst and cut < MOST_HALVINGS:
            # Worse than before: half the way.
            cut += 1
            factor *= 0.5
            for e in range(n):
                trial[e] = z[e] + factor * move[e]
            continue
        cut, worst = 0, size
        z[:] = trial
        if worst <= goal:
            return CONVERGED, worst, steps
        for e in range(n):
            move[e] = -residual[e]
        if not solve(jacobian, move):
            return SINGULAR, worst, steps
        factor = deflation(z, move, known, n_known) if n_known > 0 else 1.0
        longest = abs(factor) * largest(move)
        if longest > LONGEST_MOVE:
            factor *= LONGEST_MOVE / longest
        for e in range(n):
            trial[e] = z[e] + factor * move[e]
        if not SLOWEST < trial[0] < FASTEST:
            return OUT_OF_RANGE, worst, steps
    return OUT_OF_STEPS, worst, steps
