"""Curves of special points: one unknown more, and what is special as one more condition."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from legspring.asking import Counted
from legspring.continuation import Special
from legspring.footing import Feet, Moment, apart, at_zero_of, moments_of, trivial_of
from legspring.gait import IDLE, Gait, Invalid
from legspring.kernel.events import WINDOW
from legspring.kernel.footfalls import LANDING, LEAVING, STANCE, STARTING, TOUCH
from legspring.kernel.walker import Floats
from legspring.landmarks import Kind, from_circle, from_minus_one, from_one
from legspring.measures.registry import BY_NAME
from legspring.problem import GaitProblem
from legspring.stretch import Look, Point, Stretch

APART = 1e-6
"""Distance of points, in units of the unknowns, whose difference is a derivative."""
CLOSE_BY = 1e-4
"""Distance within which they are the same."""
JUMP = 1e-2
"""Difference in such a distance that is a jump."""
MARGINS = (1e-3, 1e-5, 1e-7, 1e-8)
"""How far from where something jumps points are sought, one after the other."""
SLOWLY = (8e-3, 6e-3, 4.5e-3, 3e-3)
"""Rates at which points are sought from which the one with a rate of zero is extrapolated."""
SLOW = 0.05
"""Rate, m per step duration, at which a leg may lift off or come down where it grazes."""
RATES = {Kind.GRAZING_LIFTOFF: LEAVING, Kind.GRAZING_TOUCHDOWN: LANDING}
GRAZING = tuple(RATES)
ONE_SIDED = (Kind.WINDOW, Kind.NO_LIFTOFF, *GRAZING)
TESTS = {
    Kind.BRANCHING: from_one,
    Kind.PLUS_ONE: from_one,
    Kind.PERIOD_DOUBLING: from_minus_one,
    Kind.SYMMETRY_BREAKING: from_minus_one,
    Kind.NEIMARK_SACKER: from_circle,
}
Condition = Callable[["Line", Point], float]


class Target(NamedTuple):
    """What was asked for and varies: which condition it is, and its value at the start, by its unit."""

    row: int
    value: float


@dataclass
class Line(Stretch):
    """A part of a boundary.

    The numbers of its points are the problem's unknowns, among them a parameter that was let go; or else, last of them,
    the value of what was asked for; then the place.

    Attributes
    ----------
    condition
        What is zero all along.
    target
        What was asked for, if that varies.
    one_sided
        Whether there is something on one side only, where the condition is positive.
    margin
        How far from zero it stays then.
    is_inside
        Whether a point is in the range that is not left.
    near
        Where the derivatives of the condition were measured last, and what they are.
    """

    condition: Condition = field(default=lambda _, __: 0.0)
    target: Target | None = None
    one_sided: bool = False
    margin: float = 0.0
    is_inside: Callable[[Floats], bool] = lambda _: True
    near: tuple[Floats, Floats] | None = None

    def unknowns(self, y: Floats) -> Floats:
        """Return the unknowns of the problem at a point."""
        return y[:-1] if self.target is None else y[:-2]

    def inside(self, y: Floats) -> bool:
        """Whether a point is in the range that is not left."""
        return self.is_inside(y)

    def look(self, y: Floats) -> Look | None:
        """Look at all conditions; the derivatives of the one that is special are differences."""
        here = self.without(y)
        if here is None:
            return None
        value = self.condition(self, Point(y, y, here))
        if self.near is None or np.max(np.abs(self.near[0] - y)) > CLOSE_BY:
            rates = self.measured(y, value)
            if rates is None:
                return None
            self.near = (y.copy(), rates)
        left, by = self.last_row(value, self.near[1])
        return Look(np.append(here.values, left), np.vstack([here.by, by]), here.map)

    def last_row(self, value: float, rates: Floats) -> tuple[float, Floats]:
        """Return by how much what is special is missed, and the derivatives of that."""
        return value - self.margin, rates

    def measured(self, y: Floats, value: float) -> Floats | None:
        """Return the derivatives of what is special, as differences; None where it jumps on both sides."""
        rates = np.zeros(len(y))
        for n in range(len(y)):
            steps = []
            for side in (APART, -APART):
                beside = y.copy()
                beside[n] += side
                there = self.without(beside)
                if there is not None:
                    steps.append((self.condition(self, Point(beside, beside, there)) - value) / side)
            known = [step for step in steps if abs(step) * APART < JUMP]
            if not known:
                return None
            rates[n] = sum(known) / len(known)
        return rates

    def without(self, y: Floats) -> Look | None:
        """Look at all conditions but the one that is special."""
        look = super().look(y)
        if look is None or self.target is None:
            return look
        column = np.zeros(len(look.values))
        column[self.target.row] = -1.0
        values = look.values + (y[-2] - self.target.value) * column
        return Look(values, np.insert(look.by, -1, column, axis=1), look.map)

    def corrected(self, guess: Floats, normal: Floats, ahead: Floats) -> Point | None:
        """Return the point of the curve in the plane through a guess; where there is one side only, from there."""
        found = self._corrected(guess, normal, ahead)
        if found is None and self.near is not None:
            # Derivatives from close by may not be close enough.
            self.near = None
            found = self._corrected(guess, normal, ahead)
        return found

    def _corrected(self, guess: Floats, normal: Floats, ahead: Floats) -> Point | None:
        guess, found = self.from_inside(guess, normal, MARGINS[0]) if self.one_sided else guess, None
        for margin in MARGINS if self.one_sided else (0.0,):
            self.margin = margin
            found = super().corrected(guess if found is None else found.y, normal, ahead)
            if found is None:
                return None
        return found

    def from_inside(self, guess: Floats, normal: Floats, margin: float) -> Floats:
        """Return a guess from where there is something."""
        if self.near is None:
            return guess
        rates = self.near[1]
        rates = rates - float(rates @ normal) / float(normal @ normal) * normal
        return guess + margin * rates / max(float(rates @ rates), 1e-12)


@dataclass
class GrazingLine(Line):
    """A line along which a leg lifts off, or comes down, at a rate of zero; the condition is the square of that rate.

    There derivatives grow without bounds, but points are smooth functions of the rate: they are extrapolated from
    points at which it is not zero.

    Attributes
    ----------
    aside
        From the last point found to that with the first of these rates.
    """

    aside: Floats | None = None

    def last_row(self, value: float, rates: Floats) -> tuple[float, Floats]:
        """Return by how much the rate is missed, and the derivatives of that."""
        rate = math.sqrt(value) if value > 0.0 else math.nan
        return rate - self.margin, rates / (2.0 * rate)

    def _corrected(self, guess: Floats, normal: Floats, ahead: Floats) -> Point | None:
        first, met = self.first_rates(guess) if self.aside is None else [], []
        found = guess if self.aside is None else guess + self.aside
        for rate in (*first, *SLOWLY):
            self.margin = rate
            point = Stretch.corrected(self, found, normal, ahead)
            if point is None:
                return None
            found = point.y
            met.append(point)
        some = [point.y for point in met[-len(SLOWLY) :]]
        y = at_zero_of(SLOWLY, some)
        self.aside = some[0] - y
        return met[-1]._replace(y=y)

    def first_rates(self, guess: Floats) -> list[float]:
        """Return rates that lead from the first point of all to those from which is extrapolated."""
        here = self.without(guess)
        value = math.nan if here is None else self.condition(self, Point(guess, guess, here))
        count = math.floor(math.log2(SLOWLY[0] / math.sqrt(value))) if 0.0 < value < SLOWLY[0] ** 2 else 0
        return [SLOWLY[0] * 0.5**n for n in range(count, 0, -1)]


def let_go(problem: GaitProblem, name: str) -> GaitProblem:
    """Return a problem with one unknown more than conditions: a coordinate that was given, or a parameter."""
    given, free = dict(problem.given), problem.free
    if name in given:
        del given[name]
    else:
        free = (*free, name)
    return Counted(problem.system, free, given)


# What is special --------------------------------------------------------------------------------------------


def of_fold(column: int) -> Condition:
    """Return what is zero where the conditions are singular but for one column, that of what varies."""

    def condition(line: Line, point: Point) -> float:
        size = len(point.y) - 2
        columns = [n for n in range(size + 1) if n != column]
        return float(np.linalg.det(point.look.by[:size, columns]))

    return condition


def of_multipliers(test: Callable[[NDArray[np.complex128]], float]) -> Condition:
    """Return what is zero where a multiplier leaves the unit circle."""

    def condition(line: Line, point: Point) -> float:
        system = line.loaded(point.y).problem.system
        return test(trivial_of(system).free(point.look.map[None])[0])

    return condition


def of_leg(feet: Feet, leg: int, kind: Kind) -> Condition:
    """Return what is zero where a leg begins to do something else."""

    def condition(line: Line, point: Point) -> float:
        p = line.parameters(point.y)
        if kind is Kind.IDLE:
            # As large as other conditions are.
            return (feet.peak(p, leg) - IDLE) / IDLE
        seen = feet.seen(p[None])[2][0, leg]
        if kind is Kind.WRONG_START:
            return float(seen[STARTING])
        return float(seen[STANCE] - WINDOW if kind is Kind.WINDOW else 2.0 - seen[STANCE])

    return condition


def is_slow(special: Special) -> bool:
    """Whether a leg lifts off, or comes down, at a rate of zero; one that grazes may also touch zero in between."""
    if special.kind not in GRAZING:
        return False
    system, p = special.gait.system, special._stretch.parameters(special._point.y)
    leg = [one.name for one in system.animal.legs].index(special.leg)
    return bool(abs(Feet(system).seen(p[None])[2][0, leg, RATES[special.kind]]) < SLOW)


def of_rate(feet: Feet, leg: int, kind: Kind) -> Condition:
    """Return what is zero where a leg lifts off, or comes down, at a rate of zero."""
    # Where two zeros meet, the square of the rate is what goes to zero evenly.
    return lambda line, point: float(feet.seen(line.parameters(point.y)[None])[2][0, leg, RATES[kind]] ** 2)


def of_dip(feet: Feet, leg: int, kind: Kind) -> Condition:
    """Return what is zero where the force of a leg, or the height of its foot, touches zero in between."""
    return lambda line, point: feet.dip(line.parameters(point.y), leg, kind is Kind.GRAZING_LIFTOFF)


def of_old_leg(feet: Feet, leg: int) -> Condition:
    """Return what is zero where a leg lifts off just as a step begins, by which it was put down before."""
    system = feet.system
    alike = system.animal.first_legs[system.pair[leg]] if system.mirrored else leg
    by_clock = system.animal.legs[leg].touchdown == "clock"

    def condition(line: Line, point: Point) -> float:
        p = line.parameters(point.y)
        _, times, seen = feet.seen(p[None])
        if by_clock:
            return float(seen[0, alike, STANCE] - 2.0 + p[system.place(leg, "offset")])
        return float(seen[0, leg, TOUCH] + seen[0, leg, STANCE] - times[0])

    return condition


def of_sequence(feet: Feet, one: Moment, other: Moment) -> Condition:
    """Return what is zero where two events are at one time."""

    def condition(line: Line, point: Point) -> float:
        return apart(feet.traits(line, [point]), 0, one, other)

    return condition


def of_level(measure: str, value: float, gait_of: Callable[[Line, Floats], Gait]) -> Condition:
    """Return what is zero where a measure has a value."""
    one = BY_NAME[measure]

    def condition(line: Line, point: Point) -> float:
        return float(one.of(gait_of(line, point.y))) - value

    return condition


def condition_for(special: Special, problem: GaitProblem, column: int) -> Condition:
    """Return the condition for a special point.

    Parameters
    ----------
    special
        The point.
    problem
        The problem of which one parameter, or target, was let go.
    column
        Which of the numbers of a point that is.

    Raises
    ------
    ValueError
        If there is no curve of such points.
    """
    kind, system = special.kind, problem.system
    if kind is Kind.FOLD:
        return of_fold(column)
    if kind in TESTS:
        return of_multipliers(TESTS[kind])
    feet, legs = Feet(system), [leg.name for leg in system.animal.legs]
    if kind in GRAZING:
        return (of_rate if is_slow(special) else of_dip)(feet, legs.index(special.leg), kind)
    by_clock = special.leg in legs and system.animal.legs[legs.index(special.leg)].touchdown == "clock"
    if kind in (Kind.IDLE, Kind.WRONG_START, *ONE_SIDED) and (by_clock or kind is not Kind.NO_LIFTOFF):
        return of_leg(feet, legs.index(special.leg), kind)
    if kind is Kind.VALIDITY and special.words == Invalid.OLD_LEGS:
        return of_old_leg(feet, legs.index(special.leg))
    if kind is Kind.SEQUENCE:
        return of_sequence(feet, *together(special, feet))
    raise ValueError(f"special = {special}: must be of a kind of which there are curves, and not {kind}")


def together(special: Special, feet: Feet) -> tuple[Moment, Moment]:
    """Return the two events that are at one time in a special point."""
    traits = feet.traits(special._stretch, [special._point])
    moments = moments_of(traits)
    pairs = [(one, other) for n, one in enumerate(moments) for other in moments[n + 1 :]]
    return min(pairs, key=lambda pair: abs(apart(traits, 0, *pair)))
