"""Simulations: one with all that happened, or many at once; the one door to what the kernel has seen."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from legspring.kernel.many import DURATION, N_SEEN, Ends, many, new_ends
from legspring.kernel.measure import write_series
from legspring.kernel.pack import GRAVITATION, MASS, STEP_DURATION
from legspring.kernel.walker import (
    DOWN,
    EVENT_LOST,
    FALLEN,
    FOOT_X,
    FORCE,
    GRIP_X,
    LEVEL,
    LIFTOFF,
    NO_TOUCHDOWN,
    SINCE,
    SPRING,
    STEP_TOO_SMALL,
    TAPE_FULL,
    TIME,
    TOO_MANY_STEPS,
    VX,
    VY,
    WATCHED,
    YAW_RATE,
    Floats,
    Ints,
    Tape,
    Walker,
    X,
    Y,
    new_tape,
)
from legspring.layout import ACCURACY, START, System
from legspring.parallel import in_threads

NO_PUSH, NO_PUSHES = np.zeros((0, 3)), np.zeros((0, 0, 3))
SEEN = (*START, "duration", "x", "y", "distance", "energy", "apex_height")
"""Names of what is observed at the end of a simulation; what comes after the duration, if asked for."""
assert SEEN.index("duration") == DURATION and len(SEEN) == N_SEEN
Direction = str | Floats
"""A parameter's name, or a vector in the space of the parameters."""

MOST_STEPS_AT_ONCE = 2000
"""Longest simulation, in steps."""
REASONS = {
    STEP_TOO_SMALL: "the integrator's step became too small: a leg collapsed to its hip, or forces are too stiff",
    TOO_MANY_STEPS: "the integrator needed too many steps: forces are too stiff for the time that a step takes",
    EVENT_LOST: "a lift-off could not be located: the leg's force stays too near zero",
    NO_TOUCHDOWN: "no leg touches down any more",
    FALLEN: "the body falls to the ground",
}


class IntegrationError(ArithmeticError):
    """A simulation could not be carried on; the message says why.

    Attributes
    ----------
    evaluations
        Of the equations of motion, in vain.
    """

    def __init__(self, message: str, evaluations: int = 0) -> None:
        super().__init__(message)
        self.evaluations = evaluations


class Events(NamedTuple):
    """Touch-downs and lift-offs, in order: when (s), which leg, whether it lifts off, its gap's rate then, and where.

    The rate (m/s) is that of a lift-off by zero force; where: the centre of mass, ``(E, 2)``.
    """

    time: Floats
    leg: Ints
    lifts: NDArray[np.bool_]
    rate: Floats
    place: Floats


class Contacts(NamedTuple):
    """Legs at one moment: down or not; whether they are put down right then, or else lift off once their force is zero.

    Then feet seen from the centre of mass, ``(L, 2)``, and height of the ground, from there (nan where there is none);
    gap of those that are down, m, and stiffness, N/m.
    """

    down: NDArray[np.bool_]
    lands: NDArray[np.bool_]
    leaves: NDArray[np.bool_]
    feet: Floats
    ground: Floats
    gaps: Floats
    stiffness: Floats


class Samples(NamedTuple):
    """A motion at T times: states ``(T, 6)``, SI; legs down or not, ``(T, L)``.

    Then hips as seen from the centre of mass, legs as seen from there, and feet, ``(T, L, 2)``, and of the legs,
    ``(T, L)``: force-free length, force (in m g, > 0 pulling), and rates of the force-free and of the actual length
    (m/s). All this is without meaning in swing.
    """

    states: Floats
    down: NDArray[np.bool_]
    hips: Floats
    legs: Floats
    feet: Floats
    free: Floats
    force: Floats
    free_rate: Floats
    length_rate: Floats


