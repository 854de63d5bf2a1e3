"""Tracing a curve of solutions: pseudo-arclength continuation with exact derivatives.

Along a route (`legspring.route`) a problem of gaits has one unknown more than conditions: its solutions are curves. A
curve is followed along its tangent, and each point is corrected across it (`legspring.stretch`), so that folds are
nothing special. What means something along a curve is looked at afterwards (`legspring.landmarks`).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise

import numpy as np

from legspring.kernel.walker import Floats
from legspring.route import Route
from legspring.stretch import SAME_PLACE, Point, Stretch, ahead_of, at_place, at_zero, tangent_of, turns_back

FIRST_STEP, LONGEST_STEP, SHORTEST_STEP = 0.02, 0.1, 1e-10
"""Steps along a curve, in units of the unknowns (speed in units of v_des, angles in rad) and of the route's scale."""
NO_ANIMAL_STEP = 1e-3
"""Step below which a curve is left where there is no animal any more."""
STRAIGHT, CORNER = 0.95, 0.5
"""Least cosine between the tangents at two ends of a step; and of one so short that there is a corner."""
TURNED = 0.15
"""Angle between them, rad, that steps are made for."""
OFF, OFF_CORNER = 0.3, 1.5
"""Largest correction, in units of the step: what is further off is another curve; and where there is a corner."""
CLOSED = 1e-7
"""Distance from the first point at which a curve is closed."""
CROWDED = 1e-5
"""Distance from the last point of a curve within which there are no others."""


class Stop(StrEnum):
    """Why tracing stopped; what is behind it is found out afterwards."""

    EDGE = "reached the edge of the range"
    CLOSED = "came back to where it began"
    LOST = "there is no solution a hair ahead"
    NO_ANIMAL = "there is no such animal beyond"
    OUT_OF_RANGE = "speeds leave the range in which gaits are looked for"
    ENOUGH = "has as many points as were allowed"


@dataclass
class Trace:
    """A curve as it was traced: its stretches, between which the route has kinks, and why it stopped."""

    stretches: list[Stretch]
    stop: Stop
    words: str = ""


