"""Points of a curve of solutions: the conditions along a route, and how points are found.

Along a route (`legspring.route`) a problem of gaits has one unknown more than conditions. A point is corrected across a
direction, so that folds are nothing special.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from legspring.flow import Simulator
from legspring.kernel.many import N_FEW
from legspring.kernel.walker import OK, Floats
from legspring.layout import TIGHT
from legspring.returnmap import seen_at, signs, state_names
from legspring.route import Piece, Route

MOST_CORRECTIONS = 6
OFF, OFF_CORNER = 0.3, 1.5
"""Largest correction, in units of the step: what is further off is another curve; and where there is a corner."""
SOLVED = 2e-11
"""Residual after which one more of Newton's steps leaves nothing, as each squares what is left."""
ROUNDING = 64.0 * math.ulp(1.0)
"""The same by the largest derivative: where small things grow fast, so does rounding."""
SAME_PLACE = 1e-5
"""How far a point may move when its place is made exact."""
HALVINGS, ASIDE = 7, 0.02
"""Halvings of a step of a curve in which another one crosses, and how far from there points are well known."""
STEEP = 0.2
"""Part of a chord along the route from which on the place says well where a point is."""
LEVEL = 1e-7
"""Part of a tangent along the route that is none."""


class Look(NamedTuple):
    """What is known at a place with some unknowns.

    Attributes
    ----------
    values, by
        ``(m,)``, ``(m, n + 1)``: conditions left; their derivatives by the unknowns, and by the place by its scale.
    map
        ``(k, k)``: Jacobian of the complete map of a period, in the units of the unknowns.
    """

    values: Floats
    by: Floats
    map: Floats


class Point(NamedTuple):
    """A point of a curve: unknowns and place by its scale, ``(n + 1,)``; the tangent; and what is known there."""

    y: Floats
    tangent: Floats
    look: Look


class Loaded:
    """A piece of a route with room to evaluate it in; for one thread."""

    def __init__(self, piece: Piece, scale: float, z: Floats, place: float) -> None:
        self.piece, self.problem, self.scale = piece, piece.problem, scale
        self.size = self.problem.size
        system, task, n = self.problem.system, self.problem.task, self.size
        self.numbers, self.rates = piece.fixed.copy(), np.zeros(len(piece.fixed))
        self.base, self.along, self.at_end, self.at_start, self.given = piece.unpacked(self.numbers)
        self.d_base, self.d_along, self.d_at_end, self.d_at_start, self.d_given = piece.unpacked(self.rates)
        self.rows, self.moved, self.turns = task.rows, task.columns, np.where(task.turns > 0.0, task.turns, math.inf)
        self.has_turns = bool(task.turns.any())
        # Where in the vector of all numbers the directions, at_end and at_start are: most of it never moves.
        (_, (along, _), (first, _), (last, _), _) = piece.cuts
        self.ways_move = bool(np.any((piece.moving >= along.start) & (piece.moving < along.stop)))
        self.conditions_move = bool(np.any((piece.moving >= first.start) & (piece.moving < last.stop)))
        self.fixed: tuple[Floats, Floats] | None = None
        self.names = state_names(system, self.point(z, place))
        unknowns, own = self.problem.unknowns, system.along(self.names)
        self.columns: list[int] = []
        extra: list[Floats] = []
        self.units: list[tuple[int, int]] = []
        for number, (name, way) in enumerate(zip(self.names, own, strict=True)):
            row = unknowns.index(name) if name in unknowns else -1
            # A coordinate of the state that is an unknown is a direction already, unless something is tied to it.
            if row >= 0 and np.array_equal(way != 0.0, self.along[row] != 0.0):
                self.columns.append(row)
                self.units.append((number, system.place_of(name)))
            else:
                self.columns.append(n + 1 + len(extra))
                extra.append(way)
        self.known = [number for number, _ in self.units]
        self.known_rows, self.known_places = [self.columns[n] for n in self.known], [place for _, place in self.units]
        self.seen_at = [seen_at(system, name) for name in self.names]
        self.image = np.ix_(self.seen_at, [1 + column for column in self.columns])
        self.signs = signs(system, self.names)[:, None]
        self.ways = np.vstack([self.along, self.base[None], *extra])
        everything = self.problem.seen > N_FEW or bool(system.contacts)
        self.simulate = Simulator(system, steps=system.period, along=self.ways, everything=everything, accuracy=TIGHT)

    def point(self, z: Floats, place: float) -> Floats:
        """Return all parameters at a place, ``(n,)``."""
        self.piece.write(place, self.numbers, self.rates)
        p: Floats = self.base + z @ self.along
        return p

    def __call__(self, z: Floats, place: float) -> Look | None:
        """Look at the conditions at a place; None where a step cannot be simulated."""
        n, p, ways = self.size, self.point(z, place), self.ways
        if self.ways_move:
            ways[:n], ways[n] = self.along, (self.d_base + z @ self.d_along) * self.scale
        else:
            ways[n] = self.d_base * self.scale
        ends = self.simulate(p[None])
        if ends.status[0] != OK:
            return None
        seen = ends.seen[0]
        # What is not used may be infinite, or unknown.
        rows, columns = self.rows, self.moved
        if self.fixed is None or self.conditions_move:
            self.fixed = self.at_end.take(rows, axis=1), self.at_start.take(columns, axis=1)
        known, (at_end, at_start) = seen.take(rows, axis=0), self.fixed
        values = at_end @ known[:, 0] + at_start @ p.take(columns) - self.given
        if self.has_turns and (whole := np.round(values / self.turns)).any():
            values -= whole * np.where(whole == 0.0, 0.0, self.turns)
        by = at_end @ known[:, 1 : n + 2] + at_start @ ways[: n + 1].take(columns, axis=1).T
        if self.conditions_move:
            further = self.d_at_end.take(rows, axis=1) @ known[:, 0]
            further += self.d_at_start.take(columns, axis=1) @ p.take(columns)
            by[:, n] += further * self.scale
        by[:, n] -= self.d_given * self.scale
        jacobian = seen[self.image] * self.signs
        if self.units:
            jacobian[:, self.known] /= ways[self.known_rows, self.known_places]
        return Look(values, by, jacobian)


