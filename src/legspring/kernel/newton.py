"""Newton's method, damped and with the exact Jacobian, for conditions on the two ends of some steps.

Levenberg and Marquardt's damping: far from a solution it follows the sum of squares downhill, near one it is
Newton's method. What the unknowns and the conditions mean is not known here: unknowns are steps along directions in the
space of parameters, conditions are linear in the parameters and in what is observed at the end.
"""

import math
from typing import NamedTuple

import numpy as np

from legspring.kernel.contact import copy
from legspring.kernel.jit import driver, formula
from legspring.kernel.launch import launch
from legspring.kernel.many import observe, take_step
from legspring.kernel.pack import pack_directions
from legspring.kernel.walker import EVALUATIONS, FASTEST, OK, TIME, Floats, Ints, Tape, Walker, new_tape

CONVERGED, STALLED, OUT_OF_RANGE, OUT_OF_STEPS, BROKEN = 0, 1, 2, 3, 4
"""Endings of a search."""
LONGEST_MOVE = 1.0
"""Largest change of an unknown in one iteration."""
PATIENCE = 6
"""Iterations before a search may be given up for want of progress."""
SLOW, LITTLE = 0.98, 0.95
"""What is left of the sum of squares after a move that was not worth it, and if the move before had failed."""
NEAR = 1e-4
"""Sum of squared residuals below which Newton's method needs no damping."""
FIRST_DAMPING, MOST_DAMPING = 1e-3, 1e3
NO_TIME = 1e-4
"""Duration, in the shortest of the motion's own times, that is none."""


class Task(NamedTuple):
    """What is to be solved, for m conditions and n unknowns.

    Attributes
    ----------
    along
        ``(n, P)``: directions, in the space of the P parameters, that the unknowns are steps along.
    moved
        Parameters that the unknowns move.
    low, high
        ``(n,)``: range that the unknowns are not to leave.
    at_end, at_start, given
        ``(m, n_seen)``, ``(m, P)``, ``(m,)``: what must be zero is ``at_end @ seen + at_start @ p - given``.
    rows, columns
        What is used of ``seen`` and of ``p``.
    turns
        ``(m,)``: what a condition may differ by and be the same (a whole turn of an angle), or 0.
    stops
        Whether a search ends where it would leave the range; else it takes shorter steps.
    """

    along: Floats
    moved: Ints
    low: Floats
    high: Floats
    at_end: Floats
    at_start: Floats
    rows: Ints
    columns: Ints
    given: Floats
    turns: Floats
    stops: bool


class Workspace(NamedTuple):
    """Room for one search after another."""

    tape: Tape
    p: Floats
    seen: Floats
    residual: Floats
    move: Floats
    trial: Floats
    jacobian: Floats
    square: Floats
    best_residual: Floats
    best_jacobian: Floats


class Found(NamedTuple):
    """Where N searches ended: how, the largest condition left and the sum of squares; steps and evaluations it took."""

    endings: Ints
    residuals: Floats
    squares: Floats
    steps: Ints
    evaluations: Ints


def new_workspace(task: Task, w: Walker) -> Workspace:
    """Return room to search in."""
    (n, parameters), m = task.along.shape, len(task.given)
    seen = np.zeros((task.at_end.shape[1], 1 + n))
    return Workspace(
        new_tape(0, 0, w),
        np.zeros(parameters),
        seen,
        np.zeros(m),
        np.zeros(n),
        np.zeros(n),
        np.zeros((m, n)),
        np.zeros((n, n)),
        np.zeros(m),
        np.zeros((m, n)),
    )


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
    for _ in range(20):
        for a in range(move.size):
            move[a] = 0.0
            for e in range(residual.size):
                move[a] -= jacobian[e, a] * residual[e]
            for c in range(move.size):
                square[a, c] = damping if a == c else 0.0
                for e in range(residual.size):
                    square[a, c] += jacobian[e, a] * jacobian[e, c]
        if not solve(square, move):
            damping = max(5.0 * damping, 1e-9)
        elif largest(move) <= LONGEST_MOVE:
            return True, damping
        else:
            damping = max(5.0 * damping, 1e-6)
    return False, damping


@formula
def left_by(jacobian: Floats, residual: Floats, move: Floats) -> float:
    """Sum of squares that a move leaves by the Jacobian."""
    total = 0.0
    for e in range(residual.size):
        left = residual[e]
        for a in range(move.size):
            left += jacobian[e, a] * move[a]
        total += left * left
    return total


