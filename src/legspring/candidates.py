"""Gaits of animals whose parameters may be anywhere in a box: followed there, verified and judged.

A candidate is a gait that goes back to one of some that are given: it is followed to where its parameters are, from the
nearest of those that are known. What cannot be followed there is none.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from legspring.checks import shown
from legspring.constraints import Constraints
from legspring.criteria import Criterion, criterion
from legspring.direct import charges
from legspring.flow import IntegrationError
from legspring.gait import Gait
from legspring.kernel.walker import Floats
from legspring.measures.sensitivity import breaks_symmetry, checked, unit_of, value_of
from legspring.model import ModelError
from legspring.problem import GaitProblem
from legspring.route import limits_of
from legspring.solve import Origin, gait_near

LONGEST_MOVE = 0.1
"""Change of a parameter, by its range, over which a gait is followed at once."""
SHORTEST_MOVE = 0.01
"""The same where it is lost otherwise."""
LARGEST_GAP, SMALLEST_GAP = 0.05, 1e-9
"""Difference between a step and what the rates at both its ends say of it that is plausible, by the step's size; and at
any rate."""
DIFFERENCE = 1e-4
"""Step of the derivatives, by the range."""
Bounds = Mapping[str | Callable[[Gait], float], tuple[float | None, float | None]]


@dataclass(frozen=True)
class Box:
    """Ranges of parameters; places in it are counted from 0 to 1 along each.

    Attributes
    ----------
    names, low, high
        The parameters and their ranges, in the units of their names.
    units
        These units.
    """

    names: tuple[str, ...]
    low: Floats
    high: Floats
    units: tuple[str, ...]

    def place(self, gait: Gait) -> Floats:
        """Return where a gait is."""
        values = np.array([value_of(gait, name) for name in self.names])
        return (values - self.low) / (self.high - self.low)

    def values(self, place: Floats) -> Floats:
        """Return the parameters at a place, in their units."""
        return self.low + np.asarray(place) * (self.high - self.low)

    def problem(self, gait: Gait, place: Floats) -> GaitProblem:
        """Return what a gait is to be a solution of at another place.

        Raises
        ------
        ValueError
            If there is no such animal.
        """
        assert isinstance(gait.origin, Origin)
        problem, _ = gait.origin.loosened(gait, self.names)
        values = dict(zip(self.names, self.values(place).tolist(), strict=True))
        given = {**problem.given, **{name: value for name, value in values.items() if name in problem.given}}
        slope = next((value for name, value in values.items() if name == "slope"), problem.system.slope)
        slope = next((math.radians(value) for name, value in values.items() if name == "slope_deg"), slope)
        own = {name: v for name, v in values.items() if name not in problem.given and not name.startswith("slope")}
        animal = problem.system.animal.replace(**own) if own else problem.system.animal
        return replace(problem, system=replace(problem.system, animal=animal, slope=slope), given=given)


def box_of(gaits: Sequence[Gait], over: Mapping[str, tuple[float, float]]) -> Box:
    """Return the ranges that parameters may be in, checked.

    Raises
    ------
    ValueError
        For a name that is none, a range that is none or has no such animals, or one that a gait lies outside of.
    """
    if not isinstance(over, Mapping) or not over:
        raise ValueError(f"over = {shown(over)}: must map parameters to ranges, as in {{'F.stiffness': (1.0, 2.0)}}")
    bodies = [(gait.animal.body.yaw, gait.animal.sagittal, *(leg.name for leg in gait.animal.legs)) for gait in gaits]
    if len(set(bodies)) > 1:
        raise ValueError(f"gaits: must be of one animal, and not of {', '.join({g.animal.name: 0 for g in gaits})}")
    low, high, names = list[float](), list[float](), list[str]()
    for name, limits in over.items():
        key = f"over[{shown(name)}]"
        try:
            if isinstance(limits, str):
                raise TypeError
            least, most = (float(one) for one in limits)
        except (TypeError, ValueError):
            raise ValueError(f"{key} = {shown(limits)}: must be a range, two rising numbers") from None
        if not -math.inf < least < most < math.inf:
            raise ValueError(f"{key} = {shown(limits)}: must be a range, two rising numbers")
        for gait in gaits:
            if not isinstance(gait.origin, Origin):
                raise ValueError("gait: must be one that a search has found, which says what was given and free")
            if breaks_symmetry(gait, name):
                raise ValueError(
                    f"{key}: must be of both legs of a pair, as the gait's steps mirror one another; ls.follow goes on"
                )
            bottom, top = limits_of(gait.origin.loosened(gait, [checked(gait, name)])[0], name)
            if least < bottom or most > top:
                raise ValueError(f"{key} = {shown(limits)}: must be within {bottom:g} and {top:g}")
            if not least <= value_of(gait, name) <= most:
                raise ValueError(f"{key} = {shown(limits)}: must hold the gait's own, {value_of(gait, name):g}")
        low, high, names = [*low, least], [*high, most], [*names, name]
    box = Box(tuple(names), np.array(low), np.array(high), tuple(unit_of(name) for name in names))
    for n in range(len(names)):
        both = [name for name in names[:n] if _overlap(gaits[0], name, names[n])]
        if both:
            raise ValueError(f"over: must not have {names[n]!r} beside {both[0]!r}, which moves it as well")
    for gait in gaits:
        for end in (0.0, 1.0):
            box.problem(gait, np.full(len(names), end))
    return box


def _overlap(gait: Gait, one: str, other: str) -> bool:
    """Whether two names stand for what is, in part, the same parameter."""
    if {one, other} <= {"slope", "slope_deg"}:
        return True
    given = () if gait.origin is None else gait.origin.given
    if one in given or other in given:
        return one == other
    first, second = (gait.system.direction(name) != 0.0 for name in (one, other))
    return bool(np.any(first & second)) and "slope" not in one + other


def agree(gone: Floats, before: Floats, after: Floats) -> NDArray[np.bool_]:
    """Whether a step, ``(..., n)``, is what the rates at its beginning and at its end say, so that both are one sheet.

    On a smooth sheet the difference from their mean is small of third order; another sheet is as far off as it is.
    """
    size = np.max(np.abs(np.stack([gone, before, after])), axis=(0, -1), initial=0.0)
    off = np.max(np.abs(gone - 0.5 * (before + after)), axis=-1, initial=0.0)
    found: NDArray[np.bool_] = off <= LARGEST_GAP * size + SMALLEST_GAP
    return found


@dataclass(frozen=True)
class Trial:
    """A candidate that was tried.

    Attributes
    ----------
    place, start
        Where it is in the box; which of the given gaits it goes back to.
    gait
        The gait; None if there is none.
    values, excess
        ``(M,)``: the criteria, what is to be large with a minus, charged for what constraints ask; ``(C,)``: by how
        much it is beyond bounds, in their units, negative where it is not.
    """

    place: Floats
    start: int
    gait: Gait | None = None
    values: Floats = field(default_factory=lambda: np.zeros(0))
    excess: Floats = field(default_factory=lambda: np.zeros(0))

    @property
    def numbers(self) -> Floats:
        """Criteria, and by how much it is beyond bounds, ``(M + C,)``."""
        return np.concatenate([self.values, self.excess])

    @property
    def keeps(self) -> bool:
        """Whether it is a gait within all bounds, of which all criteria are known."""
        return self.gait is not None and bool(np.all(self.excess <= 0.0)) and bool(np.all(np.isfinite(self.values)))


@dataclass(frozen=True)
class Judge:
    """What candidates are judged by.

    Attributes
    ----------
    box, starts
        Where they may be; the gaits that they go back to.
    criteria, signs
        What is to be small (1) or large (-1).
    bounds
        Criteria with the least and the largest value that they may have.
    constraints
        What else a gait has to keep to, at a price; None for nothing.
    """

    box: Box
    starts: tuple[Gait, ...]
    criteria: tuple[Criterion, ...]
    signs: Floats
    bounds: tuple[tuple[Criterion, float, float], ...] = ()
    constraints: Constraints | None = None

    def first(self) -> list[Trial]:
        """Return the given gaits as trials."""
        return [self.judged(self.box.place(gait), n, gait) for n, gait in enumerate(self.starts)]

    def __call__(self, place: Floats, start: int, known: Sequence[Trial]) -> Trial:
        """Try a place: follow the nearest gait that is known and goes back to the same one, and judge it."""
        near = [trial for trial in known if trial.start == start and trial.gait is not None]
        if not near:
            return Trial(place, start)
        nearest = min(near, key=lambda trial: float(np.max(np.abs(trial.place - place))))
        gait = self.followed(nearest, place)
        if gait is None or gait.invalid() is not None:
            return Trial(place, start)
        return self.judged(place, start, gait)

    def followed(self, trial: Trial, place: Floats, *, strict: bool = False) -> Gait | None:
        """Return the gait at another place, in steps if it is far; None if it is lost.

        ``strict``: only a step that agrees with the rates at both its ends, so that no other branch is landed on.
        """
        here, gait = trial.place, trial.gait
        move = LONGEST_MOVE
        while gait is not None and np.any(here != place):
            far = float(np.max(np.abs(place - here)))
            there = place if far <= move else here + (place - here) * move / far
            found = self.along(gait, there, there - here) if strict else self.near(gait, there)
            if found is not None:
                here, gait, move = there, found, min(2.0 * move, LONGEST_MOVE)
            elif min(move, far) > SHORTEST_MOVE:
                move = 0.25 * min(move, far)
            else:
                return None
        return gait

    def near(self, gait: Gait, place: Floats) -> Gait | None:
        """Return the gait next to one, at another place, whether it is valid or not; None if there is none."""
        try:
            problem = self.box.problem(gait, place)
            return gait_near(problem, problem.z_of(gait))
        except (ModelError, ValueError, IntegrationError, np.linalg.LinAlgError):
            return None

    def along(self, gait: Gait, place: Floats, way: Floats) -> Gait | None:
        """Return the gait of the same branch at another place: one that the rates at both ends of the step agree on."""
        change = way * (self.box.high - self.box.low)
        try:
            assert isinstance(gait.origin, Origin)
            before = gait.origin.rates(gait, self.box.names).T @ change
            problem = self.box.problem(gait, place)
            places = [problem.places[name] for name in problem.unknowns]
            found = gait_near(problem, (gait.point + before)[places] / problem.units)
            if found is None or not isinstance(found.origin, Origin):
                return None
            after = found.origin.rates(found, self.box.names).T @ change
        except (ModelError, ValueError, IntegrationError, np.linalg.LinAlgError):
            return None
        steps = [found.point[places] - gait.point[places], before[places], after[places]]
        return found if agree(*(step / problem.units for step in steps)) else None

    def judged(self, place: Floats, start: int, gait: Gait) -> Trial:
        """Judge a gait."""
        penalty = 0.0 if self.constraints is None else sum(one.amount for one in charges(gait, self.constraints))
        values = self.signs * np.array([one.function(gait) for one in self.criteria]) + penalty
        return Trial(place, start, gait, values, self.excess(gait))

    def excess(self, gait: Gait) -> Floats:
        """Return by how much a gait is beyond each bound; infinite where it has no such number."""
        found = []
        for one, low, high in self.bounds:
            value = one.function(gait)
            found += [low - value] if low > -math.inf else []
            found += [value - high] if high < math.inf else []
        return np.nan_to_num(np.array(found), nan=math.inf)

    @property
    def sizes(self) -> Floats:
        """What is a large excess of each bound, ``(C,)``: a tenth of it."""
        ends = [end for _, low, high in self.bounds for end in (low, high) if math.isfinite(end)]
        return 0.1 * np.maximum(np.abs(np.array(ends)), 1e-3)

    def slopes(self, trial: Trial) -> Floats | None:
        """Return derivatives of criteria and of what is beyond bounds, ``(M + C, D)``; None where a gait is lost.

        Differences of gaits found anew on both sides, or on one at the edge of the box.
        """
        assert trial.gait is not None
        rows = []
        for n in range(len(trial.place)):
            ends = []
            for side in (1.0, -1.0):
                place = trial.place.copy()
                place[n] = min(max(place[n] + side * DIFFERENCE, 0.0), 1.0)
                gait = trial.gait if place[n] == trial.place[n] else self.near(trial.gait, place)
                if gait is None:
                    return None
                ends.append(trial if gait is trial.gait else self.judged(place, trial.start, gait))
            width = ends[0].place[n] - ends[1].place[n]
            rows.append((ends[0].numbers - ends[1].numbers) / width)
        by = np.array(rows).T
        return by if np.all(np.isfinite(by)) else None


def bounds_of(bounds: Bounds) -> tuple[tuple[Criterion, float, float], ...]:
    """Return bounds of criteria, checked; None stands for no bound.

    Raises
    ------
    ValueError
        For a criterion or a range that is none.
    """
    if not isinstance(bounds, Mapping):
        raise ValueError(f"bounds = {shown(bounds)}: must map criteria to ranges, as in {{'friction': (None, 1.0)}}")
    found = []
    for name, limits in bounds.items():
        one = criterion(name)
        try:
            low, high = limits
            least, most = -math.inf if low is None else float(low), math.inf if high is None else float(high)
        except (TypeError, ValueError):
            raise ValueError(f"bounds[{shown(one.name)}] = {shown(limits)}: must be a range") from None
        if not least < most:
            raise ValueError(f"bounds[{shown(one.name)}] = {shown(limits)}: must be a range, of rising numbers")
        found.append((one, least, most))
    return tuple(found)