@dataclass
class Stretch:
    """A part of a curve in which the route is smooth: its points, and how to find others between them.

    Attributes
    ----------
    route, region
        What varies, and between which places.
    points
        In order.
    known
        Pieces of the route that are ready to be evaluated.
    looks
        How often the conditions were looked at.
    """

    route: Route
    region: tuple[float, float]
    points: list[Point] = field(default_factory=list)
    known: dict[tuple[float, float], Loaded] = field(default_factory=dict)
    looks: int = 0

    def loaded(self, y: Floats) -> Loaded:
        """Return the piece of the route where a point is, ready to be evaluated."""
        place = self.route.place(y)
        piece = self.route.piece(place, self.region)
        key = piece.low, piece.high
        if key not in self.known:
            self.known[key] = Loaded(piece, self.route.scale, self.unknowns(y), place)
        return self.known[key]

    def look(self, y: Floats) -> Look | None:
        """Look at the conditions at a point; None where a step cannot be simulated."""
        self.looks += 1
        return self.loaded(y)(self.unknowns(y), self.route.place(y))

    def unknowns(self, y: Floats) -> Floats:
        """Return the unknowns of a point, by their units."""
        return y[:-1]

    def parameters(self, y: Floats) -> Floats:
        """Return all parameters of a point, ``(n,)``."""
        return self.loaded(y).point(self.unknowns(y), self.route.place(y))

    def inside(self, y: Floats) -> bool:
        """Whether unknowns are in the range in which gaits are looked for."""
        task = self.loaded(y).problem.task
        return bool(np.all((y[:-1] > task.low) & (y[:-1] < task.high)))

    def way(self, start: Floats, end: Floats) -> Floats:
        """Return the way from one point to another: the short one, where unknowns are angles."""
        return np.append(self.loaded(start).problem.wrapped(end[:-1] - start[:-1]), end[-1] - start[-1])

    def corrected(self, guess: Floats, normal: Floats, ahead: Floats) -> Point | None:
        """Return the point of the curve in the plane through a guess across a direction; None if there is none.

        Parameters
        ----------
        guess, normal
            ``(n + 1,)``.
        ahead
            What its tangent should be like, up to its length.
        """
        y, before = guess.copy(), math.inf
        for number in range(MOST_CORRECTIONS):
            try:
                look = self.look(y)
            except ValueError:
                # That there is no animal where a curve goes is said; where a correction goes astray is none of its.
                if number == 0:
                    raise
                return None
            if look is None or not np.all(np.isfinite(look.by)):
                return None
            left = float(np.max(np.abs(look.values)))
            solved = left <= max(SOLVED, ROUNDING * float(np.max(np.abs(look.by))))
            # Newton's method squares what is small: what does not get smaller jumps.
            if not solved and left > 0.5 * before:
                return None
            before = left
            # The next move, and the way along the curve, at once.
            system, right = np.vstack([look.by, normal]), np.zeros((len(y), 2))
            right[:-1, 0], right[-1] = -look.values, (normal @ (guess - y), 1.0)
            try:
                move, tangent = np.linalg.solve(system, right).T
            except np.linalg.LinAlgError:
                return None
            y = y + move
            if solved:
                size = math.copysign(float(np.linalg.norm(tangent)), float(tangent @ ahead))
                return Point(y, tangent / size, look)
        return None

    def middle(self, first: Point, last: Point, share: float) -> Point | None:
        """Return a point between two that are not far apart."""
        if share in (0.0, 1.0):
            return last if share else first
        chord = last.y - first.y
        size, guess = float(np.linalg.norm(chord)), cubic_between(first, last, share)
        return self.corrected(guess, chord / size, (1.0 - share) * first.tangent + share * last.tangent)


