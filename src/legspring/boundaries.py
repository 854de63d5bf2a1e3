"""Where gaits are born, change and die, as curves in two parameters: `legspring.boundary`.

Of two parameters one is let go, and what is special is one more condition: then the solutions are a curve again, which
the same continuation follows along the other one.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np

from legspring.checks import checked_whole, shown
from legspring.continuation import Special, two_ways
from legspring.curve import Point, Stop, Stretch, Trace, Tracer, at_zero
from legspring.footing import Ending, Feet, Reason, ending_of, find_idle, find_starts
from legspring.gait import Gait
from legspring.kernel.walker import Floats
from legspring.landmarks import Kind, find_crossings, in_order
from legspring.layout import unit_and_words
from legspring.lines import ONE_SIDED, Condition, Line, Target, condition_for, let_go, of_level
from legspring.measures.registry import BY_NAME
from legspring.measures.sensitivity import checked
from legspring.problem import TARGETS, TIED, GaitProblem
from legspring.route import Route, route_for, with_value
from legspring.solve import Origin

MOST_POINTS = 400
LONGEST = 0.05
"""Longest step along a boundary, in units of the unknowns and of the parameters' scales."""
CUSP_WORDS = "two lines of folds meet, and there are none beyond"
TURN_WORDS = "the line turns back"
Range = tuple[float, float]


@dataclass(frozen=True)
class Plane:
    """Two parameters in which a boundary lies: the first is let go, the second is followed.

    Attributes
    ----------
    gait
        Where it begins.
    p1, p2
        Their names.
    ranges
        What is not left.
    """

    gait: Gait
    p1: str
    p2: str
    ranges: tuple[Range, Range]

    @cached_property
    def unchanged(self) -> Route:
        """The second parameter, with nothing let go."""
        route = route_for(self.gait, self.p2)
        low, high = max(self.ranges[1][0], route.low), min(self.ranges[1][1], route.high)
        if not low <= route.start <= high:
            raise ValueError(f"within = ({low:g}, {high:g}): must hold the value of {self.p2}, {route.start:g}")
        return replace(route, low=low, high=high, kinks=tuple(kink for kink in route.kinks if low < kink < high))

    @cached_property
    def target(self) -> Target | None:
        """What was asked for and varies; None if it is a coordinate of the start, or a parameter."""
        problem = self.unchanged.problem_at(self.unchanged.start)
        if self.p1 not in problem.targets:
            return None
        if self.p1 in ("mean_speed", "lateral_drift"):
            raise ValueError(f"p1 = {self.p1!r}: must be another one, as it is asked of a stride here")
        return Target(problem.conditions.index(self.p1), problem.wanted(self.p1) / problem.unit(self.p1))

    @cached_property
    def route(self) -> Route:
        """The second parameter, with the first one let go."""
        unchanged, p1 = self.unchanged, self.p1
        if self.target is not None:
            return unchanged
        return replace(unchanged, problem_at=lambda place: let_go(unchanged.problem_at(place), p1))

    @cached_property
    def problem(self) -> GaitProblem:
        """The problem at the start."""
        return self.route.problem_at(self.route.start)

    @cached_property
    def column(self) -> int:
        """Which of the numbers of a point is the first parameter."""
        if self.target is not None:
            return self.problem.size
        return self.problem.unknowns.index({"mean_speed": "Dy", "lateral_drift": "Dx"}.get(self.p1, self.p1))

    @cached_property
    def start(self) -> Floats:
        """The numbers of the point where it begins, but for the place."""
        z = self.problem.z_of(self.gait)
        return z if self.target is None else np.append(z, self.target.value)

    def first(self, line: Stretch, y: Floats) -> float:
        """Return the value of the first parameter at a point."""
        problem = line.loaded(y).problem
        if self.target is not None:
            return float(y[-2]) * self.problem.unit(self.p1)
        if self.p1 in ("mean_speed", "lateral_drift"):
            p = line.parameters(y)
            share = p[problem.system.place_of("step_duration")]
            return float(p[problem.system.place_of("Dy")] if self.p1 == "mean_speed" else -p[2]) / float(share)
        return float(line.parameters(y)[problem.system.place_of(self.p1)])

    def gait_of(self, line: Stretch, y: Floats) -> Gait:
        """Return a point in the form of a gait, valid or not."""
        problem = with_value(self.unchanged.problem_at(self.route.place(y)), self.p1, self.first(line, y))
        p = line.parameters(y)
        z = p[[problem.places[name] for name in problem.unknowns]] / problem.units
        return replace(problem.gait(z, 0.0), origin=Origin(problem))

    @cached_property
    def units(self) -> tuple[str, str]:
        """Of the two parameters."""
        first = TARGETS[self.p1].split(",")[0] if self.p1 in TARGETS else unit_and_words(self.p1)[0]
        return first, self.route.unit

    def is_inside(self, line: Stretch, y: Floats) -> bool:
        """Whether the first parameter is in its range."""
        low, high = self.ranges[0]
        return low <= self.first(line, y) <= high


