"""Walkers with any rules of touch-down and lift-off, dampers and length laws, by Taylor series.

They are described by numbers in the kernel's units and layout: a body (gravity along -y, m / I, and gravity along -x if
there is any), legs (hip x and y, stiffness,
length, ldev, phase, angle, damping, trigger, stay) and a start (speed, heading, Dx, Dy, yaw, yaw rate, turn). Triggers:
0 by the clock, -1 the ground, n the lift-off of the n-th leg. A stay of 0 lasts until the force is zero.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import cache
from typing import Any

import heyoka as hy
import numpy as np

from .problem import IGNORED, Array

Law = Callable[[Any, Any, Any, Any, Any], Any]
_FAR = 1e3
_SAME = 1e-9
_LEG = 12  # parameters of a leg: stiffness, length, ldev, phase, hip, foot, damping, begun, level, whether it is down
_SETTLE = 1e-6  # the first steps after an event, in which a leg just put down has a zero that hides others
_COOL = 1e-8
_TOGETHER = 1e-9  # height of a foot that is put down with another one, and gap of a leg that lifts off with another


def sinusoid(m: Any, t: Any, l0: Any, ldev: Any, phi: Any) -> Any:
    """Eq. (2.2); `m` has sin, cos and exp."""
    return l0 - ldev * m.sin(np.pi * t + phi)


@dataclass(frozen=True)
class Moved:
    """A leg that was put down before the start: how far the body has come since then, and turned."""

    x: float
    y: float
    turn: float


@dataclass(frozen=True)
class Stood:
    """A leg that an event has put down before the start: where its foot is from the body, and how long ago.

    From the side, its foot is on the ground.
    """

    x: float
    y: float | None
    age: float


@dataclass(frozen=True)
class Lands:
    """A leg that is put down at the start, as one of offset 0."""


Before = Moved | Stood | Lands | None
"""What is known of a leg before the start; None: that it is up."""


@dataclass(frozen=True)
class Walker:
    """What is to be simulated, in the kernel's units; `before` has what is known of each leg, if the start does not."""

    body: Array
    legs: Array
    side: Array
    offset: Array
    start: Array
    yaws: bool
    law: Law = sinusoid
    before: tuple[Before, ...] = ()

    def perturbed(self, name: str, index: Any, amount: float) -> Walker:
        """The same with one number changed: of the "body", the "legs" or the "start"."""
        parts = dict(vars(self))
        parts[name] = parts[name].copy()
        parts[name][index] += amount
        return Walker(**parts)

    @property
    def event_driven(self) -> bool:
        """Whether no leg goes by the clock."""
        return bool(np.all(self.legs[:, 8] != 0.0))


@dataclass(frozen=True)
class Walk:
    """States (x, y, vx, vy, yaw, yaw rate) and times at the ends of steps; events as (time, leg, kind).

    And, at the end, place (x, y, yaw) of the body when each leg was put down last, its foot, that time, and which are
    down.
    """

    states: Array
    times: Array
    events: list[tuple[float, int, str]]
    places: Array
    feet: Array
    since: Array
    down: Array

    @property
    def sequence(self) -> list[tuple[int, str]]:
        """Which leg did what, in order."""
        return [event[1:] for event in self.events]


@cache
def _integrator(n_legs: int, law: Law) -> Any:
    x, y, vx, vy, theta, omega = hy.make_vars("x", "y", "vx", "vy", "theta", "omega")
    gravity, mobility, across = (hy.par[n_legs * _LEG + i] for i in range(3))
    forces: list[tuple[Any, Any, Any]] = []
    pulls, heights = [], []
    for leg in range(n_legs):
        k, l0, ldev, phi, hip_x, hip_y, foot_x, foot_y, c, begun, level, down = (
            hy.par[leg * _LEG + i] for i in range(_LEG)
        )
        cosine, sine = hy.cos(theta), hy.sin(theta)
        arm_x, arm_y = cosine * hip_x - sine * hip_y, sine * hip_x + cosine * hip_y
        r_x, r_y = foot_x - x - arm_x, foot_y - y - arm_y
        distance = hy.sqrt(r_x**2 + r_y**2)
        lengthening = -(r_x * (vx - omega * arm_y) + r_y * (vy + omega * arm_x)) / distance
        age = hy.make_vars("age")
        free = hy.subs(law(hy, age, l0, ldev, phi), {age: hy.time - begun})
        pull = k * (distance - free) + c * lengthening
        pulls.append(pull)
        force_x, force_y = down * pull * r_x / distance, down * pull * r_y / distance
        forces.append((force_x, force_y, (foot_x - x) * force_y - (foot_y - y) * force_x))
        # The reach of a leg in the air, as seen from the body, is given in the place of its hip.
        heights.append(y + arm_y - level)
    sums = [hy.sum([force[i] for force in forces]) for i in range(3)]
    motion = [
        (x, vx),
        (y, vy),
        (vx, sums[0] - across),
        (vy, sums[1] - gravity),
        (theta, omega),
        (omega, mobility * sums[2]),
    ]
    events = [hy.t_event(pull, cooldown=_COOL) for pull in pulls]
    events += [hy.t_event(height, cooldown=_COOL, direction=hy.event_direction.negative) for height in heights]
    return hy.taylor_adaptive(motion, np.zeros(6), t_events=events, compact_mode=True)


