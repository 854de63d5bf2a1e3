"""Special points of a curve: folds, and where multipliers leave the unit circle.

What is looked at is zero at a special point, and is found between two points of a curve where it changes its sign.
Nothing here knows of legs: what these do is looked at by `legspring.footing`.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import combinations, pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from legspring.kernel.walker import Floats
from legspring.stretch import Point, Stretch, at_crossing, at_zero, turns_back


class Kind(StrEnum):
    """What a special point of a curve is."""

    FOLD = "fold"
    PERIOD_DOUBLING = "period doubling"
    SYMMETRY_BREAKING = "symmetry breaking"
    BRANCHING = "branch point"
    PLUS_ONE = "multiplier of 1"
    NEIMARK_SACKER = "Neimark-Sacker"
    SEQUENCE = "sequence of events"
    IDLE = "idle leg"
    WRONG_START = "wrong start"
    NO_LIFTOFF = "no lift-off"
    VALIDITY = "edge of validity"
    KINK = "kink"
    WINDOW = "ignored window"
    GRAZING_LIFTOFF = "grazing lift-off"
    GRAZING_TOUCHDOWN = "grazing touch-down"


WORDS = {
    Kind.FOLD: "two solutions meet, and there are none beyond",
    Kind.PERIOD_DOUBLING: "a multiplier is -1: gaits that take twice the time branch off",
    Kind.SYMMETRY_BREAKING: "a multiplier of a step is -1: gaits branch off whose steps do not mirror one another",
    Kind.BRANCHING: "a multiplier is 1: another curve crosses",
    Kind.PLUS_ONE: "a multiplier is 1, and nothing else happens to gaits that are tuned",
    Kind.NEIMARK_SACKER: "two complex multipliers are on the unit circle",
    Kind.KINK: "a law of the animal has a kink, or something is kept for this value only",
}
ON_FOLD, NEAR_FOLD = 1e-5, 0.05
"""Distance of two places, by the scale, and of two points within which a multiplier of 1 belongs to a fold."""
SINGULAR = 1e-4
"""Singular value of the conditions below which another curve crosses."""
ON_CIRCLE = 1e-6
"""Distance of a multiplier from the unit circle that is none."""
SMALL = 0.1
"""What is looked at is below this at a special point; else it jumps from one sign to the other."""


class Landmark(NamedTuple):
    """A special point: its kind, whose it is (of a leg, or legs), what else there is to say, the point, and where."""

    kind: Kind
    leg: str
    words: str
    point: Point
    stretch: Stretch
    after: int


@dataclass(frozen=True)
class Trivial:
    """Multipliers that are what they are because something is conserved: their values."""

    values: tuple[float, ...] = ()

    def free(self, maps: Floats) -> NDArray[np.complex128]:
        """Return the multipliers of some maps, ``(N, k, k)``, without these, largest first: ``(N, k - c)``."""
        found = np.linalg.eigvals(maps).astype(complex)
        for value in self.values:
            keep = np.ones(found.shape, dtype=bool)
            keep[np.arange(len(found)), np.argmin(np.abs(found - value), axis=1)] = False
            found = found[keep].reshape(len(found), -1)
        order = np.argsort(-np.abs(found), axis=1, kind="stable")
        return np.take_along_axis(found, order, axis=1)


def from_one(values: NDArray[np.complex128]) -> float:
    """Return what is zero where a multiplier is 1."""
    return float(np.prod(values - 1.0).real)


def from_minus_one(values: NDArray[np.complex128]) -> float:
    """Return what is zero where a multiplier is -1."""
    return float(np.prod(values + 1.0).real)


def from_circle(values: NDArray[np.complex128]) -> float:
    """Return what is zero where the product of two multipliers is 1."""
    return float(np.prod([one * other - 1.0 for one, other in combinations(values, 2)]).real)


def find_folds(stretch: Stretch) -> Iterator[Landmark]:
    """Find where the place ceases to grow, or to fall."""
    for row, (first, second) in enumerate(pairwise(stretch.points)):
        if turns_back(first, second):
            point = at_zero(stretch, first, second, lambda one: float(one.tangent[-1]))
            if point is not None:
                yield Landmark(Kind.FOLD, "", WORDS[Kind.FOLD], point, stretch, row)


def find_crossings(stretch: Stretch, trivial: Trivial, minus: Kind) -> Iterator[Landmark]:
    """Find where multipliers cross the unit circle.

    Parameters
    ----------
    stretch
        A part of a curve.
    trivial
        Multipliers that stay where they are.
    minus
        What a multiplier of -1 stands for.
    """
    multipliers = trivial.free(np.array([point.look.map for point in stretch.points]))
    folds = list(find_folds(stretch))
    yield from folds
    for kind, test in ((Kind.BRANCHING, from_one), (minus, from_minus_one), (Kind.NEIMARK_SACKER, from_circle)):

        def value(point: Point, test: Callable[[NDArray[np.complex128]], float] = test) -> float:
            return test(trivial.free(point.look.map[None])[0])

        values = [test(row) for row in multipliers]
        for row in sign_changes(values):
            ends = stretch.points[row], stretch.points[row + 1]
            point = at_crossing(stretch, *ends, value) if kind is Kind.BRANCHING else at_zero(stretch, *ends, value)
            if point is None or not abs(value(point)) < SMALL:
                continue
            own = kind
            if kind is Kind.BRANCHING and not is_singular(point):
                own, point = Kind.PLUS_ONE, at_zero(stretch, *ends, value) or point
            if kind is Kind.BRANCHING and any(is_at(stretch, point, fold.point) for fold in folds):
                continue
            if kind is Kind.NEIMARK_SACKER and not has_pair_on_circle(trivial.free(point.look.map[None])[0]):
                continue
            yield Landmark(own, "", WORDS[own], point, stretch, row)


def is_singular(point: Point) -> bool:
    """Whether the conditions do not tell a curve from another one that crosses it."""
    return bool(np.linalg.svd(point.look.by, compute_uv=False)[-1] < SINGULAR)


def is_at(stretch: Stretch, point: Point, fold: Point) -> bool:
    """Whether a multiplier of 1 is that of a fold; near one, it is known less well than its place."""
    way = stretch.way(point.y, fold.y)
    return bool(np.linalg.norm(way) < NEAR_FOLD and abs(way[-1]) < ON_FOLD)


def sign_changes(values: Sequence[float]) -> Iterator[int]:
    """Return the rows after which values change their sign."""
    return (row for row, (one, other) in enumerate(pairwise(values)) if one * other < 0.0)


def has_pair_on_circle(values: NDArray[np.complex128]) -> bool:
    """Whether two complex multipliers are on the unit circle; two real ones may have a product of 1 as well."""
    near = np.abs(np.abs(values) - 1.0) < ON_CIRCLE
    return bool(np.any(near & (np.abs(values.imag) > ON_CIRCLE)))


def in_order(marks: Sequence[Landmark]) -> list[Landmark]:
    """Return the special points of a stretch in their order along it."""

    def along(mark: Landmark) -> tuple[int, float]:
        first, second = mark.stretch.points[mark.after : mark.after + 2]
        return mark.after, float(mark.stretch.way(first.y, mark.point.y) @ (second.y - first.y))

    return sorted(marks, key=along)


def at_change(stretch: Stretch, row: int, label: Callable[[Point], object], here: object) -> Point:
    """Return the last point of a step of a curve at which something that is no number is as at its beginning."""
    first, second = stretch.points[row], stretch.points[row + 1]
    low, high, found = 0.0, 1.0, first
    while high - low > math.ulp(1.0) * 64.0:
        share = 0.5 * (low + high)
        point = stretch.middle(first, second, share)
        if point is None:
            break
        if label(point) == here:
            low, found = share, point
        else:
            high = share
    return found
