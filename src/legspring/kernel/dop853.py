"""One step of the Runge-Kutta method of order 8 of Dormand and Prince, with its interpolant.

E. Hairer, S. P. Norsett, G. Wanner, *Solving Ordinary Differential Equations I*, section II.10; the coefficients are
those that SciPy carries.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853

from legspring.kernel.jit import formula, jit
from legspring.kernel.length import Pair, phase_at
from legspring.kernel.motion import ONE, THREE, TWO, Index, rates, tangent_rates
from legspring.kernel.walker import (
    ALL_PLAIN,
    EVALUATIONS,
    FASTEST,
    LEVER,
    VX,
    VY,
    YAW,
    YAW_RATE,
    Floats,
    Walker,
    X,
    Y,
)

STAGES = 12


def all_weights() -> Floats:
    """Weights of the rates in the stages of a step; row 12 is its end, the rest are those of the interpolant."""
    weights = np.zeros((16, 16))
    weights[:STAGES, :STAGES], weights[STAGES, :STAGES] = DOP853.A, DOP853.B
    weights[STAGES + 1 :] = DOP853.A_EXTRA
    return weights


def first_used(weights: Floats) -> NDArray[np.uint64]:
    """First column after column 0, in each row, in which there is anything; what lies before it is left out."""
    return np.array([min(np.flatnonzero(row[1:]) + 1, default=len(row)) for row in weights], np.uint64)


# The rates of positions are the velocities, so that accelerations are all that is combined: with the weights A for a
# velocity and, for a position, A A.
A = all_weights()
AA = np.where(np.abs(A @ A) > 1e-14, A @ A, 0.0)
A_FROM, AA_FROM = first_used(A), first_used(AA)
C = np.concatenate([DOP853.C, [1.0], DOP853.C_EXTRA])
C_TRIED = C[1 : STAGES + 1].copy()
# Weights of the accelerations in the errors of orders 5 and 3 of a velocity and, times h, of a position.
ERRORS = np.stack([DOP853.E5, DOP853.E3, DOP853.E5 @ A[:13, :13], DOP853.E3 @ A[:13, :13]], axis=1)
DENSE = DOP853.D.copy()


@formula
def push(weights: Floats, j: int, first: np.uint64, last: int, k: Floats) -> tuple[float, float, float]:
    """Sum up the accelerations (x, y, and of the yaw) of stage 0 and stages first to last, without derivatives."""
    x, y, yaw = weights[j, 0] * k[0, VX, 0], weights[j, 0] * k[0, VY, 0], 0.0
    for m in range(first, np.uint64(last)):
        x += weights[j, m] * k[m, VX, 0]
        y += weights[j, m] * k[m, VY, 0]
    if k.shape[1] == 6:
        yaw = weights[j, 0] * k[0, YAW_RATE, 0]
        for m in range(first, np.uint64(last)):
            yaw += weights[j, m] * k[m, YAW_RATE, 0]
    return x, y, yaw


@formula
def place(y: Floats, h: float, j: int, k: Floats, out: Floats) -> None:
    """Write the positions at stage j of a step into ``out``, but for the derivatives' columns.

    They do not depend on the stage before, so that two stages can be computed at a time.
    """
    px, py, turned = push(AA, j, AA_FROM[j], j - 1, k)
    out[X, 0] = y[X, 0] + h * (C[j] * y[VX, 0] + h * px)
    out[Y, 0] = y[Y, 0] + h * (C[j] * y[VY, 0] + h * py)
    if y.shape[0] == 6:
        out[YAW, 0] = y[YAW, 0] + h * (C[j] * y[YAW_RATE, 0] + h * turned)


@formula
def speed(y: Floats, h: float, j: int, k: Floats, out: Floats) -> None:
    """Write the velocities at stage j of a step into ``out``, but for the derivatives' columns."""
    px, py, turned = push(A, j, A_FROM[j], j, k)
    out[VX, 0] = y[VX, 0] + h * px
    out[VY, 0] = y[VY, 0] + h * py
    if y.shape[0] == 6:
        out[YAW_RATE, 0] = y[YAW_RATE, 0] + h * turned


@formula
def rows_of(n: int) -> tuple[np.uint64, np.uint64]:
    """Rows of a position and of its velocity: x, y, yaw."""
    return (np.uint64(n), np.uint64(n + VX)) if n < YAW - VX else (np.uint64(YAW), np.uint64(YAW_RATE))


