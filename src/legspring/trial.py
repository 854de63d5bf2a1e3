"""Gaits with their actuation free: what constraints and objectives of an actuation are functions of.

Nothing here makes a `Gait`, which measures itself at leisure: a search for the best actuation looks at thousands of
candidates, and wants a few numbers of each, soon.
"""

from typing import Literal, NamedTuple

import numpy as np

from legspring.kernel.look import ENDS, STEP, STRIDE, WORK, conditions_at, look
from legspring.kernel.walker import Floats
from legspring.layout import ACCURACY
from legspring.model import Animal
from legspring.returnmap import Direction, Start, jets
from legspring.solve import Problem, Solutions, check_tuned

Map = Literal["complete", "reduced"]
What = Literal["ends", "cost", "complete", "reduced"]

GOAL = 1e-9
"""Largest residual of a candidate."""
KINDS: dict[What, tuple[int, tuple[Direction, ...]]] = {
    "ends": (ENDS, ()),
    "cost": (WORK, ()),
    "reduced": (STRIDE, ("speed", "heading")),
    "complete": (STEP, ("speed", "heading", "Dx", "Dy")),
}
"""What the kernel is to look at, and the directions that this takes."""


class Look(NamedTuple):
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


class Trial:
    """One family at one slope and heading, with its actuation free.

    An actuation is an array of one number for each pair of legs, in units of their nominal lengths; the unknowns z of a
    gait are those of `legspring.solve.Problem`; a candidate is both in one array.

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
        self.problem = Problem(animal, slope, heading, family)
        self.system = system = self.problem.system
        self.heading, self.family = self.problem.heading, family
        self.lengths = pair_lengths(animal)
        self._first = np.array(animal.first_legs)
        self._scale = system.error_scale(ACCURACY)
        # One set of arrays for each set of directions; every simulation writes its values into them.
        self._jets: dict[tuple[Direction, ...], tuple[Floats, Floats, Floats]] = {}
        self._unknowns: tuple[Direction, ...] = (
            *(("actuation", pair) for pair in animal.pairs),
            "speed",
            *(("phase", pair) for pair in animal.pairs),
        )
        self._scales = np.concatenate([self.lengths, [system.step_length], np.ones(len(animal.pairs))])

    def beside(self, heading: float) -> "Trial":
        """Return the same at another heading."""
        return Trial(self.system.animal, self.system.slope, heading, self.family)

    def _jets_along(self, along: tuple[Direction, ...]) -> tuple[Floats, Floats, Floats]:
        """Return arrays for the kernel with derivatives along some directions."""
        if along not in self._jets:
            start, phase = Start(self.system.desired_speed, self.heading), np.zeros(len(self.lengths))
            self._jets[along] = jets(self.system, phase, start, along)
        return self._jets[along]

    def solve(self, actuation: Floats, near: Floats) -> Solutions:
        """Solve for gaits with actuations ``(N, P)`` from starts ``(N, n)``."""
        return self.problem.solve(near, ACCURACY, GOAL, np.atleast_2d(actuation) * self.lengths)

    def conditions(self, actuation: Floats, z: Floats) -> tuple[Floats, Floats] | None:
        """Return what is left of a gait's conditions, ``(4,)``, and its derivatives by u and z; None if broken."""
        body, legs, start = self._jets_along(self._unknowns)
        system, points = self.system, np.concatenate([actuation, z])[None]
        pair, lengths, stride, scale = system.pair, self.lengths, system.step_length, self._scale
        residuals, jacobians = conditions_at(
            body, legs, system.side, system.offset, pair, lengths, start, stride, scale, points
        )
        return None if np.isnan(residuals[0, 0]) else (residuals[0], jacobians[0] * self._scales)

    def look(self, candidates: Floats, what: What) -> Look:
        """Simulate a stride from candidates, ``(N, P + n)``."""
        system, points = self.system, np.atleast_2d(candidates)
        kind, along = KINDS[what]
        body, legs, start = self._jets_along(along)
        pair, lengths, stride, scale = system.pair, self.lengths, system.step_length, self._scale
        side, offset, rate = system.side, system.offset, 1.0 / system.step_duration
        angles, is_gait, jacobians, work = look(
            body, legs, side, offset, pair, self._first, lengths, start, stride, rate, scale, points, kind
        )
        return Look(angles, is_gait, work / (system.weight * stride), jacobians)


def pair_lengths(animal: Animal) -> Floats:
    """Nominal length of each pair of legs, m."""
    return np.array([next(leg.length for leg in animal.legs if leg.pair == pair) for pair in animal.pairs])
