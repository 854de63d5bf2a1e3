"""One step of the Runge-Kutta method of order 8 of Dormand and Prince, with its interpolant.

E. Hairer, S. P. Norsett, G. Wanner, *Solving Ordinary Differential Equations I*, section II.10; the coefficients are
those that SciPy carries.
"""

import numpy as np
from scipy.integrate import DOP853

from legspring.kernel.jit import formula, jit
from legspring.kernel.length import phase_at
from legspring.kernel.motion import rates, tangent_rates
from legspring.kernel.walker import EVALUATIONS, FASTEST, LEVER, VX, VY, YAW, YAW_RATE, Floats, Walker, X, Y

STAGES = 12
# Row 12 is the end of the step.
A, A_EXTRA = np.vstack([DOP853.A, DOP853.B]), DOP853.A_EXTRA.copy()
C, C_EXTRA = np.append(DOP853.C, 1.0), DOP853.C_EXTRA.copy()
C_ALL = np.append(C, np.zeros(3))
E3, E5 = DOP853.E3.copy(), DOP853.E5.copy()
DENSE = DOP853.D.copy()


@formula
def combine(y: Floats, h: float, weights: Floats, j: int, n: int, k: Floats, out: Floats) -> None:
    """Write y + h sum_m weights[j, m] k[m], m < n, into ``out``, but for the derivatives' columns.

    The four rows that every body has go together: their sums stay in registers.
    """
    x = y_ = vx = vy = 0.0
    for m in range(n):
        weight = weights[j, m]
        x += weight * k[m, X, 0]
        y_ += weight * k[m, Y, 0]
        vx += weight * k[m, VX, 0]
        vy += weight * k[m, VY, 0]
    out[X, 0] = y[X, 0] + h * x
    out[Y, 0] = y[Y, 0] + h * y_
    out[VX, 0] = y[VX, 0] + h * vx
    out[VY, 0] = y[VY, 0] + h * vy
    for row in range(4, y.shape[0]):
        total = 0.0
        for m in range(n):
            total += weights[j, m] * k[m, row, 0]
        out[row, 0] = y[row, 0] + h * total


@formula
def combine_all(y: Floats, h: float, weights: Floats, j: int, n: int, k: Floats, out: Floats) -> None:
    """Do the same for all columns at once; jets come flat, and four at a time, which suits vector instructions."""
    fours = y.size // 4 * 4
    for e in range(0, fours, 4):
        a = b = c = d = 0.0
        for m in range(n):
            weight = weights[j, m]
            a += weight * k[m, e]
            b += weight * k[m, e + 1]
            c += weight * k[m, e + 2]
            d += weight * k[m, e + 3]
        out[e], out[e + 1], out[e + 2], out[e + 3] = y[e] + h * a, y[e + 1] + h * b, y[e + 2] + h * c, y[e + 3] + h * d
    for e in range(fours, y.size):
        total = 0.0
        for m in range(n):
            total += weights[j, m] * k[m, e]
        out[e] = y[e] + h * total


@formula
def set_phases(s: float, h: float, phases: Floats) -> None:
    """Write sine and cosine of pi times the times of a step's stages.

    One by one they take longer than all else; in a loop, of a length that the compiler does not know, they become
    vector instructions.
    """
    sines, cosines = phases[0], phases[1]
    for j in range(sines.size):
        sines[j], cosines[j] = phase_at(s + C_ALL[j] * h)


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
    for j in range(1, STAGES + 1):
        combine(w.y, h, A, j, j, w.k, w.ahead)
        phase = w.phases[0, j], w.phases[1, j]
        rates(s + C[j] * h, phase, w.ahead, w.stance, w.contacts, w.body, w.clock, w.struts[j], w.k[j])
    w.clock[EVALUATIONS] += STAGES
    return h * error(w.k, w.clock[LEVER], w.clock[FASTEST])


@jit
def step_tangents(s: float, h: float, w: Walker) -> None:
    """Take the derivatives along the step tried last: the same stages, so that they are those of the numbers."""
    for j in range(1, STAGES + 1):
        combine_all(w.flat_y, h, A, j, j, w.flat_k, w.flat_ahead)
        phase = w.phases[0, j], w.phases[1, j]
        tangent_rates(s + C[j] * h, phase, w.ahead, w.stance, w.contacts, w.body, w.clock, w.struts[j], w.k[j])
    # The values again, to their last digit: derivatives are not to change the motion.
    combine(w.y, h, A, j, j, w.k, w.ahead)


@formula
def all_rates(s: float, y: Floats, w: Walker, j: int) -> None:
    """Write the rates of a state at time s, those of the derivatives among them, into ``w.k[j]``."""
    phase = phase_at(s)
    rates(s, phase, y, w.stance, w.contacts, w.body, w.clock, w.struts[j], w.k[j])
    w.clock[EVALUATIONS] += 1
    if y.shape[1] > 1:
        tangent_rates(s, phase, y, w.stance, w.contacts, w.body, w.clock, w.struts[j], w.k[j])


@formula
def error(k: Floats, lever: float, unit: float) -> float:
    """Combine the error estimates of orders 5 and 3 into one of order 8, per unit of time, m.

    The lever makes an angle a length, the unit of time a speed.
    """
    fifth = third = 0.0
    for row in range(k.shape[1]):
        e5 = e3 = 0.0
        for j in range(STAGES + 1):
            e5 += E5[j] * k[j, row, 0]
            e3 += E3[j] * k[j, row, 0]
        weight = 1.0 if row < YAW else lever * lever
        if row in (VX, VY, YAW_RATE):
            weight *= unit * unit
        fifth += weight * e5 * e5
        third += weight * e3 * e3
    if fifth == 0.0 and third == 0.0:
        return 0.0
    return fifth / np.sqrt((fifth + 0.01 * third) * k.shape[1])


@jit
def interpolant(s: float, h: float, w: Walker, dense: Floats) -> None:
    """Write the coefficients of the interpolant of order 7 of the step tried last into ``dense``."""
    for j in range(3):
        last, time = STAGES + 1 + j, s + C_EXTRA[j] * h
        combine_all(w.flat_y, h, A_EXTRA, j, last, w.flat_k, w.flat_room)
        all_rates(time, w.room, w, last)
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
