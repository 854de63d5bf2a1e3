"""Gaits with their actuation free: what constraints and objectives of an actuation are functions of.

Nothing here makes a `Gait`, which measures itself at leisure: a search for the best actuation looks at thousands of
candidates, and wants a few numbers of each, soon.
"""

import math
from collections.abc import Sequence
from functools import cached_property
from typing import Literal, NamedTuple, get_args

import numpy as np

from legspring.flow import flows
from legspring.kernel.walker import OK, Floats
from legspring.layout import ACCURACY, PLACES
from legspring.model import Animal
from legspring.problem import GaitProblem, check_tuned, tuned
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


class Measured(NamedTuple):
    """What a step from each of N candidates shows of gaits; nan where it cannot be simulated.

    Attributes
    ----------
    angles
        ``(N, P, 2)``: angle between length and force-free length against time, deg with rates in m/s, at touch-down and
        lift-off; positive where the leg begins, and ends, with the force of its function.
    is_gait
        ``(N,)``: whether legs lift off, as their function wants, and those down at the start are the right ones. That
        no leg is idle is left to `legspring.Gait.invalid`.
    cost
        ``(N,)``: transport cost (Eq. 3.6).
    jacobians
        ``(N, n, n)``: of the reduced map of a stride, or of the complete map of a mirrored step, in units of v_des, rad
        and v_des t_des.
    """

    angles: Floats
    is_gait: np.ndarray[tuple[int], np.dtype[np.bool_]]
    cost: Floats
    jacobians: Floats


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
        self._first, self._side = np.array(firsts), system.side[firsts]
        self._old = np.array(system.animal.partners)[firsts]
        self._places = np.array([system.place(leg, "actuation") for leg in range(len(system.pair))])
        names = [f"{pair}.actuation" for pair in system.animal.pairs]
        self._along = np.array([problem.direction(name) for name in names]) * self.lengths[:, None]
        lean = np.array([system.animal.legs[leg].angle for leg in firsts]) - self.heading
        self._approach = -system.desired_speed * np.cos(lean)
        self._swing = -math.pi * self._side * self.lengths / system.step_duration

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
        base = np.repeat(self.base(actuation), len(z), axis=0)
        if headings is not None:
            base[:, PLACES["heading"]] = headings
        values, by = self.problem.residual(z, self._along, base=base)
        size = self.problem.size
        return None if np.isnan(values).any() else (values, np.concatenate([by[..., size:], by[..., :size]], axis=2))

    def measure(self, candidates: Floats, what: What) -> Measured:
        """Simulate a step from candidates, ``(N, P + n)``; the next one is taken to mirror it, as in a gait."""
        points, pairs, system = np.atleast_2d(candidates), len(self.lengths), self.system
        p = self.problem.points(points[:, pairs:], self.base(points[:, :pairs]))
        (ways, scales), maps = self._state, what in MAPS
        ends = flows(system, p, along=ways if maps else ways[:0], liftoffs=True, work=what == "cost")
        fine, first, old = ends.status == OK, ends.liftoffs[:, self._first], ends.liftoffs[:, self._old]
        # A leg that is not up by the end of the step lifts off in the next one, as its old image does in this one.
        late = np.isnan(first[:, :, 0])
        time = np.where(late, old[:, :, 0] + system.step_duration, first[:, :, 0])
        rate = np.where(late, old[:, :, 1], first[:, :, 1])
        is_gait = fine & (rate * self._side < 0.0).all(axis=1)
        is_gait &= (late == (ends.down[:, self._old] != 0.0)).all(axis=1)
        angles = self._angles(points, time, rate)
        angles[~fine] = np.nan
        cost, jacobians = np.full(len(p), np.nan), np.full((len(p), 0, 0), np.nan)
        if what == "cost":
            cost = np.sum(np.abs(ends.work), axis=(1, 2)) / self._weight
        if maps:
            jacobians = ends.seen[:, PLACED, 1:] * scales[:, None]
        if what == "reduced":
            jacobians = (jacobians @ jacobians)[:, :2, :2]
        return Measured(angles, is_gait, cost, jacobians)

    @cached_property
    def _weight(self) -> float:
        """What a transport cost is counted in: m g by the desired displacement of a step, J."""
        return self.system.animal.body.mass * self.system.animal.gravity * self.system.step_length

    @cached_property
    def _state(self) -> tuple[Floats, Floats]:
        """Directions of the complete state, in the units of the unknowns, and what makes such of its mirrored image."""
        units = np.array([self.problem.unit(name) for name in STATE])
        return self.system.along(STATE) * units[:, None], signs(self.system, STATE) / units

    def _angles(self, points: Floats, time: Floats, rate: Floats) -> Floats:
        """Return the angles between length and force-free length against time where stances begin and end.

        Both rates are known from the candidate at touch-down, and differ by the gap's rate at lift-off.
        """
        pairs, unit = len(self.lengths), self.system.step_duration
        phase, swing = points[:, pairs + 1 :], self._swing * points[:, :pairs]
        rates = np.empty((4, *phase.shape))
        # At touch-down and at lift-off: of the length, and of the force-free length.
        rates[0], rates[1] = points[:, pairs, None] * self._approach, swing * np.cos(phase)
        rates[3] = swing * np.cos(math.pi / unit * time + phase)
        rates[2] = rates[3] + rate
        slopes = self._side * np.degrees(np.arctan(rates))
        return np.stack([slopes[0] - slopes[1], slopes[3] - slopes[2]], axis=-1)


def pair_lengths(animal: Animal) -> Floats:
    """Nominal length of each pair of legs, m."""
    return np.array([next(leg.length for leg in animal.legs if leg.pair == pair) for pair in animal.pairs])