@dataclass(frozen=True, eq=False)
class Flow:
    """A simulation.

    Attributes
    ----------
    system, p, along
        What was simulated: all its parameters, ``(n,)``, and the directions of the derivatives, ``(D, n)``.
    seen
        ``(8, 1 + D)``, or ``(13 + 3 L, 1 + D)`` where everything is asked for: what is observed at the end (see `SEEN`
        and ``legspring.kernel.many.Ends``), and its derivatives; SI units.
    times, states
        ``(S + 1,)``, ``(S + 1, n)``: of each start of a step, and of the end: place, velocity and, where the body yaws,
        yaw and yaw rate; SI units.
    walker, tape
        The end, and what happened, as the kernel has them.
    """

    system: System
    p: Floats
    along: Floats
    seen: Floats
    times: Floats
    states: Floats
    walker: Walker
    tape: Tape

    @property
    def state(self) -> Floats:
        """State at the end and its derivatives, ``(n, 1 + D)``; SI units."""
        y, rate = self.walker.y[:, : 1 + len(self.along)].copy(), 1.0 / self.unit
        for row in (VX, VY, *([YAW_RATE] if self.system.yaws else [])):
            y[row, 1:] -= y[row, 0] * self.along[:, STEP_DURATION] * rate
            y[row] *= rate
        return y

    @property
    def unit(self) -> float:
        """Unit of time of the kernel, the step duration t_des, s."""
        return float(self.p[STEP_DURATION])

    @property
    def weight(self) -> float:
        """Unit of forces, m g, by the mass, in the kernel's units (m per step duration squared)."""
        return float(self.p[GRAVITATION]) * self.unit**2

    @property
    def step_ends(self) -> Floats:
        """Times between the steps, start and end among them, in step durations."""
        return self.times / self.unit

    @property
    def down_at_start(self) -> NDArray[np.bool_]:
        """Which legs are down at the start of what was recorded, ``(L,)``."""
        return self.tape.down[0] != 0.0

    @cached_property
    def events(self) -> Events:
        """What happened, in order."""
        tape = self.tape
        time, leg, kind, step, rate = tape.events[: tape.counts[1]].T
        places = tape.y[step.astype(int), :2, 0] if len(time) else np.zeros((0, 2))
        return Events(time * self.unit, leg.astype(int), kind == LIFTOFF, rate / self.unit, places)

    def contacts(self) -> Contacts:
        """Return what is known of the legs at the end."""
        w, stance = self.walker, self.walker.stance[:, :, 0]
        down = w.contacts[:, DOWN] != 0.0
        lands = self.system.lands if w.clock[TIME] == 0.0 else down & (w.contacts[:, SINCE] == w.clock[TIME])
        leaves = (w.contacts[:, WATCHED] == FORCE) & ~lands
        feet = stance[:, FOOT_X : FOOT_X + 2] - w.y[X : X + 2, 0]
        ground = w.contacts[:, LEVEL] if self.system.animal.sagittal else np.full(len(down), math.nan)
        stiffness = stance[:, SPRING] * self.p[MASS] / self.unit**2
        return Contacts(down, lands, leaves, feet, ground - w.y[Y, 0], w.gaps[0, :, 0], stiffness)

    @cached_property
    def duty_factor(self) -> Floats:
        """Share of what was recorded in which each leg is down, ``(L,)``."""
        steps = int(self.tape.counts[0])
        time = self.tape.time[: steps + 1]
        share: Floats = np.diff(time) @ self.tape.down[:steps] / (time[-1] - time[0])
        return share

    def samples(self, times: Floats, index: Ints | None = None) -> Samples:
        """Look at some times (in step durations) of what was recorded.

        ``index`` says which of the integrator's steps is meant, where a time is at the end of one and the start of the
        next; by default the next.
        """
        tape = self.tape
        if index is None:
            count = int(tape.counts[0])
            index = np.clip(np.searchsorted(tape.time[: count + 1], times, side="right") - 1, 0, count - 1)
        y, legs = np.zeros((len(times), *tape.y.shape[1:])), np.zeros((len(times), tape.down.shape[1], 4))
        write_series(tape, index, np.asarray(times), y, legs)
        states, (free, free_rate, force, length_rate) = y[:, :, 0], np.moveaxis(legs, -1, 0)
        stance, down = tape.stance[index, :, :, 0], tape.down[index] != 0.0
        states = np.pad(states, ((0, 0), (0, 6 - states.shape[1])))
        states[:, [VX, VY, YAW_RATE]] /= self.unit
        cosine, sine = np.cos(states[:, 4, None]), np.sin(states[:, 4, None])
        hip_x, hip_y = stance[:, :, GRIP_X], stance[:, :, GRIP_X + 1]
        hips = np.stack([cosine * hip_x - sine * hip_y, sine * hip_x + cosine * hip_y], axis=-1)
        feet = stance[:, :, FOOT_X : FOOT_X + 2]
        rates = free_rate / self.unit, length_rate / self.unit
        return Samples(states, down, hips, feet - states[:, None, :2] - hips, feet, free, force / self.weight, *rates)


def directions(system: System, along: Sequence[Direction] | Floats) -> Floats:
    """Return directions given by names, or as they are, as rows, ``(D, n)``."""
    if isinstance(along, np.ndarray):
        return along
    names = [one for one in along if isinstance(one, str)]
    if len(names) == len(along):
        return system.along(names)
    rows = [system.direction(one) if isinstance(one, str) else np.asarray(one, dtype=float) for one in along]
    return np.array(rows).reshape(len(rows), len(system.values))


