"""Finding the gaits of an animal at one slope and heading.

Where tuned animals are searched: right after touch-down the force of a leg has the sign of the rate of its gap,

    d(|r| - l)/dt = -v cos(beta - heading) - theta' (dx cos(beta) + dy sin(beta)) + ldev (pi/t_des) cos(phi),

so that the leg's function bounds the cosine of its phase: all gaits at initial speeds, and yaw
rates within `NARROW`, lie in a box (`GaitProblem.box`). Searches start from points spread evenly over that box,
and may well end outside it. A map over slope and heading adds the gaits of neighbouring cells as starts, back and forth
until nothing new turns up (`legspring.mapping`). `benchmarks/audit.py` searches from very many random starts, and finds
nothing else for the thesis's cockroach. That is evidence, and no proof.
"""

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from legspring.asking import checked_targets, problems_for
from legspring.checks import MOST_STARTS, checked_angle, checked_names, checked_whole, shown
from legspring.flow import NO_PUSH
from legspring.gait import Gait, Invalid
from legspring.kernel import newton
from legspring.kernel.walker import Floats
from legspring.layout import ACCURACY, TIGHT, System, slope_for
from legspring.model import Animal, ModelError
from legspring.problem import GaitProblem
from legspring.progress import progress_bar
from legspring.starts import ROUGH_ACCURACY, contacts_then, starts_for

STARTS = 96
"""Starts for each family."""
ROUGH_GOAL = 1e-7
GOAL = 1e-12
MOST_ITERATIONS = 40
AT_ONCE = 8
"""Starts between two looks at the effort so far."""
MOST_EFFORT = 100_000_000
"""Evaluations of the equations of motion after which the search for one family begins from no more starts."""
MOST_SETTLINGS = 4
ALL = "all"
"""In place of a family: all ways in which legs may push and pull."""
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
class Origin:
    """What a gait is a solution of; and how it moves if something else is varied."""

    problem: GaitProblem

    @property
    def free(self) -> tuple[str, ...]:
        """Parameters that were let go."""
        return self.problem.free

    @property
    def given(self) -> Mapping[str, float | str]:
        """What was asked for."""
        return self.problem.given

    def rates(self, gait: Gait, names: Sequence[str]) -> Floats:
        """Return the derivatives of all of a gait's parameters by some of them, ``(D, n)``; exact."""
        problem, gait = self.loosened(gait, names)
        return problem.rates(problem.z_of(gait), names)

    def moved(self, gait: Gait, name: str, amount: float) -> Gait | None:
        """Return the gait where a parameter, or what was given, has changed by so much; None if it is not found."""
        if not self.lasts(gait, name, amount):
            return None
        rates = self.rates(gait, [name])[0]
        problem, gait = self.loosened(gait, [name])
        given = dict(problem.given)
        if name in given:
            given[name] = float(problem.wanted(name)) + amount
        other = replace(problem, system=self._changed(problem.system, name, amount), given=given)
        z = (gait.point + amount * rates)[[other.places[one] for one in other.unknowns]] / other.units
        return gait_near(other, z)

    def lasts(self, gait: Gait, name: str, amount: float) -> bool:
        """Whether there is such an animal, and it keeps what this one keeps: energy, for instance."""
        problem, _ = self.loosened(gait, [name])
        try:
            return self._changed(problem.system, name, amount).conserved == problem.system.conserved
        except ValueError:
            return False

    def _changed(self, system: System, name: str, amount: float) -> System:
        """Return an animal on its slope of which a parameter has changed by so much."""
        if name in self.problem.given:
            return system
        if name.startswith("slope"):
            return replace(system, slope=system.slope + (math.radians(amount) if name == "slope_deg" else amount))
        here = float(system.values[system.place_of(name)])
        return replace(system, animal=system.animal.replace(**{name: here + amount}))

    def loosened(self, gait: Gait, names: Sequence[str]) -> tuple[GaitProblem, Gait]:
        """Return problem and gait with the gait's own animal and, if offsets vary, each foot remembered for itself."""
        own, problem = gait.actuation == gait.animal.actuation, self.problem
        animal = gait.animal if own else gait.animal.replace(actuation=gait.actuation)
        gait, system = replace(gait, animal=animal), replace(problem.system, animal=animal, actuation=None)
        if any(name.endswith("offset") for name in names):
            gait = remembering(gait)
            system = replace(system, contacts=gait.contacts, apart=True)
            gait = replace(gait, remembered=tuple(float(gait.point[system.place_of(name)]) for name in system.memory))
        return replace(problem, system=system), gait


