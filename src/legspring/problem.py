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

import numpy as np

from legspring.checks import shown
from legspring.flow import SEEN, Direction, flows
from legspring.gait import Gait
from legspring.kernel.many import N_FEW, N_SEEN
from legspring.kernel.newton import Task
from legspring.kernel.walker import Floats
from legspring.layout import ACCURACY, BY_CLOCK, PLACES, START, TIGHT, System
from legspring.model import Animal
from legspring.returnmap import seen_at, signs

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
    "turn": (-0.4, 0.4),
    "foot_x": (-1.0, 1.0),
    "foot_y": (-1.0, 1.0),
    "age": (0.0, 1.0),
}
"""Where searches start, in units of v_des, t_des (where steps end at touch-downs: of the time for a leg's length), the
longest leg and rad; an animal whose legs have no mirror images may go anywhere."""
DOWNWARDS = (0.4 * math.pi, 1.6 * math.pi)
"""Headings of a body that comes down to the ground, ahead or back, or a little upwards where a foot turns with it."""
NARROW = {"speed": (0.6, 1.4), "yaw": (-0.2, 0.2), "yaw_rate": (-0.4, 0.4)}
"""The same where phases are tuned to a given progress."""
SLACK = 0.15
"""Allowance on the cosine of the phase for what a force does in the ignored window."""
STRAIGHT = 1e-12
"""By how much, in units of v_des t_des, the step before may differ from the desired one, and count as that."""
TIED = ("slope", "slope_deg", "desired_speed")
"""What others depend on by the animal's laws, which are no straight lines."""
POSITIVE = ("stiffness", "length", "mass", "inertia", "gravity", "step_duration", "stance")
"""What cannot be negative, or nought."""
TARGETS = {
    "speed": "m/s, at the start of a step",
    "mean_speed": "m/s",
    "energy": "J, at the start of a step",
    "apex_height": "m, above the ground",
    "heading": "rad, at the start of a step",
    "lateral_drift": "m/s",
}
"""What gaits may be asked for, and its unit."""
PINNED = {"mean_speed": "Dy", "lateral_drift": "Dx"}
"""Where steps mirror one another and last as long as the clock says, what is asked of a step fixes a coordinate of its
start: the step before was like this one."""


