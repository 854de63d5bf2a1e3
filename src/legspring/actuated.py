"""Gaits with their actuation free: what constraints and objectives of an actuation are functions of.

Nothing here makes a `Gait`, which measures itself at leisure: a search for the best actuation looks at thousands of
candidates, and wants a few numbers of each, soon.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, get_args

import numpy as np

from legspring.asking import check_tuned, tuned
from legspring.flow import Simulator
from legspring.kernel.many import Ends
from legspring.kernel.walker import OK, Floats
from legspring.layout import ACCURACY, PLACES
from legspring.measures.cost import weighed
from legspring.model import Animal
from legspring.problem import GaitProblem
from legspring.returnmap import signs
from legspring.solve import Solutions, solve

Map = Literal["complete", "reduced"]
What = Literal["ends", "cost", "complete", "reduced"]

GOAL = 1e-9
"""Largest residual of a candidate."""
MAPS = get_args(Map)
STATE = ("speed", "heading", "Dx", "Dy")
"""State that the complete map maps; the reduced one is that of the first two, over a stride."""
PLACED = [PLACES[name] for name in STATE]
"""Where it is among what is observed."""


@dataclass(frozen=True, eq=False)
class Measured:
    """What a step from each of N candidates shows of gaits, in which the next step mirrors it.

    Attributes
    ----------
    actuated, points, what, ends
        Whose candidates, ``(N, P + n)``; what was asked for; and what became of them.
    """

    actuated: "Actuated"
    points: Floats
    what: What
    ends: Ends

    @property
    def angles(self) -> Floats:
        """Angles between length and force-free length against time, ``(N, P, 2)``, deg with rates in m/s.

        At touch-down and lift-off; positive where the leg begins, and ends, with the force of its function; nan where
        there is none. Both rates are known from the candidate at touch-down, and differ by the gap's rate at lift-off.
        """
        actuated, (_, time, rate) = self.actuated, self._liftoffs
        pairs, unit = len(actuated.lengths), actuated.system.step_duration
        phase, swing = self.points[:, pairs + 1 :], actuated.swing * self.points[:, :pairs]
        rates = np.empty((4, *phase.shape))
        # At touch-down and at lift-off: of the length, and of the force-free length.
        rates[0], rates[1] = self.points[:, pairs, None] * actuated.approach, swing * np.cos(phase)
        rates[3] = swing * np.cos(math.pi / unit * time + phase)
        rates[2] = rates[3] + rate
        slopes = actuated.side * np.degrees(np.arctan(rates))
        angles = np.empty((*phase.shape, 2))
        angles[..., 0], angles[..., 1] = slopes[0] - slopes[1], slopes[3] - slopes[2]
        angles[self.ends.status != OK] = np.nan
        return angles

    @property
    def is_gait(self) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        """Whether legs lift off, as their function wants, and those down at the start are the right ones, ``(N,)``.

        That no leg is idle is left to `legspring.Gait.invalid`.
        """
        late, _, rate = self._liftoffs
        right = (rate * self.actuated.side < 0.0) & (late == (self.ends.down[:, self.actuated.old] != 0.0))
        found: np.ndarray[tuple[int], np.dtype[np.bool_]] = (self.ends.status == OK) & right.all(axis=1)
        return found

    @property
    def cost(self) -> Floats:
        """Transport costs (Eqs. 3.5, 3.6), ``(N,)``; nan where it is not known."""
        if self.what != "cost":
            return np.full(len(self.points), np.nan)
        system = self.actuated.system
        weight = system.animal.body.mass * system.animal.gravity
        return weighed(self.ends.work, system.animal.work_weights) / (weight * system.step_length)

    @property
    def jacobians(self) -> Floats:
        """Jacobians of the map that was asked for, ``(N, n, n)``, in units of v_des, rad and v_des t_des.

        Of the complete map of a mirrored step, or of the reduced map of a stride, which takes the rest of its start as
        it is.
        """
        step = self.ends.seen[:, PLACED, 1:] * self.actuated.state[1][:, None]
        return (step @ step)[:, :2, :2] if self.what == "reduced" else step

    @cached_property
    def _liftoffs(self) -> tuple[np.ndarray[Any, np.dtype[np.bool_]], Floats, Floats]:
        """Of each pair, ``(N, P)``: whether legs lift off in the step after their first one; when, and the gap's rate.

        A leg that is not up by the end of the step lifts off in the next one, as its old image does in this one.
        """
        first, old = self.ends.liftoffs[:, self.actuated.first], self.ends.liftoffs[:, self.actuated.old]
        late = np.isnan(first[:, :, 0])
        time = np.where(late, old[:, :, 0] + self.actuated.system.step_duration, first[:, :, 0])
        return late, time, np.where(late, old[:, :, 1], first[:, :, 1])


class Actuated:
    """One family at one slope and heading, with its actuation free.

    An actuation is an array of one number for each pair of legs, in units of their nominal lengths; the unknowns z of a
    gait are those of its `GaitProblem`; a candidate is both in one array.

    Raises
    ------
    ValueError
        For an angle out of range, an unknown family, or an animal whose gaits have other unknowns.
    """

    def __init__(self, animal: Animal, slope: float, heading: float, family: str) -> None:
        check_tuned(animal, "for its actuation to be optimised")
        if animal.body.yaw == "free":
            raise ValueError(f"animal = {animal.name!r}: must have its yaw held for its actuation to be optimised")
        if not all(leg.plain for leg in animal.legs):
            raise ValueError(
                f"animal = {animal.name!r}: must have legs without length_law, stance and damping for its actuation to "
                "be optimised"
            )
        self._use(tuned(animal, slope, heading, family))

    def _use(self, problem: GaitProblem) -> None:
        """Note what all candidates have in common."""
        system = problem.system
        self.problem, self.system, self.family = problem, system, system.family
        self.heading = problem.pins["heading"]
        self.lengths, firsts = pair_lengths(system.animal), list(system.animal.first_legs)
        self.first, self.side = np.array(firsts), system.side[firsts]
        self.old = np.array(system.animal.partners)[firsts]
        self._places = np.array([system.place(leg, "actuation") for leg in range(len(system.pair))])
        names = [f"{pair}.actuation" for pair in system.animal.pairs]
        by_actuation = np.array([problem.direction(name) for name in names]) * self.lengths[:, None]
        self._along = np.vstack([by_actuation, problem.task.along])
        lean = np.array([system.animal.legs[leg].angle for leg in firsts]) - self.heading
        self.approach = -system.desired_speed * np.cos(lean)
        self.swing = -math.pi * self.side * self.lengths / system.step_duration

    def beside(self, heading: float) -> "Actuated":
        """Return the same at another heading."""
        other = object.__new__(Actuated)
        other._use(self.problem.at(heading=heading))
        return other

    def base(self, actuation: Floats) -> Floats:
        """Return all parameters where the unknowns are zero, ``(N, n)``, for actuations ``(N, P)``."""
        magnitudes = np.atleast_2d(actuation) * self.lengths
        p = np.empty((len(magnitudes), len(self.problem.base)))
        p[:] = self.problem.base
        p[:, self._places] = magnitudes[:, self.system.pair]
        return p

    def solve(self, actuation: Floats, near: Floats, accuracy: float = ACCURACY, goal: float = GOAL) -> Solutions:
        """Solve for gaits with actuations ``(N, P)`` from starts ``(N, n)``."""
        return solve(self.problem, near, accuracy, goal, self.base(actuation))

    def conditions(
        self, actuation: Floats, z: Floats, headings: Sequence[float] | None = None
    ) -> tuple[Floats, Floats] | None:
        """Return what is left of a gait's conditions, and its derivatives by u and z; None if one is broken.

        Parameters
        ----------
        actuation
            ``(P,)``.
        z, headings
            ``(K, n)``, ``(K,)``: unknowns, and the heading of each, if others than the problem's.

        Returns
        -------
        values, derivatives
            ``(K, 4)``, ``(K, 4, P + n)``.
        """
        p = self.problem.points(z, self.base(actuation))
        if headings is not None:
            p[:, PLACES["heading"]] = headings
        values, by = self.problem.left(p, self._along, self._step(p).seen)
        return None if np.isnan(values).any() else (values, by)

    def measure(self, candidates: Floats, what: What) -> Measured:
        """Simulate a step from candidates, ``(N, P + n)``; the next one is taken to mirror it, as in a gait."""
        points, pairs = np.atleast_2d(candidates), len(self.lengths)
        p = self.problem.points(points[:, pairs:], self.base(points[:, :pairs]))
        return Measured(self, points, what, self._simulators[what](p))

    @cached_property
    def state(self) -> tuple[Floats, Floats]:
        """Directions of the complete state, in the units of the unknowns, and what makes such of its mirrored image."""
        units = np.array([self.problem.unit(name) for name in STATE])
        return self.system.along(STATE) * units[:, None], signs(self.system, STATE) / units

    @cached_property
    def _step(self) -> Simulator:
        """A step, with derivatives by actuation and unknowns."""
        return Simulator(self.system, along=self._along)

    @cached_property
    def _simulators(self) -> dict[What, Simulator]:
        """A step with its lift-offs, and with what else is asked for: work of legs, or derivatives by the state."""
        by_state = Simulator(self.system, along=self.state[0], liftoffs=True)
        return {
            "ends": Simulator(self.system, liftoffs=True),
            "cost": Simulator(self.system, liftoffs=True, work=True),
            "complete": by_state,
            "reduced": by_state,
        }


def pair_lengths(animal: Animal) -> Floats:
    """Nominal length of each pair of legs, m."""
    return np.array([next(leg.length for leg in animal.legs if leg.pair == pair) for pair in animal.pairs])
