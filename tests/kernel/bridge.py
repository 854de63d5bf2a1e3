"""The oracles' problems in the kernel's units, and the kernel's answers back in SI."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from legspring.kernel.run import run
from legspring.kernel.walker import LIFTOFF, Tape, Walker
from legspring.model import cockroach
from legspring.setting import TIGHT, Setting
from tests.oracle.problem import Array, Direction, Event, Problem

ROOM = 4000
NO_PUSH = np.zeros((0, 3))


@dataclass(frozen=True)
class Walk:
    """What the kernel made of a problem."""

    problem: Problem
    status: int
    walker: Walker
    tape: Tape

    @property
    def units(self) -> Array:
        """Of the state (x, y, vx, vy, yaw, yaw rate)."""
        return units(self.problem)

    def index(self, time: float) -> int:
        """Number of integrator steps before a time, in step durations, at which one of them ends."""
        (where,) = np.flatnonzero(self.tape.time[: self.tape.counts[0] + 1] == time)
        return int(where)

    def jet(self, time: float) -> Array:
        """State and its derivatives at such a time, shape (6, 1 + directions)."""
        return self._padded(self.tape.y[self.index(time)]) * self.units[:, None]

    def state(self, time: float) -> Array:
        """State at such a time."""
        return np.asarray(self.jet(time)[:, 0])

    @property
    def events(self) -> list[Event]:
        """In order of time, without those at the very end."""
        tape, t_des = self.tape, self.problem.t_des
        events = []
        for time, leg, kind, step, rate in tape.events[: tape.counts[1]]:
            if step < tape.counts[0]:
                state = self._padded(tape.y[int(step)])[:, 0] * self.units
                foot = tape.stance[int(step), int(leg), :2, 0]
                name = "liftoff" if kind == LIFTOFF else "touchdown"
                events.append(Event(time * t_des, int(leg), name, state, foot, rate / t_des))
        return events

    @property
    def down_at_start(self) -> list[bool]:
        """For each leg whether it was put down before the start and is in stance then."""
        old = self.problem.offset > 0
        return [bool(down) for down in old & (self.tape.down[0] != 0)]

    def _padded(self, y: Array) -> Array:
        """Add the rows of a yaw that is held."""
        jet = np.zeros((6, y.shape[1]))
        jet[: len(y)] = y
        jet[4, 0] = y[4, 0] if len(y) > 4 else self.problem.yaw
        return jet


def units(problem: Problem) -> Array:
    """SI units of the kernel's state."""
    return np.array([1.0, 1.0, 1.0 / problem.t_des, 1.0 / problem.t_des, 1.0, 1.0 / problem.t_des])


def scales(problem: Problem, run_speed: float | None = None) -> Array:
    raise NotImplementedError


def numbers(problem: Problem) -> tuple[Array, Array, Array]:
    """Body, legs and start in the kernel's units, in the problem's precision."""
    p, t = problem, problem.t_des
    pull = p.gravity * np.sin(p.slope) * t**2
    body = np.array([pull, 0.0 if p.inertia is None else p.mass / p.inertia])
    legs = np.stack(
        [*p.hip.T, p.stiffness * t**2 / p.mass, p.length, p.ldev, p.phase, p.angle],
        axis=1,
    )
    turn = 2.0 * p.yaw if p.turn is None else p.turn
    return body, legs, np.array([p.speed * t, p.heading, *p.displacement, p.yaw, p.yaw_rate * t, turn])


def size(problem: Problem, direction: Direction) -> float:
    """Natural size of changes along a direction."""
    return problem.inertia or 0.0 if direction == "inertia" else problem.scale(direction)


def jets(problem: Problem, directions: Sequence[Direction]) -> list[Array]:
    """Body, legs and start as jets: with their derivatives along the directions (SI units) on a last axis."""
    columns = [numbers(problem)]
    for direction in directions:
        h = np.longdouble(1e-6 * size(problem, direction))
        ahead, behind = (numbers(problem.perturbed(direction, change)) for change in (h, -h))
        columns.append(tuple((a - b) / (2 * h) for a, b in zip(ahead, behind, strict=True)))  # type: ignore
    return [np.stack(column, axis=-1).astype(float) for column in zip(*columns, strict=True)]


def error_scale(problem: Problem, accuracy: float) -> float:
    animal = cockroach()
    longest = max(leg.length for leg in animal.legs)
    return Setting(animal, 0.0, (1, 1, 1)).error_scale(accuracy) * max(problem.length) / longest


def simulate(
    problem: Problem,
    end: float = 2.0,
    directions: Sequence[Direction] = (),
    accuracy: float = TIGHT,
    push: Array = NO_PUSH,
) -> Walk:
    body, legs, start = jets(problem, directions)
    rows = 4 if problem.inertia is None else 6
    side, offset = problem.function.astype(float), problem.offset.astype(float)
    scale = error_scale(problem, accuracy)
    return Walk(problem, *run(body, legs, side, offset, push, start, rows, end, scale, ROOM, ROOM))
