"""Following a gait while something varies: `legspring.follow`."""

from collections.abc import Sequence
from functools import partial

import numpy as np

from legspring.charts import Shelf, curve_from, request_as_json
from legspring.checks import checked_number, checked_positive, checked_whole, shown
from legspring.continuation import Continuation, Request, described, joined
from legspring.curve import LONGEST_STEP, Tracer
from legspring.files import PathLike
from legspring.gait import Gait
from legspring.kernel.walker import Floats
from legspring.measures.sensitivity import value_of
from legspring.problem import GaitProblem
from legspring.progress import progress_bar
from legspring.route import Route, Subject
from legspring.solve import gait_near, same_gait
from legspring.stretch import Stretch

MOST_POINTS, MOST_CURVES = 2000, 30


def follow(
    gait: Gait,
    parameter: Subject,
    *,
    to: float | None = None,
    within: Sequence[float] | None = None,
    most_points: int = MOST_POINTS,
    longest_step: float = LONGEST_STEP,
    store: PathLike | None = None,
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
    longest_step
        Of the curve, in units of its unknowns (speed in units of the desired one, rad) and of the parameter's scale.
    store
        File, .nc, in which the curve is kept while it is followed, and at the end: a run that was stopped goes on
        from there, and one that was finished is read.

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
    most = checked_whole("most_points", most_points, 2, 1_000_000)
    longest = checked_positive("longest_step", longest_step)
    target = None if to is None else checked_number("to", to, "a number")
    request = Request(gait, parameter, target, None if within is None else _limits(within), most, longest)
    route = request.route
    shelf = Shelf(store, request_as_json(request), partial(Stretch, route))
    finished, kept = shelf.begin()
    if finished is not None:
        return curve_from(finished, str(store))
    z = start_of(route.problem_at(route.start), route.gait or gait, route)
    traces = shelf.traced(request.ways, lambda: Tracer(route, most, note=shelf.note, longest=longest), z, kept)
    curve = described(request, *joined(route, traces, target))
    if store is not None:
        curve.save(store)
    return curve


def _limits(within: Sequence[float]) -> tuple[float, float]:
    """Return a range, checked."""
    if isinstance(within, str) or len(within) != 2:
        raise ValueError(f"within = {shown(within)}: must be two numbers, low and high")
    low, high = (checked_number("within", value, "two numbers, low and high") for value in within)
    if not low < high:
        raise ValueError(f"within = ({low:g}, {high:g}): must be two numbers, low and high")
    return low, high


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


def follow_connected(curve: Continuation, *, most: int = MOST_CURVES, progress: bool = False) -> list[Continuation]:
    """Follow what branches off a curve, and off that in turn: other families, and gaits of another symmetry or period.

    Parameters
    ----------
    curve
        A curve along one parameter.
    most
        Most curves.
    progress
        Whether to show a progress bar.

    Returns
    -------
    list of Continuation
        The other curves, within the same limits.

    Raises
    ------
    ValueError
        For a curve along several parameters at once, whose places on other curves have no names.
    """
    request = curve.request
    if not isinstance(request.parameter, str):
        raise ValueError("curve: must be along one parameter for what branches off to be followed")
    limits, found, waiting = (request.route.low, request.route.high), [curve], list(curve.special)
    with progress_bar("following", most, show=progress) as tick:
        while waiting and len(found) <= most:
            special = waiting.pop(0)
            for gait in special.switch():
                if len(found) > most or any(holds(one, gait) for one in found):
                    continue
                try:
                    other = follow(
                        gait, request.parameter, within=limits, most_points=request.most, longest_step=request.longest
                    )
                except ValueError:
                    # What branches off at the very end of a range has nowhere to go.
                    continue
                found.append(other)
                waiting += other.special
                tick(1)
    return found[1:]


def holds(curve: Continuation, gait: Gait) -> bool:
    """Whether a gait is one of a curve's."""
    if (gait.family, gait.strides, gait.symmetric) != (curve.gait.family, curve.gait.strides, curve.gait.symmetric):
        return False
    return any(same_gait(one, gait) for one in curve.at(value_of(gait, curve.parameter)))
