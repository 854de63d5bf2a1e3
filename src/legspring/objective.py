"""What an actuation is to minimise: the thesis's penalised objective (section 3.5, Table 3.1)."""

import math
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from legspring.checks import checked_angle, checked_choice, checked_vector
from legspring.gait import Gait
from legspring.kernel.walker import Floats
from legspring.measures.stability import largest_magnitude
from legspring.model import Animal
from legspring.solve import Problem
from legspring.trial import GOAL, Map, Trial, What

Goal = Literal["stability", "efficiency"]

LEAST, MOST = 0.2, 0.9
"""Range of the actuation, in units of the nominal length."""
LATEST, EARLIEST, PHASE_UNIT = math.pi / 3, -math.pi / 2, math.pi / 6
"""Range of the phases, and what a penalty counts their excess in, rad."""
SMALLEST_ANGLE, ANGLE_WEIGHT = 10.0, 0.05
"""Angle between the curves of a leg's length and its force-free length against time, deg with rates in m/s."""
NO_GAIT = 2.0
"""What it costs at least that there is no gait: one with a larger objective is not worth having."""
HALTS = 0.5, 0.8, 0.95, 1.0
"""Shares of the way to the heading beside at which a gait is looked for on the way."""
CLOSE = 1e-3
"""Distance from its limit, in units of l0 or rad (angles: a tenth of a degree), at which a constraint is active."""


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


class Penalty(NamedTuple):
    """What a constraint that is not kept adds to the objective; ``pair`` is empty where it concerns no single pair."""

    constraint: Constraint
    pair: str
    amount: float


class Candidate(NamedTuple):
    """What may be a gait: actuation (units of nominal lengths), unknowns, and those of the gait beside, if known."""

    actuation: Floats
    unknowns: Floats
    beside: Floats | None = None

    @property
    def point(self) -> Floats:
        """Actuation and unknowns, ``(P + n,)``."""
        return np.concatenate([self.actuation, self.unknowns])


@dataclass(frozen=True)
class Score:
    """Value of the objective for one actuation.

    Attributes
    ----------
    actuation
        In units of the legs' nominal lengths, ``(P,)``.
    unknowns, beside
        Of the gait (see `legspring.solve.Problem`), and of the fixed point at a slightly larger heading; None where
        there is none.
    value
        Eigenvalue magnitude or transport cost; 0 where there is no gait.
    penalties
        For the constraints that are not kept.
    """

    actuation: Floats
    unknowns: Floats | None
    beside: Floats | None
    value: float
    penalties: tuple[Penalty, ...]

    @property
    def total(self) -> float:
        """The penalised objective."""
        return self.value + sum(penalty.amount for penalty in self.penalties)


def missing_fixed_point(squares: float) -> float:
    """Say how far a search has stayed from a fixed point, by its sum of squared residuals: from 0 up."""
    return max(10.0 + math.log10(squares), 0.0) if squares > 0.0 else 0.0


def heading_beside(heading: float) -> float:
    """Return the slightly larger heading at which there must be a fixed point, too."""
    return 1.05 * heading if abs(heading) >= 0.05 else heading + math.copysign(0.0025, heading)


