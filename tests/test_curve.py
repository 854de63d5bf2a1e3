"""Curves as such: of maps that are no gaits, of which everything is known."""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from legspring.curve import Stop, Tracer
from legspring.kernel.walker import Floats
from legspring.landmarks import Kind, Landmark, Trivial, find_crossings
from legspring.route import Route
from legspring.stretch import Look, Stretch


def route(start: float, low: float, high: float) -> Route:
    def nothing(_: float) -> Any:
        raise AssertionError

    return Route("r", "1", "parameter", start, 1.0, low, high, (), nothing)


@dataclass
class OfMap(Stretch):
    """A curve of fixed points of a textbook map."""

    def look(self, y: Floats) -> Look | None:
        value, by = self.image(y[:-1], float(y[-1]))
        size = len(value)
        return Look(value - y[:-1], by - np.eye(size, size + 1), by[:, :size])

    def image(self, x: Floats, r: float) -> tuple[Floats, Floats]:
        raise NotImplementedError

    def inside(self, y: Floats) -> bool:
        return True

    def way(self, start: Floats, end: Floats) -> Floats:
        return end - start


class Delayed(OfMap):
    """The delayed logistic map (Maynard Smith 1968): Neimark-Sacker at r = 2, where x = 1/2."""

    def image(self, x: Floats, r: float) -> tuple[Floats, Floats]:
        return np.array([r * x[0] * (1.0 - x[1]), x[0]]), np.array(
            [[r * (1.0 - x[1]), -r * x[0], x[0] * (1.0 - x[1])], [1.0, 0.0, 0.0]]
        )


class Logistic(OfMap):
    """The logistic map: the two fixed points cross at r = 1, and 1 - 1/r doubles its period at r = 3."""

    def image(self, x: Floats, r: float) -> tuple[Floats, Floats]:
        return r * x * (1.0 - x), np.array([[r * (1.0 - 2.0 * x[0]), x[0] * (1.0 - x[0])]])


class Saddle(OfMap):
    """x + r - x^2: a fold at r = 0; and period doubling of the upper one where x = 1, r = 1."""

    def image(self, x: Floats, r: float) -> tuple[Floats, Floats]:
        return x + r - x**2, np.array([[1.0 - 2.0 * x[0], 1.0]])


class Loop(OfMap):
    """Fixed points on a circle in x and r."""

    def image(self, x: Floats, r: float) -> tuple[Floats, Floats]:
        return x + 0.1 * (x**2 + r**2 - 1.0), np.array([[1.0 + 0.2 * x[0], 0.2 * r]])


def traced(kind: type[OfMap], x: list[float], start: float, low: float, high: float, way: float = 1.0) -> Any:
    tracer = Tracer(route(start, low, high), 500, kind)
    return tracer.trace(np.array(x), way)


def marks(kind: type[OfMap], x: list[float], start: float, low: float, high: float, way: float = 1.0) -> list[Landmark]:
    (stretch,) = traced(kind, x, start, low, high, way).stretches
    return list(find_crossings(stretch, Trivial(), Kind.PERIOD_DOUBLING))


def test_neimark_sacker() -> None:
    (mark,) = marks(Delayed, [1 / 3, 1 / 3], 1.5, 1.2, 2.4)
    assert mark.kind is Kind.NEIMARK_SACKER
    assert mark.point.y == pytest.approx([0.5, 0.5, 2.0], abs=1e-9)


def test_period_doubling_and_crossing() -> None:
    found = marks(Logistic, [0.5], 2.0, 0.5, 3.5)
    assert [(mark.kind, round(float(mark.point.y[-1]), 9)) for mark in found] == [(Kind.PERIOD_DOUBLING, 3.0)]
    back = marks(Logistic, [0.5], 2.0, 0.5, 3.5, way=-1.0)
    assert [(mark.kind, round(float(mark.point.y[-1]), 8)) for mark in back] == [(Kind.BRANCHING, 1.0)]


def test_a_fold_is_no_crossing() -> None:
    found = marks(Saddle, [0.5], 0.25, -1.0, 2.0, way=-1.0)
    assert [(mark.kind, round(float(mark.point.y[-1]), 9)) for mark in found] == [(Kind.FOLD, 0.0)]
    ahead = marks(Saddle, [0.5], 0.25, -1.0, 2.0)
    assert [(mark.kind, round(float(mark.point.y[-1]), 9)) for mark in ahead] == [(Kind.PERIOD_DOUBLING, 1.0)]


def test_a_closed_curve_stops_where_it_began() -> None:
    trace = traced(Loop, [1.0], 0.0, -2.0, 2.0)
    assert trace.stop is Stop.CLOSED
    (stretch,) = trace.stretches
    folds = [mark for mark in find_crossings(stretch, Trivial(), Kind.PERIOD_DOUBLING) if mark.kind is Kind.FOLD]
    assert sorted(float(mark.point.y[-1]) for mark in folds) == pytest.approx([-1.0, 1.0], abs=1e-9)
    radii = [float(np.hypot(*point.y)) for point in stretch.points]
    assert radii == pytest.approx([1.0] * len(radii), abs=1e-9)
    assert max(float(np.linalg.norm(b.y - a.y)) for a, b in pairwise(stretch.points)) < 0.2


def test_an_edge_is_reached_exactly_even_if_a_fold_is_in_the_last_step() -> None:
    for edge in (0.999, 0.99999, 1.0 - 1e-9):
        trace = traced(Loop, [0.0 + math.sqrt(1.0 - 0.5**2)], 0.5, 0.0, edge)
        assert trace.stop is Stop.EDGE
        assert float(trace.stretches[-1].points[-1].y[-1]) == edge
