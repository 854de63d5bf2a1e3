"""What varies along a curve of gaits: a parameter, what is given, or several of these together.

A route is a curve in the space of all that a problem is made of. A problem is a few arrays (`legspring.problem`), and
all of them may depend on the place on the route: by the animal's laws, or through the units of the unknowns. So all are
taken as polynomials of the place, exact to rounding, piece by piece between kinks; with these come their derivatives.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from legspring.checks import checked_number, shown
from legspring.gait import Gait
from legspring.kernel.walker import Floats
from legspring.layout import LEG, PLACES, System, unit_and_words
from legspring.measures.sensitivity import ENDS, checked, scale_of, unit_of, value_of
from legspring.model import Animal
from legspring.problem import POSITIVE, TARGETS, GaitProblem
from legspring.solve import Origin

DEGREES = (2, 8, 16, 32)
SMOOTH = 1e-12
"""Difference between polynomial and problem, by the largest value, that is none."""
BETWEEN = 0.87
"""Where, within a piece, it is looked at."""
WIDEST = 1.0
"""Largest width of a piece, in units of the route's scale."""
SMALLEST = 1e-12
"""Share of its value at the start below which nothing is asked of what cannot be nought."""
INWARDS = 1e-6
"""How far from the end of a piece, by its width, there has to be an animal for there to be one up to the end."""
NARROWEST = 1e-9
"""How well it is known, by the scale, up to where there are animals."""
Range = tuple[float, float]
Subject = str | Sequence[str] | Mapping[str, float] | Animal


@dataclass(frozen=True)
class Piece:
    """A problem's numbers as polynomials of the place, between two places.

    Attributes
    ----------
    low, high
        Where it holds.
    problem
        The problem in the middle, with all that is no number.
    fixed, moving, factors
        ``(A,)``: all numbers of the problem; which of them move; and coefficients of the polynomials of these.
    """

    low: float
    high: float
    problem: GaitProblem
    fixed: Floats
    moving: NDArray[np.int64]
    factors: Floats

    def write(self, place: float, numbers: Floats, rates: Floats) -> None:
        """Write what moves of the problem's numbers at a place, and its derivatives, where the rest stands already."""
        half = 0.5 * (self.high - self.low)
        x = (place - self.low) / half - 1.0
        degree = len(self.factors) - 1
        powers, slopes = np.empty(degree + 1), np.empty(degree + 1)
        power, slope = 1.0, 0.0
        for n in range(degree + 1):
            powers[n], slopes[n] = power, slope
            power, slope = power * x, (n + 1) * power / half
        numbers[self.moving], rates[self.moving] = powers @ self.factors, slopes @ self.factors

    @cached_property
    def cuts(self) -> list[tuple[slice, tuple[int, ...]]]:
        """Where base, along, at_end, at_start and given stand in the vector of all numbers, and their shapes."""
        shapes = [array.shape for array in arrays_of(self.problem)]
        ends = np.cumsum([0, *(math.prod(shape) for shape in shapes)]).tolist()
        return [(slice(*cut), shape) for cut, shape in zip(pairwise(ends), shapes, strict=True)]

    def unpacked(self, numbers: Floats) -> list[Floats]:
        """Return base, along, at_end, at_start and given."""
        return [numbers[cut].reshape(shape) for cut, shape in self.cuts]


