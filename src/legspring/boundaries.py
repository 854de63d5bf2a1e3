"""Where gaits are born, change and die, as curves in two parameters: `legspring.boundary`.

Of two parameters one is let go, and what is special is one more condition: then the solutions are a curve again, which
the same continuation follows along the other one.
"""

import json
import math
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from legspring.boundary_charts import boundary_from
from legspring.charts import Shelf
from legspring.checks import checked_whole, shown
from legspring.continuation import Special, gait_at, two_ways
from legspring.curve import Stop, Trace, Tracer
from legspring.files import PathLike, save_netcdf
from legspring.footing import Ending, Feet, Reason, ending_of, find_idle, find_starts
from legspring.gait import Gait
from legspring.kernel.walker import Floats
from legspring.landmarks import Kind, find_crossings, in_order
from legspring.lines import ONE_SIDED, Condition, GrazingLine, Line, condition_for, is_slow, of_level
from legspring.measures.registry import BY_NAME
from legspring.measures.sensitivity import checked
from legspring.planes import Boundary, Corner, Plane, Range, swapped
from legspring.problem import TIED
from legspring.progress import progress_bar
from legspring.stretch import Point, Stretch, at_zero

MOST_POINTS = 400
LONGEST = 0.08
"""Longest step along a boundary, in units of the unknowns and of the parameters' scales."""
INSIDE, INSIDE_SLOW, NEAR = 1e-4, 8e-3, 1e-2
"""How far inside a curve its end is begun from, and where a leg has a rate of zero; how far a boundary may begin."""
CORNERS = 1e-4
"""Where events change places, derivatives have a kink, and what is made of them has a corner."""
CUSP_WORDS = "two lines of folds meet, and there are none beyond"
TURN_WORDS = "the line turns back"


def boundary(
    special: Special | Gait,
    p1: str,
    p2: str,
    *,
    level: str | None = None,
    within: Sequence[Sequence[float]] | None = None,
    most_points: int = MOST_POINTS,
    store: PathLike | None = None,
    progress: bool = False,
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
    store
        File, .nc, in which the boundary is kept while it is followed, and at the end: a run that was stopped goes on
        from there, and one that was finished is read.
    progress
        Whether to show a progress bar.

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
    gait = start_of(special) if isinstance(special, Special) else special
    for name in (p1, p2):
        checked(gait, name)
    # What laws tie others to cannot be let go.
    turned = p1 in TIED
    if p1 == p2 or (p1 in TIED and p2 in TIED):
        raise ValueError(f"p1 = {shown(p1)}, p2 = {shown(p2)}: must be two parameters, one of them tied to no other")
    plane = Plane(gait, p2, p1, ranges[::-1]) if turned else Plane(gait, p1, p2, ranges)
    leg = special.leg if isinstance(special, Special) else ""
    kind = special.kind if isinstance(special, Special) else level
    shelf = Shelf(store, json.dumps([plane.as_json(), kind, leg, most]), _lines(plane, special, level))
    finished, kept = shelf.begin()
    if finished is not None:
        return boundary_from(finished, str(store))
    found = _followed(plane, special, level, most, shelf, kept, progress)
    found = swapped(found) if turned else found
    if store is not None:
        save_netcdf(found.to_dataset().assign_attrs(request=shelf.request), store)
    return found


def start_of(special: Special) -> Gait:
    """Return the gait to begin from: that of a special point; at the end of a curve, one a little inside."""
    stretch, point = special._stretch, special._point
    if special.kind not in ONE_SIDED:
        return special.gait
    side = 1.0 if point is stretch.points[0] else -1.0
    far = side * (INSIDE_SLOW if is_slow(special) else INSIDE)
    inside = stretch.corrected(point.y + far * point.tangent, point.tangent, point.tangent)
    return special.gait if inside is None else gait_at(special._route, inside)


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


def _condition(plane: Plane, special: Special | Gait, level: str | None) -> Condition:
    """Return what is zero all along."""
    if isinstance(special, Special):
        if level is not None:
            raise ValueError(f"level = {shown(level)}: must be left out for a special point")
        return condition_for(special, plane.problem, plane.column)
    if level not in BY_NAME or BY_NAME[level].dimensions or not BY_NAME[level].unit:
        raise ValueError(f"level = {shown(level)}: must be a measure that is one number, as transport_cost")
    return of_level(level, float(BY_NAME[level].of(special)), plane.gait_of)


def _lines(plane: Plane, special: Special | Gait, level: str | None) -> Callable[[Range], Line]:
    """Return what makes a part of the boundary, in a region of the route."""
    condition = _condition(plane, special, level)
    one_sided = isinstance(special, Special) and special.kind in ONE_SIDED
    kind_of_line = GrazingLine if isinstance(special, Special) and is_slow(special) else Line

    def line(region: Range) -> Line:
        made = kind_of_line(plane.route, region, condition=condition, target=plane.target, one_sided=one_sided)
        made.is_inside = partial(plane.is_inside, made)
        return made

    return line


def _followed(
    plane: Plane,
    special: Special | Gait,
    level: str | None,
    most: int,
    shelf: Shelf,
    kept: list[Trace],
    progress: bool,
) -> Boundary:
    """Follow a boundary both ways."""
    route, own = plane.route, special.kind if isinstance(special, Special) else None
    ends, near = {1.0: route.high, -1.0: route.low}, 1e-12 * route.scale
    ways = [way for way in ends if way * (ends[way] - route.start) > near]
    with progress_bar("following", 2 * most, show=progress) as tick:

        def note(stretches: list[Stretch]) -> None:
            tick(1)
            shelf.note(stretches)

        def tracer() -> Tracer:
            made = Tracer(route, most, stretch=lambda _, region: shelf.stretch(region), note=note)
            made.longest, made.corners, made.near = LONGEST, CORNERS, NEAR
            return made

        traces = shelf.traced(ways, tracer, plane.start, kept)
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
    known = (own, Kind.FOLD, *([Kind.BRANCHING, Kind.PLUS_ONE] if own is Kind.FOLD and system.conserved else []))
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
            point.y,
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