@formula
def write_conditions(task: Task, seen: Floats, p: Floats, residual: Floats, jacobian: Floats) -> None:
    """Write what is left of the conditions, and their derivatives by the unknowns."""
    for c in range(residual.size):
        residual[c] = -task.given[c]
        for j in task.columns:
            residual[c] += task.at_start[c, j] * p[j]
        for row in task.rows:
            residual[c] += task.at_end[c, row] * seen[row, 0]
        if task.turns[c] > 0.0:
            residual[c] -= task.turns[c] * round(residual[c] / task.turns[c])
        for d in range(jacobian.shape[1]):
            jacobian[c, d] = 0.0
            for j in task.columns:
                jacobian[c, d] += task.at_start[c, j] * task.along[d, j]
            for row in task.rows:
                jacobian[c, d] += task.at_end[c, row] * seen[row, 1 + d]


@formula
def evaluate(w: Walker, task: Task, base: Floats, z: Floats, steps: int, scale: float, room: Workspace) -> float:
    """Write the conditions at z and their Jacobian; return the sum of squares, inf if a step cannot be taken."""
    copy(base, room.p)
    for j in task.moved:
        for e in range(z.size):
            room.p[j] += z[e] * task.along[e, j]
    launch(room.p, task.along, w)
    for step in range(1, steps + 1):
        if take_step(w, step, float(steps), scale, room.tape) != OK:
            return math.inf
    if w.clock[TIME] < NO_TIME * w.clock[FASTEST]:
        # A foot that is put down while it does not come down is put down again at once: that repeats itself, too.
        return math.inf
    observe(w, room.p, task.along, room.seen)
    write_conditions(task, room.seen, room.p, room.residual, room.jacobian)
    total = sum_of_squares(room.residual)
    return total if total < math.inf else math.inf


@formula
def is_inside(task: Task, z: Floats) -> bool:
    """Whether unknowns are in their range."""
    inside = True
    for e in range(z.size):
        inside &= task.low[e] < z[e] < task.high[e]
    return inside


@formula
def find_zero(
    w: Walker,
    task: Task,
    base: Floats,
    z: Floats,
    steps: int,
    scale: float,
    goal: float,
    iterations: int,
    room: Workspace,
) -> tuple[int, int]:
    """Move the unknowns ``z``, in place, to where they fulfil the conditions (see `find_zeros`).

    The conditions left there are in ``room.best_residual``. Returns how it ended, and the iterations.
    """
    for c in range(room.best_residual.size):
        room.best_residual[c] = math.inf
    best, damping, inside, failed = math.inf, FIRST_DAMPING, True, False
    copy(z, room.trial)
    for iteration in range(1, iterations + 1):
        total = evaluate(w, task, base, room.trial, steps, scale, room) if inside else math.inf
        if total < best:
            copy(room.trial, z)
            copy(room.residual, room.best_residual)
            copy(room.jacobian, room.best_jacobian)
            if largest(room.residual) <= goal:
                return CONVERGED, iteration
            slow = iteration > PATIENCE and total > SLOW * best and total > NEAR**2
            if slow or (failed and total > LITTLE * best):
                return STALLED, iteration
            damping *= 0.2 if failed or total > NEAR else 0.0
            best, failed = total, False
        elif best == math.inf:
            return BROKEN, iteration
        else:
            damping, failed = max(5.0 * damping, 1e-6), True
        solved, damping = damped_move(room.best_jacobian, room.best_residual, damping, room.square, room.move)
        # Where a leg lifts off another way the conditions jump, and no move that is short enough gains anything.
        vain = failed and inside and left_by(room.best_jacobian, room.best_residual, room.move) > LITTLE * best
        if not solved or vain or damping > MOST_DAMPING:
            return STALLED if inside else OUT_OF_RANGE, iteration
        for e in range(z.size):
            room.trial[e] = z[e] + room.move[e]
        inside = is_inside(task, room.trial)
        if task.stops and not inside:
            return OUT_OF_RANGE, iteration
    return OUT_OF_STEPS, iterations


@driver
def find_zeros(
    w: Walker,
    task: Task,
    p: Floats,
    z: Floats,
    steps: int,
    scale: float,
    goal: float,
    iterations: int,
    room: Workspace,
    found: Found,
) -> None:
    """Move each row of unknowns ``z``, in place, to where it fulfils the conditions.

    Parameters
    ----------
    w, room
        Room to work in, with what is no number.
    task
        What is to be solved.
    p, z
        ``(N, P)``, ``(N, n)``: parameters where the unknowns are zero, and the unknowns to start from.
    steps
        After which the conditions are looked at.
    scale
        Largest error estimate of an integration step, m.
    goal
        Largest residual to be reached.
    iterations
        Most iterations.
    found
        Filled.
    """
    pack_directions(task.along, w)
    for row in range(z.shape[0]):
        w.clock[EVALUATIONS] = 0.0
        ending, taken = find_zero(w, task, p[row], z[row], steps, scale, goal, iterations, room)
        found.endings[row], found.steps[row] = ending, taken * steps
        found.evaluations[row] = int(w.clock[EVALUATIONS])
        found.residuals[row], found.squares[row] = largest(room.best_residual), sum_of_squares(room.best_residual)