@dataclass(frozen=True)
class GaitProblem:
    """The conditions of a gait; a value, which any number of threads may use.

    Unknowns are a vector z: the coordinates of the start that are not given, in units of v_des, v_des t_des and rad,
    and the parameters that are free.

    See :ref:`model-conditions`.

    Parameters
    ----------
    system
        The animal on its slope, of one family; what it remembers at a start, and whether steps mirror one another.
    free
        Parameters that are unknowns beside the state, such as ``"F.phase"``.
    given
        What is known of the start (any coordinate of the state) or asked of a gait (see `TARGETS`): numbers, or the
        name of the parameter that it is equal to.

    Raises
    ------
    ValueError
        If there are more unknowns than conditions, or fewer, or a name is none of these.
    """

    system: System
    free: tuple[str, ...] = ()
    given: Mapping[str, float | str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Count unknowns and conditions."""
        for name, wanted in self.given.items():
            if name not in (*self._state, *TARGETS):
                valid = ", ".join(dict.fromkeys([*self._state, *TARGETS]))
                raise ValueError(f"given = {shown(name)}: must be one of {valid}")
            if isinstance(wanted, str) and wanted not in PLACES:
                raise ValueError(f"{name} = {shown(wanted)}: must be a number, or one of {', '.join(PLACES)}")
        side_view = self.system.animal.sagittal
        for name, fits in (("apex_height", side_view), ("lateral_drift", not side_view)):
            if name in self.given and not fits:
                view = "from the side" if side_view else "from above"
                raise ValueError(f"{name} = {self.given[name]}: must be left out for an animal that is seen {view}")
        for name in self.free:
            if name in TIED:
                raise ValueError(f"free = {name!r}: must be a parameter to which the animal's laws tie no other")
            if name in self.system.state:
                raise ValueError(f"free = {name!r}: must be no coordinate of the start, which is free unless given")
            self.system.direction(name)
        missing = self.excess
        if missing:
            known = ", ".join(f"{name} = {value}" for name, value in self.given.items()) or "nothing"
            change = f"{missing} more free, or as many fewer given" if missing > 0 else f"{-missing} more given"
            raise ValueError(
                f"animal = {self.system.animal.name!r}: has {len(self.unknowns)} unknowns ({', '.join(self.unknowns)}) "
                f"for {len(self.conditions)} conditions ({', '.join(self.conditions)}), given {known}: "
                f"must have {change}"
            )

    @property
    def excess(self) -> int:
        """By how many the conditions outnumber the unknowns."""
        return len(self.conditions) - len(self.unknowns)

    @cached_property
    def _state(self) -> list[str]:
        # Where steps mirror one another the body has turned, in the step before, by twice its yaw.
        return [name for name in self.system.state if not (name == "turn" and self.system.flips)]

    @cached_property
    def _pinned(self) -> Mapping[str, str]:
        """Which coordinate of the start a target fixes."""
        own: dict[str, str] = {name: name for name in self._state}
        return own | (PINNED if self.system.flips and "Dy" in self._state else {})

    @cached_property
    def pins(self) -> dict[str, float]:
        """Coordinates of the start that are given, in SI units."""
        pinned = self._pinned
        return {pinned[name]: self._value(name) for name in self.given if name in pinned}

    @cached_property
    def targets(self) -> tuple[str, ...]:
        """What is asked of the motion, beside that it comes back."""
        return tuple(name for name in self.given if name not in self._pinned)

    def _value(self, name: str) -> float:
        """Return what a coordinate of the start is given as; a target is that of a step."""
        return self.wanted(name) * self._share(name)

    def _share(self, name: str) -> float:
        """Return how a coordinate of the start moves with what is given for it.

        Of speeds it is the way of the step before, which to the side is the mirror image of that of this one.
        """
        share = self.system.step_duration if name in PINNED else 1.0
        return -share if name == "lateral_drift" else share

    def wanted(self, name: str) -> float:
        """Return what is given, or asked for, as a number."""
        wanted = self.given[name]
        return float(self.system.values[PLACES[wanted]]) if isinstance(wanted, str) else wanted

    @cached_property
    def unknowns(self) -> tuple[str, ...]:
        """Names of the unknowns."""
        open_ones = [name for name in self._state if name not in self.pins]
        turning = [name for name in open_ones if name.startswith("yaw")]
        return (*(name for name in open_ones if name not in turning), *self.free, *turning)

    @cached_property
    def conditions(self) -> tuple[str, ...]:
        """Names of the coordinates that have to come back, and do not do so anyway; then of what is asked for.

        Energy: the speed comes back if the rest does. A body that nothing turns does not turn; that it does not is left
        to ``legspring.repetition``, as it is for any yaw where all directions are alike.
        """
        conserved = self.system.conserved
        anyway = {"speed"} if "energy" in conserved else set()
        if "yaw_rate" in conserved:
            anyway |= {"yaw", "yaw_rate"}
        elif self.system.isotropic and not self.system.flips:
            anyway.add("yaw")
        return (*(name for name in self._state if name not in anyway), *self.targets)

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return len(self.unknowns)

    def unit(self, name: str) -> float:
        """Return the unit of an unknown, or of a condition, in SI units.

        Where steps end at touch-downs the step duration is a unit of time that somebody has chosen: turning is measured
        by the speed.
        """
        system, quantity = self.system, name.rpartition(".")[2]
        longest = max(leg.length for leg in system.animal.legs)
        units = {"speed": system.desired_speed, "energy": system.animal.body.mass * system.desired_speed**2}
        units |= {"mean_speed": system.desired_speed, "lateral_drift": system.desired_speed, "apex_height": longest}
        units["yaw_rate"] = system.desired_speed / longest if system.event_driven else 1.0 / system.step_duration
        if name in units:
            return units[name]
        if quantity in ("Dx", "Dy"):
            return system.step_length
        if quantity in ("foot_x", "foot_y"):
            return longest
        if quantity in (*START, "phase", "angle", "age"):
            return 1.0
        return abs(float(system.values[system.place_of(name)])) or 1.0

    def direction(self, name: str) -> Floats:
        """Return the direction along which a parameter grows, ``(n,)`` (see `System.direction`).

        What is given as a parameter, or by the time of a step, moves with these; in a gait whose steps mirror one
        another the body has turned, in the step before, by twice its yaw.
        """
        direction = self.system.direction(name)
        for asked, wanted in self.given.items():
            if asked not in self._pinned:
                continue
            moved = self._share(asked) * direction[PLACES[wanted]] if isinstance(wanted, str) else 0.0
            if asked in PINNED:
                moved += self._value(asked) / self.system.step_duration * direction[PLACES["step_duration"]]
            direction += moved * self.system.direction(self._pinned[asked])
        if name == "yaw" and self.system.flips and "turn" in self.system.state:
            direction[PLACES["turn"]] = 2.0
        return direction

    @cached_property
    def base(self) -> Floats:
        """All parameters where the unknowns are zero, ``(n,)``."""
        p = self.system.values.copy()
        for name in self.system.state:
            along = self.system.direction(name)
            p[along != 0.0] = self.pins.get(name, 0.0)
        for name in self.free:
            own = self.system.direction(name)
            # What moves with it is where it is for the value that the animal has.
            p -= float(self.system.values[self.system.place_of(name)]) * (self.direction(name) - own)
            p[own != 0.0] = 0.0
        return p

    @cached_property
    def task(self) -> Task:
        """The conditions in the form in which they are solved."""
        along = np.array([self.direction(name) for name in self.unknowns]) * self.units[:, None]
        low, high = np.array([self._range(name) for name in self.unknowns]).T
        count = len(self.conditions)
        at_end, at_start = np.zeros((count, self.seen)), np.zeros((count, len(self.system.values)))
        given, turns = np.zeros(count), np.zeros(count)
        for row, name in enumerate(self.conditions):
            unit = self.unit(name)
            if name in self.targets:
                at_end[row], given[row] = self._asked(name) / unit, self._goal(name) / unit
                continue
            at_end[row, seen_at(self.system, name)] = signs(self.system, [name])[0] / unit
            at_start[row, self.system.place_of(name)] = -1.0 / unit
            turns[row] = 2.0 * math.pi if name in ANGLES else 0.0
        # Nothing is beyond the range where a speed and phases are sought that go with each other; elsewhere searches
        # come back from there.
        rows, columns = (np.flatnonzero(np.any(matrix != 0.0, axis=0)) for matrix in (at_end, at_start))
        moved = np.flatnonzero(np.any(along != 0.0, axis=0))
        return Task(
            along, moved, low.copy(), high.copy(), at_end, at_start, rows, columns, given, turns, "Dy" in self.pins
        )

    def _range(self, name: str) -> tuple[float, float]:
        """Return the range that an unknown must not leave, in its unit."""
        if name == "speed":
            return SLOWEST, FASTEST
        quantity = name.rpartition(".")[2]
        return (0.0 if quantity in POSITIVE else -math.inf), math.inf

    @cached_property
    def seen(self) -> int:
        """How much has to be observed."""
        return N_SEEN + 3 * len(self.system.animal.legs) if self.system.contacts or self.targets else N_FEW

    def _asked(self, name: str) -> Floats:
        """Return the combination of what is observed that has to be as is asked for: a speed times the duration."""
        row = np.zeros(self.seen)
        if name in PINNED:
            along = "y" if self.system.flips else "distance"
            row[SEEN.index(along if name == "mean_speed" else "x")] = 1.0 / self.system.step_duration
            row[SEEN.index("duration")] = -self.wanted(name) / self.system.step_duration
        else:
            row[SEEN.index(name)] = 1.0
        return row

    def _goal(self, name: str) -> float:
        return 0.0 if name in PINNED else self.wanted(name)

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
        ends = flows(
            self.system, p, steps=self.system.period, along=ways, everything=self.seen > N_FEW, accuracy=accuracy
        )
        return self.left(p, ways, ends.seen)

    def left(self, p: Floats, along: Floats, seen: Floats) -> tuple[Floats, Floats]:
        """Return what is left of the conditions at parameters from which this was seen, and its derivatives."""
        task, rows, columns = self.task, self.task.rows, self.task.columns
        values = seen[:, rows, 0] @ task.at_end[:, rows].T + p[:, columns] @ task.at_start[:, columns].T - task.given
        if task.turns.any():
            turns = np.where(task.turns > 0.0, task.turns, np.inf)
            values -= np.where(task.turns > 0.0, task.turns * np.round(values / turns), 0.0)
        by = task.at_end[:, rows] @ seen[:, rows, 1:] + task.at_start[:, columns] @ along[:, columns].T
        for name in self.targets:
            wanted = self.given[name]
            if isinstance(wanted, str):
                # What is asked for is a parameter that may itself vary.
                share = seen[:, SEEN.index("duration"), :1] / self.system.step_duration if name in PINNED else 1.0
                by[:, self.conditions.index(name)] -= share * along[:, PLACES[wanted]] / self.unit(name)
        return values, by

    def rates(self, z: Floats, names: Sequence[str]) -> Floats:
        """Return how all parameters of a solution move with some of them, ``(D, n)``: the implicit function theorem.

        Parameters
        ----------
        z
            ``(size,)``: the solution.
        names
            Of parameters, or of what is given as a number; per SI unit.
        """
        p, named = self.points(z), np.array([self._way_to(name) for name in names])
        ways = np.vstack([self.task.along, named])
        seen = flows(self.system, p, steps=self.system.period, along=ways, everything=True, accuracy=TIGHT).seen
        by = self.left(p, ways, seen)[1][0]
        for column, name in enumerate(names, start=self.size):
            if name in self.targets:
                durations = seen[0, SEEN.index("duration"), 0] / self.system.step_duration
                share = durations if name in PINNED else 1.0
                by[self.conditions.index(name), column] -= share / self.unit(name)
        rates: Floats = named - np.linalg.solve(by[:, : self.size], by[:, self.size :]).T @ self.task.along
        return rates

    def _way_to(self, name: str) -> Floats:
        """Return the direction along which a parameter, or what is given, grows."""
        if name not in self.given:
            return self.direction(name)
        if name not in self._pinned:
            return np.zeros(len(self.system.values))
        return self._share(name) * self.system.direction(self._pinned[name])

    def phase_range(self) -> Floats:
        """Largest magnitude of the phase of each pair in any gait, ``(P,)``, rad; nan where there is no gait.

        Right after touch-down a leg's force has the sign of the rate of its gap (see ``legspring.solve``), which bounds
        the phase of legs that are put down at the start. Only legs as the thesis has them begin with such a force.
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
        animal, tuned = self.system.animal, "mean_speed" in self.given and self.system.animal.tuned
        ranges = dict(RANGES | NARROW if tuned else RANGES)
        if animal.sagittal:
            ranges["heading"] = DOWNWARDS
        elif not self.system.mirrored:
            ranges["heading"] = (-math.pi, math.pi)
        ranges |= {f"{pair}.phase": (-math.pi, math.pi) for pair in animal.pairs}
        if self.free and tuned and "heading" in self.pins:
            limits = self.phase_range()
            if np.any(np.isnan(limits)):
                return None
            ranges |= {f"{pair}.phase": (-limit, limit) for pair, limit in zip(animal.pairs, limits, strict=True)}
        for name in self.free:
            here = float(self.system.values[self.places[name]]) / self.unit(name)
            ranges.setdefault(name, (here - 0.2 * abs(here), here + 0.2 * abs(here)))
        low, high = np.array([ranges.get(name) or ranges[name.rpartition(".")[2]] for name in self.unknowns]).T
        return low, high

    def evenly(self, z: Floats) -> Floats:
        """Return starts ``(N, size)`` before which the body has moved evenly, as they go on: so are feet remembered."""
        z = z.copy()
        own = [name for name in self.unknowns if "." in name and name.rpartition(".")[2] in BY_CLOCK]
        if not own:
            return z
        starts = self.points(z)
        speed, heading = starts[:, PLACES["speed"]], starts[:, PLACES["heading"]]
        if self.system.flips:
            heading = np.zeros_like(heading)
        legs = [leg.name for leg in self.system.animal.legs]
        for name in own:
            leg, _, quantity = name.rpartition(".")
            ago = (2.0 - self.system.offset[legs.index(leg)]) * self.system.step_duration
            way = {"Dx": -np.sin(heading), "Dy": np.cos(heading), "turn": np.zeros_like(heading)}[quantity]
            z[:, self.unknowns.index(name)] = ago * speed * way / self.unit(name)
        return z

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

    def gait(self, z: Floats, residual: float = math.nan, animal: Animal | None = None) -> Gait:
        """Return unknowns in the form of a gait, whether they are one or not; of a given animal, or the one found.

        Raises
        ------
        ModelError
            If what is free has values that no animal has.
        """
        system, p = self.system, self.points(z)[0]
        found = animal is None
        animal = system.animal if animal is None else animal
        changed = {name: float(p[self.places[name]]) for name in self.free if not name.endswith(".phase")}
        if changed and found:
            turned = {name: math.remainder(value, 2.0 * math.pi) for name, value in changed.items() if "angle" in name}
            animal = animal.replace(**changed | turned)
        straight = np.allclose(p[2:4], system.values[2:4], rtol=0.0, atol=STRAIGHT * system.step_length)
        even = system.contacts is None and not straight
        return Gait(
            animal=animal,
            slope=system.slope,
            heading=float(p[PLACES["heading"]]),
            family=system.family,
            speed=float(p[PLACES["speed"]]),
            phase=tuple(float(p[system.place(leg, "phase")]) for leg in animal.first_legs),
            actuation=animal.actuation if changed else system.magnitudes,
            residual=residual,
            yaw=float(p[PLACES["yaw"]]),
            yaw_rate=float(p[PLACES["yaw_rate"]]),
            displacement=(float(p[PLACES["Dx"]]), float(p[PLACES["Dy"]])) if even else None,
            turn=float(p[PLACES["turn"]]) if system.contacts is None and not system.flips else None,
            contacts=system.contacts,
            remembered=tuple(float(p[system.place_of(name)]) for name in system.memory if "." in name),
            symmetric=system.symmetric,
            strides=system.strides,
        )
