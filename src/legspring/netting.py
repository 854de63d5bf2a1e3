"""Gaits on a grid by following: from those that are known along all lines of the grid, and to other families.

A curve is followed along one line of the grid, past folds, and met wherever it passes a place of the grid; from there
it goes on across. So one gait leads to all that hang together with it, and what hangs together without a fold in
between is one sheet of gaits.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from legspring.branching import other_families
from legspring.continuation import Special
from legspring.curve import Stop, Trace, Tracer
from legspring.footing import Reason, ending_of
from legspring.gait import Gait
from legspring.kernel.walker import Floats
from legspring.landmarks import Kind
from legspring.measures.sensitivity import scale_of, value_of
from legspring.problem import GaitProblem
from legspring.route import Route, kinks_of, with_value
from legspring.solve import is_among
from legspring.stretch import Point, Stretch, at_place, at_zero, turns_back

Place = tuple[int, ...]
Group = tuple[str, object, bool]
"""A family, the legs down as a step begins, and whether steps mirror one another."""
MOST_POINTS = 1000
SHORTEST, LONGEST = 1e-6, 0.2
"""Step at which a curve has come to its end, and the longest one: what lies in between is not looked at."""
MET = 1e-2
"""Distance of ends of curves, by the scale, that are the same."""


@dataclass
class Knot:
    """A solution at a place of the grid: which it is there, of which group, and along which axes it was followed."""

    place: Place
    group: Group
    z: Floats
    sheet: int
    done: set[int] = field(default_factory=set)


@dataclass
class Net:
    """All solutions on a grid that hang together with some that are known.

    Attributes
    ----------
    axes
        What the grid is over, with its values, rising.
    problems
        Of each group, the problem at each place.
    """

    axes: Mapping[str, tuple[float, ...]]
    problems: Mapping[Group, Mapping[Place, GaitProblem]]
    knots: list[Knot] = field(default_factory=list)
    looks: int = 0
    _at: dict[tuple[Group, Place], list[Knot]] = field(default_factory=dict)
    _routes: dict[tuple[Group, int, Place], Route] = field(default_factory=dict)
    _ends: set[tuple[object, ...]] = field(default_factory=set)
    _joined: list[int] = field(default_factory=list)

    def add(self, group: Group, place: Place, z: Floats) -> Knot:
        """Return the knot of a solution, which is a new one unless it is known."""
        problem, there = self.problems[group][place], self._at.setdefault((group, place), [])
        for knot in there:
            if is_among(problem, z, knot.z[None]):
                return knot
        knot = Knot(place, group, problem.wrapped(z), len(self._joined))
        self._joined.append(len(self._joined))
        there.append(knot)
        self.knots.append(knot)
        return knot

    def zeros(self, group: Group, place: Place) -> Floats:
        """Return the solutions at a place, ``(n, size)``."""
        some = [knot.z for knot in self._at.get((group, place), [])]
        return np.array(some) if some else np.zeros((0, self.problems[group][place].size))

    def sheet(self, number: int) -> int:
        """Return the number of the sheet that a knot's belongs to."""
        while self._joined[number] != number:
            number = self._joined[number]
        return number

    def sheet_of(self, gait: Gait, place: Place) -> int | None:
        """Return the number of the sheet of a gait at a place; None if it was not met."""
        group = (gait.family, gait.contacts, gait.symmetric)
        for knot in self._at.get((group, place), []):
            problem = self.problems[group][place]
            if is_among(problem, problem.z_of(gait), knot.z[None]):
                return self.sheet(knot.sheet)
        return None

    def spread(self) -> None:
        """Follow all that is known along all lines of the grid, until nothing new turns up."""
        for knot in self.knots:
            for axis in range(len(self.axes)):
                if axis not in knot.done:
                    self._follow(knot, axis)

    def _follow(self, knot: Knot, axis: int) -> None:
        """Follow a knot along a line of the grid, both ways."""
        knot.done.add(axis)
        name = list(self.axes)[axis]
        route = replace(self._route(knot.group, axis, knot.place), start=self.axes[name][knot.place[axis]])
        for way, end in ((1.0, route.high), (-1.0, route.low)):
            if way * (end - route.start) > 0.0:
                self._trace(route, axis, knot.place, knot.group, knot.z, way, knot)

    def _trace(
        self, route: Route, axis: int, place: Place, group: Group, z: Floats, way: float, knot: Knot | None
    ) -> None:
        """Trace a curve one way, meet what it passes, and go on with other families where it ends."""
        tracer = Tracer(route, MOST_POINTS)
        tracer.shortest, tracer.longest = SHORTEST, LONGEST
        try:
            trace = tracer.trace(z, way)
        except ValueError:
            return
        self.looks += sum(one.looks for one in trace.stretches)
        for stretch in trace.stretches:
            knot = self._meet(stretch, axis, place, group, knot)
        if trace.stop is Stop.LOST:
            self._change(trace, route, axis, place, group)

    def _meet(self, stretch: Stretch, axis: int, place: Place, group: Group, knot: Knot | None) -> Knot | None:
        """Note where a stretch passes places of the grid; return the last one, unless a fold came after it."""
        values = np.array(list(self.axes.values())[axis])
        for first, second in pairwise(stretch.points):
            fold = None
            if turns_back(first, second):
                fold = at_zero(stretch, first, second, lambda point: float(point.tangent[-1]), 1e-9)
            parts = [(first, second)] if fold is None else [(first, fold), (fold, second)]
            for number, (one, two) in enumerate(parts):
                knot = None if number else knot
                ends = sorted((float(one.y[-1]), float(two.y[-1])))
                inside = (values / stretch.route.scale >= ends[0]) & (values / stretch.route.scale <= ends[1])
                rising = one.y[-1] < two.y[-1]
                for index in np.flatnonzero(inside)[:: 1 if rising else -1].tolist():
                    bound = float(values[index]) / stretch.route.scale
                    if one.y[-1] == bound:
                        continue
                    point = at_place(stretch, one, two, bound)
                    if point is not None:
                        knot = self._note(point, axis, (*place[:axis], index, *place[axis + 1 :]), group, knot)
        return knot

    def _note(self, point: Point, axis: int, place: Place, group: Group, before: Knot | None) -> Knot:
        """Note a solution that a curve meets, of the sheet of the one before."""
        knot = self.add(group, place, point.y[:-1])
        knot.done.add(axis)
        if before is not None:
            one, other = self.sheet(before.sheet), self.sheet(knot.sheet)
            self._joined[max(one, other)] = min(one, other)
        return knot

    def _change(self, trace: Trace, route: Route, axis: int, place: Place, group: Group) -> None:
        """Go on with the family in which a leg does the opposite, where it does nothing."""
        ending = ending_of(trace, route)
        if ending.reason not in (Reason.WINDOW, Reason.WRONG_START):
            return
        stretch = trace.stretches[-1]
        last = stretch.points[-1]
        key = (axis, place[:axis], place[axis + 1 :], ending.leg, round(ending.value / route.scale / MET))
        if (key, group) in self._ends:
            return
        self._ends.add((key, group))
        special = Special(Kind.WINDOW, ending.value, ending.leg, "", 0, route, stretch, last)
        for gait in other_families(special, [label for label, *_ in self.problems]):
            other = (gait.family, group[1], group[2])
            if other in self.problems:
                self._enter(gait, route, axis, place, other)

    def _enter(self, gait: Gait, route: Route, axis: int, place: Place, group: Group) -> None:
        """Follow a gait that is at no place of the grid."""
        there = self._route(group, axis, place)
        value = value_of(gait, route.name)
        start = replace(there, start=value)
        z = start.problem_at(value).z_of(gait)
        for way, end in ((1.0, start.high), (-1.0, start.low)):
            if way * (end - value) > 0.0:
                self._trace(start, axis, place, group, z, way, None)

    def _route(self, group: Group, axis: int, place: Place) -> Route:
        """Return the line of the grid through a place, along an axis."""
        line = (*place[:axis], 0, *place[axis + 1 :])
        if (group, axis, line) not in self._routes:
            name, values = list(self.axes.items())[axis]
            problem = self.problems[group][line]
            low, high = values[0], values[-1]
            kinks = tuple(one for one in kinks_of(problem.system, name) if low < one < high)
            scale = scale_of(problem.system, name, max(map(abs, values)))
            self._routes[group, axis, line] = Route(
                name, "", "", low, scale, low, high, kinks, lambda value: with_value(problem, name, value), anchor=low
            )
        return self._routes[group, axis, line]
