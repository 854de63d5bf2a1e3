"""Following a gait while its animal changes, little by little, into another one."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from legspring.asking import tuned
from legspring.checks import checked_positive
from legspring.flow import IntegrationError
from legspring.gait import Gait, Invalid
from legspring.kernel.walker import Floats
from legspring.model import Animal, ModelError
from legspring.problem import GaitProblem
from legspring.solve import SAME, gait_near

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
        found, distance, why = _look(path, place, places, gaits)
        if found and not why:
            places.append(place)
            gaits.append(found)
            step = min(2.0 * step, LONGEST_STEP) if distance < EASY else step
        elif step > SHORTEST_STEP:
            step = max(0.5 * min(step, place - places[-1]), SHORTEST_STEP)
        else:
            return Walk(tuple(places), tuple(gaits), *(why or _why_lost(path, place, places, gaits)))
    return Walk(tuple(places), tuple(gaits))


def _first(gait: Gait, path: Path) -> Gait:
    problem = _problem(path, 0.0, gait)
    same, distance = _near(problem, problem.z_of(gait))
    if same is None or distance > SAME:
        raise ValueError(f"path(0) = {path(0.0).name!r}: must be an animal that has the gait to be followed")
    return same


def _look(
    path: Path, place: float, places: list[float], gaits: list[Gait]
) -> tuple[Gait | None, float, tuple[Loss | Invalid, str] | None]:
    """Return the solution at a place where it is expected, its distance from that, and what is wrong with it."""
    try:
        problem = _problem(path, place, gaits[-1])
    except ModelError as error:
        return None, math.inf, (Loss.NO_ANIMAL, str(error))
    found, distance = _near(problem, _expected(problem, places, gaits, place))
    return found, distance, found.invalid() if found else None


def _problem(path: Path, place: float, gait: Gait) -> GaitProblem:
    return tuned(path(place), gait.slope, gait.heading, gait.family)


def _expected(problem: GaitProblem, places: list[float], gaits: list[Gait], place: float) -> Floats:
    """Continue the straight line through the last two gaits."""
    last = problem.z_of(gaits[-1])
    if len(gaits) == 1:
        return last
    share = (place - places[-1]) / (places[-1] - places[-2])
    return last + share * problem.wrapped(last - problem.z_of(gaits[-2]))


def _near(problem: GaitProblem, expected: Floats) -> tuple[Gait | None, float]:
    """Return the solution near what is expected, if there is one, and how far from it it is."""
    found = gait_near(problem, expected)
    if found is None:
        return None, math.inf
    distance = float(np.max(np.abs(problem.wrapped(problem.z_of(found) - expected))))
    return (found if distance < AWAY else None), distance


def _why_lost(path: Path, place: float, places: list[float], gaits: list[Gait]) -> tuple[Loss, str]:
    """Say why there is no solution a shortest step ahead."""
    problem = _problem(path, place, gaits[-1])
    expected = _expected(problem, places, gaits, place)
    if _fold_ahead(places, gaits):
        return Loss.FOLD, ""
    try:
        leap = np.nan_to_num(np.abs(problem.gait(expected).liftoff - gaits[-1].liftoff), nan=math.inf)
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
    problem = tuned(gait.animal, gait.slope, gait.heading, gait.family, gait.actuation)
    return float(np.linalg.det(problem.residual(problem.z_of(gait))[1][0]))


def with_hips(animal: Animal, hips: ArrayLike, **changes: Any) -> Animal:
    """Return an animal with other hips, and its nominal feet where they are: those of legs of length l0 at angle beta.

    Parameters
    ----------
    animal
        The animal.
    hips
        ``(P, 2)``: to the right and forward of the centre of mass, m, for the leg of each pair that is put down first.
    **changes
        What else is to change, as in `Animal.replace`.
    """
    places = np.array(hips, dtype=float)
    reach = _feet(animal) - places
    length, angle = np.hypot(*reach.T), np.arctan2(-reach[:, 0], reach[:, 1])
    return animal.replace(hip=places.tolist(), length=length.tolist(), angle=angle.tolist(), **changes)


def straight(first: Animal, last: Animal) -> Path:
    """Return the straight path from one animal to another: hips, stiffness, actuation and 1/inertia change.

    A body whose yaw is held is one of infinite inertia.

    Raises
    ------
    ValueError
        If the animals differ in anything else but their names.
    """
    own = {"name", "summary", "source", "body", "legs"}
    other = [name for name in Animal.model_fields if name not in own and getattr(first, name) != getattr(last, name)]
    other += ["mass"] if first.body.mass != last.body.mass else []
    other += ["legs"] if _names(first) != _names(last) else []
    other += ["feet"] if not np.allclose(_feet(first), _feet(last), rtol=0.0, atol=1e-9) else []
    if other:
        raise ValueError(f"{first.name!r} and {last.name!r} differ in {', '.join(other)}: must be alike in it")

    def animal(s: float) -> Animal:
        if s in (0.0, 1.0):
            return last if s else first
        hips, stiffness, actuation, yielding = (
            (1.0 - s) * start + s * end for start, end in zip(_varied(first), _varied(last), strict=True)
        )
        return with_hips(
            last,
            hips,
            yaw="free" if yielding else "held",
            inertia=float(1.0 / yielding) if yielding else last.body.inertia,
            stiffness=stiffness.tolist(),
            actuation=actuation.tolist(),
        )

    return animal


def _varied(animal: Animal) -> tuple[Floats, Floats, Floats, Floats]:
    """Hips, stiffness and actuation of each pair, and 1/inertia (0 where the yaw is held)."""
    body, legs = animal.body, [animal.legs[i] for i in animal.first_legs]
    yielding = 1.0 / body.inertia if body.yaw == "free" and body.inertia else 0.0
    hips, stiffness = [leg.hip for leg in legs], [leg.stiffness for leg in legs]
    return np.array(hips), np.array(stiffness), np.array(animal.actuation), np.array(yielding)


def _feet(animal: Animal) -> Floats:
    """Nominal foot of the first leg of each pair, in the body, ``(P, 2)``, m."""
    legs = [animal.legs[i] for i in animal.first_legs]
    length, angle = np.array([leg.length for leg in legs]), np.array([leg.angle for leg in legs])
    return np.array([leg.hip for leg in legs]) + np.stack([-length * np.sin(angle), length * np.cos(angle)], axis=1)


def _names(animal: Animal) -> list[tuple[str, str, float]]:
    return [(leg.name, leg.pair, leg.offset) for leg in animal.legs]