@dataclass(frozen=True)
class Corner:
    """A point of a boundary at which something else happens as well.

    Attributes
    ----------
    kind
        ``"cusp"``, where a line of folds turns back; ``"fold"``, where another line does; or what else is special.
    values
        Of the two parameters.
    leg, words
        Whose it is, and what it means.
    after
        Number of the point of the boundary after which it comes.
    gait
        The gait there, or the solution that is none.
    """

    kind: str
    values: tuple[float, float]
    leg: str
    words: str
    after: int
    gait: Gait = field(repr=False, compare=False)


@dataclass(frozen=True)
class Boundary:
    """A curve of special points in two parameters.

    Attributes
    ----------
    kind
        What is special, as ``"fold"``; or the measure that has one value.
    leg
        Whose it is; empty where it is no leg's.
    parameters, units
        The two.
    values
        ``(N, 2)``: of the two, along the curve.
    special
        Points at which something else happens as well: cusps, other multipliers on the unit circle, idle legs.
    ending, beginning
        Why the curve ends, and begins; None if it goes one way only, or is closed.
    """

    kind: str
    leg: str
    parameters: tuple[str, str]
    units: tuple[str, str]
    values: Floats
    special: tuple[Corner, ...]
    ending: Ending
    beginning: Ending | None
    plane: Plane = field(repr=False)
    points: tuple[tuple[Stretch, Point], ...] = field(repr=False)

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.values)

    def __repr__(self) -> str:
        """Say in a line which boundary this is."""
        what = f"{self.kind} ({self.leg})" if self.leg else self.kind
        return f"Boundary({what!r}, {self.parameters}, {len(self)} points, {len(self.special)} special)"

    @cached_property
    def gaits(self) -> tuple[Gait, ...]:
        """The points in the form of gaits, valid or not; each can be followed."""
        return tuple(self.plane.gait_of(line, point.y) for line, point in self.points)


def boundary(
    special: Special | Gait,
    p1: str,
    p2: str,
    *,
    level: str | None = None,
    within: Sequence[Sequence[float]] | None = None,
    most_points: int = MOST_POINTS,
) -> Boundary:
    """Follow what is special in two parameters: the line of folds, of idle legs, of stability lost; or a level line.

    See :ref:`numerics-boundaries`.

    Parameters
    ----------
    special
        A special point of a curve (see `follow`); or a gait, through which a level line goes.
    p1, p2
        The two parameters: names as in `follow`.
    level
        Measure that stays as it is for the gait, such as ``"transport_cost"``; for a special point, left out.
    within
        Two ranges, low and high of each parameter, that are not left.
    most_points
        Points after which to stop, each way.

    Raises
    ------
    ValueError
        For a point of which there are no curves, or parameters that are none.

    Examples
    --------
    >>> import legspring as ls
    >>> gait = ls.find_gaits(ls.cockroach(), slope_deg=40, heading=0.4)[0]
    >>> fold = next(one for one in ls.follow(gait, "heading", to=0.6).special if one.kind == "fold")
    >>> line = ls.boundary(fold, "slope_deg", "heading", within=((36, 41), (0.3, 0.6)))
    >>> round(float(line.values[:, 1].min()), 4)
    0.4375
    """
    most, ranges = checked_whole("most_points", most_points, 2, 1_000_000), _ranges(within)
    gait = special.gait if isinstance(special, Special) else special
    for name in (p1, p2):
        checked(gait, name)
    # What laws tie others to cannot be let go.
    swapped = p1 in TIED
    if p1 == p2 or (p1 in TIED and p2 in TIED):
        raise ValueError(f"p1 = {shown(p1)}, p2 = {shown(p2)}: must be two parameters, one of them tied to no other")
    plane = Plane(gait, p2, p1, ranges[::-1]) if swapped else Plane(gait, p1, p2, ranges)
    found = _followed(plane, special, level, most)
    return _swapped(found) if swapped else found


def _ranges(within: Sequence[Sequence[float]] | None) -> tuple[Range, Range]:
    if within is None:
        return (-math.inf, math.inf), (-math.inf, math.inf)
    try:
        (a, b), (c, d) = ((float(low), float(high)) for low, high in within)
    except (TypeError, ValueError):
        a = b = c = d = 0.0
    if not (a < b and c < d):
        raise ValueError(f"within = {shown(within)}: must be two ranges, ((low, high), (low, high))")
    return (a, b), (c, d)


def _swapped(found: Boundary) -> Boundary:
    """Return a boundary with its parameters in the other order."""
    special = tuple(replace(one, values=one.values[::-1]) for one in found.special)
    names, units = found.parameters[::-1], found.units[::-1]
    return replace(found, parameters=names, units=units, values=found.values[:, ::-1].copy(), special=special)


def _condition(plane: Plane, special: Special | Gait, level: str | None) -> Condition:
    """Return what is zero all along."""
    if isinstance(special, Special):
        if level is not None:
            raise ValueError(f"level = {shown(level)}: must be left out for a special point")
        return condition_for(special, plane.problem, plane.column)
    if level not in BY_NAME or BY_NAME[level].dimensions or not BY_NAME[level].unit:
        raise ValueError(f"level = {shown(level)}: must be a measure that is one number, as transport_cost")
    return of_level(level, float(BY_NAME[level].of(special)), plane.gait_of)


