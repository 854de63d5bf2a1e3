"""Finding the gaits of an animal at one slope and heading.

Where tuned animals are searched: right after touch-down the force of a leg has the sign of the rate of its gap,

    d(|r| - l)/dt = -v cos(beta - heading) - theta' (dx cos(beta) + dy sin(beta)) + ldev (pi/t_des) cos(phi),

so that the leg's function bounds the cosine of its phase: all gaits at initial speeds within `SPEED_RANGE`, and yaw
rates within `YAW_RANGE`, lie in a box (`Problem.phase_range`). Searches start from points spread evenly over that box,
and may well end outside it. A map over slope and heading adds the gaits of neighbouring cells as starts, back and forth
until nothing new turns up (`legspring.sweep`). `benchmarks/audit.py` searches from very many random starts, and finds
nothing else for the thesis's cockroach. That is evidence, and no proof.
"""

import math
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from legspring.checks import MOST_STARTS, checked_angle, checked_whole, shown
from legspring.gait import Gait, Invalid
from legspring.kernel import newton
from legspring.kernel.newton import gait_conditions
from legspring.kernel.walker import EVALUATIONS, Floats
from legspring.layout import ACCURACY, TIGHT, System, slope_for
from legspring.model import Animal
from legspring.progress import progress_bar
from legspring.returnmap import Direction, Start, flow, jets

STARTS = 96
"""Starts for each family."""
SPEED_RANGE = 0.6, 1.4
"""Initial speeds to start from, in units of the desired one."""
YAW_RANGE = np.array([0.2, 0.4])
"""Largest yaw (rad) and yaw rate (rad per step duration) to start from, where the body yaws."""
SLACK = 0.15
"""Allowance on the cosine of the phase for what a force does in the ignored window."""
ROUGH_ACCURACY, ROUGH_GOAL = 1e-8, 1e-7
GOAL = 1e-12
MOST_ITERATIONS = 40
AT_ONCE = 8
"""Starts between two looks at the effort so far."""
MOST_EFFORT = 100_000_000
"""Evaluations of the equations of motion after which the search for one family begins from no more starts."""
SAME = 1e-5
"""Difference of unknowns below which two solutions are one."""


class Ending(StrEnum):
    """How a search from one start ended."""

    CONVERGED = "converged"
    STALLED = "stalled at a local minimum of the residuals"
    OUT_OF_RANGE = "left the range of speeds"
    OUT_OF_STEPS = "not converged within the iterations allowed"
    BROKEN = "the step could not be simulated"
    GIVEN_UP = "not searched from, as the search had taken all the effort that is allowed"


ENDINGS = {
    newton.CONVERGED: Ending.CONVERGED,
    newton.STALLED: Ending.STALLED,
    newton.OUT_OF_RANGE: Ending.OUT_OF_RANGE,
    newton.OUT_OF_STEPS: Ending.OUT_OF_STEPS,
    newton.BROKEN: Ending.BROKEN,
}


@dataclass(frozen=True)
class Rejection:
    """A solution of the conditions that is no gait.

    Attributes
    ----------
    reason, leg
        What is wrong, and with which leg.
    solution
        The would-be gait.
    """

    reason: Invalid
    leg: str
    solution: Gait

    def __str__(self) -> str:
        """One line."""
        phases = ", ".join(f"{math.degrees(angle):.1f}" for angle in self.solution.phase)
        return f"family {self.solution.family}, phases {phases} deg: {self.reason} ({self.leg})"


@dataclass(frozen=True)
class Search:
    """What a search for gaits found.

    Attributes
    ----------
    gaits
        By branch.
    rejections
        Solutions that are no gaits.
    endings
        How many starts ended in which way.
    steps
        Steps simulated.
    """

    gaits: tuple[Gait, ...]
    rejections: tuple[Rejection, ...]
    endings: dict[Ending, int]
    steps: int

    @property
    def starts(self) -> int:
        """Number of starting points."""
        return sum(self.endings.values())

    def summary(self) -> str:
        """Say what was rejected and why, and how the starts ended, a line each."""
        details: dict[tuple[str, str], list[str]] = {}
        for rejection in self.rejections:
            details.setdefault((rejection.solution.family, str(rejection.reason)), []).append(rejection.leg)
        lines = [
            f"rejected, family {family}: {len(legs)} x {reason} ({legs[0]}{', ...' if len(set(legs)) > 1 else ''})"
            for (family, reason), legs in sorted(details.items())
        ]
        ends = ", ".join(f"{count} {ending}" for ending, count in self.endings.items())
        return "\n".join([*lines, f"{self.starts} starts: {ends}"])


