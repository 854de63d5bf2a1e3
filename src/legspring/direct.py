"""The best actuation of any animal: a search that needs no derivatives, of gaits that measure themselves.

What a nonlinear programme knows of the thesis's cockroach (`legspring.programme`) it does not know of bodies that yaw,
of legs with dampers and formulas, of any number of legs, of animals with speeds of their own. Here each actuation is
tried: the gait is followed there, verified, measured, and charged for the constraints that it does not keep.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import get_args

import numpy as np
from scipy.optimize import minimize
from scipy.stats import qmc
from threadpoolctl import threadpool_limits

from legspring.actuated import Map, pair_lengths
from legspring.asking import checked_targets, problems_for
from legspring.checks import checked_choice
from legspring.constraints import LIMITS, Constraint, Constraints, named_constraints
from legspring.flow import IntegrationError
from legspring.gait import Gait
from legspring.kernel.measure import stretch_rates
from legspring.kernel.walker import Floats
from legspring.model import Animal, ModelError
from legspring.objective import Goal, Penalty
from legspring.optimum import Optimum
from legspring.problem import GaitProblem
from legspring.solve import gait_near, search_gaits

NODES = 12
"""Actuations at which gaits are looked for, beside the animal's own."""
STARTS = 24
"""Starts of each of these searches."""
POLISHED = 3
"""Gaits from which the search goes on."""
STOPS = {"xatol": 1e-4, "fatol": 1e-5, "maxfev": 400}
"""What ends it: changes of the actuation, in units of nominal lengths, and of the objective; evaluations."""
LONGEST_MOVE = 0.05
"""Change of an actuation, in units of nominal lengths, over which a gait is followed at once."""


@dataclass(frozen=True)
class Trial:
    """A gait, what is to be small, and what it pays for the constraints that it does not keep."""

    gait: Gait
    value: float
    penalties: tuple[Penalty, ...]

    @property
    def total(self) -> float:
        """The penalised objective."""
        return self.value + sum(penalty.amount for penalty in self.penalties)


@dataclass
class Direct:
    """The penalised objective of one family as a function of the actuation.

    Attributes
    ----------
    animal, slope, family, asked
        Whose gaits, rad; and what they are asked for, as by `search_gaits`.
    goal, of, constraints
        See `legspring.objective.Objective`.
    evaluations
        Actuations tried.
    """

    animal: Animal
    slope: float
    family: str
    asked: Mapping[str, float | None]
    goal: Goal
    of: Map
    constraints: Constraints
    evaluations: int = field(default=0)

    @cached_property
    def lengths(self) -> Floats:
        """Nominal length of each pair of legs, m."""
        return pair_lengths(self.animal)

    @cached_property
    def driven(self) -> list[int]:
        """Pairs that have an actuation, which is what varies."""
        return [pair for pair, amount in enumerate(self.animal.actuation) if amount > 0.0]

    def ratio(self, gait: Gait) -> Floats:
        """Return a gait's actuation of the pairs that have one, in units of nominal lengths."""
        return (np.array(gait.actuation) / self.lengths)[self.driven]

    def with_ratio(self, ratio: Floats) -> Animal:
        """Return the animal with such an actuation."""
        magnitudes = np.array(self.animal.actuation)
        magnitudes[self.driven] = ratio * self.lengths[self.driven]
        return self.animal.replace(actuation=magnitudes.tolist())

    def gaits(self, animal: Animal, starts: int = STARTS) -> list[Gait]:
        """Search for the gaits of one family."""
        found = search_gaits(animal, slope=self.slope, family=self.family, starts=starts, **self.asked)  # type: ignore[arg-type]
        return list(found.gaits)

    def followed(self, gait: Gait, ratio: Floats) -> Gait | None:
        """Return the gait with another actuation, in steps if it is far; None if it is lost."""
        here = self.ratio(gait)
        steps = max(1, math.ceil(float(np.max(np.abs(ratio - here))) / LONGEST_MOVE))
        found: Gait | None = gait
        for step in range(1, steps + 1):
            assert found is not None
            problem = self._problem(found, self.with_ratio(here + (ratio - here) * step / steps))
            found = None if problem is None else gait_near(problem, problem.z_of(found))
            if found is None:
                return None
        return found if found is not None and found.invalid() is None else None

    def _problem(self, gait: Gait, animal: Animal) -> GaitProblem | None:
        problem = getattr(gait.origin, "problem", None)
        if problem is None:
            return None
        system = replace(problem.system, animal=animal, actuation=None, contacts=gait.contacts)
        return replace(problem, system=system)

    def trial(self, gait: Gait) -> Trial:
        """Measure a gait."""
        eigenvalue = abs(gait.multipliers[0]) if self.of == "complete" else gait.reduced_eigenvalue
        value = float(eigenvalue) if self.goal == "stability" else gait.transport_cost
        penalties = tuple(charges(gait, self.constraints))
        return Trial(gait, value if math.isfinite(value) else math.inf, penalties)

    def polished(self, start: Trial) -> tuple[Trial, str]:
        """Go downhill from a gait by Nelder and Mead's method; every trial follows the best gait so far."""
        best = start
        least, most = self.constraints.actuation

        def total(ratio: Floats) -> float:
            nonlocal best
            self.evaluations += 1
            try:
                gait = self.followed(best.gait, np.clip(ratio, least, most))
                trial = None if gait is None else self.trial(gait)
            except (IntegrationError, ModelError, np.linalg.LinAlgError):
                trial = None
            if trial is None:
                return self.constraints.no_gait + float(np.sum((ratio - self.ratio(best.gait)) ** 2))
            if trial.total < best.total:
                best = trial
            beyond = float(np.sum(np.abs(ratio - np.clip(ratio, least, most))))
            return trial.total + 10.0 * beyond

        found = minimize(total, self.ratio(start.gait), method="Nelder-Mead", options=STOPS)
        return best, "converged" if found.success else "limit of evaluations reached"

    def search(self, seed: int, tick: Callable[[], None] = lambda: None) -> tuple[Trial, str] | None:
        """Look at actuations all over their range, and polish the best."""
        least, most = self.constraints.actuation
        sobol = qmc.Sobol(len(self.driven), rng=seed)
        # A power of two is what the sequence is made for.
        ratios = least + (most - least) * sobol.random(16)[:NODES]
        trials = [self.trial(gait) for gait in self.gaits(self.animal)]
        for ratio in ratios:
            tick()
            trials += [self.trial(gait) for gait in self.gaits(self.with_ratio(ratio))]
        trials = [trial for trial in trials if math.isfinite(trial.total)]
        trials.sort(key=lambda trial: trial.total)
        ends = [self.polished(trial) for trial in trials[:POLISHED]]
        return min(ends, key=lambda end: end[0].total, default=None)