class Objective:
    """The penalised objective of one family at one slope and heading, as a function of the actuation.

    Parameters
    ----------
    animal, slope, heading, family
        Whose gaits; rad.
    goal
        ``"stability"``: the largest eigenvalue magnitude; ``"efficiency"``: the transport cost.
    of
        The map whose eigenvalues count: of a stride of the complete map, or the thesis's reduced map.

    Raises
    ------
    ValueError
        For an unknown goal or map, and as `legspring.trial.Trial` does.
    """

    def __init__(
        self, animal: Animal, slope: float, heading: float, family: str, goal: Goal, of: Map = "complete"
    ) -> None:
        checked_choice("objective", goal, ("stability", "efficiency"))
        checked_choice("map", of, ("complete", "reduced"))
        # There is a fixed point to be looked for beside the gait.
        checked_angle("heading", heading, 0.94 * math.pi / 2)
        self.goal, self.of = goal, of
        self.trial = Trial(animal, slope, heading, family)
        self.beside = self.trial.beside(heading_beside(heading))
        self.evaluations = 0

    def at(self, slope: float, heading: float) -> "Objective":
        """Return the same at another slope and heading."""
        return Objective(self.trial.system.animal, slope, heading, self.trial.family, self.goal, self.of)

    @property
    def floor(self) -> float:
        """What no gait can be better than: the work against gravity, sin(slope) (Eq. 4.1), or 0."""
        return abs(math.sin(self.trial.system.slope)) if self.goal == "efficiency" else 0.0

    def __call__(self, actuation: ArrayLike, near: Floats, beside: Floats | None = None) -> Score:
        """Evaluate the objective for some actuation at the gait near some unknowns.

        Parameters
        ----------
        actuation
            In units of nominal lengths, ``(P,)``.
        near
            Unknowns to search from.
        beside
            Where the fixed point at a slightly larger heading may be, if not near the gait.
        """
        self.evaluations += 1
        ratio = checked_vector("actuation", actuation, len(self.trial.lengths))
        squares = 1.0
        if np.all((ratio >= 0.0) & (ratio < 1.0)):
            found = self.trial.solve(ratio, near)
            squares = float(found.squares[0])
            score = self.alone(ratio, found.z[0]) if found.residuals[0] <= GOAL else None
            if score is not None:
                return self._with_beside(score, beside)
        missing = Penalty(Constraint.FIXED_POINT, "", NO_GAIT + 2.0 * missing_fixed_point(squares))
        return Score(ratio, None, None, 0.0, (*bound_penalties(self.trial.system.animal, ratio), missing))

    def alone(self, ratio: Floats, z: Floats) -> Score | None:
        """Evaluate the objective at a solution without looking for the fixed point beside it; None if it is no gait."""
        trial, animal = self.trial, self.trial.system.animal
        what: What = "cost" if self.goal == "efficiency" else self.of
        seen = trial.look(Candidate(ratio, z).point, what)
        if not seen.is_gait[0]:
            return None
        if self.goal == "efficiency":
            value = float(seen.cost[0])
        else:
            value = largest_magnitude(seen.jacobians[0]) ** (1 if self.of == "reduced" else 2)
        penalties = (
            *bound_penalties(animal, ratio),
            *phase_penalties(animal.pairs, z[1:]),
            *angle_penalties(animal.pairs, seen.angles[0]),
        )
        return Score(ratio, z, None, value, penalties)

    def totals(self, candidates: Floats) -> Floats:
        """Evaluate the objective of candidates, ``(N, P + n)``, but for the gaits beside; infinite if it is none."""
        trial, p = self.trial, len(self.trial.lengths)
        seen = trial.look(candidates, "cost" if self.goal == "efficiency" else self.of)
        value = np.full(len(candidates), np.inf)
        if self.goal == "efficiency":
            value[seen.is_gait] = seen.cost[seen.is_gait]
        else:
            radii = np.max(np.abs(np.linalg.eigvals(seen.jacobians[seen.is_gait])), axis=1)
            value[seen.is_gait] = radii ** (1 if self.of == "reduced" else 2)
        phases = candidates[:, p + 1 :]
        late, early = (phases - LATEST) / PHASE_UNIT, (EARLIEST - phases) / PHASE_UNIT
        soft = 0.5 * np.maximum(late, 0.0) + np.where(early > 0.0, 0.5 + 0.5 * early, 0.0)
        flat = np.maximum(ANGLE_WEIGHT * (SMALLEST_ANGLE - np.abs(seen.angles)), 0.0)
        return value + np.sum(soft, axis=1) + np.nan_to_num(np.sum(flat, axis=(1, 2)))

    def _with_beside(self, score: Score, guess: Floats | None) -> Score:
        """Add the fixed point beside a gait, or the penalty for its absence."""
        assert score.unknowns is not None
        for near in (score.unknowns, guess):
            if near is not None:
                found = self.beside.solve(score.actuation, near)
                if found.residuals[0] <= GOAL:
                    return replace(score, beside=found.z[0])
        amount = 0.5 + 0.5 * missing_fixed_point(float(found.squares[0]))
        return replace(score, penalties=(*score.penalties, Penalty(Constraint.FIXED_POINT_BESIDE, "", amount)))

    def approached(self, score: Score) -> Score:
        """Look, by way of the headings in between, for a fixed point beside a gait that seems to have none."""
        if score.unknowns is None or score.beside is not None:
            return score
        heading, near = self.trial.heading, score.unknowns
        for share in HALTS:
            trial = self.trial.beside(heading + share * (self.beside.heading - heading))
            found = trial.solve(score.actuation, near)
            if found.residuals[0] > GOAL:
                return score
            near = found.z[0]
        rest = tuple(penalty for penalty in score.penalties if penalty.constraint != Constraint.FIXED_POINT_BESIDE)
        return replace(score, beside=near, penalties=rest)

    def active(self, score: Score) -> tuple[str, ...]:
        """Name the constraints that bind: those that are violated, and those that all but are."""
        trial, pairs = self.trial, self.trial.system.animal.pairs
        if score.unknowns is None:
            return ()
        seen = trial.look(Candidate(score.actuation, score.unknowns).point, "ends")
        phases, angles = score.unknowns[1:], np.abs(seen.angles[0])
        near = {
            Constraint.ACTUATION_LEAST: score.actuation < LEAST + CLOSE,
            Constraint.ACTUATION_MOST: score.actuation > MOST - CLOSE,
            Constraint.PHASE_LATEST: phases > LATEST - CLOSE,
            Constraint.PHASE_EARLIEST: phases < EARLIEST + CLOSE,
            Constraint.ANGLE_TOUCHDOWN: angles[:, 0] < SMALLEST_ANGLE + 100.0 * CLOSE,
            Constraint.ANGLE_LIFTOFF: angles[:, 1] < SMALLEST_ANGLE + 100.0 * CLOSE,
        }
        names = [f"{pair}: {rule}" for rule, rows in near.items() for pair, row in zip(pairs, rows, strict=True) if row]
        return (*names, *([str(Constraint.FIXED_POINT_BESIDE)] if self._is_near_fold(score) else []))

    def _is_near_fold(self, score: Score) -> bool:
        """Whether there is no fixed point any more a little further than there has to be one."""
        if score.beside is None:
            return True
        heading = self.trial.heading
        further = self.trial.beside(heading + 1.02 * (heading_beside(heading) - heading))
        return bool(further.solve(score.actuation, score.beside).residuals[0] > GOAL)

    def eigenvalue(self, score: Score) -> float:
        """Largest eigenvalue magnitude of a stride at a score's gait, whatever the goal; infinite if there is none."""
        if score.unknowns is None:
            return math.inf
        seen = self.trial.look(Candidate(score.actuation, score.unknowns).point, self.of)
        return largest_magnitude(seen.jacobians[0]) ** (1 if self.of == "reduced" else 2)

    def candidate(self, gait: Gait) -> Candidate:
        """Return a gait as a candidate."""
        return Candidate(np.array(gait.actuation) / self.trial.lengths, self.trial.problem.unknowns(gait))

    def gait(self, score: Score) -> Gait | None:
        """Return the gait that a score is about, refined and verified; None if it proves to be none."""
        if score.unknowns is None:
            return None
        trial = self.trial
        magnitudes = score.actuation * trial.lengths
        problem = Problem(trial.system.animal, trial.system.slope, trial.heading, trial.family, magnitudes)
        gait = problem.gait(score.unknowns)
        return gait if gait is not None and gait.invalid() is None else None