class Solutions(NamedTuple):
    """Where searches ended: unknowns, kind of ending, largest residual, sum of their squares; and effort in all.

    Which is the number of steps simulated, and that of evaluations of the equations of motion.
    """

    z: Floats
    endings: NDArray[np.int64]
    residuals: Floats
    squares: Floats
    steps: int
    evaluations: int


def spread(count: int, low: Floats, high: Floats) -> Floats:
    """Return points spread evenly over a box, the same every time: ``(count, n)``."""
    # A lattice of the golden ratio's kin (R sequence): even, and the same every time.
    root = 1.5
    for _ in range(50):
        root = (1.0 + root) ** (1.0 / (low.size + 1))
    steps = root ** -np.arange(1.0, low.size + 1)
    unit = (0.5 + np.outer(np.arange(1, count + 1), steps)) % 1.0
    return low + (high - low) * unit


class BaseProblem(ABC):
    """Conditions of a gait, ready to be solved; the unknowns are a vector."""

    system: System
    family: str
    finest, goal = TIGHT, GOAL
    """Accuracy and largest residual of gaits."""

    @property
    @abstractmethod
    def size(self) -> int:
        """Number of unknowns."""

    @abstractmethod
    def starts(self, count: int) -> Floats:
        """Return starting points spread evenly over where gaits can be: ``(count, size)`` or none at all."""

    @abstractmethod
    def solve(self, starts: Floats, accuracy: float, goal: float) -> Solutions:
        """Search from each start, ``(N, size)``."""

    @abstractmethod
    def wrapped(self, z: Floats) -> Floats:
        """Return the same unknowns with angles in (-pi, pi]."""

    @abstractmethod
    def unknowns(self, gait: Gait) -> Floats:
        """Return a gait's unknowns, to start from."""

    @abstractmethod
    def candidate(self, z: Floats, residual: float = math.nan) -> Gait:
        """Return unknowns in the form of a gait, whether they are one or not."""

    @abstractmethod
    def gait_near(self, z: Floats) -> tuple[Gait | None, float]:
        """Return the solution near z as a gait, valid or not, or None; and the sum of squared residuals left."""

    def zeros(
        self, starts: Floats, known: Floats | None = None, tick: Callable[[int], None] = lambda _: None
    ) -> tuple[Floats, "Counter[Ending]", int]:
        """Search from each start, roughly; no more once the equations of motion were evaluated `MOST_EFFORT` times.

        Returns
        -------
        zeros, endings, steps
            ``(n, size)``: the solutions, the known ones first; how the starts ended; the number of steps simulated.
        """
        zeros = np.zeros((0, self.size)) if known is None else known
        endings, steps, effort = Counter[Ending](), 0, 0
        for some in np.split(starts, range(AT_ONCE, len(starts), AT_ONCE)) if len(starts) else ():
            tick(len(some))
            if effort > MOST_EFFORT:
                endings[Ending.GIVEN_UP] += len(some)
                continue
            found = self.solve(some, ROUGH_ACCURACY, ROUGH_GOAL)
            steps, effort = steps + found.steps, effort + found.evaluations
            endings.update(ENDINGS[int(ending)] for ending in found.endings)
            for z in found.z[found.endings == newton.CONVERGED]:
                if not self._is_among(z, zeros):
                    zeros = np.vstack([zeros, z])
        return zeros, endings, steps

    def gait(self, z: Floats) -> Gait | None:
        """Return the solution near z as a gait, valid or not; None if there is none after all."""
        rough = self.solve(z, ACCURACY, GOAL).z[0]
        gait, _ = self.gait_near(rough)
        if gait is None:
            return None
        return replace(gait, drift=float(np.max(np.abs(self.wrapped(self.unknowns(gait) - rough)))))

    def sort(self, zeros: Floats) -> tuple[list[Gait], list[Rejection]]:
        """Tell gaits from solutions that are none; two rough solutions may prove to be one."""
        gaits: list[Gait] = []
        rejections: list[Rejection] = []
        met = np.zeros((0, self.size))
        for z in zeros:
            solution = self.gait(z)
            if solution is None:
                rejections.append(Rejection(Invalid.UNCONFIRMED, f"accuracy {self.finest:g}", self.candidate(z)))
                continue
            fine = self.unknowns(solution)
            if self._is_among(fine, met):
                continue
            met = np.vstack([met, fine])
            problem = solution.invalid()
            if problem is None:
                gaits.append(solution)
            else:
                rejections.append(Rejection(*problem, solution))
        return gaits, rejections

    def _is_among(self, z: Floats, others: Floats) -> bool:
        """Whether a solution is one of those in the rows of ``others``."""
        return bool(np.any(np.all(np.abs(self.wrapped(z - others)) < SAME, axis=1)))


