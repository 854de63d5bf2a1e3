"""The conditions of a gait: one problem for all animals.

A gait is a fixed point of the return map. Every coordinate of the state at the start of a step is an unknown, and that
it comes back is a condition, except for what no step changes. Who gives a coordinate of the start, or asks for
something of the motion, has to let a parameter go: the cockroach that runs at a given heading, straight up and at its
desired speed has three phases free; a template of passive legs has a gait at each of its speeds.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from legspring.checks import checked_angle, checked_vector, shown
from legspring.flow import SEEN, Direction, flows
from legspring.gait import Gait
from legspring.kernel.newton import Task
from legspring.kernel.walker import Floats
from legspring.layout import ACCURACY, PLACES, START, System
from legspring.model import Animal
from legspring.returnmap import ASIDE, state_names

SLOWEST, FASTEST = 0.2, 5.0
"""Range of the speed, in units of the desired one, further from which nothing is looked for."""
ANGLES = ("heading", "yaw")
"""What is the same after a whole turn."""
RANGES = {
    "speed": (0.3, 3.0),
    "heading": (-1.0, 1.0),
    "Dx": (-0.5, 0.5),
    "Dy": (0.5, 1.5),
    "yaw": (-0.4, 0.4),
    "yaw_rate": (-1.0, 1.0),
}
"""Where searches start, in units of v_des, t_des (where steps end at touch-downs: of the time for a leg's length) and
rad; an animal whose legs have no mirror images may go anywhere."""
NARROW = {"speed": (0.6, 1.4), "yaw": (-0.2, 0.2), "yaw_rate": (-0.4, 0.4)}
"""The same where phases are tuned to a given progress."""
SLACK = 0.15
"""Allowance on the cosine of the phase for what a force does in the ignored window."""
TIED = ("slope", "slope_deg", "desired_speed")
"""What others depend on by the animal's laws, which are no straight lines."""
TARGETS = {"mean_speed": "Dy", "lateral_drift": "Dx"}
"""What may be asked of a step, m/s, and the coordinate of the start that it fixes where steps last as long as the clock
says: the step before was like this one."""


class Symmetry(NamedTuple):
    """After how many steps a gait repeats itself, and whether as its mirror image."""

    steps: int = 1
    mirrored: bool = True


STEP_FOR_STEP = Symmetry()


@dataclass(frozen=True)
class GaitProblem:
    """The conditions of a gait; a value, which any number of threads may use.

    Unknowns are a vector z: the coordinates of the start that are not given, in units of v_des, v_des t_des and rad,
    and the parameters that are free.

    See :ref:`model-conditions`.

    Parameters
    ----------
    system
        The animal on its slope, of one family.
    free
        Parameters that are unknowns beside the state, such as ``"F.phase"``.
    given
        What is known of the start (``"speed"``, ``"heading"``, ``"yaw"``, ``"yaw_rate"``) or asked of a step
        (``"mean_speed"``, ``"lateral_drift"``, m/s): numbers, or the name of the parameter that it is equal to.
    symmetry
        When a gait repeats itself.

    Raises
    ------
    ValueError
        If there are more unknowns than conditions, or fewer, or a name is none of these.
    """

    system: System
    free: tuple[str, ...] = ()
    given: Mapping[str, float | str] = field(default_factory=dict)
    symmetry: Symmetry = STEP_FOR_STEP

    def __post_init__(self) -> None:
        """Count unknowns and conditions."""
        for name, wanted in self.given.items():
            if name not in (*self._state, *TARGETS):
                valid = ", ".join([*self._state, *TARGETS])
                raise ValueError(f"given = {shown(name)}: must be one of {valid}")
            if isinstance(wanted, str) and wanted not in PLACES:
                raise ValueError(f"{name} = {shown(wanted)}: must be a number, or one of {', '.join(PLACES)}")
        for name in self.free:
            if name in TIED:
                raise ValueError(f"free = {name!r}: must be a parameter to which the animal's laws tie no other")
            self.system.direction(name)
        missing = len(self.conditions) - len(self.unknowns)
        if missing:
            known = ", ".join(f"{name} = {value}" for name, value in self.given.items()) or "nothing"
            change = f"{missing} more free, or as many fewer given" if missing > 0 else f"{-missing} more given"
            raise ValueError(
                f"animal = {self.system.animal.name!r}: has {len(self.unknowns)} unknowns ({', '.join(self.unknowns)}) "
                f"for {len(self.conditions)} conditions (that {', '.join(self.conditions)} come back), given {known}: "
                f"must have {change}"
            )

    @property
    def _state(self) -> list[str]:
        return [name for name in state_names(self.system, memory=not self.system.event_driven) if name != "turn"]

    @cached_property
    def pins(self) -> dict[str, float]:
        """Coordinates of the start that are given, in SI units."""
        return {TARGETS.get(name, name): self._value(name) for name in self.given}

    def _value(self, name: str) -> float:
        """Return what a coordinate of the start is given as; a target is that of a step."""
        wanted = self.given[name]
        value = float(self.system.values[PLACES[wanted]]) if isinstance(wanted, str) else wanted
        return value * self.system.step_duration if name in TARGETS else value

    @cached_property
    def unknowns(self) -> tuple[str, ...]:
        """Names of the unknowns."""
        open_ones = [name for name in self._state if name not in self.pins]
        turning = [name for name in open_ones if name.startswith("yaw")]
        return (*(name for name in open_ones if name not in turning), *self.free, *turning)

    @cached_property
    def conditions(self) -> tuple[str, ...]:
        """Names of the coordinates that have to come back, and do not do so anyway.

        Energy: the speed comes back if the rest does. A body that nothing turns does not turn; that it does not is left
        to ``legspring.repetition``, as it is for any yaw where all directions are alike.
        """
        conserved = self.system.conserved
        anyway = {"speed"} if "energy" in conserved else set()
        if "yaw_rate" in conserved:
            anyway |= {"yaw", "yaw_rate"}
        elif self.system.isotropic and not self.symmetry.mirrored:
            anyway.add("yaw")
        return tuple(name for name in self._state if name not in anyway)

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return len(self.unknowns)

    def unit(self, name: str) -> float:
        """Return the unit of an unknown, or of a condition, in SI units.

        Where steps end at touch-downs the step duration is a unit of time that somebody has chosen: turning is measured
        by the speed.
        """
        system = self.system
        if name in ("Dx", "Dy"):
            return system.step_length
        if name == "speed":
            return system.desired_speed
        if name == "yaw_rate":
            longest = max(leg.length for leg in system.animal.legs)
            return system.desired_speed / longest if system.event_driven else 1.0 / system.step_duration
        if name in START or name.endswith(("phase", "angle")):
            return 1.0
        return abs(float(self.system.values[self.system.place_of(name)])) or 1.0

    def direction(self, name: str) -> Floats:
        """Return the direction along which a parameter grows, ``(n,)`` (see `System.direction`).

        What is given as a parameter, or by the time of a step, moves with these; in a gait whose steps mirror one
        another the body has turned, in the step before, by twice its yaw.
        """
        direction = self.system.direction(name)
        for asked, wanted in self.given.items():
            moved = direction[PLACES[wanted]] if isinstance(wanted, str) else 0.0
            if asked in TARGETS:
                duration = self.system.step_duration
                moved = moved * duration + self._value(asked) / duration * direction[PLACES["step_duration"]]
            direction[PLACES[TARGETS.get(asked, asked)]] += moved
        if name == "yaw" and self.symmetry.mirrored:
            direction[PLACES["turn"]] = 2.0
        return direction

    @cached_property
    def base(self) -> Floats:
        """All parameters where the unknowns are zero, ``(n,)``."""
        p = self.system.values.copy()
        for name in self._state:
            p[PLACES[name]] = self.pins.get(name, 0.0)
        for name in self.free:
            p[self.system.direction(name) != 0.0] = 0.0
        return p

    @cached_property
    def task(self) -> Task:
        """The conditions in the form in which they are solved."""
        along = np.array([self.direction(name) for name in self.unknowns]) * self.units[:, None]
        ranges = [(SLOWEST, FASTEST) if name == "speed" else (-math.inf, math.inf) for name in self.unknowns]
        low, high = np.array(ranges).T
        at_end, at_start = np.zeros((len(self.conditions), len(SEEN))), np.zeros((len(self.conditions), len(START)))
        turns = np.zeros(len(self.conditions))
        for row, name in enumerate(self.conditions):
            mirror = -1.0 if self.symmetry.mirrored and name in ASIDE else 1.0
            at_end[row, PLACES[name]], at_start[row, PLACES[name]] = mirror / self.unit(name), -1.0 / self.unit(name)
            turns[row] = 2.0 * math.pi if name in ANGLES else 0.0
        # Nothing is beyond the range where a speed and phases are sought that go with each other; elsewhere searches
        # come back from there.
        given, stops = np.zeros(len(self.conditions)), "Dy" in self.pins
        return Task(along, low.copy(), high.copy(), at_end, at_start, given, turns, stops)

    def points(self, z: Floats, base: Floats | None = None) -> Floats:
        """Return all parameters at some unknowns, ``(N, n)``; other parameters than the system's may be the base."""
        return (self.base if base is None else base) + np.atleast_2d(z) @ self.task.along

    def residual(
        self,
        z: Floats,
        along: Sequence[Direction] | Floats = (),
        *,
        base: Floats | None = None,
        accuracy: float = ACCURACY,
    ) -> tuple[Floats, Floats]:
        """Return what is left of the conditions, and their exact derivatives.

        Parameters
        ----------
        z
            ``(N, size)``.
        along
            Parameters to take derivatives by beside the unknowns, in SI units; or directions, ``(D, n)``.
        base
            ``(N, n)``: parameters where the unknowns are zero, if others than the system's.
        accuracy
            Relative accuracy of the states.

        Returns
        -------
        values, derivatives
            ``(N, m)``, ``(N, m, size + len(along))``; nan where a step cannot be simulated.
        """
        p = self.points(z, base)
        more = [self.direction(one) if isinstance(one, str) else one for one in along]
        ways = np.vstack([self.task.along, *more])
        ends = flows(self.system, p, steps=self.symmetry.steps, along=ways, accuracy=accuracy)
        return self.left(p, ways, ends.seen)

    def left(self, p: Floats, along: Floats, seen: Floats) -> tuple[Floats, Floats]:
        """Return what is left of the conditions at parameters from which this was seen, and its derivatives."""
        task = self.task
        values = seen[:, :, 0] @ task.at_end.T + p[:, : len(START)] @ task.at_start.T
        if task.turns.any():
            turns = np.where(task.turns > 0.0, task.turns, np.inf)
            values -= np.where(task.turns > 0.0, task.turns * np.round(values / turns), 0.0)
        return values, task.at_end @ seen[:, :, 1:] + task.at_start @ along[:, : len(START)].T

    def phase_range(self) -> Floats:
        """Largest magnitude of the phase of each pair in any gait, ``(P,)``, rad; nan where there is no gait.

        Right after touch-down a leg's force has the sign of the rate of its gap (see ``legspring.solve``), which bounds
        the phase. Only legs as the thesis has them begin with such a force.
        """
        system = self.system
        fastest, slowest = (limit * system.step_length for limit in reversed(NARROW["speed"]))
        spin = NARROW["yaw_rate"][1] if system.yaws else 0.0
        bound = np.full(len(system.magnitudes), -1.0)
        for leg, pair, side in zip(system.animal.legs, system.animal.pair_of, system.side, strict=True):
            if leg.offset == 0.0 and system.magnitudes[pair] > 0.0 and leg.plain:
                along = side * math.cos(leg.angle - self.pins.get("heading", 0.0))
                lever = leg.hip[0] * math.cos(leg.angle) + leg.hip[1] * math.sin(leg.angle)
                rate = along * (fastest if along < 0.0 else slowest) - abs(lever) * spin
                bound[pair] = rate / (math.pi * system.magnitudes[pair]) - SLACK
        bound[bound > 1.0] = math.nan
        return np.arccos(np.clip(bound, -1.0, 1.0))

    def box(self) -> tuple[Floats, Floats] | None:
        """Return the range of each unknown in which gaits are looked for; None where there can be no gait."""
        tuned = "Dy" in self.pins
        ranges = dict(RANGES | NARROW if tuned else RANGES)
        if not self.symmetry.mirrored:
            ranges["heading"] = (-math.pi, math.pi)
        if self.free and tuned:
            limits = self.phase_range()
            if np.any(np.isnan(limits)):
                return None
            ranges |= {
                f"{pair}.phase": (-limit, limit) for pair, limit in zip(self.system.animal.pairs, limits, strict=True)
            }
        for name in self.free:
            here = float(self.system.values[self.places[name]]) / self.unit(name)
            ranges.setdefault(name, (here - 0.2 * abs(here), here + 0.2 * abs(here)))
        low, high = np.array([ranges[name] for name in self.unknowns]).T
        return low, high

    def at(self, *, slope: float | None = None, heading: float | None = None) -> "GaitProblem":
        """Return the same problem at another slope or heading, rad."""
        system = self.system if slope is None else replace(self.system, slope=slope)
        return replace(self, system=system, given=self.given if heading is None else {**self.given, "heading": heading})

    def wrapped(self, z: Floats) -> Floats:
        """Return the same unknowns with angles in (-pi, pi].

        Where all directions are alike, a gait whose steps mirror one another is the same turned by half a turn.
        """
        columns, turns = self._angles
        z = z.copy()
        z[..., columns] = 0.5 * turns - (0.5 * turns - z[..., columns]) % turns
        return z

    @cached_property
    def _angles(self) -> tuple[list[int], Floats]:
        """Which unknowns are angles, and after what they are the same."""
        names = [name for name in self.unknowns if name in ANGLES or name.endswith("phase")]
        half = self.system.isotropic
        turns = [math.pi if half and name == "yaw" else 2.0 * math.pi for name in names]
        return [self.unknowns.index(name) for name in names], np.array(turns)

    def z_of(self, gait: Gait) -> Floats:
        """Return a gait's unknowns, to start from."""
        return gait.point[[self.places[name] for name in self.unknowns]] / self.units

    @cached_property
    def places(self) -> dict[str, int]:
        """Where in p each unknown is; of a pair of legs, its first one."""
        return {name: self.system.place_of(name) for name in self.unknowns}

    @cached_property
    def units(self) -> Floats:
        """Units of the unknowns, ``(size,)``, in SI units."""
        return np.array([self.unit(name) for name in self.unknowns])

    def gait(self, z: Floats, residual: float = math.nan) -> Gait:
        """Return unknowns in the form of a gait, whether they are one or not."""
        system, p = self.system, self.points(z)[0]
        animal = system.animal
        changed = {name: float(p[self.places[name]]) for name in self.free if not name.endswith(".phase")}
        if changed:
            animal = animal.replace(**changed)
        place = float(p[PLACES["Dx"]]), float(p[PLACES["Dy"]])
        return Gait(
            animal=animal,
            slope=system.slope,
            heading=float(p[PLACES["heading"]]),
            family=system.family,
            speed=float(p[PLACES["speed"]]),
            phase=tuple(float(p[system.place(leg, "phase")]) for leg in animal.first_legs),
            actuation=system.magnitudes,
            residual=residual,
            yaw=float(p[PLACES["yaw"]]),
            yaw_rate=float(p[PLACES["yaw_rate"]]),
            displacement=None if place == tuple(system.values[2:4]) else place,
        )


def check_tuned(animal: Animal, purpose: str) -> None:
    """Raise ValueError unless an animal's legs are tuned to its desired speed."""
    if not animal.tuned:
        raise ValueError(
            f"animal = {animal.name!r}: must have actuated legs whose phases are not given {purpose}; this one's gaits "
            "have speeds and headings of their own"
        )


def check_mirrored(animal: Animal) -> None:
    """Raise ValueError unless every pair has a leg for each step, and these are mirror images."""
    for pair in animal.pairs:
        if not {0.0, 1.0} == {leg.offset for leg in animal.legs if leg.pair == pair}:
            raise ValueError(
                f"pair {pair!r} of animal {animal.name!r}: a gait that mirrors itself from step to step needs one leg "
                "that touches down at offset 0 and one at offset 1"
            )
    if not animal.mirrored:
        raise ValueError(
            f"pair {animal.odd_pair!r} of animal {animal.name!r}: must have legs that are mirror images for a gait "
            "that mirrors itself from step to step; it may be simulated"
        )


def tuned(animal: Animal, slope: float, heading: float, family: str, actuation: ArrayLike | None = None) -> GaitProblem:
    """Return the problem of a gait at a given heading, straight up at the desired speed: phases are free."""
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
    if actuation is not None:
        actuation = tuple(checked_vector("actuation", actuation, len(animal.pairs)).tolist())
    system = System(animal, slope, family, actuation)
    wanted: dict[str, float | str] = {
        "heading": checked_angle("heading", heading, math.pi / 2),
        "mean_speed": "desired_speed",
        "lateral_drift": 0.0,
    }
    check_mirrored(animal)
    return GaitProblem(system, tuple(f"{pair}.phase" for pair in animal.pairs), wanted)


def periodic(animal: Animal, slope: float, family: str) -> GaitProblem:
    """Return the problem of a gait that only repeats itself; where energy is conserved, at the desired speed."""
    system = System(animal, slope, family)
    if system.steps_per_stride == 2:
        check_mirrored(animal)
    elif any(leg.offset for leg in animal.legs):
        raise ValueError(f"animal = {animal.name!r}: must have legs of offset 0, or in pairs, for steps to be alike")
    given: dict[str, float | str] = {"speed": "desired_speed"} if "energy" in system.conserved else {}
    # A body that nothing turns may have any yaw, and so may one for which all directions are alike.
    if "yaw_rate" in system.conserved:
        given |= {"yaw": 0.0, "yaw_rate": 0.0}
    elif system.isotropic and not system.mirrored:
        given["yaw"] = 0.0
    return GaitProblem(system, (), given, Symmetry(1, system.mirrored))


def problem_for(
    animal: Animal, slope: float, heading: float | None, family: str, actuation: ArrayLike | None
) -> GaitProblem:
    """Return the problem of a gait of one family.

    Raises
    ------
    ValueError
        If there is a heading, or an actuation, where gaits have their own, or no heading where they have none.
    """
    if animal.tuned:
        if heading is None:
            raise ValueError("heading is missing: must be an angle in rad, within +-pi/2")
        return tuned(animal, slope, heading, family, actuation)
    for name, value in (("heading", heading), ("actuation", actuation)):
        if value is not None:
            raise ValueError(
                f"{name} = {shown(value)}: must be left out for {animal.name!r}, whose gaits have their own"
            )
    return periodic(animal, slope, family)
