"""When a leg lifts off: the first zero of its gap after the ignored window; or when a foot comes to the ground.

Over one step the gap is the quintic that has its value and two rates at both ends, in Bernstein's form: where all six
coefficients have one sign there is no zero, and their convex hull bounds the first one from below. The quintic only
says where to end the step; the zero itself is taken from a step that ends there. For want of the gap's second rate
it is the cubic.
"""

import math

from legspring.kernel.jit import formula, jit
from legspring.kernel.walker import NOTHING, SIGN, SINCE, WATCHED, Floats

WINDOW = 1.0 / 50.0
"""Step durations after its touch-down in which a leg does not lift off."""
LANDED = 1e-5
"""Distance from a zero at which a step's end is moved onto it, in the shortest of the motion's own times."""
LANDED_BY_CUBIC = 1e-7
"""The same where the gap's second rate is an estimate."""
INSTANT = 1e-12
"""Times closer than this, in step durations, are one to the clock."""
LEFT = 1e-9
"""Part of where a gap goes to below which it is still the zero that it comes from."""
NONE, SHORTER, HERE = 0, 1, 2

Six = tuple[float, float, float, float, float, float]


@formula
def quintic(gaps: Floats, i: int, h: float) -> Six:
    """Bernstein coefficients of the quintic with the values and rates of leg i's gap at both ends of a step."""
    g, v, a = gaps[0, i, 0], h * gaps[0, i, 1], h * h * gaps[0, i, 2]
    g1, v1, a1 = gaps[1, i, 0], h * gaps[1, i, 1], h * h * gaps[1, i, 2]
    return g, g + v / 5.0, g + 0.4 * v + a / 20.0, g1 - 0.4 * v1 + a1 / 20.0, g1 - v1 / 5.0, g1


@formula
def hull_crossing(b: Six) -> float:
    """Where the convex hull of the coefficients, the first of them positive, first meets zero; inf if nowhere."""
    first = math.inf
    for j in range(1, 6):
        if b[j] <= 0.0:
            for i in range(j):
                if b[i] > 0.0:
                    first = min(first, (i + (j - i) * b[i] / (b[i] - b[j])) / 5.0)
    return first


@formula
def right_part(b: Six, x: float) -> Six:
    """Coefficients of the same polynomial on [x, 1] (de Casteljau)."""
    a, b1, c, d, e, f = b
    y = 1.0 - x
    a, b1, c, d, e = y * a + x * b1, y * b1 + x * c, y * c + x * d, y * d + x * e, y * e + x * f
    a, b1, c, d = y * a + x * b1, y * b1 + x * c, y * c + x * d, y * d + x * e
    a, b1, c = y * a + x * b1, y * b1 + x * c, y * c + x * d
    a, b1 = y * a + x * b1, y * b1 + x * c
    a = y * a + x * b1
    return a, b1, c, d, e, f


@formula
def without_first(b: Six) -> Six:
    """Coefficients of the polynomial that has a zero at 0, divided by that zero."""
    return 5.0 * b[1], b[1] + 2.0 * b[2], b[2] + b[3], b[3] + 0.5 * b[4], b[4] + 0.2 * b[5], b[5]


@jit
def first_zero(b: Six, sign: float) -> float:
    """First zero in (0, 1] of a polynomial that starts with the given sign; inf if there is none."""
    start = 0.0
    b = (sign * b[0], sign * b[1], sign * b[2], sign * b[3], sign * b[4], sign * b[5])
    if abs(b[0]) < LEFT * b[1]:
        # It has just left zero; rounding may put it on either side.
        b = without_first(b)
    for _ in range(60):
        x = hull_crossing(b)
        if x > 1.0:
            return math.inf
        start += (1.0 - start) * x
        if x < 1e-9 or 1.0 - start < 1e-12:
            return start
        b = right_part(b, x)
        if b[0] <= 0.0:
            return start
    return start


