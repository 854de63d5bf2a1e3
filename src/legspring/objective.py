"""What an actuation is to minimise: the thesis's penalised objective (section 3.5, Table 3.1)."""

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from legspring.gait import Gait
from legspring.kernel.measure import stretch_rates
from legspring.kernel.walker import LIFTOFF, Floats
from legspring.model import Animal
from legspring.setting import checked_vector
from legspring.solve import Problem

Goal = Literal["stability", "efficiency"]
Map = Literal["complete", "reduced"]

LEAST, MOST = 0.2, 0.9
"""Range of the actuation, in units of the nominal length."""
LATEST, EARLIEST, PHASE_UNIT = math.pi / 3, -math.pi / 2, math.pi / 6
"""Range of the phases, and what a penalty counts their excess in, rad."""
SMALLEST_ANGLE = 10.0
"""Angle between the curves of a leg's length and its force-free length against time, deg with rates in m/s."""


class Constraint(StrEnum):
    """Constraints of Table 3.1."""

    FIXED_POINT = "there is a gait"
    FIXED_POINT_BESIDE = "there is a fixed point at a slightly larger heading"
    PHASE_LATEST = "the phase is at most 60 deg"
    PHASE_EARLIEST = "the phase is at least -90 deg"
    ANGLE_TOUCHDOWN = "length and force-free length part clearly at touch-down"
    ANGLE_LIFTOFF = "length and force-free length meet clearly at lift-off"
    ACTUATION_LEAST = "the actuation is at least 0.2 l0"
    ACTUATION_MOST = "the actuation is at most 0.9 l0"


@dataclass(frozen=True)
class Penalty:
    """What a constraint that is not kept adds to the objective; ``pair`` is empty where it concerns no single pair."""

    constraint: Constraint
    pair: str
    amount: float


@dataclass(frozen=True)
class Score:
    """Value of the objective for one actuation.

    Attributes
    ----------
    actuation
        Magnitudes for each pair of legs, m.
    gait
        The gait, None if there is none.
    value
        Eigenvalue magnitude or transport cost; 0 where there is no gait.
    penalties
        For the constraints that are not kept.
    """

    actuation: tuple[float, ...]
    gait: Gait | None
    value: float
    penalties: tuple[Penalty, ...]

    @property
    def total(self) -> float:
        """The penalised objective."""
        return self.value + sum(penalty.amount for penalty in self.penalties)


def missing_fixed_point(squares: float) -> float:
    """Say how far a search has stayed from a fixed point, by its sum of squared residuals: from 0 up."""
    return max(10.0 + math.log10(squares), 0.0) if squares > 0.0 else 0.0


class Objective:
    """The penalised objective of one family at one slope and heading, as a function of the actuation.

    Every evaluation starts its search for the gait from that of the best one so far.

    Parameters
    ----------
    gait
        Where to start from: its animal, slope, heading and family are those to be optimised.
    goal
        ``"stability"``: the largest eigenvalue magnitude; ``"efficiency"``: the transport cost.
    of
        The map whose eigenvalues count: of a stride of the complete map, or the thesis's reduced map.
    """

    def __init__(self, gait: Gait, goal: Goal, of: Map = "complete") -> None:
        if goal not in ("stability", "efficiency"):
            raise ValueError(f"goal = {goal!r}: must be 'stability' or 'efficiency'")
        if of not in ("complete", "reduced"):
            raise ValueError(f"of = {of!r}: must be 'complete' or 'reduced'")
        self.goal, self.of = goal, of
        self.evaluations = 0
        self._near = gait
        self.best = self(gait.actuation)

    def __call__(self, actuation: ArrayLike) -> Score:
        """Evaluate the objective for some magnitudes, m, of which there is one for each pair of legs."""
        self.evaluations += 1
        animal = self._near.animal
        magnitudes = checked_vector("actuation", actuation, len(animal.pairs))
        lengths = pair_lengths(animal)
        penalties = bound_penalties(animal, magnitudes)
        gait = None
        if np.all((magnitudes >= 0.0) & (magnitudes < lengths)):
            gait, squares = self._gait(magnitudes)
        else:
            squares = 1.0
        if gait is None:
            penalties.append(Penalty(Constraint.FIXED_POINT, "", 2.0 + 2.0 * missing_fixed_point(squares)))
            return Score(tuple(map(float, magnitudes)), None, 0.0, tuple(penalties))
        penalties += self._beside(gait) + phase_penalties(gait) + angle_penalties(gait)
        score = Score(gait.actuation, gait, self.measure(gait), tuple(penalties))
        if self.evaluations == 1 or score.total < self.best.total:
            self.best, self._near = score, gait
        return score

    def measure(self, gait: Gait) -> float:
        """Return what is to be small, without penalties."""
        if self.goal == "efficiency":
            return gait.transport_cost
        return gait.reduced_eigenvalue if self.of == "reduced" else float(abs(gait.multipliers[0]))

    def _problem(self, magnitudes: Floats | tuple[float, ...], heading: float) -> Problem:
        near = self._near
        return Problem(near.animal, near.slope, heading, near.family, magnitudes)

    def _gait(self, magnitudes: Floats) -> tuple[Gait | None, float]:
        """Solve for the gait near the best one; return it if it is valid, and the sum of squared residuals."""
        problem = self._problem(magnitudes, self._near.heading)
        gait, squares = problem.gait_near(problem.unknowns(self._near))
        return (gait if gait is not None and gait.invalid() is None else None), squares

    def _beside(self, gait: Gait) -> list[Penalty]:
        """Penalise a gait that would not survive a slightly larger heading."""
        heading = 1.05 * gait.heading if abs(gait.heading) >= 0.05 else gait.heading + 0.0025
        problem = self._problem(gait.actuation, heading)
        beside, squares = problem.gait_near(problem.unknowns(gait))
        if beside is not None:
            return []
        return [Penalty(Constraint.FIXED_POINT_BESIDE, "", 0.5 + 0.5 * missing_fixed_point(squares))]


