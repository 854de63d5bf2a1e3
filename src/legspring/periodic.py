"""Gaits of animals whose legs are not tuned to a speed: whatever repeats itself.

The unknowns are the state at the start of a step. Nothing but the return map is asked about: it maps a gait to itself.
Where energy is conserved there is a gait at every speed, and the desired one is that of the start of a step.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np
from scipy.optimize import least_squares

from legspring.gait import Gait
from legspring.kernel import newton
from legspring.kernel.newton import FASTEST, SLOWEST
from legspring.kernel.walker import EVALUATIONS, Floats
from legspring.layout import System
from legspring.model import Animal
from legspring.returnmap import IntegrationError, Start, flow, image_of, state_names
from legspring.solve import BaseProblem, Solutions, check_offsets, spread

BROKEN = 1e3
"""Residual where a step cannot be simulated."""
MOST_EVALUATIONS = 60
ANGLES = ("heading", "yaw")
"""Unknowns that are the same after a whole turn."""
RANGES = {
    "speed": (0.5, 1.5),
    "heading": (-1.0, 1.0),
    "Dx": (-0.5, 0.5),
    "Dy": (0.5, 1.5),
    "yaw": (-0.4, 0.4),
    "yaw_rate": (-1.0, 1.0),
    "turn": (-0.8, 0.8),
}
"""Where searches start, in units of v_des, t_des (where steps end at touch-downs: of the time for a leg's length) and
rad, in the order of a start; an animal whose legs have no mirror images may go anywhere."""


class PeriodicProblem(BaseProblem):
    """The conditions of a gait that repeats itself, for one family on one slope.

    The unknowns are those of `legspring.returnmap.complete_map`, in units of v_des and t_des, but for the speed where
    energy is conserved.
    """

    def __init__(self, animal: Animal, slope: float, family: str) -> None:
        self.system = System(animal, slope, animal.functions(family))
        self.family = family
        self._check_steps()
        self.names = state_names(self.system, memory=not self.system.event_driven)
        # Where energy is conserved, the speed comes back if the rest does.
        kept = {"speed"} if "energy" in self.system.conserved else set()
        # A body that nothing turns is one that does not turn, and any yaw will do; so it does where all directions are
        # alike. That the body does not turn there is left to `legspring.repetition`.
        if "yaw_rate" in self.system.conserved:
            kept |= {"yaw", "yaw_rate"}
        elif self.system.isotropic and not self.system.mirrored:
            kept.add("yaw")
        self.free = [name for name in self.names if name not in kept]
        length = self.system.step_length
        units = dict.fromkeys(("speed", "Dx", "Dy"), length)
        if self.system.event_driven:
            # The step duration is a unit of time that somebody has chosen: turning is measured by the speed.
            units["yaw_rate"] = length / max(leg.length for leg in animal.legs)
        self._units = [units.get(name, 1.0) for name in self.names]
        self._rows = [self.names.index(name) for name in self.free]

    def _check_steps(self) -> None:
        """Insist on steps that either mirror one another or are all alike."""
        animal = self.system.animal
        if self.system.steps_per_stride == 2:
            check_offsets(animal)
        elif any(leg.offset for leg in animal.legs):
            raise ValueError(
                f"animal = {animal.name!r}: must have legs of offset 0, or in pairs, for steps to be alike"
            )

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return len(self.free)

    def starts(self, count: int) -> Floats:
        """Return starting points spread evenly over where gaits may be: ``(count, size)``."""
        ranges = RANGES if self.system.mirrored else RANGES | {"heading": (-math.pi, math.pi)}
        low, high = np.array([ranges[name] for name in self.free]).T
        return spread(count, low, high)

    def start(self, z: Floats) -> Start:
        """Return the start of a step with some unknowns."""
        units = dict(zip(self.names, self._units, strict=True))
        state = dict(units)
        state |= {name: 0.0 for name in ("heading", "yaw", "yaw_rate") if name in state}
        state |= {name: units[name] * value for name, value in zip(self.free, z.tolist(), strict=True)}
        duration = self.system.step_duration
        displacement = (state["Dx"], state["Dy"]) if "Dx" in state else None
        yaws = {"yaw": state["yaw"], "yaw_rate": state["yaw_rate"] / duration} if "yaw" in state else {}
        turn = state.get("turn", 0.0)
        return Start(state["speed"] / duration, state["heading"], displacement, **yaws, turn=turn)

    def residual(self, z: Floats, accuracy: float) -> tuple[Floats, Floats]:
        """Return what a step changes in the unknowns, ``(n,)``, and its derivatives."""
        return self._residual(z, accuracy)[:2]

    def _in_range(self, z: Sequence[float] | Floats) -> bool:
        """Whether the speed is from 0.2 to 5 times that of the speed law, further from which nothing is looked for."""
        return "speed" not in self.free or SLOWEST < z[self.free.index("speed")] < FASTEST

    def _residual(self, z: Floats, accuracy: float) -> tuple[Floats, Floats, int]:
        """Return the same, and how often the equations of motion were evaluated."""
        broken = np.full(self.size, BROKEN), np.eye(self.size)
        if not self._in_range(z):
            return *broken, 0
        start, phase = self.start(z), self.system.animal.phase
        try:
            walker, _ = flow(self.system, phase, start, along=self.names, accuracy=accuracy)
        except IntegrationError as error:
            return *broken, error.evaluations
        except ValueError:
            return *broken, 0
        image, jacobian = image_of(self.system, start, self.names, walker.y)
        units = np.array(self._units)
        by = jacobian * units / units[:, None]
        left = image[self._rows] / units[self._rows] - z
        for row, name in enumerate(self.free):
            if name in ANGLES:
                left[row] = math.remainder(left[row], 2.0 * math.pi)
        by = by[np.ix_(self._rows, self._rows)] - np.eye(self.size)
        return left, by, int(walker.clock[EVALUATIONS])

    def solve(self, starts: Floats, accuracy: float, goal: float) -> Solutions:
        """Search from each start, ``(N, size)``."""
        found = [self._solve(z, accuracy, goal) for z in np.array(starts, ndmin=2)]
        z, endings, residuals, squares, steps, evaluations = (np.array(column) for column in zip(*found, strict=True))
        return Solutions(self.wrapped(z), endings, residuals, squares, int(steps.sum()), int(evaluations.sum()))

    def _solve(self, z: Floats, accuracy: float, goal: float) -> tuple[Floats, int, float, float, int, int]:
        """Search from one start."""
        evaluations, strayed = 0, False

        # The method asks for values and derivatives at the same place, one after the other.
        @lru_cache(maxsize=1)
        def at(z: tuple[float, ...]) -> tuple[Floats, Floats]:
            nonlocal evaluations, strayed
            left, by, taken = self._residual(np.array(z), accuracy)
            evaluations, strayed = evaluations + taken, strayed or not self._in_range(z)
            return left, by

        found = least_squares(
            lambda z: at(tuple(z))[0],
            z,
            lambda z: at(tuple(z))[1],
            method="lm",
            ftol=1e-15,
            xtol=1e-15,
            gtol=1e-15,
            max_nfev=MOST_EVALUATIONS,
        )
        largest = float(np.max(np.abs(found.fun)))
        ending = newton.BROKEN if largest >= BROKEN else newton.OUT_OF_RANGE if strayed else newton.STALLED
        ending = newton.CONVERGED if largest <= goal else ending
        return found.x, ending, largest, float(np.sum(found.fun**2)), found.nfev, evaluations

    def wrapped(self, z: Floats) -> Floats:
        """Return the same unknowns with heading and yaw in (-pi, pi].

        Where all directions are alike, a gait whose steps mirror one another is the same turned by half a turn.
        """
        z = z.copy()
        for column, name in enumerate(self.free):
            if name in ANGLES:
                turn = math.pi if name == "yaw" and self.system.isotropic else 2.0 * math.pi
                z[..., column] = 0.5 * turn - (0.5 * turn - z[..., column]) % turn
        return z

    def unknowns(self, gait: Gait) -> Floats:
        """Return a gait's unknowns, to start from."""
        start = gait.start.in_kernel_units(self.system)
        turn = 2.0 * gait.yaw if self.system.mirrored else 0.0
        values = dict(zip(("speed", "heading", "Dx", "Dy", "yaw", "yaw_rate", "turn"), start, strict=True)) | {
            "turn": turn
        }
        units = dict(zip(self.names, self._units, strict=True))
        return np.array([values[name] / units[name] for name in self.free])

    def gait_near(self, z: Floats) -> tuple[Gait | None, float]:
        """Return the solution near z as a gait, valid or not, or None; and the sum of squared residuals left."""
        found = self.solve(z, self.finest, self.goal)
        squares, residual = float(found.squares[0]), float(found.residuals[0])
        if not residual < 100.0 * self.goal:
            return None, squares
        by = self.residual(found.z[0], self.finest)[1]
        isolation = float(np.linalg.svd(by, compute_uv=False)[-1])
        return replace(self.candidate(found.z[0], residual), isolation=isolation), squares

    def candidate(self, z: Floats, residual: float = math.nan) -> Gait:
        """Return unknowns in the form of a gait, whether they are one or not."""
        system, start = self.system, self.start(z)
        return Gait(
            animal=system.animal,
            slope=system.slope,
            heading=start.heading,
            family=self.family,
            speed=start.speed,
            phase=system.animal.phase,
            actuation=system.animal.actuation,
            residual=residual,
            yaw=start.yaw,
            yaw_rate=start.yaw_rate,
            displacement=start.displacement,
        )