def flow(
    system: System,
    p: Floats,
    *,
    steps: int = 1,
    along: Sequence[Direction] | Floats = (),
    push: Floats = NO_PUSH,
    record: bool = False,
    everything: bool = False,
    accuracy: float = ACCURACY,
) -> Flow:
    """Simulate a number of steps.

    A step lasts a step duration; that of an animal of which no leg goes by the clock ends at the next touch-down.

    See :ref:`numerics-derivatives`.

    Parameters
    ----------
    system, p
        The animal on its slope, and all parameters, ``(n,)``, the start among them (see `System.point`).
    steps
        How far.
    along
        Parameters to take exact derivatives by: their names (see `System.direction`), or directions, ``(n,)``.
    push
        ``(P, 3)``: knots of an acceleration from outside, in the kernel's units.
    record
        Whether to fill the tape.
    everything
        Whether to observe everything, and not only what a start is made of.
    accuracy
        Relative accuracy of the states after a stride.

    Returns
    -------
    Flow
        Where steps end at touch-downs, the derivatives are those of the state at the touch-down, whose time varies.

    Raises
    ------
    ValueError
        For an unknown parameter.
    IntegrationError
        If the simulation cannot be carried to its end.
    """
    if not 0 <= steps <= MOST_STEPS_AT_ONCE:
        raise ValueError(f"steps = {steps!r}: must be from 0 to {MOST_STEPS_AT_ONCE}")
    ways, scale, rows = directions(system, along), system.error_scale(accuracy), p[None]
    walker = system.walker(len(ways), push)
    room = 60 * steps + 60 if record else 0
    while True:
        tape, ends = new_tape(room, room // 2, walker), new_ends(1, steps, len(ways), walker, everything=everything)
        many(walker, tape, rows, ways, NO_PUSHES, float(steps), steps, scale, False, ends)
        status = int(ends.status[0])
        if status != TAPE_FULL:
            break
        room *= 2
    if status in REASONS:
        time = walker.clock[TIME] * p[STEP_DURATION]
        raise IntegrationError(f"stopped at t = {time:.6g} s: {REASONS[status]}", int(ends.evaluations[0]))
    return Flow(system, p, ways, ends.seen[0], ends.times[0], ends.states[0], walker, tape)


class Simulator:
    """Simulations that differ in their parameters only, one after another: for one thread at a time.

    Parameters and errors are those of `flows`; ``knots`` is the number of knots of a push.
    """

    def __init__(
        self,
        system: System,
        *,
        steps: int = 1,
        along: Sequence[Direction] | Floats = (),
        watched: int = 0,
        liftoffs: bool = False,
        work: bool = False,
        everything: bool = False,
        accuracy: float = ACCURACY,
        knots: int = 0,
    ) -> None:
        self.steps, self.along, self.work, self.everything = steps, directions(system, along), work, everything
        self._watched, self._scale = watched or steps, system.error_scale(accuracy)
        self._walker = system.walker(len(self.along), np.zeros((knots, 3)))
        self._room = 30 * steps + 30 if liftoffs or work else 0
        self._tape = self._blank_tape()

    def _blank_tape(self) -> Tape:
        return new_tape(2 * self._room if self.work else 0, self._room, self._walker)

    def __call__(self, p: Floats, pushes: Floats = NO_PUSHES) -> Ends:
        """Simulate from rows of parameters, ``(N, n)``, contiguous in memory."""
        while True:
            ends = new_ends(len(p), self.steps, len(self.along), self._walker, self.work, self.everything)
            many(
                self._walker,
                self._tape,
                p,
                self.along,
                pushes,
                float(self.steps),
                self._watched,
                self._scale,
                self.work,
                ends,
            )
            if not self._room or TAPE_FULL not in ends.status:
                return ends
            self._room *= 2
            self._tape = self._blank_tape()


def flows(
    system: System,
    p: Floats,
    *,
    steps: int = 1,
    along: Sequence[Direction] | Floats = (),
    pushes: Floats = NO_PUSHES,
    watched: int = 0,
    liftoffs: bool = False,
    work: bool = False,
    everything: bool = False,
    accuracy: float = ACCURACY,
    workers: int = 1,
) -> Ends:
    """Simulate from many rows of parameters.

    Parameters
    ----------
    system, steps, along, accuracy
        See `flow`.
    p
        ``(N, n)``.
    pushes
        ``(N, P, 3)``: a push for each (see `flow`).
    watched
        Step at whose end the observables and their derivatives are taken; by default the last one.
    liftoffs, work
        Whether to note lift-offs, and the work of legs in the first step.
    everything
        Whether to observe everything (see `flow`).
    workers
        Threads; Python's lock is not held.

    Returns
    -------
    Ends
        What became of each; nothing is raised for those that could not be carried to their end.
    """
    knots = pushes.shape[1] if len(pushes) else 0

    def simulate(rows: slice) -> Ends:
        alike = Simulator(
            system,
            steps=steps,
            along=along,
            watched=watched,
            liftoffs=liftoffs,
            work=work,
            everything=everything,
            accuracy=accuracy,
            knots=knots,
        )
        return alike(np.ascontiguousarray(p[rows]), pushes[rows] if len(pushes) else NO_PUSHES)

    count = max(1, min(workers, len(p)))
    if count == 1:
        return simulate(slice(None))
    cuts = [len(p) * n // count for n in range(count + 1)]
    parts = in_threads(simulate, [slice(*ends) for ends in pairwise(cuts)], count)
    return Ends(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))
