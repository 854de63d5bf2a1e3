"""Gaits with their actuation free: what constraints and objectives of an actuation are functions of.

Nothing here makes a `Gait`, which measures itself at leisure: a search for the best actuation looks at thousands of
candidates, and wants a few numbers of each, soon.
"""

from typing import Literal, NamedTuple

import numpy as np

from legspring.kernel.launch import HEADING, SPEED
from legspring.kernel.look import ENDS, STEP, STRIDE, WORK, look
from legspring.kernel.newton import gait_conditions
from legspring.kernel.run import run
from legspring.kernel.walker import ACTUATION, OK, PHASE, Floats
from legspring.model import Animal
from legspring.returnmap import NO_PUSH, Start, jets
from legspring.setting import ACCURACY
from legspring.solve import Problem, Solutions

Map = Literal["complete", "reduced"]
What = Literal["ends", "cost", "complete", "reduced"]

GOAL = 1e-9
"""Largest residual of a candidate."""


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
        if animal.body.yaw == "free":
            raise ValueError(f"animal = {animal.name!r}: must have its yaw held for its actuation to be optimised")
        self.problem = Problem(animal, slope, heading, family)
        self.setting = setting = self.problem.setting
        self.heading, self.family = self.problem.heading, family
        self.lengths = pair_lengths(animal)
        pairs = range(len(animal.pairs))
        self._first = np.array([np.flatnonzero((setting.pair == p) & (setting.offset == 0.0))[0] for p in pairs])
        self._placement = np.array([animal.legs[leg].angle for leg in self._first])
        # One set of arrays for each set of directions; every simulation writes its values into them.
        start, phase = Start(setting.desired_speed, heading), np.zeros(len(pairs))
        actuation, phases = ([(name, pair) for pair in animal.pairs] for name in ("actuation", "phase"))
        still, maps = jets(setting, phase, start), jets(setting, phase, start, ["speed", "heading"])
        self._unknowns = jets(setting, phase, start, [*actuation, "speed", *phases])
        self._jets = {
            "ends": (ENDS, still),
            "cost": (WORK, still),
            "reduced": (STRIDE, maps),
            "complete": (STEP, jets(setting, phase, start, ["speed", "heading", "Dx", "Dy"])),
        }
        self._scales = np.concatenate([self.lengths, [setting.step_length], np.ones(len(pairs))])

    def beside(self, heading: float) -> "Trial":
        """Return the same at another heading."""
        return Trial(self.setting.animal, self.setting.slope, heading, self.family)

    def solve(self, actuation: Floats, near: Floats) -> Solutions:
        """Solve for gaits with actuations ``(N, P)`` from starts ``(N, n)``."""
        return self.problem.solve(near, ACCURACY, GOAL, np.atleast_2d(actuation) * self.lengths)

    def conditions(self, actuation: Floats, z: Floats) -> tuple[Floats, Floats] | None:
        """Return what is left of a gait's conditions, ``(4,)``, and its derivatives by u and z; None if broken."""
        body, legs, start = self._unknowns
        setting, stride = self.setting, self.setting.step_length
        legs[:, ACTUATION, 0] = setting.side * (actuation * self.lengths)[setting.pair]
        legs[:, PHASE, 0] = z[1:][setting.pair]
        start[SPEED, 0], start[HEADING, 0] = z[0] * stride, self.heading
        scale = setting.error_scale(ACCURACY)
        status, walker, _ = run(body, legs, setting.side, setting.offset, NO_PUSH, start, 4, 1.0, scale, 0, 0)
        if status != OK:
            return None
        residual, jacobian = gait_conditions(walker.y, start, stride)
        return residual, jacobian * self._scales

    def look(self, candidates: Floats, what: What) -> Look:
        """Simulate a stride from candidates, ``(N, P + n)``."""
        setting, points = self.setting, np.atleast_2d(candidates)
        kind, (body, legs, start) = self._jets[what]
        ends, down, jacobians, work = look(
            body,
            legs,
            setting.side,
            setting.offset,
            setting.pair,
            self._first,
            self.lengths,
            start,
            setting.step_length,
            setting.error_scale(ACCURACY),
            points,
            kind,
        )
        time, old, functions = ends[:, :, 0], setting.offset != 0.0, np.array(setting.functions)
        fits = np.all((time[:, setting.pair[old]] > 1.0) == (down[:, old] != 0.0), axis=1)
        leaves = np.all(ends[:, :, 1] * functions < 0.0, axis=1)
        cost = work / (setting.weight * setting.step_length)
        return Look(self._angles(points, ends), fits & leaves, cost, jacobians)

    def _angles(self, points: Floats, ends: Floats) -> Floats:
        """Angles between the two lengths where stances begin and end: ``(N, P, 2)``."""
        setting, n = self.setting, len(self.lengths)
        actuation, speed, phase = points[:, :n], points[:, n : n + 1], points[:, n + 1 :]
        swing = np.pi * np.array(setting.functions) * actuation * self.lengths
        free = -np.stack([swing * np.cos(phase), swing * np.cos(np.pi * ends[:, :, 0] + phase)], axis=2)
        length = free + ends[:, :, 1:]
        length[:, :, 0] = -speed * setting.step_length * np.cos(self._placement - self.heading)
        rate = 1.0 / setting.step_duration
        between = np.degrees(np.arctan(length * rate) - np.arctan(free * rate))
        return between * np.array(setting.functions)[:, None] * [1.0, -1.0]


def pair_lengths(animal: Animal) -> Floats:
    """Nominal length of each pair of legs, m."""
    return np.array([next(leg.length for leg in animal.legs if leg.pair == pair) for pair in animal.pairs])