def remembering(gait: Gait) -> Gait:
    """Return a gait with what is remembered of each foot in place of the step before."""
    if gait.contacts is not None:
        return gait
    legs, down = gait.animal.legs, gait.stride.down_at_start
    old = tuple(leg.name for leg, is_down in zip(legs, down, strict=True) if is_down and leg.offset > 0.0)
    system = replace(gait.system, contacts=old)
    before = dict(zip(("Dx", "Dy", "turn"), gait.point[[2, 3, 6]], strict=True))
    own = [name for name in system.memory if "." in name]
    agos = {leg.name: 2.0 - leg.offset for leg in legs}
    values = [agos[name.split(".")[0]] * float(before[name.split(".")[1]]) for name in own]
    return replace(gait, contacts=old, remembered=tuple(values), displacement=None, turn=None)


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


def solve(problem: GaitProblem, starts: Floats, accuracy: float, goal: float, base: Floats | None = None) -> Solutions:
    """Solve a problem's conditions from some starts.

    Parameters
    ----------
    problem
        What is to be solved.
    starts
        ``(N, size)``.
    accuracy
        Relative accuracy of the states.
    goal
        Largest residual to be reached.
    base
        ``(N, n)``: parameters where the unknowns are zero, if others than the problem's.
    """
    z, system, task = np.array(starts, dtype=float, ndmin=2), problem.system, problem.task
    p = np.repeat(problem.base[None], len(z), axis=0) if base is None else base
    walker = system.walker(problem.size, NO_PUSH)
    room, count = newton.new_workspace(task, walker), len(z)
    whole, real = np.zeros((3, count), np.int64), np.zeros((2, count))
    found = newton.Found(whole[0], real[0], real[1], whole[1], whole[2])
    scale, steps = system.error_scale(accuracy), system.period
    newton.find_zeros(walker, task, p, z, steps, scale, goal, MOST_ITERATIONS, room, found)
    steps, evaluations = int(found.steps.sum()), int(found.evaluations.sum())
    return Solutions(problem.wrapped(z), found.endings, found.residuals, found.squares, steps, evaluations)


def zeros(
    problem: GaitProblem,
    starts: Floats,
    known: Floats | None = None,
    tick: Callable[[int], None] = lambda _: None,
) -> tuple[Floats, "Counter[Ending]", int]:
    """Search from each start, roughly; no more once the equations of motion were evaluated `MOST_EFFORT` times.

    Returns
    -------
    zeros, endings, steps
        ``(n, size)``: the solutions, the known ones first; how the starts ended; the number of steps simulated.
    """
    zeros = np.zeros((0, problem.size)) if known is None else known
    endings, steps, effort = Counter[Ending](), 0, 0
    for some in np.split(starts, range(AT_ONCE, len(starts), AT_ONCE)) if len(starts) else ():
        tick(len(some))
        if effort > MOST_EFFORT:
            endings[Ending.GIVEN_UP] += len(some)
            continue
        found = solve(problem, some, ROUGH_ACCURACY, ROUGH_GOAL)
        steps, effort = steps + found.steps, effort + found.evaluations
        endings.update(ENDINGS[int(ending)] for ending in found.endings)
        for z in found.z[found.endings == newton.CONVERGED]:
            if not is_among(problem, z, zeros):
                zeros = np.vstack([zeros, z])
    return zeros, endings, steps


def gait_near(problem: GaitProblem, z: Floats) -> Gait | None:
    """Return the solution near z as a gait, valid or not, to the last digits; None if there is none."""
    found = solve(problem, z, TIGHT, GOAL)
    # The last digits may not be had; what counts is that the conditions are met.
    if not found.residuals[0] < 100.0 * GOAL:
        return None
    by = problem.residual(found.z, accuracy=TIGHT)[1][0]
    if not np.all(np.isfinite(by)):
        return None
    isolation = float(np.linalg.svd(by, compute_uv=False)[-1])
    gait = problem.gait(found.z[0], float(found.residuals[0]))
    return replace(gait, isolation=isolation, origin=Origin(problem))


def refined(problem: GaitProblem, z: Floats) -> Gait | None:
    """Return the solution near z as a gait, valid or not, with its drift; None if there is none after all."""
    rough = solve(problem, z, ACCURACY, GOAL).z[0]
    gait = gait_near(problem, rough)
    if gait is None:
        return None
    return replace(gait, drift=float(np.max(np.abs(problem.wrapped(problem.z_of(gait) - rough)))))