def simulate(walker: Walker, steps: int = 1, up: Collection[int] = ()) -> Walk:
    """Simulate some steps: of the clock or, where no leg goes by it, to touch-downs of legs with offset 0 or 1.

    Legs that are ``up`` are so at the start, wherever they were put down before.
    """
    return _Walk(walker).run(steps, up)


class _Walk:
    def __init__(self, walker: Walker) -> None:
        self.walker, self.n = walker, len(walker.legs)
        self.taylor = _integrator(self.n, walker.law)
        taylor, start = self.taylor, walker.start
        course = start[1] + start[4]
        taylor.time = 0.0
        taylor.state[:] = (0.0, 0.0, -start[0] * np.sin(course), start[0] * np.cos(course), start[4], start[5])
        taylor.reset_cooldowns()
        self.pars = taylor.pars[:-3].reshape(self.n, _LEG)
        across = walker.body[2] if len(walker.body) > 2 else 0.0
        taylor.pars[-3:] = walker.body[0], walker.body[1] if walker.yaws else 0.0, across
        self.down = np.zeros(self.n, dtype=bool)
        self.since, self.places = np.full(self.n, -np.inf), np.zeros((self.n, 3))
        self.ground = -_FAR
        self.events: list[tuple[float, int, str]] = []
        self.ended = False

    def run(self, steps: int, up: Collection[int]) -> Walk:
        first = [leg for leg in range(self.n) if self.walker.offset[leg] == 0.0]
        self.ground = self._foot(first[0], self.taylor.state)[1] if first else -_FAR
        for leg in range(self.n):
            self._begin(leg)
        for leg in up:
            self._lift(leg)
        states, times = [self.taylor.state.copy()], [0.0]
        while len(states) <= steps:
            self._step()
            states.append(self.taylor.state.copy())
            times.append(self.taylor.time)
        return Walk(
            np.array(states), np.array(times), self.events, self.places, self.pars[:, 6:8].copy(), self.since, self.down
        )

    def _foot(self, leg: int, state: Array) -> Array:
        hip_x, hip_y, _, l0, ldev, phi, angle = self.walker.legs[leg, :7]
        length = self.walker.law(np, 0.0, l0, ldev, phi)
        cosine, sine = np.cos(state[4]), np.sin(state[4])
        x, y = hip_x - length * np.sin(angle), hip_y + length * np.cos(angle)
        return np.array([state[0] + cosine * x - sine * y, state[1] + sine * x + cosine * y])

    def _begin(self, leg: int) -> None:
        """Put a leg down at the start, or in the step before."""
        walker, start = self.walker, self.walker.start
        trigger, stay = walker.legs[leg, 8:10]
        if walker.offset[leg] == 0.0 or (walker.before and isinstance(walker.before[leg], Lands)):
            self._put_down(leg, 0.0, self.taylor.state)
            return
        ago = 2.0 - walker.offset[leg]
        before = np.array([-ago * start[2], -ago * start[3], 0.0, 0.0, start[4] - ago * start[6]])
        known = walker.before[leg] if walker.before else Moved(-before[0], -before[1], ago * start[6])
        nowhere = known is None or (not walker.before and trigger != 0.0 and start[2] == start[3] == 0.0)
        if isinstance(known, Moved):
            before = np.array([-known.x, -known.y, 0.0, 0.0, start[4] - known.turn])
        if isinstance(known, Stood):
            ago = known.age
        self._put_down(leg, -ago, before)
        if isinstance(known, Stood):
            self.pars[leg, 6:8] = known.x, self.ground if known.y is None else known.y
        if nowhere or (stay <= ago if stay > 0.0 else self._pull(leg) * walker.side[leg] < 0.0):
            self._lift(leg)

    def _pull(self, leg: int) -> float:
        (x, y, vx, vy, theta, omega), p = self.taylor.state, self.pars[leg]
        cosine, sine = np.cos(theta), np.sin(theta)
        arm_x, arm_y = cosine * p[4] - sine * p[5], sine * p[4] + cosine * p[5]
        r_x, r_y = p[6] - x - arm_x, p[7] - y - arm_y
        free = self.walker.law(np, self.taylor.time - p[9], *p[1:4])
        distance = np.hypot(r_x, r_y)
        lengthening = -(r_x * (vx - omega * arm_y) + r_y * (vy + omega * arm_x)) / distance
        return float(p[0] * (distance - free) + p[8] * lengthening)

    def _stretch(self, leg: int) -> float:
        """How far a leg is from zero force."""
        return self._pull(leg) / float(self.pars[leg, 0])

    def _height(self, leg: int) -> float:
        """Height above the ground of the foot of a leg that waits for it."""
        _, y, _, _, theta, _ = self.taylor.state
        x, ahead = self.pars[leg, 4:6]
        return float(y + np.sin(theta) * x + np.cos(theta) * ahead - self.pars[leg, 10])

    def _put_down(self, leg: int, time: float, state: Array) -> None:
        hip_x, hip_y, k, l0, ldev, phi, _, c = self.walker.legs[leg, :8]
        self.pars[leg] = k, l0, ldev, phi, hip_x, hip_y, *self._foot(leg, state), c, time, -_FAR, 1.0
        self.down[leg], self.since[leg], self.places[leg] = True, time, state[[0, 1, 4]]

    def _lift(self, leg: int) -> None:
        """Hold a leg in the air; where it waits for the ground, its foot is in the place of its hip."""
        waits = self.walker.legs[leg, 8] == -1.0
        state = np.zeros(5)
        self.pars[leg, 11] = 0.0
        self.pars[leg, 4:6] = self._foot(leg, state) if waits else 0.0
        self.pars[leg, 6:8] = 0.0, 2.0 * _FAR
        self.pars[leg, 10] = self.ground if waits else -_FAR
        self.down[leg] = False

    def _clock(self) -> list[tuple[float, int, str]]:
        """What happens by the clock, and when."""
        now, due = self.taylor.time, []
        for leg, (trigger, stay) in enumerate(self.walker.legs[:, 8:10]):
            if self.down[leg] and stay > 0.0:
                due.append((self.since[leg] + stay, leg, "liftoff"))
            if trigger == 0.0:
                due.append((self.since[leg] + 2.0, leg, "touchdown"))
        return sorted(event for event in due if event[0] > now - _SAME)

    def _step(self) -> None:
        taylor = self.taylor
        end = np.inf if self.walker.event_driven else np.floor(taylor.time + _SAME) + 1.0
        self.ended, events = False, len(self.events)
        while not self.ended:
            if len(self.events) > events + 100 or taylor.time > 1e3:
                raise ArithmeticError("the step does not end")
            due = self._clock()
            until = min([end, taylor.time + 50.0, *(event[0] for event in due[:1])])
            if self._advance(until):
                for _, leg, kind in [event for event in due if event[0] <= until + 1e-12]:
                    self._happen(leg, kind)
                if until >= end:
                    self.ended = True

    def _advance(self, until: float) -> bool:
        """Go on to a time, or to the next event and let it happen; whether the time is reached."""
        taylor = self.taylor
        fresh = taylor.time + _SETTLE
        outcome = taylor.propagate_until(min(fresh, until))[0]
        if outcome == hy.taylor_outcome.time_limit and fresh < until:
            outcome = taylor.propagate_until(until)[0]
        if outcome == hy.taylor_outcome.time_limit:
            return until < taylor.time + _SAME
        number = -int(outcome) - 1
        if not 0 <= number < 2 * self.n:
            raise ArithmeticError(f"the integration failed: {outcome}")
        leg, touches = number % self.n, number >= self.n
        trigger, stay = self.walker.legs[leg, 8:10]
        age = taylor.time - self.since[leg]
        if touches and not self.down[leg] and trigger == -1.0:
            self._happen(leg, "touchdown")
        elif not touches and self.down[leg] and stay == 0.0 and age > (IGNORED if trigger == 0.0 else _SETTLE):
            self._happen(leg, "liftoff")
        return False

    def _happen(self, leg: int, kind: str) -> None:
        time, by_event = self.taylor.time, self.walker.legs[leg, 8] != 0.0
        self.events.append((time, leg, kind))
        if kind == "touchdown":
            self._put_down(leg, time, self.taylor.state)
            if by_event and self.walker.event_driven and self.walker.offset[leg] in (0.0, 1.0):
                self.ended = True
            for other, trigger in enumerate(self.walker.legs[:, 8]):
                if trigger == -1.0 and not self.down[other] and abs(self._height(other)) < _TOGETHER:
                    self._happen(other, "touchdown")
            return
        self._lift(leg)
        for other, (trigger, stay) in enumerate(self.walker.legs[:, 8:10]):
            if trigger == leg + 1:
                self._happen(other, "touchdown")
            aged = time - self.since[other] > (IGNORED if trigger == 0.0 else _SETTLE)
            if self.down[other] and stay == 0.0 and aged and abs(self._stretch(other)) < _TOGETHER:
                self._happen(other, "liftoff")


def central_derivative(
    walker: Walker, name: str, index: Any, steps: int, step: float, levels: int = 4
) -> tuple[Array, Array]:
    """Derivative of the state and time at the end by a number, by extrapolated central differences, and its error."""

    def end(amount: float) -> Array:
        walk = simulate(walker.perturbed(name, index, amount), steps)
        # Several legs may be lifted by the clock at once.
        if sorted(walk.sequence) != sorted(expected):
            raise ValueError(f"the order of events changes along {name}{index}")
        return np.append(walk.states[-1], walk.times[-1])

    expected = simulate(walker, steps).sequence
    table: list[Array] = []
    for level in range(levels):
        h = step / 2**level
        row = [(end(h) - end(-h)) / (2 * h)]
        for order, coarser in enumerate(table, start=1):
            row.append(row[-1] + (row[-1] - coarser) / (4**order - 1))
        table = row
    return table[-1], np.abs(table[-1] - table[-2])