@formula
def time_to_zero(gaps: Floats, i: int) -> float:
    """Time from the step's end to the nearest zero of the parabola with leg i's gap and its two rates; or inf."""
    g, v, a = gaps[1, i, 0], gaps[1, i, 1], gaps[1, i, 2]
    square = v * v - 2.0 * g * a
    return -2.0 * g / (v + math.copysign(math.sqrt(square), v)) if square >= 0.0 else math.inf


@formula
def plain_sign(b: Six) -> float:
    """Sign that all coefficients share, a zero at the very start aside; 0 if they do not."""
    low = min(min(b[1], b[2]), min(min(b[3], b[4]), b[5]))
    high = max(max(b[1], b[2]), max(max(b[3], b[4]), b[5]))
    if low > 0.0 and b[0] >= 0.0:
        return 1.0
    if high < 0.0 and b[0] <= 0.0:
        return -1.0
    return 0.0


@formula
def window_split(s: float, h: float, contacts: Floats, gaps: Floats, i: int) -> float:
    """Fraction of the step at which leg i's window ends, if its gap's sign there is not plain; otherwise inf."""
    end = contacts[i, SINCE] + WINDOW
    if s + h < end + INSTANT or plain_sign(quintic(gaps, i, h)) != 0.0:
        return math.inf
    return (end - s) / h


@formula
def arm(s: float, h: float, contacts: Floats, gaps: Floats) -> None:
    """Set the sign of the gaps of the legs whose window has ended in the step just accepted."""
    for i in range(contacts.shape[0]):
        fresh = contacts[i, WATCHED] != NOTHING and contacts[i, SIGN] == 0.0
        if fresh and s + h >= contacts[i, SINCE] + WINDOW - INSTANT:
            sign = plain_sign(quintic(gaps, i, h))
            if sign == 0.0:
                sign = math.copysign(1.0, gaps[1, i, 0] if gaps[1, i, 0] != 0.0 else gaps[1, i, 1])
            contacts[i, SIGN] = sign


@formula
def estimate_second(h: float, gaps: Floats, i: int) -> None:
    """Set the second rate of leg i's gap at both ends of a step to that of the cubic with its values and rates."""
    slope, v, v1 = (gaps[1, i, 0] - gaps[0, i, 0]) / h, gaps[0, i, 1], gaps[1, i, 1]
    gaps[0, i, 2] = (6.0 * slope - 4.0 * v - 2.0 * v1) / h
    gaps[1, i, 2] = (2.0 * v + 4.0 * v1 - 6.0 * slope) / h


@formula
def next_event(s: float, h: float, contacts: Floats, gaps: Floats, unit: float) -> tuple[int, float, int]:
    """Find what happens first in a step just tried; the unit is that of what is close.

    Returns
    -------
    kind, where, leg
        ``NONE``; or ``SHORTER``: where is the factor by which to shorten the step; or ``HERE``: where is the time
        from the step's end to a zero of this leg's gap.
    """
    kind, fraction, here, leg = NONE, math.inf, 0.0, -1
    for i in range(contacts.shape[0]):
        if contacts[i, WATCHED] == NOTHING:
            continue
        sign, shift, landed = contacts[i, SIGN], math.inf, LANDED * unit
        if math.isnan(gaps[1, i, 2]):
            estimate_second(h, gaps, i)
            landed = LANDED_BY_CUBIC * unit
        if sign == 0.0:
            x = window_split(s, h, contacts, gaps, i)
        else:
            shift = time_to_zero(gaps, i)
            near = abs(shift) < landed and sign * gaps[1, i, 1] < 0.0
            x = 1.0 + shift / h if near else first_zero(quintic(gaps, i, h), sign)
            shift = shift if near else math.inf
        if x < fraction:
            fraction, here, leg = x, shift, i
            kind = HERE if shift < math.inf else SHORTER
    return kind, here if kind == HERE else fraction, leg
