"""The length law: force-free length of an actuated leg as a function of the clock alone (Eq. 2.2).

    l(s) = l0 - ldev sin(pi (s - s_touchdown) + phi) = a - b sin(pi s) - c cos(pi s)

The coefficients (a, b, c) are fixed at touch-down, so that all legs share one sine and one cosine. A law that a user
has written has the coefficients (l0, ldev, phi) and is a function of them and of the time since touch-down.
"""

import math

from legspring.kernel.jit import formula, jit
from legspring.kernel.walker import (
    ACTUATION,
    BEGUN,
    DAMPED,
    DAMPER,
    DAMPING,
    FORMULA,
    LAW,
    LENGTH,
    MANNER,
    PHASE,
    PLAIN,
    Floats,
)
from legspring.kernel.written import call

Law = tuple[float, float, float, float, float, float, float]
Pair = tuple[float, float]
Series = tuple[float, ...]


@jit
def set_law(legs: Floats, i: int, since: float, stance: Floats) -> None:
    """Write law and damper of leg i into its stance, for a touch-down at a time ``since`` without derivatives."""
    stance[i, MANNER, 0] = legs[i, FORMULA, 0]
    for d in range(legs.shape[2]):
        stance[i, BEGUN, d] = 0.0
        stance[i, DAMPER, d] = legs[i, DAMPING, d]
        if stance[i, MANNER, 0] == PLAIN and legs[i, DAMPING, d] != 0.0:
            stance[i, MANNER, 0] = DAMPED
    stance[i, BEGUN, 0] = since
    if stance[i, MANNER, 0] > DAMPED:
        for d in range(legs.shape[2]):
            for n in range(3):
                stance[i, LAW + n, d] = legs[i, LENGTH + n, d]
        return
    angle = legs[i, PHASE, 0] - math.pi * since
    sine, cosine, ldev = math.sin(angle), math.cos(angle), legs[i, ACTUATION, 0]
    for d in range(legs.shape[2]):
        stance[i, LAW, d] = legs[i, LENGTH, d]
        stance[i, LAW + 1, d] = legs[i, ACTUATION, d] * cosine - ldev * sine * legs[i, PHASE, d]
        stance[i, LAW + 2, d] = legs[i, ACTUATION, d] * sine + ldev * cosine * legs[i, PHASE, d]
    stance[i, LAW + 1, 0] = ldev * cosine
    stance[i, LAW + 2, 0] = ldev * sine


@jit
def delay_law(stance: Floats, i: int, delay: Floats) -> None:
    """Add to the law of leg i, just put down, the derivatives of its time of touch-down."""
    for d in range(1, delay.size):
        stance[i, BEGUN, d] = delay[d]
        if stance[i, MANNER, 0] <= DAMPED:
            stance[i, LAW + 1, d] += math.pi * delay[d] * stance[i, LAW + 2, 0]
            stance[i, LAW + 2, d] -= math.pi * delay[d] * stance[i, LAW + 1, 0]


SINE = tuple((-1.0) ** n * math.pi ** (2 * n + 1) / math.factorial(2 * n + 1) for n in range(12))
COSINE = tuple((-1.0) ** n * math.pi ** (2 * n) / math.factorial(2 * n) for n in range(12))
"""Coefficients of the series of sin(pi r) / r and cos(pi r) in r^2, to the last digit up to r = 1/2."""
TO_WHOLE = 1.5 * 2.0**52
"""A number so large that it has no digits after the point: adding it rounds."""


@formula
def series(x: float, c: Series) -> float:
    """Value of a polynomial with twelve coefficients."""
    high = c[6] + x * (c[7] + x * (c[8] + x * (c[9] + x * (c[10] + x * c[11]))))
    return c[0] + x * (c[1] + x * (c[2] + x * (c[3] + x * (c[4] + x * (c[5] + x * high)))))


@formula
def phase_at(s: float) -> Pair:
    """Sine and cosine of pi s, without branches and calls: in a loop they become vector instructions."""
    whole = (s + TO_WHOLE) - TO_WHOLE
    half = 0.5 * whole
    odd = half - ((half + TO_WHOLE) - TO_WHOLE)
    sign, r = 1.0 - 4.0 * abs(odd), s - whole
    return sign * r * series(r * r, SINE), sign * series(r * r, COSINE)


@formula
def length(a: float, b: float, c: float, sine: float, cosine: float) -> float:
    """Force-free length, from the sine and cosine of pi s.

    The law is linear in its coefficients: the derivative's part that is due to them is the law of their derivatives.
    """
    return a - b * sine - c * cosine


@formula
def length_rates(b: float, c: float, sine: float, cosine: float) -> tuple[float, float]:
    """First and second time derivative of the force-free length."""
    return math.pi * (c * sine - b * cosine), math.pi**2 * (b * sine + c * cosine)


@jit
def law(s: float, stance: Floats, i: int, phase: Pair) -> Law:
    """Everything about the law of leg i at time s, whatever law it is.

    Returns
    -------
    tuple of float
        The force-free length and its first two rates; the partial derivatives of the length by the rows of the stance
        from LAW to BEGUN.
    """
    if stance[i, MANNER, 0] <= DAMPED:
        sine, cosine = phase
        a, b, c = stance[i, LAW, 0], stance[i, LAW + 1, 0], stance[i, LAW + 2, 0]
        rate, second = length_rates(b, c, sine, cosine)
        return length(a, b, c, sine, cosine), rate, second, 1.0, -sine, -cosine, 0.0
    n = call(
        stance[i, MANNER, 0],
        s - stance[i, BEGUN, 0],
        stance[i, LAW, 0],
        stance[i, LAW + 1, 0],
        stance[i, LAW + 2, 0],
    )
    return n[0], n[1], n[2], n[3], n[4], n[5], -n[1]
