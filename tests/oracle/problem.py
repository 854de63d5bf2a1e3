"""What the oracles are asked (`Problem`), what they answer (`Run`), and some animals to ask them about."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Direction = str | tuple[str, int | Sequence[int]]

IGNORED = 1 / 50
"""Zeros of a leg's force within this part of a step after its own touch-down are no lift-off."""


@dataclass(frozen=True)
class Problem:
    """A planar body on clock-driven springy legs, and a start. SI units, radians.

    Parameters
    ----------
    mass, inertia
        Of the body; inertia None holds the yaw.
    gravity, slope
        The pull along the plane is ``gravity * sin(slope)``, towards -y.
    t_des, v_des
        Duration of a step and desired speed.
    hip
        Hips in the body's frame, shape (n, 2); the other leg arrays have shape (n,).
    stiffness, length, ldev, phase
        Of each leg: its force-free length is ``length - ldev sin(pi (t - t_start) / t_des + phase)``.
    angle
        Of each leg at touch-down, counter-clockwise from straight ahead of the body.
    function
        -1 for a leg meant to push, +1 for one meant to pull.
    offset
        First touch-down in units of t_des: 0 or 1. Legs with 1 were put down at -t_des, too.
    speed, heading, yaw, yaw_rate
        The start, com at the origin; the velocity points ``heading + yaw`` counter-clockwise from +y.
    previous
        Displacement of the com over the step before the start; None for (0, v_des t_des).
    turn
        Change of the yaw over the step before the start; None for 2 yaw, which mirrored steps have.
    """

    mass: float
    inertia: float | None
    gravity: float
    slope: float
    t_des: float
    v_des: float
    hip: Array
    stiffness: Array
    length: Array
    ldev: Array
    phase: Array
    angle: Array
    function: Array
    offset: Array
    speed: float
    heading: float
    yaw: float = 0.0
    yaw_rate: float = 0.0
    previous: Array | None = None
    turn: float | None = None

    @property
    def n_legs(self) -> int:
        """Number of legs."""
        return len(self.length)

    @property
    def displacement(self) -> Array:
        """Displacement of the com over the step before the start."""
        if self.previous is None:
            return np.array([0.0, self.v_des * self.t_des])
        return np.asarray(self.previous)

    @property
    def start(self) -> Array:
        """State (x, y, vx, vy, theta, omega) at t = 0."""
        course = self.heading + self.yaw
        velocity = (-self.speed * np.sin(course), self.speed * np.cos(course))
        yaw_rate = 0.0 if self.inertia is None else self.yaw_rate
        return np.array([0.0, 0.0, *velocity, self.yaw, yaw_rate])

    @property
    def before(self) -> Array:
        """State at t = -t_des as far as it is known: com and yaw; the velocities are zeros."""
        yaw = -self.yaw if self.turn is None else self.yaw - self.turn
        return np.array([*-self.displacement, 0.0, 0.0, yaw, 0.0])

    def foot(self, leg: int, state: Array) -> Array:
        """Where a leg is put down by the body in the given state."""
        length = self.length[leg] - self.ldev[leg] * np.sin(self.phase[leg])
        course = self.angle[leg] + state[4]
        foot: Array = self._hip(leg, state) + length * np.array([-np.sin(course), np.cos(course)])
        return foot

    def gap(self, leg: int, state: Array, foot: Array, age: float) -> tuple[float, float]:
        """How much longer a leg is than its force-free length, and the rate of that.

        Parameters
        ----------
        leg
            Its index.
        state
            Of the body.
        foot
            Of the leg.
        age
            Time since its touch-down, in units of t_des.

        Returns
        -------
        gap, rate
            In m and m/s.
        """
        arm = self._hip(leg, state) - state[:2]
        r = foot - state[:2] - arm
        r_rate = -state[2:4] - state[5] * np.array([-arm[1], arm[0]])
        distance = np.sqrt(r @ r)
        clock = np.pi * age + self.phase[leg]
        free = self.length[leg] - self.ldev[leg] * np.sin(clock)
        free_rate = -self.ldev[leg] * np.pi / self.t_des * np.cos(clock)
        return distance - free, r @ r_rate / distance - free_rate

    def old_leg_is_down(self, leg: int) -> bool:
        """Whether a leg put down at -t_des is in stance at the start: its force has its function's sign."""
        gap, _ = self.gap(leg, self.start, self.foot(leg, self.before), 1.0)
        return bool(gap >= 0 if self.function[leg] > 0 else gap <= 0)

    def perturbed(self, direction: Direction, amount: float) -> Problem:
        """The problem with one thing changed.

        Parameters
        ----------
        direction
            "speed", "heading", "yaw", "yaw_rate", "turn", "slope", "Dx", "Dy" (`previous`), or a pair: one of
            "phase", "ldev", "length", "stiffness", "angle", "hip_x", "hip_y" and the leg or legs to change.
        amount
            By how much, in SI units; an extended-precision number makes the field one, too.
        """
        if isinstance(direction, str):
            if direction in ("Dx", "Dy"):
                change = amount * np.array([direction == "Dx", direction == "Dy"])
                return replace(self, previous=self.displacement + change)
            value = 2 * self.yaw if direction == "turn" and self.turn is None else getattr(self, direction)
            scalar: dict[str, Any] = {direction: value + amount}
            return replace(self, **scalar)
        name, legs = direction
        chosen = np.zeros(self.n_legs)
        chosen[np.asarray(legs)] = 1.0
        if name in ("hip_x", "hip_y"):
            return replace(self, hip=self.hip + amount * np.outer(chosen, [name == "hip_x", name == "hip_y"]))
        return replace(self, **{name: getattr(self, name) + amount * chosen})

    def scale(self, direction: Direction) -> float:
        """A natural size, in SI units, for changes along a direction."""
        name = direction if isinstance(direction, str) else direction[0]
        if name == "speed":
            return self.v_des
        if name == "yaw_rate":
            return 1 / self.t_des
        if name == "stiffness":
            return float(max(self.stiffness))
        return float(max(self.length)) if name in ("Dx", "Dy", "ldev", "length", "hip_x", "hip_y") else 1.0

    def _hip(self, leg: int, state: Array) -> Array:
        sine, cosine = np.sin(state[4]), np.cos(state[4])
        x, y = self.hip[leg]
        hip: Array = state[:2] + np.array([cosine * x - sine * y, sine * x + cosine * y])
        return hip