def sort(problem: GaitProblem, zeros: Floats) -> tuple[list[Gait], list[Rejection]]:
    """Tell gaits from solutions that are none; two rough solutions may prove to be one."""
    gaits: list[Gait] = []
    rejections: list[Rejection] = []
    met = np.zeros((0, problem.size))
    for z in zeros:
        try:
            solution, rough = refined(problem, z), problem.gait(z)
        except ModelError as error:
            rejections.append(Rejection(Invalid.NO_ANIMAL, str(error), problem.gait(z, animal=problem.system.animal)))
            continue
        if solution is None:
            rejections.append(Rejection(Invalid.UNCONFIRMED, f"accuracy {TIGHT:g}", rough))
            continue
        fine = problem.z_of(solution)
        if is_among(problem, fine, met):
            continue
        met = np.vstack([met, fine])
        _, solution = settled(problem, solution)
        reason = solution.invalid()
        if reason is None:
            gaits.append(solution)
        else:
            rejections.append(Rejection(*reason, solution))
    return gaits, rejections


def is_among(problem: GaitProblem, z: Floats, others: Floats) -> bool:
    """Whether a solution is one of those in the rows of ``others``."""
    return bool(np.any(np.all(np.abs(problem.wrapped(z - others)) < SAME, axis=1)))


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


def number_all(gaits: Sequence[Gait], named: Sequence[str]) -> tuple[Gait, ...]:
    """Give gaits their branch: first those of families that an animal names, then others that are not the same."""
    first = number_branches([gait for gait in gaits if gait.family in named])
    kept = list(first)
    for gait in gaits:
        if gait.family not in named and not any(same_legs(gait, other) for other in kept):
            kept.append(gait)
    further = number_branches(kept[len(first) :])
    return (*first, *(replace(gait, branch=len(first) + gait.branch) for gait in further))


def settled(problem: GaitProblem, gait: Gait) -> tuple[GaitProblem, Gait]:
    """Return a solution with the contacts with which it ends, if it is still one with these.

    Which legs that go by the clock are down at a start is first taken from the signs of their forces, which tell
    nothing of a leg that has lifted off before and would bear again; and one that is said to be down, but would not
    bear, is up.
    """
    system = problem.system
    for _ in range(MOST_SETTLINGS if system.contacts else 0):
        names = contacts_then(system, gait.point)
        if names is None:
            break
        if names == system.contacts:
            break
        other = replace(problem, system=replace(system, contacts=names))
        found = gait_near(other, other.z_of(gait))
        if found is None:
            break
        problem, system, gait = other, other.system, replace(found, drift=gait.drift)
    return problem, gait


def same_gait(one: Gait, other: Gait) -> bool:
    """Whether two gaits, of one family, are one."""
    system = one.system
    if abs(one.speed - other.speed) > SAME * system.desired_speed:
        return False
    # Where all directions are alike, a gait is the same in another one.
    yaw = 0.0 if system.isotropic else one.yaw - other.yaw
    turned = [one.heading - other.heading, yaw, *np.subtract(one.phase, other.phase)]
    if max(abs(math.remainder(angle, 2.0 * math.pi)) for angle in turned) > SAME:
        return False
    return abs(one.yaw_rate - other.yaw_rate) * system.step_duration < SAME and math.isclose(
        one.step_duration, other.step_duration, rel_tol=SAME
    )


def same_legs(one: Gait, other: Gait) -> bool:
    """Whether two gaits, of different families, are one: a leg that pulls half a cycle later is one that pushes."""
    system, further = one.system, other.system
    shifted = [
        phase + (math.pi if amount > 0.0 and side != own else 0.0)
        for phase, amount, side, own in zip(
            other.phase, other.actuation, further.functions, system.functions, strict=True
        )
    ]
    return np.allclose(one.actuation, other.actuation) and same_gait(one, replace(other, phase=tuple(shifted)))


def without_doubles(gaits: Sequence[Gait], problems: Sequence[GaitProblem]) -> list[Gait]:
    """Count gaits once that were found with other contacts, or as symmetric ones as well."""
    symmetric = [problem for problem in problems if problem.system.mirrored]
    kept: list[Gait] = []
    for gait in gaits:
        if any(same_gait(gait, other) for other in kept):
            continue
        for problem in symmetric if not gait.symmetric and gait.animal.mirrored else ():
            twin = gait_near(problem, problem.z_of(gait)) if problem.system.contacts == gait.contacts else None
            if twin is not None and same_gait(gait, twin) and twin.invalid() is None:
                gait = twin
        kept.append(gait)
    return kept


