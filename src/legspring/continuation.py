"""Curves of gaits, with all that there is to say about them."""

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from legspring.checks import shown
from legspring.curve import Stop, Trace
from legspring.files import PathLike
from legspring.footing import Ending, Reason, ending_of, find_landmarks, kink_after
from legspring.gait import Gait
from legspring.kernel.walker import Floats
from legspring.landmarks import Kind, Landmark
from legspring.measures.registry import BY_NAME
from legspring.route import Route, Subject, route_for
from legspring.solve import Origin
from legspring.stretch import Point, Stretch, at_place, at_zero

if TYPE_CHECKING:
    import xarray as xr

BESIDE, JUMP = 1e-7, 1e-4
"""How far beside a special point derivatives are compared, and the share by which they may differ."""
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
class Request:
    """What is to be followed: a gait along a parameter, to a value or within a range; most points, longest step."""

    gait: Gait
    parameter: Subject
    to: float | None
    within: tuple[float, float] | None
    most: int
    longest: float

    @cached_property
    def route(self) -> Route:
        """What varies, between the limits that are asked for.

        Raises
        ------
        ValueError
            If the gait does not depend on it, or its value is not within the limits.
        """
        route = route_for(self.gait, self.parameter)
        low, high = self.within or (route.low, route.high)
        if not low <= route.start <= high:
            raise ValueError(f"within = ({low:g}, {high:g}): must hold the gait's value, {route.start:g}")
        low, high = max(low, route.low), min(high, route.high)
        if not high - low > 1e-12 * route.scale:
            raise ValueError(
                f"parameter = {shown(self.parameter)}: must be another one, as it can only be {low:g} here"
            )
        if self.to is not None:
            if not low <= self.to <= high or self.to == route.start:
                limits = f"from {low:g} to {high:g}"
                raise ValueError(f"to = {self.to:g}: must be another value than {route.start:g}, {limits}")
            low, high = (low, self.to) if self.to > route.start else (self.to, high)
        return replace(route, low=low, high=high, kinks=tuple(kink for kink in route.kinks if low < kink < high))

    @property
    def ways(self) -> list[float]:
        """Which ways to go: towards the value asked for, or both; from an end of the range, one only."""
        route = self.route
        ways = [1.0, -1.0] if self.to is None else [1.0 if self.to > route.start else -1.0]
        near = 1e-12 * route.scale
        return [
            way for way in ways if (route.start < route.high - near if way > 0.0 else route.start > route.low + near)
        ]


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
    after
        Number of the point of the curve after which it comes.
    """

    kind: Kind
    value: float
    leg: str
    words: str
    after: int
    _route: Route = field(repr=False, compare=False)
    _stretch: Stretch = field(repr=False, compare=False)
    _point: Point = field(repr=False, compare=False)

    @cached_property
    def gait(self) -> Gait:
        """The gait there, or the solution that is none."""
        return gait_at(self._route, self._point)

    @cached_property
    def withheld(self) -> str:
        """Why there are no multipliers; empty if there are.

        Where the sequence of events is another one on the two sides, derivatives may be, too.
        """
        sides = [self._stretch.look(self._point.y + side * BESIDE * self._point.tangent) for side in (1.0, -1.0)]
        known = [one.map for one in sides if one is not None]
        if len(known) < 2:
            return "there is nothing on one side"
        jump = float(np.max(np.abs(known[0] - known[1])))
        if jump > JUMP * max(1.0, float(np.max(np.abs(self._point.look.map)))):
            return f"derivatives differ on the two sides, by up to {jump:.2g}"
        return ""

    @property
    def multipliers(self) -> NDArray[np.complex128]:
        """Multipliers of the gait; nan where they are `withheld`."""
        found = self.gait.multipliers
        return np.full_like(found, complex(np.nan, np.nan)) if self.withheld else found

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
    request: Request = field(repr=False)
    _route: Route = field(repr=False)
    points: tuple[tuple[Stretch, Point], ...] = field(repr=False)

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.values)

    def __repr__(self) -> str:
        """Say in a line which curve this is."""
        ends = f"{self.values[0]:.4g} to {self.values[-1]:.4g}"
        return f"Continuation({self.parameter!r}, {len(self)} points, {ends}, {len(self.special)} special)"

    @property
    def gait(self) -> Gait:
        """The gait that was followed."""
        return self.request.gait

    def to_dataset(self, measures: Sequence[str] = ()) -> "xr.Dataset":
        """Return the curve as a dataset.

        Parameters
        ----------
        measures
            Names of further measures of the gaits, such as ``"transport_cost"`` (see :doc:`/reference/gait`); each
            takes a few milliseconds a point.

        Returns
        -------
        xarray.Dataset
            Over ``point``: what varies, speed, heading, phases, multipliers, whether a point is a gait, and stable;
            over ``special``: the special points. Attributes say why the curve begins and ends where it does.
        """
        from legspring.charts import to_dataset

        return to_dataset(self, measures)

    def save(self, path: PathLike) -> None:
        """Save the curve as netCDF, from which `load_curve` reads it, and figures are drawn."""
        from legspring.files import check_output, save_netcdf

        check_output(path, (".nc",))
        save_netcdf(self.to_dataset(), path)

    @cached_property
    def gaits(self) -> tuple[Gait, ...]:
        """The points in the form of gaits, valid or not."""
        return tuple(gait_at(self._route, point) for _, point in self.points)

    @property
    def multipliers(self) -> NDArray[np.complex128]:
        """``(N, m)``: of a stride, without those of what is conserved."""
        mirrored = self.points[0][0].loaded(self.points[0][1].y).problem.system.mirrored
        return self.half_multipliers ** (2 if mirrored else 1)

    def at(self, value: float) -> list[Gait]:
        """Return the gaits of the curve, valid or not, where what varies has a value: one for each time it passes."""
        target, found = value / self._route.scale, []
        for (stretch, first), (other, second) in zip(self.points, self.points[1:], strict=False):
            if stretch is not other:
                continue
            for one, two in with_folds(stretch, first, second):
                if (one.y[-1] - target) * (two.y[-1] - target) < 0.0 or one.y[-1] == target:
                    point = at_place(stretch, one, two, target)
                    if point is not None:
                        found.append(gait_at(self._route, point))
        if self.values[-1] == value:
            found.append(gait_at(self._route, self.points[-1][1]))
        return found

    def where(self, measure: str, value: float) -> list[Gait]:
        """Return the gaits of the curve, valid or not, where a measure has a value: from these, boundaries go on.

        Parameters
        ----------
        measure, value
            A measure that is one number (see :doc:`/reference/gait`), as ``"max_multiplier"`` and 1.

        Raises
        ------
        ValueError
            If there is no such measure.
        """
        return _where(self, measure, value)


def _where(curve: Continuation, measure: str, value: float) -> list[Gait]:
    """Return the gaits of a curve at which a measure has a value."""
    one = BY_NAME.get(measure)
    if one is None or one.dimensions or not one.unit:
        raise ValueError(f"measure = {shown(measure)}: must be a measure that is one number, as transport_cost")
    off = [float(one.of(gait)) - value for gait in curve.gaits]
    found = []
    for n, (stretch, point) in enumerate(curve.points[:-1]):
        after = curve.points[n + 1]
        if stretch is not after[0] or not off[n] * off[n + 1] <= 0.0 or off[n + 1] == 0.0:
            continue
        there = at_zero(stretch, point, after[1], lambda other: float(one.of(gait_at(curve._route, other))) - value)
        found += [] if there is None else [gait_at(curve._route, there)]
    return found


def with_folds(stretch: Stretch, first: Point, second: Point) -> list[tuple[Point, Point]]:
    """Return the parts of a step of a curve in which the place grows, or falls, all along."""
    if first.tangent[-1] * second.tangent[-1] >= 0.0:
        return [(first, second)]
    fold = at_zero(stretch, first, second, lambda point: float(point.tangent[-1]))
    return [(first, second)] if fold is None else [(first, fold), (fold, second)]


def joined(route: Route, traces: Sequence[Trace], to: float | None) -> tuple[Trace, Ending | None, Ending]:
    """Return the curve that was traced one way, or both ways, and why it begins and ends where it does.

    One of both ways begins with the end of the way back.
    """
    forth, ending = traces[0], ending_of(traces[0], route, to)
    if len(traces) == 1 or forth.stop is Stop.CLOSED:
        return forth, None, ending
    back, beginning = traces[1], ending_of(traces[1], route, to)
    return two_ways(back, forth), beginning, ending


def described(request: Request, trace: Trace, beginning: Ending | None, ending: Ending) -> Continuation:
    """Return a curve with all that there is to say about it."""
    route = request.route
    found = [(*find_landmarks(one), one) for one in trace.stretches]
    why = [reason for _, _, reasons, _ in found for reason in reasons]
    marks = [mark for some, _, _, one in found for mark in (*some, kink_after(one))][:-1]
    first, last = trace.stretches[0].points[0], trace.stretches[-1].points[-1]
    ends = [(ending, last)] if beginning is None else [(beginning, first), (ending, last)]
    lost = [point for end, point in ends if end.reason in AT_END]
    before = np.cumsum([0, *(len(one.points) for one in trace.stretches)]).tolist()
    starts = {id(one): n for n, one in zip(before, trace.stretches, strict=False)}
    special = [
        special_of(route, mark, starts[id(mark.stretch)])
        for mark in marks
        if not any(is_at_end(mark, point) for point in lost)
    ]
    if beginning is not None:
        special[:0] = end_point(route, trace.stretches[0], first, beginning, 0)
    special += end_point(route, trace.stretches[-1], last, ending, before[-1] - 1)
    return Continuation(
        route.name,
        route.unit,
        route.words,
        np.array([route.place(point.y) for one in trace.stretches for point in one.points]),
        np.array([one is None for one in why]),
        tuple("" if one is None else f"{one[0]}" + (f" ({one[1]})" if one[1] else "") for one in why),
        np.concatenate([traits.stable for _, traits, _, _ in found]),
        np.vstack([traits.half_multipliers for _, traits, _, _ in found]),
        tuple(special),
        ending,
        beginning,
        request,
        route,
        tuple((one, point) for one in trace.stretches for point in one.points),
    )


def is_at_end(mark: Landmark, end: Point) -> bool:
    """Whether a special point is a matter of what legs do at the end of a curve that goes no further."""
    return mark.kind is not Kind.FOLD and bool(np.linalg.norm(mark.stretch.way(mark.point.y, end.y)) < NEAR_END)


def end_point(route: Route, stretch: Stretch, point: Point, ending: Ending, number: int) -> list[Special]:
    """Return the end of a curve as a special point, if it is one."""
    if ending.reason not in AT_END:
        return []
    mark = Landmark(AT_END[ending.reason], ending.leg, str(ending.reason), point, stretch, number)
    return [replace(special_of(route, mark, 0), value=ending.value)]


def special_of(route: Route, mark: Landmark, before: int) -> Special:
    """Return a special point as users see it; so many points come before its stretch."""
    value = route.place(mark.point.y)
    return Special(mark.kind, value, mark.leg, mark.words, before + mark.after, route, mark.stretch, mark.point)


def with_points(stretch: Stretch, points: list[Point]) -> Stretch:
    """Return a stretch with other points."""
    other = copy(stretch)
    other.points = points
    return other


def two_ways(back: Trace, forth: Trace) -> Trace:
    """Return one curve of two that begin at one point: the first one backwards, then the other."""
    turned = [
        with_points(one, [point._replace(tangent=-point.tangent) for point in reversed(one.points)])
        for one in reversed(back.stretches)
    ]
    ahead = list(forth.stretches)
    if turned[-1].region == ahead[0].region:
        first, last = ahead.pop(0), turned.pop()
        turned.append(with_points(first, [*last.points[:-1], *first.points]))
    return Trace([*turned, *ahead], forth.stop, forth.words)
