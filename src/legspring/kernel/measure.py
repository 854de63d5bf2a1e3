"""What the legs did along a tape: work and forces, from the interpolant of each step."""

import math

import numba
import numpy as np

from legspring.kernel.dop853 import interpolate
from legspring.kernel.jit import driver, formula, jit, shared
from legspring.kernel.length import Pair, law, phase_at
from legspring.kernel.motion import leg_force, turn
from legspring.kernel.walker import JET, JETS, TAPE, Floats, Ints, Tape

NODES, WEIGHTS = np.polynomial.legendre.leggauss(6)
LOOKS = np.concatenate([[0.0], 0.5 + 0.5 * NODES, [1.0]])
"""Where in a step a leg is looked at, to see where its force or the rate of its length changes sign."""
NOTHING = 1e-9
"""What is a smaller part of the largest value seen has no sign at an end of a step: there stances begin and end."""
PRECISE = 1e-8
"""How well, in fractions of a step, it must be known where a sign changes: power is nearly zero there."""
SAMPLES = 12
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
ALL_LEGS = -1


@formula
def step_span(tape: Tape, n: int) -> float:
    """Fraction of a recorded step that was used: 1, but for a step whose end was moved onto a lift-off."""
    return (tape.time[n + 1] - tape.time[n]) / tape.size[n]


@formula
def rates_of(tape: Tape, n: int, s: float, i: int, lean: Pair, phase: Pair, y: Floats) -> tuple[float, float]:
    """Force (per mass, > 0 pulling) and rate of length of leg i in a state that is one of step n."""
    rx, ry, hx, hy, r, force = leg_force(s, y, tape.stance[n], i, lean, phase)
    vx, vy = -y[2, 0], -y[3, 0]
    if y.shape[0] == 6:
        vx, vy = vx + y[5, 0] * hy, vy - y[5, 0] * hx
    return force, (rx * vx + ry * vy) / r


@jit
def leg_rates(tape: Tape, n: int, x: float, i: int, y: Floats) -> tuple[float, float]:
    """Force and rate of length of leg i, as `rates_of`, at the fraction x of step n."""
    interpolate(tape.y[n], tape.dense[n], x, y)
    s = tape.time[n] + x * tape.size[n]
    return rates_of(tape, n, s, i, turn(y), phase_at(s), y)


@driver
def stretch_rates(tape: Tape, n: int, x: float, i: int) -> tuple[float, float]:
    """Rates of the length and of the force-free length of leg i at the fraction x of step n."""
    _, rate = leg_rates(tape, n, x, i, np.zeros(tape.y.shape[1:]))
    s = tape.time[n] + x * tape.size[n]
    return rate, law(s, tape.stance[n], i, phase_at(s))[1]


@driver
def write_series(tape: Tape, index: Ints, times: Floats, states: Floats, legs: Floats) -> None:
    """Write what there is at some times.

    Parameters
    ----------
    tape
        What was simulated.
    index, times
        ``(T,)``: the step in which each time is, and the time.
    states
        ``(T, n, C)``: filled with the states and their derivatives.
    legs
        ``(T, L, 4)``: filled with force-free length and its rate, force (per mass, > 0 pulling) and rate of the length,
        without meaning in swing.
    """
    for row in range(times.size):
        n, s, y = index[row], times[row], states[row]
        interpolate(tape.y[n], tape.dense[n], (s - tape.time[n]) / tape.size[n], y)
        lean, phase = turn(y), phase_at(s)
        for i in range(legs.shape[1]):
            numbers = law(s, tape.stance[n], i, phase)
            legs[row, i, 0], legs[row, i, 1] = numbers[0], numbers[1]
            legs[row, i, 2], legs[row, i, 3] = rates_of(tape, n, s, i, lean, phase, y)


@jit
def sign_change(tape: Tape, n: int, i: int, which: int, a: float, b: float, y: Floats) -> float:
    """Find the zero of the force (0) or the rate of length (1) of leg i between two fractions (Illinois method)."""
    at_a, at_b = leg_rates(tape, n, a, i, y)[which], leg_rates(tape, n, b, i, y)[which]
    for _ in range(60):
        x = b - at_b * (b - a) / (at_b - at_a)
        if abs(x - b) < PRECISE:
            return x
        at_x = leg_rates(tape, n, x, i, y)[which]
        if at_x * at_b < 0.0:
            a, at_a = b, at_b
        else:
            at_a *= 0.5
        b, at_b = x, at_x
    return b


@jit
def add_piece(tape: Tape, n: int, i: int, a: float, b: float, y: Floats, work: Floats) -> None:
    """Add the work (per mass) of leg i on the body between two fractions of step n (Gauss-Legendre)."""
    total = 0.0
    for j in range(NODES.size):
        force, rate = leg_rates(tape, n, 0.5 * (a + b) + 0.5 * (b - a) * NODES[j], i, y)
        total -= WEIGHTS[j] * force * rate
    work[i, 0 if total > 0.0 else 1] += 0.5 * (b - a) * tape.size[n] * total


@jit
def look_at_legs(tape: Tape, n: int, span: float, y: Floats, looks: Floats) -> None:
    """Write force and rate of length of each leg at `LOOKS` of step n, 0 for what has no sign at its ends."""
    for j in range(LOOKS.size):
        interpolate(tape.y[n], tape.dense[n], span * LOOKS[j], y)
        s = tape.time[n] + span * LOOKS[j] * tape.size[n]
        lean, phase = turn(y), phase_at(s)
        for i in range(tape.down.shape[1]):
            if tape.down[n, i] != 0.0:
                looks[j, i, 0], looks[j, i, 1] = rates_of(tape, n, s, i, lean, phase, y)
    for i in range(tape.down.shape[1]):
        for which in range(2):
            most = 0.0
            for j in range(LOOKS.size):
                most = max(most, abs(looks[j, i, which]))
            for j in (0, LOOKS.size - 1):
                if abs(looks[j, i, which]) < NOTHING * most:
                    looks[j, i, which] = 0.0