def search_gaits(
    animal: Animal,
    *,
    heading: float | None = None,
    slope: float | None = None,
    slope_deg: float | None = None,
    family: str | None = None,
    actuation: ArrayLike | None = None,
    speed: float | None = None,
    mean_speed: float | None = None,
    energy: float | None = None,
    apex_height: float | None = None,
    lateral_drift: float | None = None,
    free: Sequence[str] = (),
    mirrored: bool | None = None,
    starts: int = STARTS,
    progress: bool = False,
) -> Search:
    """Search for gaits at one slope, and say what was found on the way.

    Whatever repeats itself is a gait: after a step, mirrored, if legs have mirror images, else after a stride. What is
    asked for beyond that takes a parameter that is let go. An animal whose legs have phases that are not given has
    these to let go: with three, it is asked for the heading, for its desired speed and for no lateral drift; with two
    the drift is left to the gait, with one the heading, too. An animal that keeps its energy has gaits at any, and is
    asked for its desired speed at the start of a step, unless a target says another thing.

    See :ref:`numerics-search`.

    Parameters
    ----------
    animal
        The animal.
    heading
        At the start of a step, rad, within +-pi/2 for an animal that is tuned to its desired speed.
    slope, slope_deg
        Either of them; rad or degrees. Not needed where the animal's speed law is for one slope only, nor from the
        side, where the ground is level without.
    family
        Only gaits of this family are returned; branches are numbered over all. Or ``"all"``: whatever legs push and
        pull, whether the animal has such a family or not (see `Animal.every_family`); gaits of its own families keep
        their numbers, further ones follow.
    actuation
        Magnitudes for each pair of legs, m; by default the animal's.
    speed, mean_speed, lateral_drift
        At the start of a step, of a stride, and sideways, m/s.
    energy
        Kinetic, of the springs, and m g times the height above the ground, at the start of a step, J.
    apex_height
        Largest height above the ground in flight, m, of an animal that is seen from the side.
    free
        Names of parameters that are let go, as in ``("F.phase", "step_duration")`` (see `legspring.parameters`): one
        for each target too many. A gait's animal has the values found.
    mirrored
        False: look for gaits, too, whose steps do not mirror one another though the animal could.
    starts
        Starting points for each family (and set of legs that are down as a step begins). No more are used once the
        equations of motion were evaluated 1e8 times, which takes about half a minute; how many were not is said among
        the endings.
    progress
        Whether to show a progress bar.

    Raises
    ------
    ValueError
        For an angle out of range, an unknown family or parameter, or targets that do not fit what is free.
    """
    angle, starts = slope_for(animal, slope, slope_deg), checked_whole("starts", starts, 1, MOST_STARTS)
    every = isinstance(family, str) and family == ALL and ALL not in animal.families
    if family is not None and not every and not (isinstance(family, str) and family in animal.families):
        raise ValueError(f"family = {shown(family)}: must be one of {', '.join(animal.families)}, or {ALL}")
    if heading is not None and animal.tuned:
        checked_angle("heading", heading, math.pi / 2)
    given = checked_targets(
        {
            "heading": heading,
            "speed": speed,
            "mean_speed": mean_speed,
            "energy": energy,
            "apex_height": apex_height,
            "lateral_drift": lateral_drift,
        }
    )
    gaits: list[Gait] = []
    rejections: list[Rejection] = []
    steps, endings = 0, Counter[Ending]()
    named = list(animal.families)
    if every:
        animal = animal.every_family()
    problems = {
        label: problems_for(animal, angle, label, given, checked_names("free", free), actuation, mirrored)
        for label in animal.families
    }
    points = {label: [starts_for(problem, starts) for problem in some] for label, some in problems.items()}
    total = sum(len(some) for several in points.values() for some in several)
    with progress_bar("searching for gaits", total, show=progress) as tick:
        for label, some in problems.items():
            of_family: list[Gait] = []
            for problem, begin in zip(some, points[label], strict=True):
                solutions, ends, taken = zeros(problem, begin, tick=tick)
                valid, invalid = sort(problem, solutions)
                of_family += valid
                rejections += invalid
                endings += ends
                steps += taken
            gaits += without_doubles(of_family, some) if len(some) > 1 or some[0].system.contacts else of_family
    numbered = number_branches(gaits) if not every else number_all(gaits, named)
    if family is not None and not every:
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
    speed: float | None = None,
    mean_speed: float | None = None,
    energy: float | None = None,
    apex_height: float | None = None,
    lateral_drift: float | None = None,
    free: Sequence[str] = (),
    mirrored: bool | None = None,
    starts: int = STARTS,
) -> list[Gait]:
    """Find the gaits at one slope, by branch; the list is empty where the search finds none.

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
        speed=speed,
        mean_speed=mean_speed,
        energy=energy,
        apex_height=apex_height,
        lateral_drift=lateral_drift,
        free=free,
        mirrored=mirrored,
        starts=starts,
    )
    return list(search.gaits)
