"""What legs do along a curve of gaits: which points are gaits, where feet do something else, and why curves end."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from legspring.curve import Stop, Trace
from legspring.flow import NO_PUSH, REASONS, flows
from legspring.gait import IDLE, LEAST_ISOLATION, Invalid
from legspring.kernel.dips import least_dip
from legspring.kernel.events import WINDOW
from legspring.kernel.footfalls import (
    LANDING,
    LEAVING,
    OLD,
    OVER,
    PEAK,
    STANCE,
    STARTING,
    TOUCH,
    blank_footfalls,
    footfalls,
)
from legspring.kernel.measure import largest_force
from legspring.kernel.pack import GRAVITATION, SLOPE, STEP_DURATION
from legspring.kernel.walker import OK, TAPE_FULL, Floats, Tape, new_tape
from legspring.landmarks import WORDS, Kind, Landmark, Trivial, at_change, find_crossings, in_order, sign_changes
from legspring.layout import TIGHT, System
from legspring.measures.forces import MAGNITUDE
from legspring.repetition import ACCURACY, STRIDES, largest_departure
from legspring.route import Route
from legspring.stretch import Point, Stretch, at_zero

ROOM = 120
"""Steps of the integrator in a step of a gait that there is room for at first."""
BEYOND = (1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4)
"""How far beyond its end a curve is looked at, to see why it ends."""
LEAP = 3e-3
"""Change of a stance in such a distance, in step durations, that is a jump."""
GRAZES = 1e-3
"""Rate, m per step duration, at which a leg grazes at the end of a curve."""
ASIDE = (2e-2, 1.5e-2, 1e-2, 7e-3, 4e-3)
"""How far from there points are from which the end is extrapolated."""
LEVEL = 1e-6
"""Slope, rad, below which the ground is level."""
TOGETHER = 1e-9
"""Difference of times, in step durations or shares of a stride, that is none."""
NEXT_TO = 0.25
"""Times, in step durations, that are further apart do not change places."""
IDLE_WORDS = "its largest force is a thousandth of the weight"
START_WORDS = "its force begins at a rate of zero, and beyond with the wrong sign"
Verdict = tuple[Invalid, str] | None


class Reason(StrEnum):
    """Why a curve ends."""

    ARRIVED = "the value asked for is reached"
    EDGE = "the edge of the range is reached"
    CLOSED = "the curve is closed: it comes back to where it began"
    WINDOW = "the stance of a leg shrinks to the window in which lift-offs are ignored"
    WRONG_START = "a leg begins with the wrong sign for longer than the ignored window"
    GRAZING_LIFTOFF = "the force of a leg touches zero without going through it"
    GRAZING_TOUCHDOWN = "a foot touches the ground without going through it"
    NOT_SIMULATED = "a step cannot be simulated beyond"
    NO_ANIMAL = "there is no such animal beyond"
    OUT_OF_RANGE = "the speed leaves the range in which gaits are looked for"
    ENOUGH = "it has as many points as were allowed"
    LOST = "there is no solution beyond, and it is not known why"


STOPS = {
    Stop.EDGE: Reason.EDGE,
    Stop.CLOSED: Reason.CLOSED,
    Stop.NO_ANIMAL: Reason.NO_ANIMAL,
    Stop.OUT_OF_RANGE: Reason.OUT_OF_RANGE,
    Stop.ENOUGH: Reason.ENOUGH,
}


@dataclass(frozen=True)
class Ending:
    """Why a curve ends.

    Attributes
    ----------
    reason
        Why.
    value
        Of what varies.
    leg
        Which leg is to blame; empty where none is.
    words
        What else there is to say.
    """

    reason: Reason
    value: float
    leg: str = ""
    words: str = ""

    def __str__(self) -> str:
        """One line."""
        more = ", ".join(part for part in (self.leg, self.words) if part)
        return f"{self.reason}, at {self.value:.10g}" + (f" ({more})" if more else "")


def trivial_of(system: System) -> Trivial:
    """Return the multipliers of a period that are what they are because something is conserved."""
    return Trivial(tuple(-1.0 if system.flips and what != "energy" else 1.0 for what in system.conserved))


class Feet:
    """Looks at what the legs do, for many points at once; for one thread."""

    def __init__(self, system: System) -> None:
        self.system, self.trivial = system, trivial_of(system)
        self._walker, self._lands = system.walker(0, NO_PUSH), system.lands.astype(float)
        self._tape = self._blank_tape(ROOM * system.cycle)
        self._scale = system.error_scale(TIGHT)

    def _blank_tape(self, room: int) -> Tape:
        return new_tape(room, room // 3, self._walker)

    def seen(self, p: Floats, work: Floats | None = None) -> tuple[NDArray[np.int64], Floats, Floats]:
        """Return how strides went, how long they took, and what legs did; write `work` (see `kernel.footfalls`)."""
        steps, scale, lands = self.system.cycle, self._scale, self._lands
        room = np.zeros((0, len(lands), 2)) if work is None else work
        while True:
            status, times, out = np.zeros(len(p), np.int64), np.zeros(len(p)), blank_footfalls(len(p), len(lands))
            footfalls(self._walker, self._tape, p, steps, scale, lands, status, times, out, room)
            if TAPE_FULL not in status:
                return status, times, out
            self._tape = self._blank_tape(2 * len(self._tape.size))

    def peak(self, p: Floats, leg: int) -> float:
        """Return the largest force of a leg, in units of m g; nan where a stride cannot be simulated."""
        status, times, _ = self.seen(p[None])
        weight = float(p[GRAVITATION] * p[STEP_DURATION] ** 2)
        force = largest_force(self._tape, leg, MAGNITUDE, 1.0, 0.0, float(times[0]))
        return force / weight if status[0] == OK else math.nan

    def dip(self, p: Floats, leg: int, down: bool) -> float:
        """Return how near to zero a leg's force, or the height of its foot, comes in between; by m g, or in m."""
        status, _, _ = self.seen(p[None])
        unit = float(p[GRAVITATION] * p[STEP_DURATION] ** 2) if down else 1.0
        return least_dip(self._walker, self._tape, leg, float(down)) / unit if status[0] == OK else math.nan

    def traits(self, stretch: Stretch, points: Sequence[Point]) -> "Traits":
        """Return all that is known of some points of a stretch."""
        p = np.array([stretch.parameters(point.y) for point in points])
        status, times, out = self.seen(p)
        maps = np.array([point.look.map for point in points])
        return Traits(self.system, p, self.trivial.free(maps), status, times, out)