def arrays_of(problem: GaitProblem) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Return what the conditions of a problem are made of."""
    task = problem.task
    return problem.base, task.along, task.at_end, task.at_start, task.given


def piece_of(problem_at: Callable[[float], GaitProblem], low: float, high: float) -> Piece:
    """Return the polynomials of a problem between two places, of the lowest degree that will do.

    Raises
    ------
    ValueError
        If the problem is not smooth in between.
    """
    known: dict[float, GaitProblem] = {}
    middle, half = 0.5 * (low + high), 0.5 * (high - low)

    def numbers(x: float) -> Floats:
        known.setdefault(x, problem_at(middle + half * x))
        return np.concatenate([array.ravel() for array in arrays_of(known[x])])

    for degree in DEGREES:
        # Not the ends, where there may be kinks or something may be conserved; but the middle.
        nodes = np.polynomial.chebyshev.chebpts1(degree + 1)
        nodes[degree // 2] = 0.0
        values = np.array([numbers(float(x)) for x in nodes])
        moving = np.flatnonzero(np.any(values != values[0], axis=0))
        coefficients = np.polynomial.chebyshev.chebfit(nodes, values[:, moving], degree)
        size = np.max(np.abs(values[:, moving]), axis=0, initial=0.0)
        left = np.polynomial.chebyshev.chebval(BETWEEN, coefficients) - numbers(BETWEEN)[moving]
        if np.all(np.abs(left) <= SMOOTH * size):
            factors = np.zeros((degree + 1, len(moving)))
            for column, row in enumerate(coefficients.T):
                powers = np.polynomial.chebyshev.cheb2poly(row)
                factors[: len(powers), column] = powers
            return Piece(low, high, known[0.0], values[0], moving, factors)
    raise ValueError(f"route: must be smooth between {low:g} and {high:g}")


@dataclass(frozen=True)
class Route:
    """What varies along a curve.

    Attributes
    ----------
    name, unit, words
        What it is called and what it means.
    start, scale
        The place of the gait that is followed, and a change that makes a difference.
    low, high
        Places beyond which there is nothing.
    kinks
        Places where the animal's laws, and with them the curve, bend.
    problem_at
        Returns the problem at a place.
    gait
        The gait that is followed, as its problems have it: with each foot remembered for itself, where offsets vary.
    anchor
        Where pieces end; by default the start.
    positive
        Whether places are factors, which cannot be nought.
    pieces
        What is known of it: routes that differ in their start only may share it.
    """

    name: str
    unit: str
    words: str
    start: float
    scale: float
    low: float
    high: float
    kinks: tuple[float, ...]
    problem_at: Callable[[float], GaitProblem]
    gait: Gait | None = field(default=None, compare=False, repr=False)
    anchor: float | None = None
    positive: bool = False
    pieces: dict[Range, Piece] = field(default_factory=dict, compare=False, repr=False)

    def place(self, y: Floats) -> float:
        """Return the place of a point, of which it is the last number, by the scale."""
        value = float(y[-1]) * self.scale
        exact = (
            one for one in (self.start, self.low, self.high, *self.kinks) if math.isclose(value, one, rel_tol=1e-15)
        )
        return next(exact, value)

    def region(self, place: float, ahead: float) -> tuple[float, float]:
        """Return the limits of what is smooth around a place, on the side of ``ahead`` (+1 or -1) at a kink."""
        cuts = sorted({self.low, *self.kinks, self.high})
        near = 1e-12 * self.scale
        for low, high in pairwise(cuts):
            if low - near <= place <= high + near:
                at_end = place > high - near if ahead > 0.0 else place < low + near
                if not at_end:
                    return low, high
        return (cuts[-2], cuts[-1]) if place > cuts[0] + near else (cuts[0], cuts[1])

    def piece(self, place: float, region: tuple[float, float]) -> Piece:
        """Return the piece for a place, or the nearest one, in a region.

        Raises
        ------
        ValueError
            If there is no such animal.
        """
        inside = min(max(place, region[0]), region[1])
        low, high = self._cell(inside)
        width, low, high = high - low, max(low, region[0]), min(high, region[1])
        if high - low < 1e-3 * width:
            # A sliver at the end of a region belongs to the piece beside it.
            low, high = (max(low - width, region[0]), high) if low > region[0] else (low, min(high + width, region[1]))
        if (low, high) not in self.pieces:
            self.pieces[low, high] = piece_of(self.problem_at, *self._possible(low, high, inside))
        piece = self.pieces[low, high]
        if not piece.low <= inside <= piece.high:
            self.problem_at(inside)
        return piece

    def _cell(self, place: float) -> Range:
        """Return the ends of the piece around a place, if nothing cuts it: of factors, each twice the one before."""
        anchor = self.start if self.anchor is None else self.anchor
        if self.positive:
            power = math.floor(math.log2(max(place / anchor, SMALLEST)))
            return anchor * 2.0**power, anchor * 2.0 ** (power + 1)
        number = math.floor((place - anchor) / (WIDEST * self.scale))
        return anchor + number * WIDEST * self.scale, anchor + (number + 1) * WIDEST * self.scale

    def _possible(self, low: float, high: float, place: float) -> tuple[float, float]:
        """Return the part of a range around a place in which there are animals."""
        return self._last_possible(place, low), self._last_possible(place, high)

    def _last_possible(self, place: float, end: float) -> float:
        try:
            self.problem_at(place + (1.0 - INWARDS) * (end - place))
            return end
        except ValueError:
            pass
        known, beyond = place, end
        while abs(beyond - known) > NARROWEST * self.scale:
            middle = 0.5 * (known + beyond)
            try:
                self.problem_at(middle)
                known = middle
            except ValueError:
                beyond = middle
        return known


BESIDE = 1e-6
"""A change of a parameter, by its scale, that is next to none."""
LIMITS = {"offset": (0.0, 2.0), "heading": (-math.pi, math.pi), "lateral_drift": (-math.inf, math.inf)}


def route_for(gait: Gait, subject: Subject) -> Route:
    """Return what a gait is to be followed along.

    Parameters
    ----------
    gait
        A gait that a search, or a curve, has found.
    subject
        The name of a parameter or of what the gait was asked for; several names, which grow by a common factor; a
        mapping of names to values, or another animal, towards which all of them go together, from 0 here to 1 there.

    Raises
    ------
    ValueError
        If it is none of these, or what the gait has found.
    """
    if gait.origin is None or not isinstance(gait.origin, Origin):
        raise ValueError("gait: must be one that a search has found, which says what was given and what was free")
    if isinstance(subject, str):
        return _along_one(gait, subject)
    if isinstance(subject, Animal):
        targets, words = _differences(gait, subject), f"share of the way to {subject.name}"
        if not targets:
            raise ValueError(f"parameter = {subject.name!r}: must be an animal that differs from the gait's")
        return _along_several(gait, targets, "share", words)
    if isinstance(subject, Mapping) and subject:
        targets = {name: checked_number(f"parameter[{shown(name)}]", v, "a number") for name, v in subject.items()}
        ends = ", ".join(f"{name} = {value:g}" for name, value in targets.items())
        return _along_several(gait, targets, "share", f"share of the way to {ends}")
    if isinstance(subject, Sequence) and subject:
        names = list(subject)
        targets = {name: 2.0 * value_of(gait, checked(gait, name)) for name in names}
        return _along_several(gait, targets, "factor", f"factor of {', '.join(names)}", start=1.0)
    raise ValueError(f"parameter = {shown(subject)}: must be a name, several names, values by name, or an animal")


def _along_one(gait: Gait, name: str) -> Route:
    """Return the route along one parameter, or along something that was given as a number."""
    origin = gait.origin
    assert isinstance(origin, Origin)
    checked(gait, name)
    problem, own = origin.loosened(gait, [name])
    value, system = value_of(gait, name), problem.system
    low, high = limits_of(problem, name)
    unit, words = (unit_of(name), name.replace("_", " ")) if name in problem.given else _about(name)

    def changed(place: float) -> GaitProblem:
        return with_value(problem, name, place)

    kinks = tuple(one for one in kinks_of(system, name) if low < one < high)
    scale, problem_at = scale_of(system, name, value), unmirrored_where(gait, changed, value, low, high)
    check_lasting(problem_at, value, scale, name)
    quantity = name.rpartition(".")[2]
    positive = (quantity in POSITIVE or name in TARGETS or name == "desired_speed") and low == 0.0
    return Route(name, unit, words, value, scale, low, high, kinks, problem_at, own, positive=positive)


def _along_several(gait: Gait, targets: Mapping[str, float], name: str, words: str, start: float = 0.0) -> Route:
    """Return the route on which several parameters go from their values, at ``start``, to others, 1 further on."""
    origin = gait.origin
    assert isinstance(origin, Origin)
    here = {one: value_of(gait, checked(gait, one)) for one in targets}
    problem, own = origin.loosened(gait, list(targets))

    def changed(place: float) -> GaitProblem:
        there = problem
        for one, end in targets.items():
            there = with_value(there, one, here[one] + (place - start) * (end - here[one]))
        return there

    lows, highs = [-math.inf], [math.inf]
    kinks: list[float] = []
    for one, end in targets.items():
        if end != here[one]:
            low, high = limits_of(problem, one)
            ends = sorted(start + (limit - here[one]) / (end - here[one]) for limit in (low, high))
            lows, highs = [*lows, ends[0]], [*highs, ends[1]]
            kinks += [start + (kink - here[one]) / (end - here[one]) for kink in kinks_of(problem.system, one)]
    low, high = max(lows), min(highs)
    inside = tuple(sorted(one for one in kinks if low < one < high))
    problem_at = unmirrored_where(gait, changed, start, low, high)
    check_lasting(problem_at, start, 1.0, name)
    return Route(name, "1", words, start, 1.0, low, high, inside, problem_at, own, positive=start > 0.0)


def check_lasting(problem_at: Callable[[float], GaitProblem], start: float, scale: float, name: str) -> None:
    """Raise ValueError for what cannot vary at all, as something is conserved for this value only."""
    here = problem_at(start)
    for side in (1.0, -1.0):
        try:
            beside = problem_at(start + side * BESIDE * scale)
        except ValueError:
            continue
        if (beside.unknowns, beside.conditions) == (here.unknowns, here.conditions):
            return
    raise ValueError(f"parameter = {shown(name)}: must be another one; {ENDS}")


def _about(name: str) -> tuple[str, str]:
    return ("deg", "slope") if name == "slope_deg" else unit_and_words(name)


def with_value(problem: GaitProblem, name: str, value: float) -> GaitProblem:
    """Return a problem in which a parameter, or what is given, has another value.

    Raises
    ------
    ValueError
        If there is no such animal.
    """
    system = problem.system
    if name in problem.given:
        return replace(problem, given={**problem.given, name: value})
    if name.startswith("slope"):
        return replace(problem, system=replace(system, slope=math.radians(value) if name == "slope_deg" else value))
    return replace(problem, system=replace(system, animal=system.animal.replace(**{name: value})))


def limits_of(problem: GaitProblem, name: str) -> tuple[float, float]:
    """Return the range that a parameter, or what is given, cannot leave."""
    quantity, system = name.rpartition(".")[2], problem.system
    if name.startswith("slope"):
        low, high = system.animal.speed_law.domain_deg
        return (low, high) if name == "slope_deg" else (math.radians(low), math.radians(high))
    if name == "heading" and system.animal.tuned:
        return -0.5 * math.pi, 0.5 * math.pi
    if quantity in LIMITS:
        return LIMITS[quantity]
    if quantity in POSITIVE or quantity in ("actuation", "damping") or name in TARGETS or name == "desired_speed":
        return 0.0, math.inf
    return -math.inf, math.inf


def kinks_of(system: System, name: str) -> list[float]:
    """Return where the laws that a parameter moves have kinks, or something is conserved on the way."""
    law, bend = system.animal.speed_law, system.animal.step_law.constant_above
    if name == "desired_speed" and bend is not None:
        return [bend]
    if not name.startswith("slope"):
        return []
    unit = 1.0 if name == "slope" else math.degrees(1.0)
    found = [0.0] if system.animal.conservative or system.yaws else []
    if bend is not None and law.rate != 0.0:
        found.append((bend - law(0.0)) / law.rate * unit)
    return sorted(set(found))


def unmirrored_where(
    gait: Gait, problem_at: Callable[[float], GaitProblem], start: float, low: float, high: float
) -> Callable[[float], GaitProblem]:
    """Return the problems of a route, without the mirror image all along if it is lost beside the start."""
    beside = start + (1e-3 if start + 1e-3 < high else -1e-3) * (abs(start) or 1.0)
    try:
        lost = problem_at(start).system.mirrored and not problem_at(beside).system.mirrored
    except ValueError:
        lost = False
    return (lambda place: limping(problem_at(place), gait)) if lost else problem_at


def limping(problem: GaitProblem, gait: Gait) -> GaitProblem:
    """Return the problem of gaits whose steps need not mirror one another, of an animal whose phases are a gait's.

    What was asked for is left to the gait where phases were free for it: asked for no drift in a stride, steps that
    mirror one another may drift as they like, so that nothing would fix a gait beside one of these.
    """
    system = problem.system
    phases = {f"{pair}.phase": angle for pair, angle in zip(system.animal.pairs, gait.phase, strict=True)}
    tuned = [name for name in problem.free if name in phases]
    if not tuned:
        return replace(problem, system=replace(system, symmetric=False))
    animal = system.animal.replace(**{name: phases[name] for name in tuned})
    free = tuple(name for name in problem.free if name not in tuned)
    return GaitProblem(replace(system, animal=animal, symmetric=False), free)


def _differences(gait: Gait, other: Animal) -> dict[str, float]:
    """Return the numbers in which another animal differs, by name.

    Raises
    ------
    ValueError
        If it differs in what is no number.
    """
    own = gait.system.animal
    if [(leg.name, leg.pair, leg.touchdown, leg.follows, leg.length_law) for leg in own.legs] != [
        (leg.name, leg.pair, leg.touchdown, leg.follows, leg.length_law) for leg in other.legs
    ]:
        raise ValueError(f"parameter = {other.name!r}: must have the legs that {own.name!r} has, in other numbers only")
    if own.body.yaw != other.body.yaw or own.sagittal != other.sagittal:
        raise ValueError(f"parameter = {other.name!r}: must have a body that moves as that of {own.name!r} does")
    there = System(other, gait.slope, gait.family)
    found: dict[str, float] = {}
    for name in ("gravity", "mass", "inertia", "desired_speed", "step_duration"):
        here, end = gait.system.values[PLACES[name]], there.values[PLACES[name]]
        if here != end:
            found[name] = float(end)
    for i, leg in enumerate(own.legs):
        for quantity in LEG:
            here, end = (one.values[one.place(i, quantity)] for one in (gait.system, there))
            if here != end:
                found[f"{leg.name}.{quantity}"] = float(end)
    return found
