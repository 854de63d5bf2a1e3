"""Gaits with their actuation free: what constraints and objectives of an actuation are functions of.

Nothing here makes a `Gait`, which measures itself at leisure: a search for the best actuation looks at thousands of
candidates, and wants a few numbers of each, soon.
"""

import math
from typing import Literal, NamedTuple

import numpy as np

from legspring.flow import SEEN, flows
from legspring.kernel.walker import Floats
from legspring.layout import ACCURACY
from legspring.model import Animal
from legspring.problem import GaitProblem, check_tuned, tuned
from legspring.returnmap import signs
from legspring.solve import Solutions, solve

Map = Literal["complete", "reduced"]
What = Literal["ends", "cost", "complete", "reduced"]

GOAL = 1e-9
"""Largest residual of a candidate."""
STATES: dict[What, tuple[str, ...]] = {
    "ends": (),
    "cost": (),
    "reduced": ("speed", "heading"),
    "complete": ("speed", "heading", "Dx", "Dy"),
}
"""State that the map of a stride, or of a step, maps."""


class Measured(NamedTuple):
    """What a stride from each of N candidates shows; nan where it cannot be simulated.

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
        system = problem.system
        self.problem, self.system, self.family = problem, system, system.family
        self.heading = problem.pins["heading"]
        self.lengths = pair_lengths(system.animal)
        self._first = list(system.animal.first_legs)
        self._places = np.array([system.place(leg, "actuation") for leg in range(len(system.pair))])
        names = [f"{pair}.actuation" for pair in system.animal.pairs]
        self._along = [problem.direction(name) * unit for name, unit in zip(names, self.lengths, strict=True)]

    def beside(self, heading: float) -> "Actuated":
        """Return the same at another heading."""
        other = object.__new__(Actuated)
        other._use(self.problem.at(heading=heading))
        return other

    def base(self, actuation: Floats) -> Floats:
        """Return all parameters where the unknowns are zero, ``(N, n)``, for actuations ``(N, P)``."""
        magnitudes = np.atleast_2d(actuation) * self.lengths
        p = np.repeat(self.problem.base[None], len(magnitudes), axis=0)
        p[:, self._places] = magnitudes[:, self.system.pair]
        return p

    def solve(self, actuation: Floats, near: Floats, accuracy: float = ACCURACY, goal: float = GOAL) -> Solutions:
        """Solve for gaits with actuations ``(N, P)`` from starts ``(N, n)``."""
        return solve(self.problem, near, accuracy, goal, self.base(actuation))

    def conditions(self, actuation: Floats, z: Floats) -> tuple[Floats, Floats] | None:
        """Return what is left of a gait's conditions, ``(4,)``, and its derivatives by u and z; None if broken."""
        values, by = self.problem.residual(z, self._along, base=self.base(actuation))
        pairs = len(self.lengths)
        return None if np.isnan(values[0, 0]) else (values[0], np.roll(by[0], pairs, axis=1))

    def measure(self, candidates: Floats, what: What) -> Measured:
        """Simulate a stride from candidates, ``(N, P + n)``."""
        points, pairs, system = np.atleast_2d(candidates), len(self.lengths), self.system
        p = self.problem.points(points[:, pairs:], self.base(points[:, :pairs]))
        names = STATES[what]
        along = self._state_directions(names)
        once = what != "complete"
        ends = flows(system, p, steps=2, along=along if once else (), liftoffs=True, work=what == "cost")
        jacobians = np.zeros((len(p), 0, 0))
        if names:
            seen = (ends if once else flows(system, p, along=along)).seen
            rows = [SEEN.index(name) for name in names]
            units = np.array([self.problem.unit(name) for name in names])
            mirror = np.ones(len(names)) if once else signs(system, names)
            jacobians = seen[:, rows, 1:] * (mirror / units)[:, None]
        weight = system.animal.body.mass * system.animal.gravity * system.step_length
        cost = np.sum(np.abs(ends.work), axis=(1, 2)) / weight if what == "cost" else np.full(len(p), np.nan)
        fine = ends.status == 0
        time, rate = np.moveaxis(ends.liftoffs[:, self._first], -1, 0)
        side = system.side[self._first]
        is_gait = fine & np.all(rate * side < 0.0, axis=1)
        old = np.flatnonzero(system.offset)
        late = time[:, system.pair[old]] > system.step_duration
        is_gait &= np.all(late == (ends.down[:, old] != 0.0), axis=1)
        angles = np.where(fine[:, None, None], self._angles(points, time, rate), np.nan)
        return Measured(angles, is_gait, cost, jacobians)

    def _state_directions(self, names: tuple[str, ...]) -> list[Floats]:
        return [self.system.direction(name) * self.problem.unit(name) for name in names]

    def _angles(self, points: Floats, time: Floats, rate: Floats) -> Floats:
        """Return the angles between length and force-free length against time where stances begin and end.

        Both rates are known from the candidate at touch-down, and differ by the gap's rate at lift-off.
        """
        pairs, unit = len(self.lengths), self.system.step_duration
        side, phase = self.system.side[self._first], points[:, pairs + 1 :]
        swing = -math.pi * side * points[:, :pairs] * self.lengths / unit
        down, up = swing * np.cos(phase), swing * np.cos(math.pi * time / unit + phase)
        lean = np.array([self.system.animal.legs[leg].angle for leg in self._first]) - self.heading
        approach = -points[:, pairs, None] * self.system.desired_speed * np.cos(lean)
        begin = side * np.degrees(np.arctan(approach) - np.arctan(down))
        end = -side * np.degrees(np.arctan(up + rate) - np.arctan(up))
        return np.stack([begin, end], axis=-1)


def pair_lengths(animal: Animal) -> Floats:
    """Nominal length of each pair of legs, m."""
    return np.array([next(leg.length for leg in animal.legs if leg.pair == pair) for pair in animal.pairs])