@jit
def add_work(tape: Tape, n: int, i: int, span: float, y: Floats, looks: Floats, work: Floats) -> None:
    """Add leg i's work in step n, cut where its sign can change, to its positive or negative part."""
    start = total = 0.0
    for j in range(LOOKS.size - 1):
        a, b = span * LOOKS[j], span * LOOKS[j + 1]
        first = second = b
        for which in range(2):
            if looks[j, i, which] * looks[j + 1, i, which] < 0.0:
                cut = sign_change(tape, n, i, which, a, b, y)
                first, second = min(first, cut), max(first, cut)
        for cut in (first, second):
            if cut < b:
                add_piece(tape, n, i, start, cut, y, work)
                start = cut
    if start > 0.0:
        add_piece(tape, n, i, start, span, y, work)
        return
    for j in range(NODES.size):
        total -= WEIGHTS[j] * looks[j + 1, i, 0] * looks[j + 1, i, 1]
    work[i, 0 if total > 0.0 else 1] += 0.5 * span * tape.size[n] * total


def leg_work(tape: Tape, first: float, last: float) -> Floats:
    """Positive and negative work of each leg on the body, per mass, between two times at which steps end.

    Returns
    -------
    ndarray
        ``(L, 2)``, in m^2 per step duration squared; the second column is negative.
    """
    n_legs = tape.down.shape[1]
    work = np.zeros((n_legs, 2))
    measure_work(tape, first, last, np.zeros(tape.y.shape[1:]), np.zeros((LOOKS.size, n_legs, 2)), work)
    return work


@driver
def measure_work(tape: Tape, first: float, last: float, y: Floats, looks: Floats, work: Floats) -> None:
    """Do what `write_work` does, for Python."""
    write_work(tape, first, last, y, looks, work)


@shared(numba.void, TAPE, numba.float64, numba.float64, JET, JETS, JET)
def write_work(tape: Tape, first: float, last: float, y: Floats, looks: Floats, work: Floats) -> None:
    """Write what `leg_work` returns, given room for a state, and for looks at the legs, ``(8, L, 2)`` or more."""
    for i in range(work.shape[0]):
        work[i, 0] = work[i, 1] = 0.0
    for n in range(tape.counts[0]):
        if first < 0.5 * (tape.time[n] + tape.time[n + 1]) < last:
            span = step_span(tape, n)
            look_at_legs(tape, n, span, y, looks)
            for i in range(work.shape[0]):
                if tape.down[n, i] != 0.0:
                    add_work(tape, n, i, span, y, looks, work)


@jit
def force_at(tape: Tape, n: int, x: float, i: int, y: Floats) -> tuple[float, float, float]:
    """Force (per mass) of leg i, or of all legs, on the body at the fraction x of step n: x, y, magnitude."""
    interpolate(tape.y[n], tape.dense[n], x, y)
    s = tape.time[n] + x * tape.size[n]
    lean, phase = turn(y), phase_at(s)
    fx = fy = 0.0
    for leg in range(tape.down.shape[1]):
        if tape.down[n, leg] != 0.0 and i in (leg, ALL_LEGS):
            rx, ry, _, _, r, force = leg_force(s, y, tape.stance[n], leg, lean, phase)
            pull = force / r
            fx += pull * rx
            fy += pull * ry
    return fx, fy, math.hypot(fx, fy)


@jit
def summit(tape: Tape, n: int, x: float, width: float, i: int, axis: int, sign: float, y: Floats) -> float:
    """Largest value of sign times a force's component near the fraction x of step n (golden section)."""
    a, b = max(x - width, 0.0), min(x + width, step_span(tape, n))
    for _ in range(30):
        c, d = b - GOLDEN * (b - a), a + GOLDEN * (b - a)
        if sign * force_at(tape, n, c, i, y)[axis] > sign * force_at(tape, n, d, i, y)[axis]:
            b = d
        else:
            a = c
    return sign * force_at(tape, n, 0.5 * (a + b), i, y)[axis]


def largest_force(tape: Tape, i: int, axis: int, sign: float, first: float, last: float) -> float:
    """Maximum of sign times a component of the force of leg i (or of all legs) between two times.

    At least zero for one leg, which bears nothing in swing; in m per step duration squared.
    """
    return find_largest_force(tape, i, axis, sign, first, last, np.zeros(tape.y.shape[1:]))


@driver
def find_largest_force(tape: Tape, i: int, axis: int, sign: float, first: float, last: float, y: Floats) -> float:
    """Do what `largest_force` does, given room for a state."""
    best, step, where = -math.inf, -1, 0.0
    for n in range(tape.counts[0]):
        if first < 0.5 * (tape.time[n] + tape.time[n + 1]) < last and (i == ALL_LEGS or tape.down[n, i] != 0.0):
            for sample in range(SAMPLES + 1):
                x = step_span(tape, n) * sample / SAMPLES
                value = sign * force_at(tape, n, x, i, y)[axis]
                if value > best:
                    best, step, where = value, n, x
    # In the neighbours, too: the summit may lie just across the step's end.
    for n, x in ((step - 1, 1.0), (step, where), (step + 1, 0.0)):
        if step >= 0 and 0 <= n < tape.counts[0] and first < 0.5 * (tape.time[n] + tape.time[n + 1]) < last:
            best = max(best, summit(tape, n, x, 1.0 / SAMPLES, i, axis, sign, y))
    return best if i == ALL_LEGS else max(best, 0.0)