def _followed(plane: Plane, special: Special | Gait, level: str | None, most: int) -> Boundary:
    """Follow a boundary both ways."""
    route, own = plane.route, special.kind if isinstance(special, Special) else None
    condition = _condition(plane, special, level)

    def line(route: Route, region: Range) -> Line:
        made = Line(route, region, condition=condition, target=plane.target, one_sided=own in ONE_SIDED)
        made.is_inside = partial(plane.is_inside, made)
        return made

    ends, near = {1.0: route.high, -1.0: route.low}, 1e-12 * route.scale
    ways = [way for way in ends if way * (ends[way] - route.start) > near]
    traces = [Tracer(route, most, stretch=line, longest=LONGEST).trace(plane.start, way) for way in ways]
    traces = [_trimmed(plane, trace) for trace in traces]
    back = traces[1] if len(traces) > 1 and traces[0].stop is not Stop.CLOSED else None
    whole = traces[0] if back is None else two_ways(back, traces[0])
    points = [(one, point) for one in whole.stretches for point in one.points]
    values = np.array([[plane.first(one, point.y), route.place(point.y)] for one, point in points])
    leg = special.leg if isinstance(special, Special) else ""
    before, special_points = 0, []
    for one in whole.stretches:
        special_points += _corners(plane, one, before, own, leg)
        before += len(one.points)
    return Boundary(
        str(level if own is None else own),
        leg,
        (plane.p1, plane.p2),
        plane.units,
        values,
        tuple(special_points),
        _ending(plane, traces[0]),
        None if back is None else _ending(plane, back),
        plane,
        tuple(points),
    )


def _trimmed(plane: Plane, trace: Trace) -> Trace:
    """End a curve that has left the range of the first parameter where it does so."""
    stretch, (low, high) = trace.stretches[-1], plane.ranges[0]
    points = stretch.points
    if trace.stop is not Stop.OUT_OF_RANGE or len(points) < 2:
        return trace
    bound = low if plane.first(stretch, points[-1].y) < low else high
    end = at_zero(stretch, points[-2], points[-1], lambda point: plane.first(stretch, point.y) - bound, 1e-10)
    points[-1:] = [] if end is None else [end]
    return trace


def _ending(plane: Plane, trace: Trace) -> Ending:
    """Say why a boundary ends."""
    if trace.stop is Stop.OUT_OF_RANGE:
        return Ending(Reason.EDGE, plane.route.place(trace.stretches[-1].points[-1].y), "", plane.p1)
    return ending_of(trace, plane.route)


def _corners(plane: Plane, stretch: Stretch, before: int, own: Kind | None, leg: str) -> list[Corner]:
    """Find the points of a part of a boundary at which something else happens as well."""
    system = stretch.loaded(stretch.points[0].y).problem.system
    minus = Kind.SYMMETRY_BREAKING if system.mirrored and system.steps_per_stride > 1 else Kind.PERIOD_DOUBLING
    feet = Feet(system)
    traits = feet.traits(stretch, stretch.points)
    # Where energy is conserved, a fold is a multiplier of 1 itself.
    known = (own, Kind.FOLD, *([Kind.BRANCHING] if own is Kind.FOLD and system.conserved else []))
    marks = [one for one in find_crossings(stretch, feet.trivial, minus) if one.kind not in known]
    by_legs = [*find_idle(stretch, traits, feet), *find_starts(stretch, traits, feet)]
    marks += [one for one in by_legs if (one.kind, one.leg) != (own, leg)]
    found = [(str(mark.kind), mark.leg, mark.words, mark.point, mark.after) for mark in in_order(marks)]
    for point, row in _turns(plane, stretch):
        kind, words = ("cusp", CUSP_WORDS) if own is Kind.FOLD else ("fold", TURN_WORDS)
        found.append((kind, "", words, point, row))
    found.sort(key=lambda one: one[4])
    return [
        Corner(
            kind,
            (plane.first(stretch, point.y), plane.route.place(point.y)),
            whose,
            words,
            before + row,
            plane.gait_of(stretch, point.y),
        )
        for kind, whose, words, point, row in found
    ]


def _turns(plane: Plane, stretch: Stretch) -> list[tuple[Point, int]]:
    """Find where a curve turns back in both parameters at once, each after its point."""
    found, points, both = [], stretch.points, [plane.column, -1]
    for row in range(len(points) - 1):
        here, there = (points[n].tangent[both] for n in (row, row + 1))
        if float(here @ there) >= 0.0:
            continue
        along = (here - there) / np.linalg.norm(here - there)

        def value(point: Point, along: Floats = along) -> float:
            return float(point.tangent[both] @ along)

        point = at_zero(stretch, points[row], points[row + 1], value, 1e-9)
        if point is not None:
            found.append((point, row))
    return found
