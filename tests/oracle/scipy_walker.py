"""Simulation with `scipy.integrate.solve_ivp`, as one would reasonably write it for research."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import cos, pi, sin, sqrt
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from .problem import IGNORED, Array, Event, Problem, Run

RightHandSide = Callable[[float, Array], Sequence[float]]
Leg = tuple[float, ...]
_TOUCHING = 1e-12  # legs whose gap is below this part of their length lift off together with another


def simulate(
    problem: Problem,
    strides: float = 1.0,
    rtol: float = 1e-10,
    atol: float = 1e-12,
    max_step: float = np.inf,
) -> Run:
    """Simulate a number of strides.

    SciPy finds a lift-off by a change of sign from one integrator step to the next, so it misses one where
    the gap has two zeros within a step: in 1 of 500 random problems with the default tolerances.

    Parameters
    ----------
    problem
        The animal and its start.
    strides
        How many, in halves: 0.5 is a step.
    rtol, atol
        Tolerances of the integrator, DOP853.
    max_step
        Longest integrator step, in units of t_des.

    Returns
    -------
    Run
        Its work is not computed: nan.
    """
    options = {"method": "DOP853", "rtol": rtol, "atol": atol, "max_step": max_step * problem.t_des}
    t_des, n, steps = float(problem.t_des), problem.n_legs, round(2 * strides)
    states = np.empty((steps + 1, 6))
    states[0] = state = problem.start
    down_at_start = np.array([problem.offset[leg] == 1 and problem.old_leg_is_down(leg) for leg in range(n)])
    stance = {leg: (-t_des, problem.foot(leg, problem.before)) for leg in range(n) if down_at_start[leg]}
    events: list[Event] = []
    for step in range(steps):
        begin, end = step * t_des, (step + 1) * t_des
        fresh = [leg for leg in range(n) if step >= problem.offset[leg] and (step - problem.offset[leg]) % 2 == 0]
        for leg in fresh:
            foot = problem.foot(leg, state)
            stance[leg] = begin, foot
            events.append(Event(begin, leg, "touchdown", state.copy(), foot))
        window = begin + IGNORED * t_des if fresh else begin
        t = begin
        while t < end:
            watched = [leg for leg in stance if t >= window or leg not in fresh]
            stop = window if t < window else end
            t, state = _integrate(problem, stance, watched, t, stop, state, options)
            for leg in watched:
                touch_down, foot = stance[leg]
                gap, rate = problem.gap(leg, state, foot, (t - touch_down) / t_des)
                if abs(gap) < _TOUCHING * problem.length[leg]:
                    events.append(Event(t, leg, "liftoff", state.copy(), foot, rate))
                    del stance[leg]
        states[step + 1] = state
    work = np.full((2, steps, n), np.nan)
    return Run(problem, states, events, down_at_start, *work)


def _integrate(
    problem: Problem,
    stance: dict[int, tuple[float, Array]],
    watched: list[int],
    begin: float,
    end: float,
    state: Array,
    options: dict[str, Any],
) -> tuple[float, Array]:
    """Integrate until a watched leg's gap is zero, at most to the end; the time and state there."""
    legs = {leg: _constants(problem, leg, *stance[leg]) for leg in stance}
    equations, size = (_point_mass, 4) if problem.inertia is None else (_rigid_body, 6)
    solution = solve_ivp(
        equations(problem, list(legs.values())),
        (begin, end),
        state[:size],
        events=[_gap(problem, legs[leg]) for leg in watched] or None,
        **options,
    )
    if not solution.success:
        raise ArithmeticError(solution.message)
    reached = state.copy()
    reached[:size] = solution.y[:, -1]
    return float(solution.t[-1]), reached


def _constants(problem: Problem, leg: int, touch_down: float, foot: Array) -> Leg:
    """Stiffness, length, ldev, clock at t = 0, hip and foot of a leg as plain numbers."""
    clock = problem.phase[leg] - pi * touch_down / problem.t_des
    numbers = problem.stiffness[leg], problem.length[leg], problem.ldev[leg], clock, *problem.hip[leg], *foot
    return tuple(float(number) for number in numbers)


def _point_mass(problem: Problem, legs: list[Leg]) -> RightHandSide:
    """Equations of motion with the yaw held, in (x, y, vx, vy)."""
    pull, mass, rate = problem.gravity * sin(problem.slope), problem.mass, pi / problem.t_des
    sine, cosine = sin(problem.yaw), cos(problem.yaw)
    anchors = [  # feet as seen from the hips, were the com at the origin
        (
            k,
            length,
            ldev,
            clock,
            foot_x - (cosine * hip_x - sine * hip_y),
            foot_y - (sine * hip_x + cosine * hip_y),
        )
        for k, length, ldev, clock, hip_x, hip_y, foot_x, foot_y in legs
    ]

    def right_hand_side(t: float, state: Array) -> Sequence[float]:
        x, y, vx, vy = state.tolist()
        force_x = force_y = 0.0
        for k, length, ldev, clock, anchor_x, anchor_y in anchors:
            r_x, r_y = anchor_x - x, anchor_y - y
            distance = sqrt(r_x * r_x + r_y * r_y)
            force = k * (1.0 - (length - ldev * sin(rate * t + clock)) / distance)
            force_x += force * r_x
            force_y += force * r_y
        return vx, vy, force_x / mass, force_y / mass - pull

    return right_hand_side


def _rigid_body(problem: Problem, legs: list[Leg]) -> RightHandSide:
    """Equations of motion in (x, y, vx, vy, theta, omega)."""
    pull, mass, rate = problem.gravity * sin(problem.slope), problem.mass, pi / problem.t_des
    inertia = problem.inertia or np.inf

    def right_hand_side(t: float, state: Array) -> Sequence[float]:
        x, y, vx, vy, theta, omega = state.tolist()
        sine, cosine = sin(theta), cos(theta)
        force_x = force_y = torque = 0.0
        for k, length, ldev, clock, hip_x, hip_y, foot_x, foot_y in legs:
            from_com_x, from_com_y = foot_x - x, foot_y - y
            r_x = from_com_x - (cosine * hip_x - sine * hip_y)
            r_y = from_com_y - (sine * hip_x + cosine * hip_y)
            distance = sqrt(r_x * r_x + r_y * r_y)
            force = k * (1.0 - (length - ldev * sin(rate * t + clock)) / distance)
            force_x += force * r_x
            force_y += force * r_y
            torque += force * (from_com_x * r_y - from_com_y * r_x)
        return vx, vy, force_x / mass, force_y / mass - pull, omega, torque / inertia

    return right_hand_side


def _gap(problem: Problem, leg: Leg) -> Callable[[float, Array], float]:
    """A leg's length less its force-free length, as a terminal event."""
    _, length, ldev, clock, hip_x, hip_y, foot_x, foot_y = leg
    rate, yaw = pi / problem.t_des, float(problem.yaw)

    def gap(t: float, state: Array) -> float:
        theta = state[4] if len(state) > 4 else yaw
        sine, cosine = sin(theta), cos(theta)
        r_x = foot_x - state[0] - (cosine * hip_x - sine * hip_y)
        r_y = foot_y - state[1] - (sine * hip_x + cosine * hip_y)
        return sqrt(r_x * r_x + r_y * r_y) - (length - ldev * sin(rate * t + clock))

    gap.terminal = True  # type: ignore[attr-defined]
    return gap
