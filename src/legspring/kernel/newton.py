"""Newton's method, damped and with the exact Jacobian, for the conditions of a gait (Eqs. 3.1-3.4).

Levenberg and Marquardt's damping: far from a solution it follows the sum of squares downhill, near one it is
Newton's method.
"""

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

CONVERGED, STALLED, OUT_OF_RANGE, OUT_OF_STEPS, BROKEN = 0, 1, 2, 3, 4
"""Endings of a search."""
SLOWEST, FASTEST = 0.2, 5.0
"""Range of the initial speed, in units of the desired one."""
LONGEST_MOVE = 1.0
"""Largest change of an unknown in one iteration."""
PATIENCE = 6
"""Iterations before a search may be given up for want of progress."""
NEAR = 1e-4
"""Sum of squared residuals below which Newton's method needs no damping."""
SAME = 1e-5
"""Difference below which two solutions are one."""


@driver
def new_problem(
    body: Floats,
    legs: Floats,
    side: Floats,
    offset: Floats,
    pair: Ints,
    heading: float,
    stride: float,
    rows: int,
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


@jit
def damped_move(jacobian: Floats, residual: Floats, damping: float, square: Floats, move: Floats) -> tuple[bool, float]:
    """Solve (J^T J + damping 1) move = -J^T r, with more damping while the move is too long.

    Returns
    -------
    solved, damping
        Whether there is a solution, and the damping that it took.
    """
    n = move.size
    for _ in range(20):
        for a in range(n):
            move[a] = 0.0
            for c in range(n):
                move[a] -= jacobian[c, a] * residual[c]
                square[a, c] = damping if a == c else 0.0
                for e in range(n):
                    square[a, c] += jacobian[e, a] * jacobian[e, c]
        if not solve(square, move):
            damping = max(5.0 * damping, 1e-9)
        elif largest(move) <= LONGEST_MOVE:
            return True, damping
        else:
            damping = max(5.0 * damping, 1e-6)
    return False, damping


@driver
def find_zero(
    w: Walker,
    start: Floats,
    pair: Ints,
    stride: float,
    z: Floats,
    scale: float,
    goal: float,
    iterations: int,
) -> tuple[int, float, int]:
    """Move the unknowns ``z``, in place, to where they fulfil a gait's conditions.

    Parameters
    ----------
    w, start
        Of `new_problem`.
    scale
        Largest error estimate of an integration step, m.
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
    residual, move, trial = np.zeros(n), np.zeros(n), z.copy()
    best_residual, best_jacobian = np.zeros(n), np.zeros((n, n))
    jacobian, square = np.zeros((n, n)), np.zeros((n, n))
    best, damping = math.inf, 1e-3
    for iteration in range(iterations):
        set_unknowns(w, start, pair, stride, trial)
        launch(w, start)
        total = math.inf
        if advance(w, 1.0, scale, tape) == OK:
            conditions(w.y, start, stride, residual, jacobian)
            total = np.sum(residual**2)
        if total < best:
            z[:] = trial
            best_residual[:], best_jacobian[:] = residual, jacobian
            if largest(residual) <= goal:
                return CONVERGED, largest(residual), iteration + 1
            if iteration > PATIENCE and total > 0.98 * best and total > NEAR**2:
                return STALLED, largest(residual), iteration + 1
            best = total
            damping *= 0.2 if total > NEAR else 0.0
        elif best == math.inf:
            return BROKEN, math.inf, iteration + 1
        else:
            damping = max(5.0 * damping, 1e-6)
        solved, damping = damped_move(best_jacobian, best_residual, damping, square, move)
        if not solved or damping > 1e3:
            return STALLED, largest(best_residual), iteration + 1
        trial[:] = z + move
        if not SLOWEST < trial[0] < FASTEST:
            return OUT_OF_RANGE, largest(best_residual), iteration + 1
    return OUT_OF_STEPS, largest(best_residual), iterations


@formula
def wrap(angle: float) -> float:
    """Return the same angle in (-pi, pi]."""
    return angle - 2.0 * math.pi * math.ceil(angle / (2.0 * math.pi) - 0.5)


@formula
def is_known(z: Floats, zeros: Floats, count: int, n_pairs: int) -> bool:
    """Whether a solution is among the first rows of ``zeros``."""
    for row in range(count):
        distance = 0.0
        for e in range(z.size):
            gap = z[e] - zeros[row, e]
            distance = max(distance, abs(wrap(gap) if 0 < e <= n_pairs else gap))
        if distance < SAME:
            return True
    return False


@driver
def find_zeros(
    w: Walker,
    start: Floats,
    pair: Ints,
    stride: float,
    starts: Floats,
    scale: float,
    goal: float,
    iterations: int,
    zeros: Floats,
    count: int,
) -> tuple[int, int]:
    """Search from each row of ``starts``; write what is new behind the first ``count`` rows of ``zeros``.

    Returns
    -------
    count, steps
        Number of solutions now, and of steps simulated.
    """
    steps, n_pairs = 0, pair.max() + 1
    for row in range(starts.shape[0]):
        z = starts[row].copy()
        ending, _, taken = find_zero(w, start, pair, stride, z, scale, goal, iterations)
        steps += taken
        for e in range(1, n_pairs + 1):
            z[e] = wrap(z[e])
        if ending == CONVERGED and count < zeros.shape[0] and not is_known(z, zeros, count, n_pairs):
            zeros[count] = z
            count += 1
    return count, steps