def check_tuned(animal: Animal, purpose: str) -> None:
    """Raise ValueError unless an animal's legs are tuned to its desired speed."""
    if not animal.tuned:
        raise ValueError(
            f"animal = {animal.name!r}: must have actuated legs whose phases are not given {purpose}; this one's gaits "
            "have speeds and headings of their own"
        )


def check_offsets(animal: Animal) -> None:
    """Raise ValueError unless every pair has a leg for each step."""
    for pair in animal.pairs:
        if not {0.0, 1.0} == {leg.offset for leg in animal.legs if leg.pair == pair}:
            raise ValueError(
                f"pair {pair!r} of animal {animal.name!r}: a gait that mirrors itself from step to step needs one leg "
                "that touches down at offset 0 and one at offset 1"
            )


class Problem(BaseProblem):
    """The conditions of a gait for one family at one slope and heading, ready to be solved.

    The unknowns are a vector: initial speed in units of the desired one, the phase of each pair of legs (rad), and,
    where the body yaws, yaw (rad) and yaw rate (rad per step duration).
    """

    def __init__(
        self, animal: Animal, slope: float, heading: float, family: str, actuation: ArrayLike | None = None
    ) -> None:
        check_tuned(animal, "for a gait at a given heading")
        if len(animal.pairs) != 3:
            raise ValueError(
                f"animal = {animal.name!r} has {len(animal.pairs)} pairs of legs: the four conditions of a gait fix "
                "the speed and the phases of exactly three"
            )
        if given := [leg for leg in animal.legs if leg.phase is not None]:
            raise ValueError(
                f"phase = {given[0].phase!r} of pair {given[0].pair!r} of animal {animal.name!r}: must be left out, or "
                "given for all pairs; the conditions of a gait at a given heading fix all three phases"
            )
        self.system = System(animal, slope, animal.functions(family), actuation)
        self.heading = checked_angle("heading", heading, math.pi / 2)
        self.family = family
        system = self.system
        check_offsets(animal)
        self._walker, self._start = newton.new_problem(
            system.body,
            system.legs(np.zeros(len(animal.pairs))),
            system.side,
            system.offset,
            system.pair,
            self.heading,
            system.step_length,
            system.rows,
        )

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return 1 + len(self.system.animal.pairs) + (2 if self.system.rows == 6 else 0)

    def phase_range(self) -> Floats:
        """Largest magnitude of the phase of each pair in any gait, ``(P,)``, rad; nan where there is no gait.

        Only legs as the thesis has them begin with a force whose sign the phase decides.
        """
        system, fastest = self.system, SPEED_RANGE[1] * self.system.step_length
        spin = YAW_RANGE[1] if system.rows == 6 else 0.0
        bound = np.full(len(system.actuation), -1.0)
        for leg, pair, side, offset in zip(
            system.animal.legs, system.animal.pair_of, system.side, system.offset, strict=True
        ):
            if offset == 0.0 and system.actuation[pair] > 0.0 and leg.plain:
                along = side * math.cos(leg.angle - self.heading)
                speed = fastest if along < 0.0 else SPEED_RANGE[0] * system.step_length
                lever = leg.hip[0] * math.cos(leg.angle) + leg.hip[1] * math.sin(leg.angle)
                rate = along * speed - abs(lever) * spin
                bound[pair] = rate / (math.pi * system.actuation[pair]) - SLACK
        bound[bound > 1.0] = math.nan
        return np.arccos(np.clip(bound, -1.0, 1.0))

    def starts(self, count: int) -> Floats:
        """Return starting points spread evenly over where gaits can be: ``(count, size)`` or none at all."""
        limits = self.phase_range()
        if np.any(np.isnan(limits)):
            return np.zeros((0, self.size))
        low = np.concatenate([[SPEED_RANGE[0]], -limits, -YAW_RANGE])[: self.size]
        high = np.concatenate([[SPEED_RANGE[1]], limits, YAW_RANGE])[: self.size]
        return spread(count, low, high)

    def solve(self, starts: Floats, accuracy: float, goal: float, actuation: Floats | None = None) -> Solutions:
        """Search from each start, ``(N, size)``, with the problem's actuation or one for each, ``(N, P)``."""
        z = np.array(starts, dtype=float, ndmin=2)
        system = self.system
        magnitudes = np.array(system.actuation if actuation is None else actuation, ndmin=2)
        endings, residuals, squares, steps = newton.find_zeros(
            self._walker,
            self._start,
            system.pair,
            system.step_length,
            np.broadcast_to(magnitudes, (len(z), magnitudes.shape[1])).copy(),
            z,
            system.error_scale(accuracy),
            goal,
            MOST_ITERATIONS,
        )
        evaluations, self._walker.clock[EVALUATIONS] = int(self._walker.clock[EVALUATIONS]), 0.0
        return Solutions(self.wrapped(z), endings, residuals, squares, steps, evaluations)

    def conditions(self, z: Floats) -> tuple[Floats, Floats]:
        """Return what is left of a gait's conditions at z, ``(size,)``, and its derivatives, ``(size, size)``.

        Raises
        ------
        legspring.returnmap.IntegrationError
            If the step cannot be simulated.
        """
        system, n = self.system, len(self.system.animal.pairs)
        yaw, yaw_rate = (z[n + 1], z[n + 2] / system.step_duration) if system.rows == 6 else (0.0, 0.0)
        start = Start(z[0] * system.desired_speed, self.heading, yaw=yaw, yaw_rate=yaw_rate)
        along: list[Direction] = ["speed", *(("phase", pair) for pair in system.animal.pairs)]
        along += ["yaw", "yaw_rate", "turn"] if system.rows == 6 else []
        y = flow(system, z[1 : n + 1], start, along=along, accuracy=TIGHT)[0].y
        start_jet = jets(system, z[1 : n + 1], start, along)[2]
        residual, jacobian = gait_conditions(y, start_jet, system.step_length)
        jacobian[:, 0] *= system.step_length
        if system.rows == 6:
            # A gait that starts with more yaw has turned twice as much more in the step before.
            jacobian[:, n + 1] += 2.0 * jacobian[:, -1]
        return residual, jacobian[:, : self.size]

    def wrapped(self, z: Floats) -> Floats:
        """Return the same unknowns with phases in (-pi, pi]."""
        phases = slice(1, 1 + len(self.system.animal.pairs))
        z = z.copy()
        z[..., phases] = math.pi - (math.pi - z[..., phases]) % (2.0 * math.pi)
        return z

    def unknowns(self, gait: Gait) -> Floats:
        """Return a gait's unknowns, to start from."""
        yaw = (gait.yaw, gait.yaw_rate * self.system.step_duration) if self.system.rows == 6 else ()
        return np.array([gait.speed / self.system.desired_speed, *gait.phase, *yaw])

    def gait_near(self, z: Floats) -> tuple[Gait | None, float]:
        """Return the solution near z as a gait, valid or not, or None; and the sum of squared residuals left."""
        found = self.solve(z, TIGHT, GOAL)
        fine, squares = found.z[0], float(found.squares[0])
        # The last digits may not be had; what counts is that the conditions are met.
        if not found.residuals[0] < 100.0 * GOAL:
            return None, squares
        return self.candidate(fine, float(found.residuals[0])), squares

    def candidate(self, z: Floats, residual: float = math.nan) -> Gait:
        """Return unknowns in the form of a gait, whether they are one or not."""
        system, n = self.system, len(self.system.animal.pairs)
        yaw, yaw_rate = (float(z[n + 1]), float(z[n + 2])) if system.rows == 6 else (0.0, 0.0)
        return Gait(
            animal=system.animal,
            slope=system.slope,
            heading=self.heading,
            family=self.family,
            speed=float(z[0] * system.desired_speed),
            phase=tuple(float(angle) for angle in z[1 : n + 1]),
            actuation=system.actuation,
            residual=residual,
            yaw=yaw,
            yaw_rate=yaw_rate / system.step_duration,
        )


