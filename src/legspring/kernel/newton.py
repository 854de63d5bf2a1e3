"""Newton's method, damped and with the exact Jacobian, for the conditions of a gait (Eqs. 3.1-3.4).

Levenberg and Marquardt's damping: far from a solution it follows the sum of squares downhill, near one it is
Newton's method.
"""

import math
from typing import NamedTuple

import numpy as np

from legspring.kernel.jit import driver, formula
from legspring.kernel.launch import DX, DY, HEADING, N_START, SPEED, START_YAW, START_YAW_RATE, TURN, launch
from legspring.kernel.stride import advance, copy
from legspring.kernel.walker import (
    ACTUATION,
    OK,
    PHASE,
    SIDE,
    VX,
    VY,
    YAW,
    YAW_RATE,
    Floats,
    Ints,
    Tape,
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
FIRST_DAMPING, MOST_DAMPING = 1e-3, 1e3


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


@formula
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


def gait_conditions(y: Floats, start: Floats, stride: float) -> tuple[Floats, Floats]:
    """Return the conditions of a gait after one step, and their derivatives in all directions (see `conditions`)."""
    residual, jacobian = np.zeros(y.shape[0]), np.zeros((y.shape[0], y.shape[1] - 1))
    write_conditions(y, start, stride, residual, jacobian)
    return residual, jacobian


@driver
def write_conditions(y: Floats, start: Floats, stride: float, residual: Floats, jacobian: Floats) -> None:
    """Do what `conditions` does for a caller in Python."""
    conditions(y, start, stride, residual, jacobian)


@formula
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
def sum_of_squares(r: Floats) -> float:
    """Sum of the squares of an array."""
    total = 0.0
    for value in r:
        total += value * value
    return total


@formula
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


class Workspace(NamedTuple):
    """Room for one search after another."""

    tape: Tape
    residual: Floats
    move: Floats
    trial: Floats
    jacobian: Floats
    square: Floats
    best_residual: Floats
    best_jacobian: Floats


@formula
def evaluate(w: Walker, start: Floats, pair: Ints, stride: float, z: Floats, scale: float, room: Workspace) -> float:
    """Write the conditions at z and their Jacobian; return the sum of squares, inf if the step cannot be taken."""
    set_unknowns(w, start, pair, stride, z)
    launch(w, start)
    if advance(w, 1.0, scale, room.tape) != OK:
        return math.inf
    conditions(w.y, start, stride, room.residual, room.jacobian)
    total = sum_of_squares(room.residual)
    return total if total < math.inf else math.inf


@formula
def find_zero(
    w: Walker,
    start: Floats,
    pair: Ints,
    stride: float,
    z: Floats,
    scale: float,
    goal: float,
    iterations: int,
    room: Workspace,
) -> tuple[int, int]:
    """Move the unknowns ``z``, in place, to where they fulfil a gait's conditions (see `find_zeros`).

    The conditions left there are in ``room.best_residual``. Returns how it ended, and the steps simulated.
    """
    for e in range(z.size):
        room.best_residual[e] = math.inf
    best, damping = math.inf, FIRST_DAMPING
    copy(z, room.trial)
    for iteration in range(1, iterations + 1):
        total = evaluate(w, start, pair, stride, room.trial, scale, room)
        if total < best:
            copy(room.trial, z)
            copy(room.residual, room.best_residual)
            copy(room.jacobian, room.best_jacobian)
            if largest(room.residual) <= goal:
                return CONVERGED, iteration
            if iteration > PATIENCE and total > 0.98 * best and total > NEAR**2:
                return STALLED, iteration
            best = total
            damping *= 0.2 if total > NEAR else 0.0
        elif best == math.inf:
            return BROKEN, iteration
        else:
            damping = max(5.0 * damping, 1e-6)
        solved, damping = damped_move(room.best_jacobian, room.best_residual, damping, room.square, room.move)
        if not solved or damping > MOST_DAMPING:
            return STALLED, iteration
        for e in range(z.size):
            room.trial[e] = z[e] + room.move[e]
        if not SLOWEST < room.trial[0] < FASTEST:
            return OUT_OF_RANGE, iteration
    return OUT_OF_STEPS, iterations


def find_zeros(
    w: Walker,
    start: Floats,
    pair: Ints,
    stride: float,
    actuation: Floats,
    z: Floats,
    scale: float,
    goal: float,
    iterations: int,
) -> tuple[Ints, Floats, Floats, int]:
    """Move each row of unknowns ``z``, in place, to where it fulfils a gait's conditions.

    Parameters
    ----------
    w, start
        Of `new_problem`.
    actuation
        ``(N, P)``: magnitudes for each pair of legs, m.
    z
        ``(N, n)``.
    scale
        Largest error estimate of an integration step, m.
    goal
        Largest residual to be reached.
    iterations
        Most iterations.

    Returns
    -------
    endings, residuals, squares, steps
        ``(N,)`` each: how it ended, the largest residual, the sum of squares; and the number of steps simulated in
        all.
    """
    rows, n = z.shape
    room = Workspace(
        new_tape(0, 0, 0, w),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros((n, n)),
        np.zeros((n, n)),
        np.zeros(n),
        np.zeros((n, n)),
    )
    endings, residuals, squares = np.zeros(rows, np.int64), np.zeros(rows), np.zeros(rows)
    steps = search(w, start, pair, stride, actuation, z, scale, goal, iterations, room, endings, residuals, squares)
    return endings, residuals, squares, steps


@driver
def search(
    w: Walker,
    start: Floats,
    pair: Ints,
    stride: float,
    actuation: Floats,
    z: Floats,
    scale: float,
    goal: float,
    iterations: int,
    room: Workspace,
    endings: Ints,
    residuals: Floats,
    squares: Floats,
) -> int:
    """Do the same with room to work in and for the results; return the number of steps."""
    steps = 0
    for row in range(z.shape[0]):
        for i in range(pair.size):
            w.legs[i, ACTUATION, 0] = w.contacts[i, SIDE] * actuation[row, pair[i]]
        endings[row], taken = find_zero(w, start, pair, stride, z[row], scale, goal, iterations, room)
        steps += taken
        residuals[row], squares[row] = largest(room.best_residual), sum_of_squares(room.best_residual)
    return steps
