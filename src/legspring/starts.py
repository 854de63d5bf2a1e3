"""Where searches for gaits start: points spread over where gaits can be, and feet that may be down there."""

from collections.abc import Callable, Sequence

import numpy as np

from legspring.flow import IntegrationError, flow, flows
from legspring.kernel.walker import OK, Floats
from legspring.layout import System
from legspring.problem import GaitProblem

ROUGH_ACCURACY = 1e-8
MOST_TRIED = 4
"""Points tried for each start."""
MOST_SETS, TRIES = 48, 24
"""Sets of feet that are looked at, where not all are; starts from each of them for others to be met."""


def spread(count: int, low: Floats, high: Floats) -> Floats:
    """Return points spread evenly over a box, the same every time: ``(count, n)``."""
    # A lattice of the golden ratio's kin (R sequence): even, and the same every time.
    root = 1.5
    for _ in range(50):
        root = (1.0 + root) ** (1.0 / (low.size + 1))
    steps = root ** -np.arange(1.0, low.size + 1)
    unit = (0.5 + np.outer(np.arange(1, count + 1), steps)) % 1.0
    return low + (high - low) * unit


def starts_for(problem: GaitProblem, count: int) -> Floats:
    """Return starting points spread evenly over where gaits can be: ``(count, size)`` or none at all.

    Of an animal whose steps end at touch-downs, those come first from which there is a step to be simulated.
    """
    box = problem.box()
    if box is None or not problem.system.event_driven:
        return np.zeros((0, problem.size)) if box is None else problem.evenly(spread(count, *box))
    points = problem.evenly(spread(MOST_TRIED * count, *box))
    usable = flows(problem.system, problem.points(points), accuracy=ROUGH_ACCURACY).status == OK
    return points[np.argsort(~usable, kind="stable")][:count]


def contacts_then(system: System, p: Floats) -> tuple[str, ...] | None:
    """Return the legs put down before that are down after a period, or their images; None if it cannot be simulated."""
    try:
        legs = flow(system, p, steps=system.period).contacts()
    except IntegrationError:
        return None
    down, animal = legs.down & ~legs.lands, system.animal
    images = animal.partners if system.mirrored else range(len(down))
    pairs = zip(animal.legs, images, strict=True)
    return tuple(leg.name for leg, image in pairs if leg.offset > 0.0 and down[image])


def contacts_met(ask: Callable[[tuple[str, ...]], GaitProblem], legs: Sequence[str]) -> list[tuple[str, ...]]:
    """Return sets of feet that are down at the ends of steps, from starts with such sets: none, one, or all, at first.

    Parameters
    ----------
    ask
        Returns the problem with some contacts, of legs that do not go by the clock.
    legs
        These.
    """
    known: list[tuple[str, ...]] = [(), *((leg,) for leg in legs), tuple(legs)]
    for some in known:
        problem = ask(some)
        by_event = {leg.name for leg in problem.system.animal.legs if leg.touchdown != "clock"}
        for p in problem.points(starts_for(problem, TRIES)):
            then = contacts_then(problem.system, p)
            met = None if then is None else tuple(name for name in then if name in by_event)
            if met is not None and met not in known and len(known) < MOST_SETS:
                known.append(met)
    return known
