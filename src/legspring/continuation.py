"""Following a gait along a parameter: `legspring.follow`."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from legspring.checks import checked_number, checked_whole, shown
from legspring.curve import Point, Stop, Stretch, Trace, Tracer
from legspring.footing import Ending, Reason, ending_of, find_landmarks, kink_after
from legspring.gait import Gait
from legspring.kernel.walker import Floats
from legspring.landmarks import Kind, Landmark
from legspring.problem import GaitProblem
from legspring.route import Route, Subject, route_for
from legspring.solve import Origin, gait_near

MOST_POINTS = 2000
NEAR_END = 1e-6
"""Distance from the end of a curve within which what legs do is a matter of that."""
AT_END = {
    Reason.WINDOW: Kind.WINDOW,
    Reason.WRONG_START: Kind.WINDOW,
    Reason.GRAZING_LIFTOFF: Kind.GRAZING_LIFTOFF,
    Reason.GRAZING_TOUCHDOWN: Kind.GRAZING_TOUCHDOWN,
}
"""Endings that are special points, which may lead on to other curves."""


@dataclass(frozen=True)
class Special:
    """A special point of a curve.

    Attributes
    ----------
    kind
        What it is (see `Kind`).
    value
        Of what varies, in its unit.
    leg
        Whose it is; empty where it is no leg's.
    words
        What else there is to say about it.
    """

    kind: Kind
    value: float
    leg: str
    words: str
    _route: Route = field(repr=False, compare=False)
    _stretch: Stretch = field(repr=False, compare=False)
    _point: Point = field(repr=False, compare=False)

    @cached_property
    def gait(self) -> Gait:
        """The gait there, or the solution that is none."""
        return gait_at(self._route, self._point)

    def __str__(self) -> str:
        """One line."""
        return f"{self.kind} at {self.value:.10g}" + (f" ({self.leg})" if self.leg else "")

    def switch(self) -> list[Gait]:
        """Return gaits beside it on the curves that branch off, to be followed from there.

        At a period doubling they repeat themselves after twice the time, at a symmetry breaking steps mirror one
        another no more, at a branch point another family of the same kind crosses; at the ignored window, where a leg
        does nothing, that leg pulls where it pushed, half a cycle later, or the other way round. Empty where nothing
        branches off, or nothing was found.
        """
        from legspring.branching import branches

        return branches(self)


def gait_at(route: Route, point: Point) -> Gait:
    """Return a point of a curve in the form of a gait, valid or not."""
    problem = route.problem_at(route.place(point.y))
    gait = problem.gait(point.y[:-1], float(np.max(np.abs(point.look.values))))
    isolation = float(np.linalg.svd(point.look.by[:, :-1], compute_uv=False)[-1])
    return replace(gait, isolation=isolation, origin=Origin(problem))


@dataclass(frozen=True)
class Continuation:
    """A curve of gaits, and of solutions that are none.

    Attributes
    ----------
    parameter, unit, words
        What varies.
    values
        ``(N,)``: of what varies, along the curve.
    valid, reasons
        ``(N,)``: whether a point is a gait, and why not.
    stable
        ``(N,)``: whether all multipliers, but for what is conserved, are below 1.
    half_multipliers
        ``(N, m)``: of the step that the next one mirrors, or of a period, without those of what is conserved.
    special
        Special points, in order along the curve.
    ending, beginning
        Why the curve ends; and where it begins, None if that is the gait that was followed.
    """

    parameter: str
    unit: str
    words: str
    values: Floats
    valid: NDArray[np.bool_]
    reasons: tuple[str, ...]
    stable: NDArray[np.bool_]
    half_multipliers: NDArray[np.complex128]
    special: tuple[Special, ...]
    ending: Ending
    beginning: Ending | None
    start: Gait = field(repr=False)
    _route: Route = field(repr=False)
    _points: tuple[tuple[Stretch, Point], ...] = field(repr=False)

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.values)

    def __repr__(self) -> str:
        """Say in a line which curve this is."""
        ends = f"{self.values[0]:.4g} to {self.values[-1]:.4g}"
        return f"Continuation({self.parameter!r}, {len(self)} points, {ends}, {len(self.special)} special)"

    @cached_property
    def gaits(self) -> tuple[Gait, ...]:
        """The points in the form of gaits, valid or not."""
        return tuple(gait_at(self._route, point) for _, point in self._points)

    @property
    def multipliers(self) -> NDArray[np.complex128]:
        """``(N, m)``: of a stride, without those of what is conserved."""
        mirrored = self._points[0][0].loaded(self._points[0][1].y).problem.system.mirrored
        return self.half_multipliers ** (2 if mirrored else 1)

    def at(self, value: float) -> list[Gait]:
        """Return the gaits of the curve, valid or not, where what varies has a value: one for each time it passes."""
        from legspring.curve import at_place

        target, found = value / self._route.scale, []
        for (stretch, first), (other, second) in zip(self._points, self._points[1:], strict=False):
            if stretch is not other:
                continue
            for one, two in with_folds(stretch, first, second):
                if (one.y[-1] - target) * (two.y[-1] - target) < 0.0 or one.y[-1] == target:
                    point = at_place(stretch, one, two, target)
                    if point is not None:
                        found.append(gait_at(self._route, point))
        if self.values[-1] == value:
            found.append(gait_at(self._route, self._points[-1][1]))
        return found


def with_folds(stretch: Stretch, first: Point, second: Point) -> list[tuple[Point, Point]]:
    """Return the parts of a step of a curve in which the place grows, or falls, all along."""
    from legspring.curve import at_zero

    if first.tangent[-1] * second.tangent[-1] >= 0.0:
        return [(first, second)]
    fold = at_zero(stretch, first, second, lambda point: float(point.tangent[-1]))
    return [(first, second)] if fold is None else [(first, fold), (fold, second)]


def follow(
    gait: Gait,
    parameter: Subject,
    *,
    to: float | None = None,
    within: Sequence[float] | None = None,
    most_points: int = MOST_POINTS,
) -> Continuation:
    """Follow a gait while something varies, past folds, to where it ends.

    See :ref:`numerics-continuation`.

    Parameters
    ----------
    gait
        A gait that a search, or a curve, has found.
    parameter
        What varies: the name of a parameter, or of what the gait was asked for, as ``"slope_deg"``, ``"heading"`` or
        ``"F.stiffness"`` (see `legspring.parameters`); several names, which grow by a common factor, 1 at the start; or
        values by name, or another animal, towards which all goes together, from 0 at the start to 1.
    to
        Value at which to stop. By default the curve is followed both ways.
    within
        Range, low and high, that is not left.
    most_points
        Points after which to stop, each way.

    Returns
    -------
    Continuation
        The curve, with its special points.

    Raises
    ------
    ValueError
        For a parameter that the gait does not depend on or has found, or a range that does not hold its value.

    Examples
    --------
    >>> import legspring as ls
    >>> gait = ls.find_gaits(ls.cockroach(), slope_deg=40, heading=0.4)[0]
    >>> curve = ls.follow(gait, "heading", within=(0.0, 0.6))
    >>> [round(one.value, 8) for one in curve.special if one.kind == "fold"]
    [0.43820005]
    """
    route = route_for(gait, parameter)
    low, high = _range(route, within)
    most = checked_whole("most_points", most_points, 2, 1_000_000)
    target = None if to is None else checked_number("to", to, f"a number ({route.unit})")
    if target is not None and (not low <= target <= high or target == route.start):
        raise ValueError(f"to = {target:g}: must be another value than {route.start:g}, from {low:g} to {high:g}")
    if target is not None:
        low, high = (low, target) if target > route.start else (target, high)
    route = replace(route, low=low, high=high, kinks=tuple(kink for kink in route.kinks if low < kink < high))
    z = start_of(route.problem_at(route.start), gait, route)
    ways = [1.0, -1.0] if target is None else [1.0 if target > route.start else -1.0]
    # At an end of its range a curve goes one way only.
    near = 1e-12 * route.scale
    ways = [way for way in ways if (route.start < high - near if way > 0.0 else route.start > low + near)]
    tracer = Tracer(route, most)
    traces = [tracer.trace(z, way) for way in ways]
    return joined(route, gait, traces, target)


def _range(route: Route, within: Sequence[float] | None) -> tuple[float, float]:
    """Return the range that is not left, checked."""
    if within is None:
        return route.low, route.high
    if isinstance(within, str) or len(within) != 2:
        raise ValueError(f"within = {shown(within)}: must be two numbers, low and high")
    low, high = (checked_number("within", value, "two numbers, low and high") for value in within)
    if not low <= route.start <= high or low == high:
        raise ValueError(f"within = ({low:g}, {high:g}): must hold the gait's value, {route.start:g}")
    return max(low, route.low), min(high, route.high)


def start_of(problem: GaitProblem, gait: Gait, route: Route) -> Floats:
    """Return the unknowns of the gait that is followed, in the problem of its route.

    Raises
    ------
    ValueError
        If it is no solution of that.
    """
    found = gait_near(problem, problem.z_of(gait))
    if found is None or not np.allclose(problem.z_of(found), problem.z_of(gait), rtol=0.0, atol=1e-5):
        raise ValueError(f"gait: must be one that its animal has where {route.name} = {route.start:g}")
    return problem.z_of(found)


def joined(route: Route, gait: Gait, traces: Sequence[Trace], to: float | None) -> Continuation:
    """Return the curve that was traced one way, or both ways: then it begins with the end of the way back."""
    forth = traces[0]
    back = traces[1] if len(traces) > 1 and forth.stop is not Stop.CLOSED else None
    whole = forth if back is None else two_ways(back, forth)
    looked_at = [find_landmarks(one) for one in whole.stretches]
    traits, why = [one[1] for one in looked_at], [reason for one in looked_at for reason in one[2]]
    beginning, ending = None if back is None else ending_of(back, route), ending_of(forth, route, to)
    marks: list[Landmark] = []
    for (found, _, _), one in zip(looked_at, whole.stretches, strict=True):
        marks += [*found, kink_after(one)]
    marks = [mark for mark in marks[:-1] if not any(is_at_end(mark, trace) for trace in (back, forth))]
    special = [special_of(route, mark) for mark in marks]
    if back is not None and beginning is not None:
        special[:0] = end_point(route, back, beginning)
    special += end_point(route, forth, ending)
    return Continuation(
        route.name,
        route.unit,
        route.words,
        np.array([route.place(point.y) for one in whole.stretches for point in one.points]),
        np.array([one is None for one in why]),
        tuple("" if one is None else f"{one[0]}" + (f" ({one[1]})" if one[1] else "") for one in why),
        np.concatenate([one.stable for one in traits]),
        np.vstack([one.half_multipliers for one in traits]),
        tuple(special),
        ending,
        beginning,
        gait,
        route,
        tuple((one, point) for one in whole.stretches for point in one.points),
    )


def is_at_end(mark: Landmark, trace: Trace | None) -> bool:
    """Whether a special point, of what legs do, is a matter of the end of a curve that goes no further."""
    if trace is None or trace.stop is not Stop.LOST or mark.kind is Kind.FOLD:
        return False
    return bool(np.linalg.norm(mark.stretch.way(mark.point.y, trace.stretches[-1].points[-1].y)) < NEAR_END)


def end_point(route: Route, trace: Trace, ending: Ending) -> list[Special]:
    """Return the end of a curve as a special point, if it is one."""
    if ending.reason not in AT_END:
        return []
    stretch = trace.stretches[-1]
    mark = Landmark(AT_END[ending.reason], ending.leg, str(ending.reason), stretch.points[-1], stretch, 0)
    return [special_of(route, mark)]


def special_of(route: Route, mark: Landmark) -> Special:
    """Return a special point as users see it."""
    value = route.place(mark.point.y)
    return Special(mark.kind, value, mark.leg, mark.words, route, mark.stretch, mark.point)


def two_ways(back: Trace, forth: Trace) -> Trace:
    """Return one curve of two that begin at one point: the first one backwards, then the other."""
    turned = [
        Stretch(one.route, one.region, [p._replace(tangent=-p.tangent) for p in reversed(one.points)], one.known)
        for one in reversed(back.stretches)
    ]
    ahead = list(forth.stretches)
    if turned[-1].region == ahead[0].region:
        first = ahead.pop(0)
        last = turned.pop()
        both = Stretch(first.route, first.region, [*last.points[:-1], *first.points], last.known | first.known)
        turned.append(both)
    return Trace([*turned, *ahead], forth.stop, forth.words)