def charges(gait: Gait, constraints: Constraints) -> list[Penalty]:
    """Name the constraints that a gait does not keep, and what that costs; phases that are given are not its fault."""
    free = {name.partition(".")[0] for name in getattr(gait.origin, "free", ())}
    early, late = constraints.phase
    middle = 0.5 * (early + late)
    ratio = np.array(gait.actuation) / pair_lengths(gait.animal)
    least, most = constraints.actuation
    ratio = np.where(np.array(gait.actuation) > 0.0, ratio, 0.5 * (least + most))
    phase = [phi if pair in free else middle for pair, phi in zip(gait.animal.pairs, gait.phase, strict=True)]
    excess = constraints.excess(ratio, phase, angles_of(gait), signed=False)
    amounts = np.nan_to_num(constraints.penalties(excess))
    found = [
        Penalty(LIMITS[rule], gait.animal.pairs[pair], float(amounts[pair, rule]))
        for pair, rule in np.argwhere(amounts > 0.0)
    ]
    if gait.origin is not None and "heading" in gait.origin.given:
        there = constraints.heading_beside(gait.heading) - gait.heading
        if gait.origin.moved(gait, "heading", there) is None:
            missing = constraints.missing(Constraint.FIXED_POINT_BESIDE, 1.0)
            found.append(Penalty(Constraint.FIXED_POINT_BESIDE, "", missing))
    return found


def angles_of(gait: Gait) -> Floats:
    """Return angles between length and force-free length against time, ``(P, 2)``, deg with rates in m/s.

    Of the leg of each pair that is put down first, at touch-down and at lift-off; nan where it is not in stance there.
    """
    run, found = gait.stride, np.full((len(gait.first_legs), 2), math.nan)
    tape = run.tape
    for pair, leg in enumerate(gait.first_legs):
        down = tape.down[: tape.counts[0], leg] != 0.0
        begins = np.flatnonzero(down & ~np.append(False, down[:-1]))
        ends = np.flatnonzero(down & ~np.append(down[1:], False))
        for column, (where, x) in enumerate(((begins, 0.0), (ends, None))):
            if len(where):
                n = int(where[0])
                share = (tape.time[n + 1] - tape.time[n]) / tape.size[n] if x is None else x
                rates = [rate / run.unit for rate in stretch_rates(tape, n, share, leg)]
                found[pair, column] = abs(np.degrees(math.atan(rates[0]) - math.atan(rates[1])))
    return found


def is_programmable(animal: Animal) -> bool:
    """Whether an animal is one that the nonlinear programme is written for: as the thesis has them."""
    as_thesis = animal.tuned and animal.mirrored and len(animal.pairs) == 3 and animal.body.yaw == "held"
    legs = all(leg.plain and leg.phase is None and leg.offset in (0.0, 1.0) for leg in animal.legs)
    return as_thesis and legs and all(amount > 0.0 for amount in animal.actuation)


def direct(
    animal: Animal,
    slope: float,
    family: str,
    heading: float | None,
    goal: Goal,
    of: Map,
    constraints: Constraints | str,
) -> Direct:
    """Return the objective of an animal whose actuations are tried.

    Raises
    ------
    ValueError
        If it has no actuation, or no such map.
    """
    checked_choice("objective", goal, get_args(Goal))
    checked_choice("map", of, get_args(Map))
    if not any(animal.actuation):
        raise ValueError(f"animal = {animal.name!r}: must have legs with an actuation for it to be optimised")
    if of == "reduced" and not animal.tuned:
        raise ValueError(f"map = 'reduced': must be complete for {animal.name!r}, which has no desired speed")
    problems_for(animal, slope, family, checked_targets({"heading": heading}))
    return Direct(animal, slope, family, {"heading": heading}, goal, of, named_constraints(constraints))


def tried(objective: Direct, seed: int) -> Optimum | None:
    """Search one family by trial; None if there is no gait worth having."""
    with threadpool_limits(1):
        end = objective.search(seed)
    if end is None or not end[0].total < objective.constraints.no_gait:
        return None
    trial, reason = end
    active = tuple(f"{penalty.pair}: {objective.constraints.words(penalty.constraint)}" for penalty in trial.penalties)
    return Optimum(
        **{field.name: getattr(trial.gait, field.name) for field in fields(Gait)},
        objective=objective.goal,
        map=objective.of,
        method="default",
        value=trial.value,
        penalised=trial.total,
        ending=reason,
        active=active,
        evaluations=objective.evaluations,
    )
