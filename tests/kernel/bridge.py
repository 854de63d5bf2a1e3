"""The oracles' problems in the kernel's units, and the kernel's answers back in SI."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, ParamSpec, TypeVar

import numba
import numpy as np

from legspring.kernel.many import many, new_ends
from legspring.kernel.walker import LIFTOFF, OK, TOUCHDOWN, Tape, Walker, new_tape, new_walker
from legspring.layout import TIGHT, System
from legspring.model import cockroach
from tests.oracle.problem import Array, Direction, Event, Problem, Run, random_problem

P = ParamSpec("P")
R = TypeVar("R")
njit: Any = numba.njit
KINDS: dict[float, Literal["touchdown", "liftoff"]] = {TOUCHDOWN: "touchdown", LIFTOFF: "liftoff"}
NO_PUSH = np.zeros((0, 3))


@dataclass(frozen=True)
class Walk:
    """What the kernel made of a problem. Times are in step durations, all else is in SI units."""

    problem: Problem
    status: int
    walker: Walker
    tape: Tape
    states: Array

    @property
    def times(self) -> Array:
        """At which the integrator's steps begin, and the last one ends."""
        return self.tape.time[: self.tape.counts[0] + 1]

    def jet(self, time: float) -> Array:
        """State at the end of an integrator step and its derivatives, shape (6, 1 + directions)."""
        (step,) = np.flatnonzero(self.times == time)
        return self.si(self.tape.y[step])

    def state(self, time: float) -> Array:
        """State at the end of an integrator step."""
        return np.asarray(self.jet(time)[:, 0])

    def si(self, y: Array) -> Array:
        """A state jet of the kernel in SI units, with the rows of a yaw that is held."""
        jet = np.zeros((6, y.shape[1]))
        jet[: len(y)] = y
        return jet * units(self.problem)[:, None]

    @property
    def events(self) -> list[Event]:
        """In order of time, after the start and before the end."""
        tape, events = self.tape, []
        t_des = self.problem.t_des
        for time, leg, kind, step, rate in tape.events[: tape.counts[1]]:
            if step < tape.counts[0]:
                state, foot = self.si(tape.y[int(step)])[:, 0], tape.stance[int(step), int(leg), :2, 0]
                events.append(Event(time * t_des, int(leg), KINDS[kind], state, foot, rate / t_des))
        return events

    @property
    def down_at_start(self) -> list[bool]:
        """For each leg whether it was put down before the start and is in stance then."""
        return [bool(down) for down in (self.problem.offset > 0) & (self.tape.down[0] != 0)]


def simulate(
    problem: Problem,
    end: float = 2.0,
    directions: Sequence[Direction] = (),
    accuracy: float = TIGHT,
    push: Array = NO_PUSH,
) -> Walk:
    """Walk until a time, in step durations, with derivatives along directions."""
    walk = attempt(problem, parameters(problem, directions), end, accuracy, push)
    assert walk.status == OK
    return walk


def attempt(
    problem: Problem,
    numbers: tuple[Array, Array],
    end: float = 2.0,
    accuracy: float = TIGHT,
    push: Array = NO_PUSH,
    room: int = 4000,
) -> Walk:
    """Walk with the given parameters and directions, however it ends; `room` is what the tape has for steps, events."""
    p, along = numbers
    rows, none = 4 if problem.inertia is None else 6, np.zeros(problem.n_legs)
    walker = new_walker(problem.function.astype(float), none, none, none, push, rows, len(along))
    tape, ends = new_tape(room, room, walker), new_ends(1, int(end), len(along), walker)
    many(walker, tape, p[None], along, np.zeros((0, 0, 3)), end, int(end), error_scale(problem, accuracy), False, ends)
    return Walk(problem, int(ends.status[0]), walker, tape, ends.states[0])


def parameters(problem: Problem, along: Sequence[Direction] = ()) -> tuple[Array, Array]:
    """Parameters for the kernel, and the directions of its derivatives."""
    rows = []
    for direction in along:
        h: Any = np.longdouble(1e-6 * size(problem, direction))
        ahead, behind = (numbers(problem.perturbed(direction, change)) for change in (h, -h))
        # What differs by nothing may be infinite.
        with np.errstate(invalid="ignore"):
            rows.append(np.where(ahead == behind, 0.0, (ahead - behind) / (2 * h)))
    p = numbers(problem).astype(float)
    return p, np.array(rows, dtype=float).reshape(len(along), len(p))


def numbers(problem: Problem) -> Array:
    """Parameters for the kernel in the problem's precision."""
    p, none = problem, np.zeros(problem.n_legs)
    turn = 2 * p.yaw if p.turn is None else p.turn
    inertia = np.inf if p.inertia is None else p.inertia
    start = [p.speed, p.heading, *p.displacement, p.yaw, p.yaw_rate, turn]
    rest = [p.slope, p.gravity, p.mass, inertia, p.v_des, p.t_des]
    amplitude = p.ldev * p.function
    legs = np.stack(
        [*p.hip.T, p.stiffness, p.length, amplitude, p.phase, p.angle, *[none] * 2, p.offset, *[none] * 3], axis=1
    )
    return np.concatenate([np.array(start), np.array(rest), legs.ravel()])


def size(problem: Problem, direction: Direction) -> float:
    """A natural size, in SI units, for changes along a direction."""
    return problem.inertia or 0.0 if direction == "inertia" else problem.scale(direction)


def error_scale(problem: Problem, accuracy: float) -> float:
    """Largest error of an integrator step, m, that `System` would choose for an animal of this size."""
    longest = max(leg.length for leg in cockroach().legs)
    return System(cockroach(), 0.0, "A").error_scale(accuracy) * max(problem.length) / longest


def units(problem: Problem) -> Array:
    """The kernel's units of the state (x, y, vx, vy, yaw, yaw rate), in SI units."""
    rate = 1.0 / problem.t_des
    return np.array([1.0, 1.0, rate, rate, 1.0, rate])


def scale(problem: Problem, run: Run) -> Array:
    """Largest length, speed, 1 rad, 1/t_des: what errors of the state are relative to."""
    length = max(problem.length)
    speed = max(np.hypot(*state[2:4]) for state in (*run.states, *(event.state for event in run.events)))
    return np.array([length, length, speed, speed, 1.0, 1.0 / problem.t_des], dtype=float)


def sequence(events: Sequence[Event]) -> list[tuple[int, str]]:
    """Which leg did what, in order, after the start."""
    return [(event.leg, event.kind) for event in events if event.t > 0]


def point_mass(seed: int) -> Problem:
    """A random point mass, every other one with its hips off the centre."""
    problem = random_problem(np.random.default_rng((seed, False)), yaw=False)
    return replace(problem, hip=rigid_body(seed).hip) if seed % 2 else problem


def rigid_body(seed: int) -> Problem:
    """A random body that yaws."""
    return random_problem(np.random.default_rng((seed, True)), yaw=True)


def callable_here(function: Callable[P, R]) -> Callable[P, R]:
    """A function of the kernel that otherwise only compiled functions call."""
    inner: Any = function
    compiled: Callable[P, R] = njit(lambda *arguments: inner(*arguments))
    return compiled