def tangent_of(by: Floats, ahead: Floats) -> Floats:
    """Return the unit tangent of a curve from the derivatives of its conditions, ``(n + 1,)``, that points ahead."""
    size = by.shape[1]
    try:
        tangent = np.linalg.solve(np.vstack([by, ahead]), np.append(np.zeros(size - 1), 1.0))
    except np.linalg.LinAlgError:
        tangent = np.linalg.svd(by)[2][-1]
    unit: Floats = tangent / np.linalg.norm(tangent)
    return unit if unit @ ahead > 0.0 else -unit


def ahead_of(points: Sequence[Point], step: float) -> Floats:
    """Return where a curve is expected a step further on: on the cubic through its last two points, along tangents."""
    last = points[-1]
    straight: Floats = last.y + step * last.tangent
    if len(points) < 2:
        return straight
    before = points[-2]
    size = float(np.linalg.norm(last.y - before.y))
    if not size > 0.3 * step:
        return straight
    # Its second and third derivative, by the length of the chord, at the last point.
    slope = (last.y - before.y) / size
    second = (2.0 * before.tangent + 4.0 * last.tangent - 6.0 * slope) / size
    third = (6.0 * before.tangent + 6.0 * last.tangent - 12.0 * slope) / size**2
    return straight + step**2 * second / 2.0 + step**3 * third / 6.0


def turns_back(first: Point, second: Point) -> bool:
    """Whether the place grows at one of two points and falls at the other, by more than rounding."""
    ahead, back = first.tangent[-1], second.tangent[-1]
    return bool(ahead * back < 0.0 and max(abs(ahead), abs(back)) > LEVEL)


def at_place(stretch: Stretch, first: Point, second: Point, bound: float) -> Point | None:
    """Return the point between two where the place, by its scale, is a given one; None if it cannot be found."""
    if bound in (first.y[-1], second.y[-1]):
        return first if first.y[-1] == bound else second
    size, across = float(np.linalg.norm(second.y - first.y)), np.append(np.zeros(len(first.y) - 1), 1.0)
    guess = cubic_between(first, second, share_at(first, second, bound))
    guess[-1] = bound
    steep = abs(second.y[-1] - first.y[-1]) > STEEP * size
    found = stretch.corrected(guess, across, first.tangent + second.tangent) if steep else None
    if found is not None and np.linalg.norm(found.y - guess) < OFF * size:
        return found
    # Along the curve: next to a fold the place says little of where a point is.
    near = at_zero(stretch, first, second, lambda point: float(point.y[-1]) - bound)
    if near is None:
        return None
    guess = np.append(near.y[:-1], bound)
    exact = stretch.corrected(guess, across, near.tangent)
    is_it = exact is not None and np.linalg.norm(exact.y - near.y) < SAME_PLACE
    return exact if is_it else Point(guess, near.tangent, near.look)


