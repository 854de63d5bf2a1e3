"""Simulation with `scipy.integrate.solve_ivp`, the legs as NumPy arrays, as most researchers would write it.

The rules are those of `tests.oracle.scipy_walker`, which computes leg after leg in plain floats.
"""

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from tests.oracle.problem import IGNORED, Problem

Floats = NDArray[np.float64]
TOUCHING = 1e-12


class Walk:
    """A walk of one animal, and where its feet are."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        n = problem.n_legs
        self.down = np.array([problem.offset[leg] == 1 and problem.old_leg_is_down(leg) for leg in range(n)])
        self.since = np.full(n, -problem.t_des)
        self.feet = np.array([problem.foot(leg, problem.before) for leg in range(n)])
        self.pull = np.array([0.0, problem.gravity * np.sin(problem.slope)])

    def hips(self, state: Floats) -> Floats:
        """Hips relative to the centre of mass."""
        if len(state) == 4:
            return self.problem.hip
        sine, cosine = np.sin(state[4]), np.cos(state[4])
        hips: Floats = self.problem.hip @ np.array([[cosine, sine], [-sine, cosine]])
        return hips

    def springs(self, t: float, state: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Return hips, vectors from hip to foot, their lengths, and how much longer than force-free these are."""
        p, hips = self.problem, self.hips(state)
        r = self.feet - state[:2] - hips
        distance = np.hypot(r[:, 0], r[:, 1])
        free = p.length - p.ldev * np.sin(np.pi * (t - self.since) / p.t_des + p.phase)
        return hips, r, distance, distance - free

    def rates(self, t: float, state: Floats) -> Floats:
        """Return the equations of motion."""
        p = self.problem
        hips, r, distance, gap = self.springs(t, state)
        force = np.where(self.down, p.stiffness * gap / distance, 0.0)[:, None] * r
        acceleration = force.sum(axis=0) / p.mass - self.pull
        if p.inertia is None:
            return np.concatenate([state[2:4], acceleration])
        torque = np.sum(hips[:, 0] * force[:, 1] - hips[:, 1] * force[:, 0])
        return np.concatenate([state[2:4], acceleration, [state[5], torque / p.inertia]])

    def gap(self, leg: int, t: float, state: Floats) -> float:
        """Return a leg's length less its force-free length."""
        p = self.problem
        x, y = self.feet[leg] - state[:2] - self.hips(state)[leg]
        free = p.length[leg] - p.ldev[leg] * np.sin(np.pi * (t - self.since[leg]) / p.t_des + p.phase[leg])
        return float(np.hypot(x, y) - free)

    def leg_event(self, leg: int) -> Callable[[float, Floats], float]:
        """Return a leg's gap as a terminal event."""
        event = partial(self.gap, leg)
        event.terminal = True  # type: ignore[attr-defined]
        return event


def simulate(problem: Problem, strides: float = 1.0, rtol: float = 1e-10, atol: float = 1e-12) -> Floats:
    """Simulate a number of strides; return the state at the end."""
    walk, t_des = Walk(problem), float(problem.t_des)
    state = problem.start if problem.inertia is not None else problem.start[:4]
    for step in range(round(2 * strides)):
        begin, end = step * t_des, (step + 1) * t_des
        fresh = (step - problem.offset) % 2 == 0
        whole = np.append(state, np.zeros(6 - len(state)))
        for leg in np.flatnonzero(fresh).tolist():
            walk.feet[leg] = problem.foot(leg, whole)
        walk.down |= fresh
        walk.since[fresh] = begin
        t, window = begin, begin + IGNORED * t_des
        while t < end:
            watched = np.flatnonzero(walk.down & ~(fresh & (t < window))).tolist()
            solution = solve_ivp(
                walk.rates,
                (t, window if t < window else end),
                state,
                method="DOP853",
                rtol=rtol,
                atol=atol,
                events=[walk.leg_event(leg) for leg in watched] or None,
            )
            t, state = float(solution.t[-1]), solution.y[:, -1]
            gap = np.abs(walk.springs(t, state)[3])
            for leg in watched:
                walk.down[leg] = gap[leg] >= TOUCHING * problem.length[leg]
    end_state: Floats = state
    return end_state
