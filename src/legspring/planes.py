"""Curves of special points in two parameters."""

import json
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from legspring.files import PathLike
from legspring.footing import Ending
from legspring.gait import Gait
from legspring.kept import gait_as_json, gait_from_json
from legspring.kernel.walker import Floats
from legspring.layout import unit_and_words
from legspring.lines import Target, let_go
from legspring.problem import TARGETS, GaitProblem
from legspring.route import Route, route_for, with_value
from legspring.solve import Origin
from legspring.stretch import Point, Stretch

if TYPE_CHECKING:
    import xarray as xr

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
        return replace(unchanged, problem_at=lambda place: let_go(unchanged.problem_at(place), p1), pieces={})

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
        z = self.problem.z_of(self.route.gait or self.gait)
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

    def as_json(self) -> str:
        """Return what it takes to make it anew."""
        about = {"p1": self.p1, "p2": self.p2, "ranges": self.ranges, "gait": json.loads(gait_as_json(self.gait))}
        return json.dumps(about)

    @classmethod
    def from_json(cls, text: str) -> "Plane":
        """Return the plane of which this is the JSON."""
        kept = json.loads(text)
        (a, b), (c, d) = kept["ranges"]
        return cls(gait_from_json(json.dumps(kept["gait"])), kept["p1"], kept["p2"], ((a, b), (c, d)))

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
    y
        Unknowns and place.
    gait
        The gait there, or the solution that is none.
    """

    kind: str
    values: tuple[float, float]
    leg: str
    words: str
    after: int
    y: Floats = field(repr=False, compare=False)
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

    def to_dataset(self) -> "xr.Dataset":
        """Return the boundary as a dataset: the two parameters over ``point``, and the special points."""
        from legspring.boundary_charts import boundary_dataset

        return boundary_dataset(self)

    def save(self, path: PathLike) -> None:
        """Save the boundary as netCDF, from which `load_boundary` reads it, and figures are drawn."""
        from legspring.files import check_output, save_netcdf

        check_output(path, (".nc",))
        save_netcdf(self.to_dataset(), path)

    @cached_property
    def gaits(self) -> tuple[Gait, ...]:
        """The points in the form of gaits, valid or not; each can be followed."""
        return tuple(self.plane.gait_of(line, point.y) for line, point in self.points)


def swapped(found: Boundary) -> Boundary:
    """Return a boundary with its parameters in the other order."""
    special = tuple(replace(one, values=one.values[::-1]) for one in found.special)
    names, units = found.parameters[::-1], found.units[::-1]
    return replace(found, parameters=names, units=units, values=found.values[:, ::-1].copy(), special=special)
