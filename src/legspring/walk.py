"""Following a gait while its animal changes, little by little, into another one."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from legspring.gait import Gait, Invalid
from legspring.kernel.walker import Floats
from legspring.model import Animal, ModelError
from legspring.returnmap import IntegrationError
from legspring.setting import checked_positive
from legspring.solve import SAME, Problem

Path = Callable[[float], Animal]
"""Animals from s = 0 to s = 1."""

FIRST_STEP, LONGEST_STEP, SHORTEST_STEP = 0.05, 0.2, 1e-5
"""Sizes of steps along the path."""
AWAY = 0.1
"""Largest distance of a solution from where it is expected (speed in units of v_des, phases and yaw in rad)."""
LEAP = 0.1
"""Change of a lift-off in a shortest step, in step durations, that is a jump."""
EASY = 0.02
"""Distance below which the next step is longer."""
AHEAD = 10.0
"""A fold that is no further ahead, in shortest steps, is what ended a walk."""


class Loss(StrEnum):
    """Why a solution could not be followed to the end of the path; `Invalid` says why one is no gait any more."""

    FOLD = "two solutions meet there, and beyond there is none (a fold)"
    JUMP = "the lift-off of a leg jumps there, as where its force begins with the wrong sign"
    LOST = "the solution cannot be followed, for another reason than a fold or a jump"
    NO_ANIMAL = "there is no such animal"


@dataclass(frozen=True)
class Walk:
    """What became of a gait along a path.

    Attributes
    ----------
    places, gaits
        Where on the path, from 0 up, and the gait there.
    loss
        Why the walk ended before the end of the path; None if it did not.
    detail
        What else there is to say about it, such as the leg that is to blame.
    """

    places: tuple[float, ...]
    gaits: tuple[Gait, ...]
    loss: Loss | Invalid | None = None
    detail: str = ""

    @property
    def end(self) -> Gait | None:
        """The gait at the end of the path, if it got there."""
        return None if self.loss else self.gaits[-1]

    def __str__(self) -> str:
        """One line."""
        if self.loss is None:
            return f"arrived in {len(self.gaits) - 1} steps"
        return f"ended at s = {self.places[-1]:.4f}: {self.loss}" + (f" ({self.detail})" if self.detail else "")


def walk(gait: Gait, path: Path, *, step: float = FIRST_STEP) -> Walk:
    """Follow a gait along a path of animals, with steps that adapt, for as long as it exists and is valid.

    Slope, heading and family stay. Where it ends, the step before the end is as short as 1e-5 of the path.

    Parameters
    ----------
    gait
        A gait of ``path(0)``.
    path
        From s in [0, 1] to an animal, with its actuation, continuous in s. The yaw may be held at the start and free
        later if the inertia comes from infinity there.
    step
        Size of the first step.

    Raises
    ------
    ValueError
        If ``path(0)`` does not have this gait.
    """
    step = min(checked_positive("step", step), 1.0)
    places, gaits = [0.0], [_first(gait, path)]
    while places[-1] < 1.0:
        place = min(places[-1] + step, 1.0)
        found = _next(places, gaits, path, place)
        if isinstance(found, tuple):
            if step <= SHORTEST_STEP:
                return Walk(tuple(places), tuple(gaits), *found)
            step = max(0.5 * min(step, place - places[-1]), SHORTEST_STEP)
            continue
        gait, distance = found.gait, found.distance
        places.append(place)
        gaits.append(gait)
        step = min(2.0 * step, LONGEST_STEP) if distance < EASY else step
    return Walk(tuple(places), tuple(gaits))


@dataclass(frozen=True)
class _Found:
    """A gait and its distance from where it was expected."""

    gait: Gait
    distance: float


def _first(gait: Gait, path: Path) -> Gait:
    problem = Problem(path(0.0), gait.slope, gait.heading, gait.family)
    near = problem.unknowns(gait)
    same, _ = problem.gait_near(near)
    if same is None or float(np.max(np.abs(problem.wrapped(problem.unknowns(same) - near)))) > SAME:
        raise ValueError(f"path(0) = {path(0.0).name!r}: must be an animal that has the gait to be followed")
    return same


def _next(places: list[float], gaits: list[Gait], path: Path, place: float) -> _Found | tuple[Loss | Invalid, str]:
    """Look for the gait at the next place, or say why there is none."""
    last = gaits[-1]
    try:
        problem = Problem(path(place), last.slope, last.heading, last.family)
    except ModelError as error:
        return Loss.NO_ANIMAL, str(error)
    expected = _expected(problem, places, gaits, place)
    gait, _ = problem.gait_near(expected)
    distance = math.inf if gait is None else _distance(problem, gait, expected)
    if gait is None or distance > AWAY:
        return _why_lost(problem, places, gaits, expected)
    if (reason := gait.invalid()) is not None:
        return reason
    return _Found(gait, distance)


def _expected(problem: Problem, places: list[float], gaits: list[Gait], place: float) -> Floats:
    """Continue the straight line through the last two gaits."""
    last = problem.unknowns(gaits[-1])
    if len(gaits) == 1:
        return last
    share = (place - places[-1]) / (places[-1] - places[-2])
    return last + share * problem.wrapped(last - problem.unknowns(gaits[-2]))


def _distance(problem: Problem, gait: Gait, expected: Floats) -> float:
    return float(np.max(np.abs(problem.wrapped(problem.unknowns(gait) - expected))))


def _why_lost(problem: Problem, places: list[float], gaits: list[Gait], expected: Floats) -> tuple[Loss, str]:
    """Say why there is no solution where one is expected; what is said holds if the step was a shortest one."""
    if _fold_ahead(places, gaits):
        return Loss.FOLD, ""
    try:
        leap = np.nan_to_num(np.abs(problem.candidate(expected).liftoff - gaits[-1].liftoff), nan=math.inf)
    except IntegrationError as error:
        return Loss.LOST, str(error)
    if np.max(leap) < LEAP:
        return Loss.LOST, ""
    return Loss.JUMP, gaits[-1].animal.legs[gaits[-1].first_legs[int(np.argmax(leap))]].name


def _fold_ahead(places: list[float], gaits: list[Gait]) -> bool:
    """Whether the conditions become singular a hair ahead.

    Near a fold their determinant goes to zero like the square root of the distance.
    """
    if len(gaits) < 2:
        return False
    try:
        before, now = (_determinant(gait) ** 2 for gait in gaits[-2:])
    except IntegrationError:
        return False
    return 0.0 < now * (places[-1] - places[-2]) < AHEAD * SHORTEST_STEP * (before - now)


def _determinant(gait: Gait) -> float:
    problem = Problem(gait.animal, gait.slope, gait.heading, gait.family, gait.actuation)
    return float(np.linalg.det(problem.conditions(problem.unknowns(gait))[1]))


def straight(first: Animal, last: Animal) -> Path:
    """Return the straight path from one animal to another: hips, nominal feet, stiffness, actuation and 1/inertia.

    A body whose yaw is held is one of infinite inertia. The feet are those of legs of nominal length at their angle.

    Raises
    ------
    ValueError
        If the animals differ in anything else but their names.
    """
    own = {"name", "source", "body", "legs"}
    fixed = [name for name in Animal.model_fields if name not in own and getattr(first, name) != getattr(last, name)]
    fixed += ["mass"] if first.body.mass != last.body.mass else []
    fixed += ["legs"] if _names(first) != _names(last) else []
    if fixed:
        raise ValueError(f"{first.name!r} and {last.name!r} differ in {', '.join(fixed)}: must be alike in it")
    start, end = _geometry(first), _geometry(last)

    def animal(s: float) -> Animal:
        if s in (0.0, 1.0):
            return last if s else first
        between = {name: (1.0 - s) * start[name] + s * end[name] for name in start}
        reach = between["foot"] - between["hip"]
        yields = (1.0 - s) * _yielding(first) + s * _yielding(last)
        return last.replace(
            yaw="free" if yields else "held",
            inertia=1.0 / yields if yields else last.body.inertia,
            hip=between["hip"].tolist(),
            length=np.hypot(*reach.T).tolist(),
            angle=np.arctan2(-reach[:, 0], reach[:, 1]).tolist(),
            stiffness=between["stiffness"].tolist(),
            actuation=between["actuation"].tolist(),
        )

    return animal


def _names(animal: Animal) -> list[tuple[str, str, float]]:
    return [(leg.name, leg.pair, leg.offset) for leg in animal.legs]


def _yielding(animal: Animal) -> float:
    """1/inertia, 1/(kg m^2); 0 where the yaw is held."""
    inertia = animal.body.inertia
    return 1.0 / inertia if animal.body.yaw == "free" and inertia else 0.0


def _geometry(animal: Animal) -> dict[str, Floats]:
    """Of the first leg of each pair: hip, nominal foot (``(P, 2)``, m), stiffness and actuation."""
    legs = [min((leg for leg in animal.legs if leg.pair == pair), key=lambda leg: leg.offset) for pair in animal.pairs]
    foot = [
        (leg.hip[0] - leg.length * math.sin(leg.angle), leg.hip[1] + leg.length * math.cos(leg.angle)) for leg in legs
    ]
    return {
        "hip": np.array([leg.hip for leg in legs]),
        "foot": np.array(foot),
        "stiffness": np.array([leg.stiffness for leg in legs]),
        "actuation": np.array([leg.actuation for leg in legs]),
    }