@dataclass
class Tracer:
    """Traces a curve from one of its points on.

    Attributes
    ----------
    route
        What varies.
    most
        Most points.
    stretch
        How points are found: by what a problem of gaits says, or another one.
    note
        Called with what there is of the curve after each point.
    step, longest, shortest
        Size of the next step, of the longest one, and of that below which a curve has come to its end.
    corners
        Size of a step below which a curve may have corners: curves of gaits have none but the route's kinks.
    near
        How far from where it is said to begin a curve may begin.
    """

    route: Route
    most: int
    stretch: Callable[[Route, tuple[float, float]], Stretch] = Stretch
    note: Callable[[list[Stretch]], None] = lambda _: None
    step: float = FIRST_STEP
    longest: float = LONGEST_STEP
    shortest: float = SHORTEST_STEP
    corners: float = 0.0
    near: float = SAME_PLACE

    def trace(self, z: Floats, way: float, begun: Sequence[Stretch] = ()) -> Trace:
        """Trace from unknowns at the route's start, the place growing at first (``way`` 1) or falling (-1).

        Or go on with what has begun.

        Raises
        ------
        ValueError
            If there is no solution at the start, or no animal beside it.
        """
        stretches = list(begun) or [self._first(z, way)]
        while True:
            stop, words = self._run(stretches)
            kink = self._kink(stretches[-1].points[-1]) if stop is Stop.EDGE else None
            beyond = None if kink is None else self._beyond(kink, stretches[-1].points[-1])
            if beyond is None:
                return Trace(stretches, stop if kink is None else Stop.LOST, words)
            stretches.append(beyond)
            self.step = FIRST_STEP

    def _first(self, z: Floats, way: float) -> Stretch:
        """Return a stretch with the first point."""
        y = np.append(z, self.route.start / self.route.scale)
        across = np.append(np.zeros(len(z)), way)
        stretch = self.stretch(self.route, self.route.region(self.route.start, way))
        first = stretch.corrected(y, across, across)
        if self._is_far(first, y) and (look := stretch.look(y)) is not None:
            # At a fold the place says nothing of where a point is.
            first = stretch.corrected(y, tangent_of(look.by, across), across)
        if first is None or self._is_far(first, y):
            raise ValueError(f"gait: must be one that its animal has where {self.route.name} = {self.route.start:g}")
        stretch.points.append(first)
        return stretch

    def _is_far(self, first: Point | None, y: Floats) -> bool:
        """Whether a point is not where a curve is said to begin."""
        return first is None or bool(np.max(np.abs(first.y - y)) > self.near)

    def _beyond(self, kink: float, last: Point) -> Stretch | None:
        """Return a stretch that begins at a kink where another one has ended; None if the curve does not go on."""
        ahead = math.copysign(1.0, last.tangent[-1])
        stretch = self.stretch(self.route, self.route.region(kink, ahead))
        across = np.append(np.zeros(len(last.y) - 1), ahead)
        start = stretch.corrected(last.y, across, last.tangent)
        if start is None:
            return None
        stretch.points.append(start)
        return stretch

    def _kink(self, last: Point) -> float | None:
        """Return the kink at which a stretch ends, if it does, and there is something beyond."""
        place = self.route.place(last.y)
        return place if place in self.route.kinks else None

    def _run(self, stretches: list[Stretch]) -> tuple[Stop, str]:
        """Trace through the last stretch."""
        stretch, origin = stretches[-1], stretches[0].points[0]
        failed, points, before = False, stretch.points, sum(len(one.points) for one in stretches[:-1])
        while before + len(points) < self.most:
            last = points[-1]
            if self.step < self.shortest:
                thin_out(points)
                return Stop.LOST, ""
            try:
                found = self._next(stretch, last, self.step)
            except ValueError as error:
                if self.step < NO_ANIMAL_STEP:
                    thin_out(points)
                    return Stop.NO_ANIMAL, str(error)
                found = None
            if found is None:
                self.step, failed = 0.35 * self.step, True
                continue
            end = self._crossed(stretch, last, found)
            if end is not None:
                points.append(end)
                return Stop.EDGE, ""
            if self._closes(stretch, origin, last, found):
                points.append(origin)
                return Stop.CLOSED, ""
            points.append(found)
            if not stretch.inside(found.y):
                return Stop.OUT_OF_RANGE, ""
            turned = math.acos(min(1.0, float(last.tangent @ found.tangent)))
            # What was too long once is so still: where a curve ends, no time is lost with that.
            most = 0.9 if failed else 2.0
            self.step, failed = min(self.step * min(most, max(0.5, TURNED / max(turned, 1e-3))), self.longest), False
            self.note(stretches)
        return Stop.ENOUGH, ""

    def _next(self, stretch: Stretch, last: Point, step: float) -> Point | None:
        """Return the point a step further on; None if it is not clearly of the same curve."""
        guess = ahead_of(stretch.points, step)
        found = stretch.corrected(guess, last.tangent, last.tangent)
        if found is None:
            return None
        straight, off = (STRAIGHT, OFF) if step > self.corners else (CORNER, OFF_CORNER)
        is_far = np.linalg.norm(found.y - guess) > off * step
        return None if is_far or last.tangent @ found.tangent < straight else found

    def _crossed(self, stretch: Stretch, last: Point, found: Point) -> Point | None:
        """Return the point between two at which a curve comes to an end of its region first, if it does."""
        pieces = [last, found]
        if turns_back(last, found):
            fold = at_zero(stretch, last, found, lambda point: float(point.tangent[-1]))
            pieces = [last, fold, found] if fold is not None else pieces
        for first, second in pairwise(pieces):
            ends = []
            for bound in (place / self.route.scale for place in stretch.region if math.isfinite(place)):
                # A curve that begins at an end of the region leaves it.
                crosses = (first.y[-1] - bound) * (second.y[-1] - bound) < 0.0 or second.y[-1] == bound
                if crosses and abs(first.y[-1] - bound) > 1e-12:
                    ends.append((abs(first.y[-1] - bound), bound))
            if ends:
                return at_place(stretch, first, second, min(ends)[1])
        return None

    def _closes(self, stretch: Stretch, origin: Point, last: Point, found: Point) -> bool:
        """Whether a curve comes back to its first point between two points."""
        size = float(np.linalg.norm(found.y - last.y))
        if len(stretch.points) < 3 or abs(origin.y[-1] - last.y[-1]) > 2.0 * size:
            return False
        if origin.tangent @ last.tangent < 0.5:
            return False
        way = stretch.way(last.y, origin.y)
        chord = found.y - last.y
        share = float(way @ chord) / size**2
        if not 0.0 < share <= 1.0 or np.linalg.norm(way - share * chord) > 0.1 * size:
            return False
        here = stretch.middle(last, found, share)
        if here is None:
            return False
        here = stretch.corrected(last.y + way, chord / size, last.tangent)
        return here is not None and bool(np.max(np.abs(here.y - last.y - way)) < CLOSED)


def thin_out(points: list[Point]) -> None:
    """Remove the points that crowd before the last one, where a curve could go no further."""
    last = points[-1]
    kept = [point for point in points[1:-1] if np.linalg.norm(point.y - last.y) > CROWDED]
    points[1:] = [*kept, last] if len(points) > 1 else []