@dataclass(frozen=True)
class Event:
    """A touch-down or lift-off: time, leg, the body's state, the foot, d(|r| - l)/dt (0 at touch-down)."""

    t: float
    leg: int
    kind: Literal["touchdown", "liftoff"]
    state: Array
    foot: Array
    gap_rate: float = 0.0


@dataclass(frozen=True)
class Run:
    """The motion over a number of steps.

    Parameters
    ----------
    problem
        What was simulated.
    states
        (x, y, vx, vy, theta, omega) at the start and at the end of each step, shape (steps + 1, 6).
    events
        In order of time, from the touch-downs at t = 0 on; those at the end are not in it.
    down_at_start
        For each leg whether it was put down before t = 0 and is in stance then.
    work_positive, work_negative
        Work done on the body by each leg in each step, its gains and its losses, shape (steps, n).
    """

    problem: Problem
    states: Array
    events: list[Event]
    down_at_start: NDArray[np.bool_]
    work_positive: Array
    work_negative: Array

    @property
    def state(self) -> Array:
        """State at the end."""
        return np.asarray(self.states[-1])

    @property
    def liftoffs(self) -> list[Event]:
        """The lift-offs in order of time."""
        return [event for event in self.events if event.kind == "liftoff"]

    @property
    def min_gap_rate(self) -> float:
        """Smallest abs(d(|r| - l)/dt) at a lift-off, m/s: how far the motion is from a tangential one."""
        return min((abs(event.gap_rate) for event in self.liftoffs), default=float("inf"))

    def transport_cost(self, steps: int = 1) -> float:
        """Transport cost (3.6), averaged over the first steps."""
        p = self.problem
        effort = np.sum(self.work_positive[:steps] - self.work_negative[:steps])
        return float(effort / (p.mass * p.gravity * p.v_des * p.t_des * steps))