def hindmost(animal: Animal) -> int:
    """Index of the pair of legs whose nominal feet are furthest back."""
    feet = [leg.hip[1] + leg.length * math.cos(leg.angle) for leg in animal.legs]
    return animal.pair_of[int(np.argmin(feet))]


def number_branches(gaits: Sequence[Gait]) -> tuple[Gait, ...]:
    """Give the gaits of one cell their branch, by the phase of the hindmost legs, or heading, most negative first."""
    if not gaits:
        return ()
    pair = hindmost(gaits[0].animal)
    ordered = sorted(gaits, key=lambda gait: (gait.phase[pair], gait.heading))
    return tuple(replace(gait, branch=number) for number, gait in enumerate(ordered))


def problem_for(
    animal: Animal, slope: float, heading: float | None, family: str, actuation: ArrayLike | None
) -> BaseProblem:
    """Return the conditions of a gait of one family.

    Raises
    ------
    ValueError
        If there is a heading, or an actuation, where gaits have their own, or no heading where they have none.
    """
    from legspring.periodic import PeriodicProblem

    if animal.tuned:
        if heading is None:
            raise ValueError("heading is missing: must be an angle in rad, within +-pi/2")
        return Problem(animal, slope, heading, family, actuation)
    for name, value in (("heading", heading), ("actuation", actuation)):
        if value is not None:
            raise ValueError(
                f"{name} = {shown(value)}: must be left out for {animal.name!r}, whose gaits have their own"
            )
    return PeriodicProblem(animal, slope, family)