def pair_lengths(animal: Animal) -> Floats:
    """Nominal length of each pair of legs, m."""
    return np.array([next(leg.length for leg in animal.legs if leg.pair == pair) for pair in animal.pairs])


def bound_penalties(animal: Animal, magnitudes: Floats) -> list[Penalty]:
    """Penalise an actuation out of its range."""
    penalties = []
    for pair, length, magnitude in zip(animal.pairs, pair_lengths(animal), magnitudes, strict=True):
        if magnitude < LEAST * length:
            amount = 30.0 + (LEAST * length - magnitude) / (LEAST * length)
            penalties.append(Penalty(Constraint.ACTUATION_LEAST, pair, float(amount)))
        if magnitude > MOST * length:
            amount = 30.0 + (magnitude - MOST * length) / ((1.0 - MOST) * length)
            penalties.append(Penalty(Constraint.ACTUATION_MOST, pair, float(amount)))
    return penalties


def phase_penalties(gait: Gait) -> list[Penalty]:
    """Penalise phases out of their range: late ones softly."""
    penalties = []
    for pair, phase in zip(gait.animal.pairs, gait.phase, strict=True):
        if phase > LATEST:
            penalties.append(Penalty(Constraint.PHASE_LATEST, pair, 0.5 * (phase - LATEST) / PHASE_UNIT))
        if phase < EARLIEST:
            penalties.append(Penalty(Constraint.PHASE_EARLIEST, pair, 0.5 + 0.5 * (EARLIEST - phase) / PHASE_UNIT))
    return penalties


def angle_penalties(gait: Gait) -> list[Penalty]:
    """Penalise, softly, legs whose length hardly parts from its force-free length at touch-down or lift-off."""
    penalties = []
    ends = (Constraint.ANGLE_TOUCHDOWN, Constraint.ANGLE_LIFTOFF)
    for pair, leg in zip(gait.animal.pairs, gait.first_legs, strict=True):
        for constraint, angle in zip(ends, crossing_angles(gait, leg), strict=True):
            if angle < SMALLEST_ANGLE:
                penalties.append(Penalty(constraint, pair, 0.05 * (SMALLEST_ANGLE - angle)))
    return penalties


def crossing_angles(gait: Gait, leg: int) -> tuple[float, float]:
    """Angle (deg, rates in m/s) between length and force-free length against time, at touch-down and at lift-off."""
    tape = gait.tape
    rows = tape.events[: int(tape.counts[1])]
    lifts = rows[(rows[:, 1] == leg) & (rows[:, 2] == LIFTOFF) & (rows[:, 0] > 0.0)]
    angles = []
    for step, end in ((0, 0.0), (int(lifts[0, 3]) - 1, 1.0)):
        length, free = stretch_rates(tape, step, end, leg)
        rate = 1.0 / gait.setting.step_duration
        angles.append(math.degrees(abs(math.atan(length * rate) - math.atan(free * rate))))
    return angles[0], angles[1]