LEGS = ("FL", "MR", "BL", "FR", "ML", "BR")
_SIDE = np.array([1.0, 1.0, 1.0, -1.0, -1.0, -1.0])
_LENGTH = np.array([0.032, 0.026, 0.019] * 2)
_ANGLE = np.deg2rad([25.0, -55.0, 120.0] * 2) * _SIDE
_HIP = 1e-3 * np.array([(-3.5, 14.0), (3.5, 7.0), (-3.5, 0.0), (3.5, 14.0), (-3.5, 7.0), (3.5, 0.0)])
_OFFSET = np.array([0.0, 0.0, 0.0, 1.0, 1.0, 1.0])
_MASS, _INERTIA, _STIFFNESS, _GRAVITY = 2.5e-3, 2.04e-7, 1.5, 9.81


def cockroach_problem(row: Mapping[str, str], rigid: bool = False) -> Problem:
    """The thesis's cockroach, started as a row of ``strides.csv`` says.

    Parameters
    ----------
    row
        Column names to values.
    rigid
        Instead of the point mass, a body that yaws, with hips off its centre and the same nominal feet.
    """

    def legs(name: str) -> Array:
        return np.array([float(row[f"{name}_{leg}"]) for leg in "FMB"] * 2)

    function = 1.0 - 2.0 * legs("push")
    hip, length, angle = _nominal_legs(_HIP if rigid else np.zeros((6, 2)))
    return Problem(
        mass=_MASS,
        inertia=_INERTIA if rigid else None,
        gravity=_GRAVITY,
        slope=np.deg2rad(float(row["slope_deg"])),
        t_des=float(row["t_des"]),
        v_des=float(row["v_des"]),
        hip=hip,
        stiffness=np.full(6, _STIFFNESS),
        length=length,
        ldev=function * legs("ldev"),
        phase=legs("phi"),
        angle=angle,
        function=function,
        offset=_OFFSET,
        speed=float(row["v0"]),
        heading=float(row["heading"]),
    )


def random_problem(rng: np.random.Generator, yaw: bool) -> Problem:
    """An animal like the cockroach, scaled and distorted at random, its legs not even symmetric, and a start.

    Parameters
    ----------
    rng
        Where the randomness comes from.
    yaw
        Whether the body yaws and its hips are off its centre.
    """

    def vary(least: float, most: float, shape: int | tuple[int, ...] | None = None) -> Any:
        return np.exp(rng.uniform(np.log(least), np.log(most), shape))

    size, mass = vary(0.4, 2.5), vary(0.4, 2.5)
    hip, length, angle = _nominal_legs(_HIP * vary(0.7, 1.4, (6, 2)) if yaw else np.zeros((6, 2)))
    slope = np.deg2rad(rng.uniform(-30.0, 90.0))
    uphill = max(slope, 0.0) / (np.pi / 2)
    function = rng.choice([-1.0, 1.0], 6)
    length = size * length * vary(0.8, 1.25, 6)
    v_des = np.sqrt(size) * (0.35 - 0.15 * uphill) * vary(0.8, 1.25)
    t_des = np.sqrt(size) * (0.0364 + 0.0234 * uphill) * vary(0.8, 1.25)
    return Problem(
        mass=_MASS * mass,
        inertia=_INERTIA * mass * size**2 * vary(0.7, 2.0) if yaw else None,
        gravity=_GRAVITY,
        slope=slope,
        t_des=t_des,
        v_des=v_des,
        hip=size * hip,
        stiffness=_STIFFNESS * mass / size * vary(0.6, 1.6, 6),
        length=length,
        ldev=function * length * rng.uniform(0.15, 0.6, 6),
        phase=np.deg2rad(rng.uniform(-80.0, 87.0, 6)),
        angle=angle + rng.uniform(-0.15, 0.15, 6),
        function=function,
        offset=_OFFSET,
        speed=v_des * rng.uniform(0.8, 1.3),
        heading=rng.uniform(-0.4, 0.4),
        yaw=rng.uniform(-0.15, 0.15) if yaw else 0.0,
        yaw_rate=rng.uniform(-0.3, 0.3) / t_des if yaw else 0.0,
        previous=v_des * t_des * np.array([rng.uniform(-0.1, 0.1), rng.uniform(0.9, 1.1)]),
    )


def _nominal_legs(hip: Array) -> tuple[Array, Array, Array]:
    """Hips, lengths and angles of legs from given hips to the thesis's nominal feet."""
    leg = _LENGTH[:, None] * np.stack([-np.sin(_ANGLE), np.cos(_ANGLE)], axis=1) - hip
    return hip, np.hypot(*leg.T), np.arctan2(-leg[:, 0], leg[:, 1])