def search_gaits(
    animal: Animal,
    *,
    heading: float | None = None,
    slope: float | None = None,
    slope_deg: float | None = None,
    family: str | None = None,
    actuation: ArrayLike | None = None,
    starts: int = STARTS,
    progress: bool = False,
) -> Search:
    """Search for gaits at one slope and heading, and say what was found on the way.

    Parameters
    ----------
    animal
        The animal.
    heading
        rad, within +-pi/2; not to be given for an animal that is not tuned to its desired speed: its gaits have theirs.
    slope, slope_deg
        Either of them; rad or degrees. Not needed where the animal's speed law is for one slope only.
    family
        Only gaits of this family are returned; branches are numbered over all.
    actuation
        Magnitudes for each pair of legs, m; by default the animal's.
    starts
        Starting points for each family. No more are used once the equations of motion were evaluated 1e8 times, which
        takes about half a minute; how many were not is said among the endings.
    progress
        Whether to show a progress bar.

    Raises
    ------
    ValueError
        For an angle out of range, an unknown family, or an animal whose gaits have other unknowns.
    """
    angle, starts = slope_for(animal, slope, slope_deg), checked_whole("starts", starts, 1, MOST_STARTS)
    if family is not None:
        animal.functions(family)
    gaits: list[Gait] = []
    rejections: list[Rejection] = []
    steps, endings = 0, Counter[Ending]()
    problems = [problem_for(animal, angle, heading, label, actuation) for label in animal.families]
    points = [problem.starts(starts) for problem in problems]
    with progress_bar("searching for gaits", sum(map(len, points)), show=progress) as tick:
        for problem, some in zip(problems, points, strict=True):
            zeros, ends, taken = problem.zeros(some, tick=tick)
            valid, invalid = problem.sort(zeros)
            gaits += valid
            rejections += invalid
            endings += ends
            steps += taken
    numbered = number_branches(gaits)
    if family is not None:
        numbered = tuple(gait for gait in numbered if gait.family == family)
        rejections = [rejection for rejection in rejections if rejection.solution.family == family]
    return Search(numbered, tuple(rejections), dict(endings), steps)


def find_gaits(
    animal: Animal,
    *,
    heading: float | None = None,
    slope: float | None = None,
    slope_deg: float | None = None,
    family: str | None = None,
    actuation: ArrayLike | None = None,
    starts: int = STARTS,
) -> list[Gait]:
    """Find the gaits at one slope and heading, by branch; the list is empty where the search finds none.

    Parameters and errors are those of `search_gaits`, which also says what was rejected and why.

    Examples
    --------
    >>> import legspring as ls
    >>> gait = ls.find_gaits(ls.cockroach(), slope_deg=45, heading=0.15)[0]
    >>> gait.family, round(gait.speed, 4)
    ('B', 0.2731)
    """
    search = search_gaits(
        animal,
        heading=heading,
        slope=slope,
        slope_deg=slope_deg,
        family=family,
        actuation=actuation,
        starts=starts,
    )
    return list(search.gaits)