def cubic_between(first: Point, second: Point, share: float) -> Floats:
    """Return where a curve is expected between two of its points: on the cubic along their tangents."""
    size = float(np.linalg.norm(second.y - first.y))
    h00, h10 = (1.0 + 2.0 * share) * (1.0 - share) ** 2, share * (1.0 - share) ** 2
    h01, h11 = share**2 * (3.0 - 2.0 * share), share**2 * (share - 1.0)
    y: Floats = h00 * first.y + h01 * second.y + size * (h10 * first.tangent + h11 * second.tangent)
    return y


def share_at(first: Point, second: Point, bound: float) -> float:
    """Return where between two points, on that cubic, the place is a given one."""
    low, high = 0.0, 1.0
    rising = second.y[-1] > first.y[-1]
    for _ in range(HALVINGS + 6):
        middle = 0.5 * (low + high)
        above = cubic_between(first, second, middle)[-1] > bound
        low, high = (low, middle) if above == rising else (middle, high)
    return 0.5 * (low + high)


def at_zero(
    stretch: Stretch, first: Point, second: Point, value: Callable[[Point], float], accuracy: float = 1e-11
) -> Point | None:
    """Return the point between two at which something that differs in sign is zero; None if it cannot be found."""
    from scipy.optimize import brentq

    met = {0.0: first, 1.0: second}

    def at(share: float) -> float:
        point = met[share] if share in met else stretch.middle(first, second, share)
        if point is None:
            raise ArithmeticError
        met[share] = point
        found = value(point)
        if not math.isfinite(found):
            raise ArithmeticError
        return found

    try:
        share = brentq(at, 0.0, 1.0, xtol=accuracy, rtol=1e-14)
    except (ArithmeticError, ValueError):
        return None
    return met[share] if share in met else stretch.middle(first, second, share)


def at_crossing(stretch: Stretch, first: Point, second: Point, value: Callable[[Point], float]) -> Point | None:
    """Return the point between two at which something is zero because another curve crosses; None if there is none.

    There the conditions do not tell the two curves from each other: the point is interpolated from those around.
    """
    low, high, at_low = 0.0, 1.0, value(first)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        point = stretch.middle(first, second, middle)
        here = 0.0 if point is None else value(point)
        if here == 0.0:
            break
        low, high, at_low = (middle, high, here) if here * at_low > 0.0 else (low, middle, at_low)
    around = np.clip(0.5 * (low + high) + ASIDE * np.array([-1.0, -0.75, -0.5, 0.5, 0.75, 1.0]), 0.0, 1.0)
    points = [(share, stretch.middle(first, second, float(share))) for share in np.unique(around)]
    known = [(share, point) for share, point in points if point is not None]
    if len(known) < 4:
        return None
    shares, some = np.array([share for share, _ in known]), [point for _, point in known]
    centre, degree = 0.5 * (low + high), len(known) - 1
    values = np.polynomial.polynomial.polyfit((shares - centre) / ASIDE, [value(point) for point in some], degree)
    roots = np.polynomial.polynomial.polyroots(values)
    real = roots[np.abs(roots.imag) < 1e-9].real
    if not len(real) or not np.min(np.abs(real)) <= 1.0:
        return None
    root = float(real[np.argmin(np.abs(real))])
    coefficients = np.polynomial.polynomial.polyfit((shares - centre) / ASIDE, [point.y for point in some], degree)
    y = np.array(np.polynomial.polynomial.polyval(root, coefficients))
    look, share = stretch.look(y), centre + ASIDE * root
    tangent = (1.0 - share) * first.tangent + share * second.tangent
    return None if look is None else Point(y, tangent / np.linalg.norm(tangent), look)
