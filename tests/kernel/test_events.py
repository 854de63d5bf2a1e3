"""The first zero of a quintic in Bernstein's form."""

import math
from collections.abc import Sequence

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from legspring.kernel import events
from tests.kernel.bridge import callable_here

Six = tuple[float, float, float, float, float, float]
some = settings(max_examples=300, derandomize=True, deadline=None, database=None)
whole = st.integers(-20, 20).map(float)
signs = st.sampled_from([-1.0, 1.0])

first_zero = callable_here(events.first_zero)


def polynomial(b: Six) -> Polynomial:
    """The polynomial with the given Bernstein coefficients."""
    x, rest = Polynomial([0.0, 1.0]), Polynomial([1.0, -1.0])
    return sum((math.comb(5, j) * b[j] * x**j * rest ** (5 - j) for j in range(6)), Polynomial([0.0]))


def bernstein(p: Polynomial) -> Six:
    """The Bernstein coefficients of a polynomial of at most degree 5."""
    a = [*p.coef, *[0.0] * 5][:6]
    b = [sum(math.comb(j, i) / math.comb(5, i) * a[i] for i in range(j + 1)) for j in range(6)]
    return b[0], b[1], b[2], b[3], b[4], b[5]


def zeros(b: Six) -> NDArray[np.float64]:
    """Zeros in (0, 1) by NumPy; rejects what has zeros near each other, near 1, or nearly real ones."""
    roots = polynomial(b).roots()
    is_real = np.abs(roots.imag) < 1e-6
    real = np.sort(roots[is_real].real)
    assume(np.all(is_real | (np.abs(roots.imag) > 0.01)))
    assume(np.all(np.abs(real - 1.0) > 0.01) and np.all(np.diff(real) > 0.01))
    return np.asarray(real[(real > 0.0) & (real < 1.0)])


@some
@given(st.tuples(st.integers(1, 20).map(float), whole, whole, whole, whole, whole), signs)
def test_first_zero_is_never_passed(b: Six, sign: float) -> None:
    expected = zeros(b)
    found = first_zero((sign * b[0], sign * b[1], sign * b[2], sign * b[3], sign * b[4], sign * b[5]), sign)
    if len(expected) > 0:
        assert 0.0 < found < expected[0] + 1e-11
    else:
        assert found == math.inf


@some
@given(drops=st.tuples(*[st.floats(0.5, 2.0)] * 5), share=st.floats(0.05, 0.95))
def test_first_zero_where_the_quintic_falls_steadily(drops: Sequence[float], share: float) -> None:
    a, b, c, d, e, f = share * sum(drops) - np.cumsum([0.0, *drops])
    (expected,) = zeros((a, b, c, d, e, f))
    assert abs(first_zero((a, b, c, d, e, f), 1.0) - expected) < 1e-8


inner = st.floats(0.05, 0.95)
positive = st.tuples(*[st.floats(0.5, 2.0)] * 4).map(lambda c: Polynomial(c))


@some
@given(root=inner, rest=positive, depth=st.floats(1e-12, 1e-4))
def test_a_dip_is_seen_if_it_reaches_zero(root: float, rest: Polynomial, depth: float) -> None:
    """Next to a double zero: two zeros on one side, none on the other."""
    dip = Polynomial([-root, 1.0]) ** 2 * rest
    first, _ = np.sort((root - np.sqrt(depth / rest(root)), root + np.sqrt(depth / rest(root))))
    found = first_zero(bernstein(dip - depth), 1.0)
    assert abs(found - first) < 1e-6 + 10.0 * depth
    assert abs((dip - depth)(found)) < 1e-13
    assert first_zero(bernstein(dip + depth), 1.0) == math.inf


@some
@given(root=inner, rest=positive)
def test_double_zero(root: float, rest: Polynomial) -> None:
    """Whether it counts as a zero is up to the rounding; if so it is in the right place."""
    found = first_zero(bernstein(Polynomial([-root, 1.0]) ** 2 * rest), 1.0)
    assert found == math.inf or abs(found - root) < 1e-6


@some
@given(b=st.tuples(*[st.floats(1e-300, 1e300)] * 6), sign=signs)
def test_no_zero_where_all_coefficients_have_one_sign(b: Six, sign: float) -> None:
    assert first_zero((sign * b[0], sign * b[1], sign * b[2], sign * b[3], sign * b[4], sign * b[5]), sign) == math.inf


def test_zero_at_the_end() -> None:
    assert first_zero((1.0, 0.8, 0.6, 0.4, 0.2, 0.0), 1.0) == 1.0


def test_a_gap_that_has_just_left_zero_is_not_back_there() -> None:
    """A foot that rises from the ground: rounding may put it above or below."""
    for rounding in (0.0, 2e-15, -2e-15):
        for root in (0.05, 0.7):
            flight = bernstein(Polynomial([rounding, root, -1.0]))
            assert abs(first_zero(flight, 1.0) - root) < 1e-8
        assert first_zero(bernstein(Polynomial([rounding, 1.0, -0.5])), 1.0) == math.inf