@dataclass
class Traits:
    """What is known of some points of a curve, a row each.

    Attributes
    ----------
    p
        All parameters.
    half_multipliers
        Of the map of a period, without those of what is conserved, largest first.
    status, times, feet
        How a stride went (see `legspring.flow.REASONS`); how long it takes, in step durations; what each leg does (see
        `legspring.kernel.footfalls`).
    """

    system: System
    p: Floats
    half_multipliers: NDArray[np.complex128]
    status: NDArray[np.int64]
    times: Floats
    feet: Floats

    @property
    def multipliers(self) -> NDArray[np.complex128]:
        """Those of a stride."""
        return self.half_multipliers ** (2 if self.system.mirrored else 1)

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Whether all multipliers, but for what is conserved, are below 1."""
        return np.all(np.abs(self.half_multipliers) < 1.0, axis=1)

    @cached_property
    def peaks(self) -> Floats:
        """Largest force of each leg, in units of m g."""
        weights = self.p[:, GRAVITATION] * self.p[:, STEP_DURATION] ** 2
        peaks: Floats = self.feet[:, :, PEAK] / weights[:, None]
        return peaks

    @cached_property
    def watched(self) -> list[int]:
        """The legs that matter: where steps mirror one another, one of each pair."""
        animal = self.system.animal
        return list(animal.first_legs) if self.system.mirrored else list(range(len(animal.legs)))


# Which points are gaits -------------------------------------------------------------------------------------


def wrongs(traits: Traits) -> Iterator[tuple[Invalid, str, NDArray[np.bool_]]]:
    """Yield all that legs may do wrong, of which the first counts, with the leg's name, and which points do it."""
    system, feet = traits.system, traits.feet
    legs = system.animal.legs
    yield Invalid.NOT_SIMULATED, "", traits.status != OK
    for leg, one in enumerate(legs):
        yield Invalid.COLLAPSED, one.name, feet[:, leg, OVER] == 1.0
    for leg in traits.watched:
        name = legs[leg].name
        yield Invalid.NO_LIFTOFF, name, np.isnan(feet[:, leg, STANCE])
        if legs[leg].stance is None:
            yield Invalid.WRONG_SIGN, name, feet[:, leg, LEAVING] * system.side[leg] > 0.0
        yield Invalid.IDLE, name, traits.peaks[:, leg] < IDLE
    for leg, one in enumerate(legs):
        if one.offset > 0.0 and not system.lands[leg]:
            yield Invalid.OLD_LEGS, one.name, stay(traits, leg) != (feet[:, leg, OLD] == 1.0)


