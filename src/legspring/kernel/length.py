"""The length law: force-free length of an actuated leg as a function of the clock alone (Eq. 2.2).

    l(s) = l0 - ldev sin(pi (s - s_touchdown) + phi) = a - b sin(pi s) - c cos(pi s)

The coefficients (a, b, c) are fixed at touch-down, so that all legs share one sine and one cosine. Another law is
another module with these four functions.
"""

import math

from legspring.kernel.jit import formula, jit
from legspring.kernel.walker import ACTUATION, LAW, LENGTH, PHASE, Floats


@jit
def set_law(legs: Floats, i: int, since: float, stance: Floats) -> None:
    """Write the law's coefficients for a touch-down of leg i at time ``since`` into its stance."""
    angle = legs[i, PHASE, 0] - math.pi * since
    sine, cosine, ldev = math.sin(angle), math.cos(angle), legs[i, ACTUATION, 0]
    for d in range(legs.shape[2]):
        stance[i, LAW, d] = legs[i, LENGTH, d]
        stance[i, LAW + 1, d] = legs[i, ACTUATION, d] * cosine - ldev * sine * legs[i, PHASE, d]
        stance[i, LAW + 2, d] = legs[i, ACTUATION, d] * sine + ldev * cosine * legs[i, PHASE, d]
    stance[i, LAW + 1, 0] = ldev * cosine
    stance[i, LAW + 2, 0] = ldev * sine


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


@formula
def length_partials(sine: float, cosine: float) -> tuple[float, float, float]:
    """Partial derivatives of the force-free length by the three coefficients."""
    return 1.0, -sine, -cosine
