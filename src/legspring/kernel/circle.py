"""Whether the eigenvalues of a small matrix lie within a circle, as smooth functions of the matrix."""

import numpy as np

from legspring.kernel.jit import driver
from legspring.kernel.walker import Floats


@driver
def characteristic(matrices: Floats) -> Floats:
    """Return the coefficients c of the characteristic polynomials z^n + c1 z^(n-1) + ... of matrices ``(N, n, n)``."""
    size, n, _ = matrices.shape
    out, power, product = np.zeros((size, n)), np.zeros((n, n)), np.zeros((n, n))
    for row in range(size):
        power[:] = np.eye(n)
        for k in range(n):
            product[:] = 0.0
            for i in range(n):
                for j in range(n):
                    for e in range(n):
                        product[i, j] += matrices[row, i, e] * power[e, j]
            out[row, k] = -np.trace(product) / (k + 1)
            power[:] = product + out[row, k] * np.eye(n)
    return out


@driver
def inside(c: Floats, t: float) -> tuple[Floats, Floats, Floats]:
    """Conditions for the zeros of a polynomial of degree 2 or 4 to lie within a circle of radius t.

    On leaving the circle, a zero passes through t, through -t, or a pair of them has a product of t^2 (Jury's critical
    conditions): p(t) >= 0, p(-t) >= 0 and the product of all 1 - z_i z_j / t^2 >= 0, where the last is a polynomial of
    the coefficients. All three are multiplied by t, so that their slopes stay of one size where t is small.

    Returns
    -------
    values, by_c, by_t
        ``(3,)``, ``(3, n)``, ``(3,)``: what must not be negative, and its derivatives.

    Raises
    ------
    ValueError
        For another degree.
    """
    n = c.size
    if n not in (2, 4):
        raise ValueError("c: must be the 2 or 4 coefficients of a polynomial of that degree")
    a, by_a, values = np.zeros(n), np.ones((3, n)), np.ones(3)
    for k in range(n):
        a[k] = c[k] / t ** (k + 1)  # the coefficients of the zeros in units of t
        by_a[1, k] = 1.0 if k % 2 == 1 else -1.0
        values[0] += a[k]
        values[1] += by_a[1, k] * a[k]
    if n == 2:
        values[2] = 1.0 - a[1]
        by_a[2, 0], by_a[2, 1] = 0.0, -1.0
    else:
        e1, e2, e3, e4 = -a[0], a[1], -a[2], a[3]
        values[2] = 1 - e2 + e1 * e3 - e4 + 2 * e2 * e4 - e3**2 - e1**2 * e4 + e1 * e3 * e4 - e4**2 - e2 * e4**2 + e4**3
        by_a[2, 0] = -(e3 - 2 * e1 * e4 + e3 * e4)
        by_a[2, 1] = -1 + 2 * e4 - e4**2
        by_a[2, 2] = -(e1 - 2 * e3 + e1 * e4)
        by_a[2, 3] = -1 + 2 * e2 - e1**2 + e1 * e3 - 2 * e4 - 2 * e2 * e4 + 3 * e4**2
    by_t = values.copy()
    for k in range(n):
        by_t -= by_a[:, k] * (k + 1) * a[k]
        by_a[:, k] /= t**k
    return t * values, by_a, by_t