def bound_penalties(animal: Animal, ratio: Floats) -> list[Penalty]:
    """Penalise an actuation (in units of nominal lengths) out of its range."""
    penalties = []
    for pair, share in zip(animal.pairs, ratio.tolist(), strict=True):
        if share < LEAST:
            penalties.append(Penalty(Constraint.ACTUATION_LEAST, pair, 30.0 + (LEAST - share) / LEAST))
        if share > MOST:
            penalties.append(Penalty(Constraint.ACTUATION_MOST, pair, 30.0 + (share - MOST) / (1.0 - MOST)))
    return penalties


def phase_penalties(pairs: tuple[str, ...], phases: Floats) -> list[Penalty]:
    """Penalise phases (rad) out of their range: late ones softly."""
    penalties = []
    for pair, phase in zip(pairs, phases.tolist(), strict=True):
        if phase > LATEST:
            penalties.append(Penalty(Constraint.PHASE_LATEST, pair, 0.5 * (phase - LATEST) / PHASE_UNIT))
        if phase < EARLIEST:
            penalties.append(Penalty(Constraint.PHASE_EARLIEST, pair, 0.5 + 0.5 * (EARLIEST - phase) / PHASE_UNIT))
    return penalties


def angle_penalties(pairs: tuple[str, ...], angles: Floats) -> list[Penalty]:
    """Penalise, softly, legs whose length hardly parts from its force-free length at touch-down or lift-off."""
    penalties = []
    for pair, row in zip(pairs, np.abs(angles).tolist(), strict=True):
        for constraint, angle in zip((Constraint.ANGLE_TOUCHDOWN, Constraint.ANGLE_LIFTOFF), row, strict=True):
            if angle < SMALLEST_ANGLE:
                penalties.append(Penalty(constraint, pair, ANGLE_WEIGHT * (SMALLEST_ANGLE - angle)))
    return penalties
