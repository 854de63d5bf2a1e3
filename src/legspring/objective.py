"""What an actuation is to minimise: stability or cost, with a penalty for each constraint that is not kept."""

import math
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from legspring.actuated import GOAL, Actuated, Map
from legspring.asking import tuned
from legspring.checks import checked_angle, checked_choice, checked_vector
from legspring.constraints import LIMITS, Constraint, Constraints, named_constraints
from legspring.gait import Gait
from legspring.kernel.walker import Floats
from legspring.measures.stability import largest_magnitude
from legspring.model import Animal
from legspring.solve import refined

Goal = Literal["stability", "efficiency"]

SHARES_ON_THE_WAY = 0.5, 0.8, 0.95, 1.0
"""Shares of the way to the heading beside at which a gait is looked for."""
CLOSE = np.array([1e-3, 1e-3, 1e-3, 1e-3, 0.1, 0.1])
"""Distance from its limit, in units of l0, rad or deg, at which a constraint is active."""


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
        Of the gait (see `legspring.problem.GaitProblem`), and of the fixed point at a slightly larger heading; None
        where there is none.
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
    constraints
        What a gait must keep to, or its name.

    Raises
    ------
    ValueError
        For an unknown goal, map or name, and as `legspring.actuated.Actuated` does.
    """

    def __init__(
        self,
        animal: Animal,
        slope: float,
        heading: float,
        family: str,
        goal: Goal,
        of: Map = "complete",
        *,
        constraints: Constraints | str = "peterson2011",
    ) -> None:
        checked_choice("objective", goal, ("stability", "efficiency"))
        checked_choice("map", of, ("complete", "reduced"))
        # There is a fixed point to be looked for beside the gait.
        checked_angle("heading", heading, 0.94 * math.pi / 2)
        self.goal, self.of, self.constraints = goal, of, named_constraints(constraints)
        self.actuated = Actuated(animal, slope, heading, family)
        self.beside = self.actuated.beside(self.constraints.heading_beside(heading))
        self.evaluations = 0

    def at(self, slope: float, heading: float) -> "Objective":
        """Return the same at another slope and heading."""
        animal, family = self.actuated.system.animal, self.actuated.family
        return Objective(animal, slope, heading, family, self.goal, self.of, constraints=self.constraints)

    def like(self, goal: Goal, of: Map) -> "Objective":
        """Return the objective of the same gaits for another goal and map."""
        actuated = self.actuated
        animal, slope = actuated.system.animal, actuated.system.slope
        return Objective(animal, slope, actuated.heading, actuated.family, goal, of, constraints=self.constraints)

    @property
    def floor(self) -> float:
        """What no gait can be better than: the work against gravity, or with it, by its weight (Eq. 4.1), or 0."""
        (up, down), climb = self.actuated.system.animal.work_weights, math.sin(self.actuated.system.slope)
        return max(up * climb, -down * climb) if self.goal == "efficiency" else 0.0

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
        ratio = checked_vector("actuation", actuation, len(self.actuated.lengths))
        squares = 1.0
        if np.all((ratio >= 0.0) & (ratio < 1.0)):
            found = self.actuated.solve(ratio, near)
            squares = float(found.squares[0])
            score = self.alone(ratio, found.z[0]) if found.residuals[0] <= GOAL else None
            if score is not None:
                return self._with_beside(score, beside)
        unknown = np.full(len(ratio), np.nan)
        limits = self.constraints.excess(ratio, unknown, np.full((len(ratio), 2), np.nan), signed=False)
        missing = Penalty(Constraint.FIXED_POINT, "", self.constraints.missing(Constraint.FIXED_POINT, squares))
        return Score(ratio, None, None, 0.0, (*self._penalties(limits), missing))

    def alone(self, ratio: Floats, z: Floats) -> Score | None:
        """Evaluate the objective at a solution without looking for the fixed point beside it; None if it is no gait."""
        values, excess = self._measured(Candidate(ratio, z).point[None])
        return Score(ratio, z, None, float(values[0]), self._penalties(excess[0])) if np.isfinite(values[0]) else None

    def totals(self, candidates: Floats) -> Floats:
        """Evaluate the objective of candidates, ``(N, P + n)``, but for the gaits beside; infinite if it is none."""
        values, excess = self._measured(candidates)
        return values + np.sum(self.constraints.penalties(excess), axis=(1, 2))

    def _measured(self, candidates: Floats) -> tuple[Floats, Floats]:
        """Return what is to be small, infinite where there is no gait, and by how much limits are passed."""
        p = len(self.actuated.lengths)
        seen = self.actuated.measure(candidates, "cost" if self.goal == "efficiency" else self.of)
        values = np.full(len(candidates), np.inf)
        if self.goal == "efficiency":
            values[seen.is_gait] = seen.cost[seen.is_gait]
        else:
            radii = np.max(np.abs(np.linalg.eigvals(seen.jacobians[seen.is_gait])), axis=1)
            values[seen.is_gait] = radii ** (1 if self.of == "reduced" else 2)
        return values, self.constraints.excess(candidates[:, :p], candidates[:, p + 1 :], seen.angles, signed=False)

    def _penalties(self, excess: Floats) -> tuple[Penalty, ...]:
        """Name the limits of one candidate that are passed, each with its penalty."""
        amounts, pairs = self.constraints.penalties(excess).T, self.actuated.system.animal.pairs
        places = np.argwhere(amounts > 0.0).tolist()
        return tuple(Penalty(LIMITS[rule], pairs[pair], float(amounts[rule, pair])) for rule, pair in places)

    def _with_beside(self, score: Score, guess: Floats | None) -> Score:
        """Add the fixed point beside a gait, or the penalty for its absence."""
        assert score.unknowns is not None
        for near in (score.unknowns, guess):
            if near is not None:
                found = self.beside.solve(score.actuation, near)
                if found.residuals[0] <= GOAL:
                    return replace(score, beside=found.z[0])
        amount = self.constraints.missing(Constraint.FIXED_POINT_BESIDE, float(found.squares[0]))
        return replace(score, penalties=(*score.penalties, Penalty(Constraint.FIXED_POINT_BESIDE, "", amount)))

    def approached(self, score: Score) -> Score:
        """Look, by way of the headings in between, for a fixed point beside a gait that seems to have none."""
        if score.unknowns is None or score.beside is not None:
            return score
        heading, near = self.actuated.heading, score.unknowns
        for share in SHARES_ON_THE_WAY:
            actuated = self.actuated.beside(heading + share * (self.beside.heading - heading))
            found = actuated.solve(score.actuation, near)
            if found.residuals[0] > GOAL:
                return score
            near = found.z[0]
        rest = tuple(penalty for penalty in score.penalties if penalty.constraint != Constraint.FIXED_POINT_BESIDE)
        return replace(score, beside=near, penalties=rest)

    def active(self, score: Score) -> tuple[str, ...]:
        """Name the constraints that bind: those that are violated, and those that all but are."""
        actuated, pairs = self.actuated, self.actuated.system.animal.pairs
        if score.unknowns is None:
            return ()
        seen = actuated.measure(Candidate(score.actuation, score.unknowns).point, "ends")
        excess = self.constraints.excess(score.actuation, score.unknowns[1:], seen.angles[0], signed=False)
        near = np.argwhere(-CLOSE[:, None] < excess.T).tolist()
        names = [f"{pairs[pair]}: {self.constraints.words(LIMITS[rule])}" for rule, pair in near]
        return (*names, *([self.constraints.words(Constraint.FIXED_POINT_BESIDE)] if self._is_near_fold(score) else []))

    def _is_near_fold(self, score: Score) -> bool:
        """Whether there is no fixed point any more a little further than there has to be one."""
        if score.beside is None:
            return True
        heading = self.actuated.heading
        further = self.actuated.beside(heading + 1.02 * (self.beside.heading - heading))
        return bool(further.solve(score.actuation, score.beside).residuals[0] > GOAL)

    def eigenvalue(self, score: Score) -> float:
        """Largest eigenvalue magnitude of a stride at a score's gait, whatever the goal; infinite if there is none."""
        if score.unknowns is None:
            return math.inf
        seen = self.actuated.measure(Candidate(score.actuation, score.unknowns).point, self.of)
        return largest_magnitude(seen.jacobians[0]) ** (1 if self.of == "reduced" else 2)

    def candidate(self, gait: Gait) -> Candidate:
        """Return a gait as a candidate."""
        return Candidate(np.array(gait.actuation) / self.actuated.lengths, self.actuated.problem.z_of(gait))

    def gait(self, score: Score) -> Gait | None:
        """Return the gait that a score is about, refined and verified; None if it proves to be none."""
        if score.unknowns is None:
            return None
        actuated = self.actuated
        system, magnitudes = actuated.system, score.actuation * actuated.lengths
        problem = tuned(system.animal, system.slope, actuated.heading, actuated.family, magnitudes)
        gait = refined(problem, score.unknowns)
        return gait if gait is not None and gait.invalid() is None else None