def verdict(traits: Traits, row: int) -> Verdict:
    """Say why a point is no gait, as `Gait.invalid` does, as far as legs tell; None if they see nothing wrong."""
    return next(((reason, leg) for reason, leg, where in wrongs(traits) if where[row]), None)


def stay(traits: Traits, leg: int) -> NDArray[np.bool_]:
    """Whether a leg that was put down before the end of a stride is down then, at each point."""
    system, feet, one = traits.system, traits.feet, traits.system.animal.legs[leg]
    until, end = feet[:, leg, TOUCH] + feet[:, leg, STANCE], traits.times * (1.0 + TOGETHER)
    if one.touchdown == "clock":
        alike = system.animal.first_legs[system.pair[leg]] if system.mirrored else leg
        # Offsets may vary along a curve.
        until, end = feet[:, alike, STANCE], 2.0 - traits.p[:, system.place(leg, "offset")]
    return np.greater(until, end)


def departs(traits: Traits) -> NDArray[np.bool_]:
    """Whether points do not repeat themselves over two strides, simulated with other steps of the integrator."""
    system = traits.system
    steps = STRIDES * system.cycle
    ends = flows(system, traits.p, steps=steps, accuracy=ACCURACY)
    growth = np.max(np.abs(traits.multipliers), axis=1, initial=0.0)
    allowed = np.array([largest_departure(float(one)) for one in growth])
    first, speed, off = ends.states[:, 0], traits.p[:, 0], np.zeros(len(traits.p))
    length = max(leg.length for leg in system.animal.legs)
    for step in range(system.period, steps + 1, system.period):
        side = -1.0 if system.flips and (step // system.period) % 2 else 1.0
        now = ends.states[:, step]
        gaps = [(side * now[:, 2] - first[:, 2]) / speed, (now[:, 3] - first[:, 3]) / speed]
        if system.yaws:
            turned = side * now[:, 4] - first[:, 4]
            gaps.append(turned - 2.0 * math.pi * np.round(turned / (2.0 * math.pi)))
            gaps.append((side * now[:, 5] - first[:, 5]) * length / speed)
        off = np.maximum(off, np.max(np.abs(gaps), axis=0))
    return ~((ends.status == OK) & (off <= allowed))


def verdicts(stretch: Stretch, traits: Traits) -> list[Verdict]:
    """Say of all points of a stretch why they are no gaits."""
    found: list[Verdict] = [None] * len(traits.p)
    for reason, leg, where in wrongs(traits):
        for row in np.flatnonzero(where).tolist():
            found[row] = found[row] or (reason, leg)
    isolation = np.linalg.svd(np.array([point.look.by for point in stretch.points]), compute_uv=False)[:, -1]
    for row, off in enumerate(departs(traits)):
        if found[row] is None and off:
            found[row] = Invalid.DEPARTS, "after two strides"
        elif found[row] is None and isolation[row] < LEAST_ISOLATION:
            found[row] = Invalid.NOT_ISOLATED, ""
    return found


# Where they change ------------------------------------------------------------------------------------------


class Moment(NamedTuple):
    """A touch-down or lift-off within a period: of which leg, whether it is a lift-off, or begins a step."""

    leg: int
    lifts: bool
    step: bool = False

    def words(self, system: System) -> str:
        """Say what happens."""
        if self.step:
            return "the beginning of a step"
        return f"the {'lift-off' if self.lifts else 'touch-down'} of {system.animal.legs[self.leg].name}"


def moments_of(traits: Traits) -> list[Moment]:
    """Return all that happens in a period; what the clock puts down at one time, once."""
    legs, found = traits.system.animal.legs, [Moment(leg, True) for leg in traits.watched]
    known: list[float] = []
    for leg in traits.watched:
        offset, by_clock = legs[leg].offset, legs[leg].touchdown == "clock"
        if by_clock and any(abs(offset - other) < TOGETHER for other in known):
            continue
        known += [offset] if by_clock else []
        found.append(Moment(leg, False, offset in (0.0, 1.0)))
    return found


def apart(traits: Traits, row: int, one: Moment, other: Moment) -> float:
    """Return by how much something happens later than another, in a motion that repeats itself; step durations."""
    feet, system = traits.feet[row], traits.system
    times = [feet[m.leg, TOUCH] + (feet[m.leg, STANCE] if m.lifts else 0.0) for m in (one, other)]
    gap = float(times[0] - times[1])
    period = float(traits.times[row]) * system.period / system.cycle
    return math.remainder(gap, period) if math.isfinite(gap) else math.nan


def find_landmarks(stretch: Stretch) -> tuple[list[Landmark], Traits, list[Verdict]]:
    """Find the special points of a stretch, in order; what is known of its points; and why they are no gaits."""
    system = stretch.loaded(stretch.points[0].y).problem.system
    feet = Feet(system)
    traits = feet.traits(stretch, stretch.points)
    reasons = verdicts(stretch, traits)
    breaking = system.mirrored and system.steps_per_stride > 1
    minus = Kind.SYMMETRY_BREAKING if breaking else Kind.PERIOD_DOUBLING
    found = [mark for mark in find_crossings(stretch, feet.trivial, minus) if not is_isotropic(system, mark)]
    found += [*find_idle(stretch, traits, feet), *find_starts(stretch, traits, feet)]
    found += [*find_sequences(stretch, traits, feet), *find_edges(stretch, reasons, feet)]
    return in_order(found), traits, reasons


def is_isotropic(system: System, mark: Landmark) -> bool:
    """Whether a multiplier is 1 or -1 because all directions are alike: those of a body that yaws on the level."""
    level = abs(mark.stretch.parameters(mark.point.y)[SLOPE]) < LEVEL
    alike = level and system.yaws and not system.animal.sagittal
    return bool(alike and mark.kind in (Kind.SYMMETRY_BREAKING, Kind.BRANCHING, Kind.PLUS_ONE))


def zero_of(stretch: Stretch, row: int, value: Callable[[Point], float]) -> Point | None:
    """Return the point of a step of a curve at which something is zero; None if it cannot be told."""
    return at_zero(stretch, stretch.points[row], stretch.points[row + 1], value)


def find_idle(stretch: Stretch, traits: Traits, feet: Feet) -> Iterator[Landmark]:
    """Find where legs begin or cease to bear anything worth mentioning."""
    for leg in traits.watched:

        def value(point: Point, leg: int = leg) -> float:
            return feet.peak(stretch.parameters(point.y), leg) - IDLE

        for row in sign_changes((traits.peaks[:, leg] - IDLE).tolist()):
            point = zero_of(stretch, row, value)
            if point is not None:
                yield Landmark(Kind.IDLE, traits.system.animal.legs[leg].name, IDLE_WORDS, point, stretch, row)


def find_starts(stretch: Stretch, traits: Traits, feet: Feet) -> Iterator[Landmark]:
    """Find where the forces of legs begin or cease to begin with the wrong sign."""
    for leg in traits.watched:

        def value(point: Point, leg: int = leg) -> float:
            return float(feet.traits(stretch, [point]).feet[0, leg, STARTING])

        for row in sign_changes(traits.feet[:, leg, STARTING].tolist()):
            point = zero_of(stretch, row, value)
            if point is not None:
                yield Landmark(Kind.WRONG_START, traits.system.animal.legs[leg].name, START_WORDS, point, stretch, row)


def find_sequences(stretch: Stretch, traits: Traits, feet: Feet) -> Iterator[Landmark]:
    """Find where two events change places."""
    legs = traits.system.animal.legs
    for one, other in combinations(moments_of(traits), 2):
        if not (one.lifts or other.lifts) and legs[one.leg].touchdown == legs[other.leg].touchdown == "clock":
            continue

        def value(point: Point, one: Moment = one, other: Moment = other) -> float:
            return apart(feet.traits(stretch, [point]), 0, one, other)

        gaps = [apart(traits, row, one, other) for row in range(len(traits.p))]
        for row in sign_changes(gaps):
            if not TOGETHER < max(abs(gaps[row]), abs(gaps[row + 1])) < NEXT_TO:
                continue
            point = zero_of(stretch, row, value)
            if point is not None:
                words = f"{one.words(traits.system)} and {other.words(traits.system)} change places"
                names = ", ".join(dict.fromkeys(legs[m.leg].name for m in (one, other) if m.lifts or not m.step))
                yield Landmark(Kind.SEQUENCE, names, words, point, stretch, row)


def find_edges(stretch: Stretch, reasons: Sequence[Verdict], feet: Feet) -> Iterator[Landmark]:
    """Find where solutions cease to be gaits, or become such again, but for idle legs: they have a test of their own.

    Whether a motion repeats itself is no matter of a place: it cannot be told where small departures grow too fast.
    """
    elsewhere = (Invalid.IDLE, Invalid.DEPARTS, Invalid.NOT_ISOLATED)

    def of_edges(reason: Verdict) -> Verdict:
        return None if reason is None or reason[0] in elsewhere else reason

    def label(point: Point) -> Verdict:
        return of_edges(verdict(feet.traits(stretch, [point]), 0))

    seen = [of_edges(reason) for reason in reasons]
    for row in range(len(seen) - 1):
        if seen[row] != seen[row + 1]:
            about = seen[row + 1] or seen[row]
            assert about is not None
            kind = Kind.NO_LIFTOFF if about[0] is Invalid.NO_LIFTOFF else Kind.VALIDITY
            point = at_change(stretch, row, label, seen[row])
            yield Landmark(kind, about[1], str(about[0]), point, stretch, row)


def kink_after(stretch: Stretch) -> Landmark:
    """Return the kink at which a stretch ends and another one begins."""
    return Landmark(Kind.KINK, "", WORDS[Kind.KINK], stretch.points[-1], stretch, len(stretch.points) - 2)


# Why they end -----------------------------------------------------------------------------------------------


def ending_of(trace: Trace, route: Route, to: float | None = None) -> Ending:
    """Say why a curve ends, which was to arrive somewhere."""
    stretch = trace.stretches[-1]
    last = stretch.points[-1]
    value = route.place(last.y)
    if trace.stop is Stop.EDGE and value == to:
        return Ending(Reason.ARRIVED, value)
    if trace.stop in STOPS:
        return Ending(STOPS[trace.stop], value, "", trace.words)
    feet = Feet(stretch.loaded(last.y).problem.system)
    here = feet.seen(stretch.parameters(last.y)[None])[2][0]
    for distance in BEYOND:
        y = last.y + distance * last.tangent
        status, _, seen = feet.seen(stretch.parameters(y)[None])
        grazing = what_grazes(feet.system, here)
        cause = grazing if status[0] != OK else what_leaps(feet.system, here, seen[0])
        if cause is not None:
            if grazing is not None and grazing[0] is cause[0]:
                value = where_rate_vanishes(feet, stretch, route, *grazing)
            return Ending(cause[0], value, feet.system.animal.legs[cause[1]].name)
        if status[0] != OK:
            return Ending(Reason.NOT_SIMULATED, value, "", REASONS[int(status[0])])
    return Ending(Reason.LOST, value)


def what_grazes(system: System, here: Floats) -> tuple[Reason, int] | None:
    """Say which leg lifts off, or comes down, at a rate of nearly zero; or None."""
    for leg, one in enumerate(system.animal.legs):
        if one.stance is None and abs(here[leg, LEAVING]) < GRAZES:
            return Reason.GRAZING_LIFTOFF, leg
        if abs(here[leg, LANDING]) < GRAZES:
            return Reason.GRAZING_TOUCHDOWN, leg
    return None


def where_rate_vanishes(feet: Feet, stretch: Stretch, route: Route, reason: Reason, leg: int) -> float:
    """Return where a curve ends at which a leg grazes: its place is a smooth function of the leg's rate.

    Next to the end itself derivatives have no bounds, and points are not known as well.
    """
    last, column = stretch.points[-1], LEAVING if reason is Reason.GRAZING_LIFTOFF else LANDING
    places, rates = [], []
    for distance in ASIDE:
        point = stretch.corrected(last.y - distance * last.tangent, last.tangent, last.tangent)
        if point is None:
            return route.place(last.y)
        places.append(route.place(point.y))
        rates.append(float(feet.seen(stretch.parameters(point.y)[None])[2][0, leg, column]))
    return at_zero_of(rates, places)


def at_zero_of(some: Sequence[float], others: Sequence[Any]) -> Any:
    """Return the value at zero, a number or an array, of the polynomial through some points."""
    return sum(other * math.prod(r / (r - x) for r in some if r != x) for x, other in zip(some, others, strict=True))


def what_leaps(system: System, here: Floats, beyond: Floats) -> tuple[Reason, int] | None:
    """Say what a leg does otherwise a little further on, and which leg, the one that is the cause; or None."""
    legs, before, after = system.animal.legs, here[:, STANCE], beyond[:, STANCE]
    leaps, lands = leaps_between(before, after), leaps_between(here[:, TOUCH], beyond[:, TOUCH])
    for reason, stance in ((Reason.WINDOW, before), (Reason.WRONG_START, after)):
        for leg in np.flatnonzero(leaps & (np.abs(stance - WINDOW) < LEAP)):
            if legs[leg].touchdown == "clock":
                return reason, int(leg)
    # What comes first makes all that follows different.
    leaves = np.fmin(here[:, TOUCH] + before, beyond[:, TOUCH] + after)
    touches = np.fmin(here[:, TOUCH], beyond[:, TOUCH])
    causes = [(float(leaves[leg]), Reason.GRAZING_LIFTOFF, int(leg)) for leg in np.flatnonzero(leaps)]
    causes += [(float(touches[leg]), Reason.GRAZING_TOUCHDOWN, int(leg)) for leg in np.flatnonzero(lands)]
    return min(causes)[1:] if causes else None


def leaps_between(before: Floats, after: Floats) -> NDArray[np.bool_]:
    """Whether times jump, or happen no more."""
    return (np.abs(before - after) > LEAP) | (np.isnan(before) != np.isnan(after))
