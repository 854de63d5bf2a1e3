"""Other curves that leave a special point of a curve of gaits."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from legspring.continuation import Special, gait_at
from legspring.gait import Gait
from legspring.kernel.events import WINDOW
from legspring.kernel.walker import Floats
from legspring.landmarks import Kind
from legspring.layout import TIGHT, System
from legspring.problem import GaitProblem
from legspring.route import Route
from legspring.solve import GOAL, gait_near, solve
from legspring.stretch import Stretch

AMOUNTS = (0.02, 0.05, 0.01, 0.1, 0.003)
"""How far from a special point other curves are looked for, in units of the unknowns."""
ASIDE = (0.0, 1e-5, 1e-4, 1e-3, 3e-3)
"""How far from the end of a curve, by the route's scale, another one is looked for."""
SHIFTS = (0.0, 0.003, 0.01, 0.03)
"""How far from its phase a leg is looked for that does the opposite, rad."""
LONGEST = 0.2
"""Longest stance of a leg that does hardly anything, in step durations."""
NEAR = 0.1
"""Largest change of an unknown, but for a phase that is turned on purpose, from one family to the other."""


def branches(special: Special) -> list[Gait]:
    """Return gaits on the curves that branch off (see `legspring.continuation.Special.switch`)."""
    if special.kind in (Kind.WINDOW, Kind.IDLE):
        return other_families(special)
    if special.kind in (Kind.PERIOD_DOUBLING, Kind.SYMMETRY_BREAKING):
        return crossing(special, doubled if special.kind is Kind.PERIOD_DOUBLING else unmirrored)[:1]
    return crossing(special, lambda problem: problem) if special.kind is Kind.BRANCHING else []


def doubled(problem: GaitProblem) -> GaitProblem:
    """Return the problem of gaits that repeat themselves after twice the time."""
    return replace(problem, system=replace(problem.system, strides=2 * problem.system.strides))


def unmirrored(problem: GaitProblem) -> GaitProblem:
    """Return the problem of gaits whose steps need not mirror one another.

    No drift in a stride would say nothing of those that do: it is the step before the start that has none.
    """
    given = dict(problem.given)
    if "lateral_drift" in given:
        given["Dx"] = float(problem.system.step_duration) * -float(given.pop("lateral_drift"))
    return replace(problem, system=replace(problem.system, symmetric=False), given=given)


def crossing(special: Special, twin: Callable[[GaitProblem], GaitProblem]) -> list[Gait]:
    """Return gaits on a curve that crosses this one in a special point, on either side.

    There the conditions have two tangents: that of the curve, and another one.
    """
    route = special._route
    other = replace(route, problem_at=lambda place: twin(route.problem_at(place)), pieces={})
    stretch = Stretch(other, special._stretch.region)
    y, beside = (seen_in(other, gait, place) for gait, place in _here_and_beside(special))
    look = stretch.look(y)
    if look is None:
        return []
    kernel = np.linalg.svd(look.by)[2][-2:]
    own = kernel @ (beside - y)
    across = np.array([-own[1], own[0]]) @ kernel / np.linalg.norm(own)
    found: list[Gait] = []
    for side in (1.0, -1.0):
        for amount in AMOUNTS:
            point = stretch.corrected(y + side * amount * across, across, side * across)
            if point is not None and np.linalg.norm(point.y - y) < 3.0 * amount:
                found.append(gait_at(other, point))
                break
    return found


def _here_and_beside(special: Special) -> list[tuple[Gait, float]]:
    """Return the gait at a special point and one a little further on, each with its place."""
    stretch, point = special._stretch, special._point
    beside = stretch.corrected(point.y + 1e-4 * point.tangent, point.tangent, point.tangent) or point
    return [(gait_at(special._route, one), special._route.place(one.y)) for one in (point, beside)]


def seen_in(route: Route, gait: Gait, place: float) -> Floats:
    """Return unknowns and place of a gait in the problem of a route, ``(n + 1,)``."""
    return np.append(route.problem_at(place).z_of(gait), place / route.scale)


def other_families(special: Special, known: Sequence[str] | None = None) -> list[Gait]:
    """Return gaits in which the leg that does nothing pulls where it pushed, or the other way round.

    Where the stance of a leg shrinks to the ignored window, its gap is zero at both ends of that. So it is for the leg
    that is actuated the other way and whose phase at the end of the window is that of this one at its beginning,
    mirrored: pi - phase - pi/50.

    Parameters
    ----------
    special
        Where a leg does nothing.
    known
        Families that count; by default all.
    """
    route, gait = special._route, special.gait
    system = gait.system
    legs = [leg.name for leg in system.animal.legs]
    if special.leg not in legs:
        return []
    pair = system.animal.pair_of[legs.index(special.leg)]
    turned = -gait.phase[pair] + math.pi - math.pi * WINDOW
    label = family_with(system, pair)
    if label is None or (known is not None and label not in known):
        return []
    if f"{system.animal.pairs[pair]}.phase" not in route.problem_at(special.value).free:
        return []
    for aside in both_ways(ASIDE):
        place = special.value + aside * route.scale
        if not route.low <= place <= route.high:
            continue
        problem = of_family(route.problem_at(place), label)
        phase = tuple(turned if n == pair else angle for n, angle in enumerate(gait.phase))
        guess = problem.z_of(replace(gait, animal=problem.system.animal, family=label, phase=phase))
        guesses = np.repeat(guess[None], 2 * len(SHIFTS) - 1, axis=0)
        guesses[:, problem.unknowns.index(f"{system.animal.pairs[pair]}.phase")] += both_ways(SHIFTS)
        found = solve(problem, guesses, TIGHT, GOAL)
        for z in found.z[found.residuals < 100.0 * GOAL]:
            one = gait_near(problem, z) if np.max(np.abs(problem.wrapped(z - guess))) < NEAR else None
            # Beyond the window its stance is another one, which has nothing to do with this.
            if one is not None and WINDOW <= one.liftoff[pair] < LONGEST:
                return [one]
    return []


def both_ways(amounts: tuple[float, ...]) -> list[float]:
    """Return amounts, the small ones first, with either sign."""
    return [side * amount for amount in amounts for side in ((1.0, -1.0) if amount else (1.0,))]


def of_family(problem: GaitProblem, label: str) -> GaitProblem:
    """Return the problem of another family, which the animal may not have a name for."""
    system = problem.system
    animal = system.animal if label in system.animal.families else system.animal.every_family()
    return replace(problem, system=replace(system, animal=animal, family=label))


def family_with(system: System, pair: int) -> str | None:
    """Return the label of the family in which one pair does the opposite; None if there is none."""
    wanted = tuple(-side if n == pair else side for n, side in enumerate(system.functions))
    for animal in (system.animal, system.animal.every_family()):
        for label in animal.families:
            if animal.functions(label) == wanted:
                return label
    return None