@formula
def four_pushes(
    weights: Floats, j: int, first: np.uint64, last: int, k: Floats, row: Index, d: Index
) -> tuple[float, float, float, float]:
    """Do what `push` does for a row and four directions, from d on, which suits vector instructions."""
    weight = weights[j, 0]
    a, b, c, e = (
        weight * k[0, row, d],
        weight * k[0, row, d + ONE],
        weight * k[0, row, d + TWO],
        weight * k[0, row, d + THREE],
    )
    for m in range(first, np.uint64(last)):
        weight = weights[j, m]
        a += weight * k[m, row, d]
        b += weight * k[m, row, d + ONE]
        c += weight * k[m, row, d + TWO]
        e += weight * k[m, row, d + THREE]
    return a, b, c, e


@formula
def place_all(y: Floats, h: float, j: int, k: Floats, out: Floats) -> None:
    """Do what `place` does for the derivatives, in the same fours as `plain_tangents`, which reads them."""
    width, now = y.shape[1], C[j]
    for n in range(y.shape[0] // 2):
        row, rate = rows_of(n)
        for first in range(1, width, 4):
            d = np.uint64(min(first, width - 4))
            p, q, r, t = four_pushes(AA, j, AA_FROM[j], j - 1, k, rate, d)
            p, q = (
                y[row, d] + h * (now * y[rate, d] + h * p),
                y[row, d + ONE] + h * (now * y[rate, d + ONE] + h * q),
            )
            r = y[row, d + TWO] + h * (now * y[rate, d + TWO] + h * r)
            t = y[row, d + THREE] + h * (now * y[rate, d + THREE] + h * t)
            out[row, d], out[row, d + ONE], out[row, d + TWO], out[row, d + THREE] = p, q, r, t


@formula
def speed_all(y: Floats, h: float, j: int, k: Floats, out: Floats) -> None:
    """Do what `speed` does for the derivatives."""
    width = y.shape[1]
    for n in range(y.shape[0] // 2):
        _, row = rows_of(n)
        for first in range(1, width, 4):
            d = np.uint64(min(first, width - 4))
            p, q, r, t = four_pushes(A, j, A_FROM[j], j, k, row, d)
            p, q, r, t = (
                y[row, d] + h * p,
                y[row, d + ONE] + h * q,
                y[row, d + TWO] + h * r,
                y[row, d + THREE] + h * t,
            )
            out[row, d], out[row, d + ONE], out[row, d + TWO], out[row, d + THREE] = p, q, r, t


@formula
def set_phases(s: float, h: float, phases: Floats) -> None:
    """Write sine and cosine of pi times the times of a step's stages.

    One by one they take longer than all else; in a loop, of a length that the compiler does not know, they become
    vector instructions.
    """
    sines, cosines = phases[0], phases[1]
    for n in range(sines.size):
        sines[n], cosines[n] = phase_at(s + C_TRIED[n] * h)


@jit
def step(s: float, h: float, w: Walker) -> float:
    """Try a step from the present state at time s, where the rates are ``w.k[0]``, without the derivatives.

    The state at its end goes into ``w.ahead`` and the rates there into ``w.k[12]``.

    Returns
    -------
    float
        Estimate of the error.
    """
    set_phases(s, h, w.phases)
    plain = w.clock[ALL_PLAIN] != 0.0
    for j in range(1, STAGES + 1):
        place(w.y, h, j, w.k, w.ahead)
        if j == STAGES or not plain:
            speed(w.y, h, j, w.k, w.ahead)
        phase = w.phases[0, j - 1], w.phases[1, j - 1]
        rates(s + C[j] * h, phase, w.ahead, w.stance, w.contacts, w.body, w.clock, w.struts[j], w.k[j])
    carry(w.ahead, 0, 1, w.k[STAGES])
    w.clock[EVALUATIONS] += STAGES
    return h * error(h, w.k, w.clock[LEVER], w.clock[FASTEST])


@jit
def step_tangents(s: float, h: float, w: Walker) -> None:
    """Take the derivatives along the step tried last: the same stages, so that they are those of the numbers."""
    plain = w.clock[ALL_PLAIN] != 0.0
    # The values are kept, to their last digit: derivatives are not to change the motion.
    for row in range(w.y.shape[0]):
        w.room[row, 0] = w.ahead[row, 0]
    for j in range(1, STAGES + 1):
        if not plain or w.y.shape[0] == 6:
            place(w.y, h, j, w.k, w.ahead)
        place_all(w.y, h, j, w.k, w.ahead)
        if j == STAGES or not plain:
            speed(w.y, h, j, w.k, w.ahead)
            speed_all(w.y, h, j, w.k, w.ahead)
        phase = w.phases[0, j - 1], w.phases[1, j - 1]
        tangent_rates(s + C[j] * h, phase, w.ahead, w.stance, w.contacts, w.body, w.clock, w.struts[j], w.k[j])
    carry(w.ahead, 1, w.y.shape[1], w.k[STAGES])
    for row in range(w.y.shape[0]):
        w.ahead[row, 0] = w.room[row, 0]


@formula
def carry(y: Floats, first: int, last: int, out: Floats) -> None:
    """Write the velocities of a state, which are the rates of its positions, into ``out``, for some columns."""
    for d in range(first, last):
        out[X, d], out[Y, d] = y[VX, d], y[VY, d]
        if y.shape[0] == 6:
            out[YAW, d] = y[YAW_RATE, d]


@jit
def tangents_at(s: float, phase: Pair, y: Floats, w: Walker, j: int) -> None:
    """Write the derivatives' rates of a state whose rates are ``w.k[j]`` there as well, where the step does not."""
    tangent_rates(s, phase, y, w.stance, w.contacts, w.body, w.clock, w.struts[j], w.k[j])


@jit
def all_rates(s: float, y: Floats, w: Walker, j: int) -> None:
    """Write the rates of a state at time s, those of the derivatives among them, into ``w.k[j]``."""
    phase = phase_at(s)
    carry(y, 0, y.shape[1], w.k[j])
    rates(s, phase, y, w.stance, w.contacts, w.body, w.clock, w.struts[j], w.k[j])
    w.clock[EVALUATIONS] += 1
    if y.shape[1] > 1:
        tangents_at(s, phase, y, w, j)


@formula
def error(h: float, k: Floats, lever: float, unit: float) -> float:
    """Combine the error estimates of orders 5 and 3 into one of order 8, per unit of time, m.

    The lever makes an angle a length, the unit of time a speed.
    """
    fifth = third = 0.0
    for row in (VX, VY, YAW_RATE):
        if row < k.shape[1]:
            v5 = v3 = p5 = p3 = 0.0
            for m in range(STAGES):
                v5 += ERRORS[m, 0] * k[m, row, 0]
                v3 += ERRORS[m, 1] * k[m, row, 0]
                p5 += ERRORS[m, 2] * k[m, row, 0]
                p3 += ERRORS[m, 3] * k[m, row, 0]
            weight = 1.0 if row != YAW_RATE else lever * lever
            fifth += weight * (h * h * p5 * p5 + unit * unit * v5 * v5)
            third += weight * (h * h * p3 * p3 + unit * unit * v3 * v3)
    if fifth == 0.0 and third == 0.0:
        return 0.0
    return fifth / np.sqrt((fifth + 0.01 * third) * k.shape[1])


@jit
def interpolant(s: float, h: float, w: Walker, dense: Floats) -> None:
    """Write the coefficients of the interpolant of order 7 of the step tried last into ``dense``."""
    width = w.y.shape[1]
    for j in range(1, 16):
        if j != STAGES:
            speed(w.y, h, j, w.k, w.room)
            speed_all(w.y, h, j, w.k, w.room)
            if j < STAGES:
                carry(w.room, 0, width, w.k[j])
            else:
                place(w.y, h, j, w.k, w.room)
                place_all(w.y, h, j, w.k, w.room)
                all_rates(s + C[j] * h, w.room, w, j)
    for row in range(w.y.shape[0]):
        for d in range(w.y.shape[1]):
            change = w.ahead[row, d] - w.y[row, d]
            dense[0, row, d] = change
            dense[1, row, d] = h * w.k[0, row, d] - change
            dense[2, row, d] = 2.0 * change - h * (w.k[STAGES, row, d] + w.k[0, row, d])
            for m in range(4):
                total = 0.0
                for j in range(16):
                    total += DENSE[m, j] * w.k[j, row, d]
                dense[3 + m, row, d] = h * total


@jit
def interpolate(y: Floats, dense: Floats, x: float, out: Floats) -> None:
    """Write the state at the fraction x of a step that starts at ``y`` into ``out``."""
    for row in range(y.shape[0]):
        for d in range(y.shape[1]):
            value = 0.0
            for m in range(6, -1, -1):
                value = (value + dense[m, row, d]) * (x if m % 2 == 0 else 1.0 - x)
            out[row, d] = y[row, d] + value
