"""Simulation by Taylor series, to the last bits of a double or, if asked, of an extended one.

One integrator is compiled for each number of legs; everything that tells problems and moments apart is a
runtime parameter. Inside, the units are the step (t_des; each begins at 0), the longest leg and the mass.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import heyoka as hy
import numpy as np

from .problem import IGNORED, Array, Direction, Event, Problem, Run

_FAR = 1e3  # where the feet of swinging legs are parked, in longest legs
_SAME = 1e-14  # lift-offs closer than this, in steps, are one event
_SETTLE = 1e-6  # the first integrator step after a touch-down, in steps
_LEG_PARAMETERS = 8


@dataclass
class _Integrator:
    """A compiled integrator of (x, y, vx, vy, theta, omega, work of each leg).

    While it steps, it notes zeros of each leg's gap and rate of lengthening as (time, leg, is gap).
    """

    n_legs: int
    tol: float
    real: Any
    marks: list[tuple[Any, int, bool]] = field(default_factory=list)

    def __post_init__(self) -> None:
        x, y, vx, vy, theta, omega = hy.make_vars("x", "y", "vx", "vy", "theta", "omega")
        pull, mobility = (hy.par[self.n_legs * _LEG_PARAMETERS + i] for i in range(2))
        force_x, force_y, torque, work, events = [], [], [], [], []
        for leg in range(self.n_legs):
            first = leg * _LEG_PARAMETERS
            stiffness, length, ldev, clock, hip_x, hip_y, foot_x, foot_y = (
                hy.par[first + i] for i in range(_LEG_PARAMETERS)
            )
            arm_x = hy.cos(theta) * hip_x - hy.sin(theta) * hip_y
            arm_y = hy.sin(theta) * hip_x + hy.cos(theta) * hip_y
            r_x, r_y = foot_x - x - arm_x, foot_y - y - arm_y
            distance = hy.sqrt(r_x**2 + r_y**2)
            lengthening = -(r_x * (vx - omega * arm_y) + r_y * (vy + omega * arm_x)) / distance
            gap = distance - length + ldev * hy.sin(hy.pi * hy.time + clock)
            force = stiffness * gap
            force_x.append(force * r_x / distance)
            force_y.append(force * r_y / distance)
            torque.append((foot_x - x) * force_y[leg] - (foot_y - y) * force_x[leg])
            work.append((hy.make_vars(f"work_{leg}"), -force * lengthening))
            events += [self._note(gap, leg, True), self._note(lengthening, leg, False)]
        motion = [
            (x, vx),
            (y, vy),
            (vx, hy.sum(force_x)),
            (vy, hy.sum(force_y) - pull),
            (theta, omega),
            (omega, mobility * hy.sum(torque)),
        ]
        self.taylor = hy.taylor_adaptive(
            motion + work,
            np.zeros(6 + self.n_legs, dtype=self.real),
            nt_events=events,
            tol=self.real(self.tol),
            fp_type=self.real,
            compact_mode=True,
        )

    def _note(self, expression: Any, leg: int, is_gap: bool) -> Any:
        marks = self.marks
        return hy.nt_event(expression, lambda _, t, __: marks.append((t, leg, is_gap)), fp_type=self.real)


@cache
def _integrator(n_legs: int, tol: float, real: Any) -> _Integrator:
    return _Integrator(n_legs, tol, real)


def simulate(problem: Problem, strides: float = 1.0, tol: float = 0.0, real: Any = float) -> Run:
    """Simulate a number of strides.

    Parameters
    ----------
    problem
        The animal and its start.
    strides
        How many, in halves: 0.5 is a step.
    tol
        Of the Taylor series, relative; 0 for the roundoff of `real`.
    real
        Floating-point type to compute in and to answer in: float or ``numpy.longdouble``.

    Returns
    -------
    Run
        With the work of the legs.
    """
    return _Walk(problem, _integrator(problem.n_legs, tol, real)).run(round(2 * strides))


class _Walk:
    """The rules of touch-down and lift-off around the compiled integrator."""

    def __init__(self, problem: Problem, integrator: _Integrator) -> None:
        self.problem, self.integrator, self.taylor = problem, integrator, integrator.taylor
        real, n = integrator.real, problem.n_legs
        self.length, self.t_des, mass = real(max(problem.length)), real(problem.t_des), real(problem.mass)
        speed = self.length / self.t_des
        self.units = np.array([self.length, self.length, speed, speed, real(1), 1 / self.t_des])
        self.energy = mass * speed**2
        self.pi = 4 * np.arctan(real(1))
        mobility = real(0) if problem.inertia is None else mass * self.length**2 / real(problem.inertia)
        self.taylor.pars[-2:] = (
            real(problem.gravity) * np.sin(real(problem.slope)) * self.t_des / speed,
            mobility,
        )
        self.legs = self.taylor.pars[:-2].reshape(n, _LEG_PARAMETERS)
        self.legs[:, 1] = problem.length / self.length
        self.legs[:, 2] = problem.ldev / self.length
        self.legs[:, 4:6] = problem.hip / self.length
        self.stiffness = problem.stiffness * self.t_des**2 / mass
        self.feet = np.zeros((n, 2), dtype=real)
        self.down = np.zeros(n, dtype=bool)
        self.age = np.ones(n, dtype=int)  # of the stance at the beginning of the step, in steps
        self.events: list[Event] = []
        for leg in range(n):
            self._lift(leg)

    def run(self, steps: int) -> Run:
        """Walk from the start."""
        problem, real = self.problem, self.integrator.real
        old = [leg for leg in range(problem.n_legs) if problem.offset[leg] == 1 and problem.old_leg_is_down(leg)]
        for leg in old:
            self._put_down(leg, problem.before)
        states = np.empty((steps + 1, 6), dtype=real)
        states[0] = problem.start
        work = np.zeros((2, steps, problem.n_legs), dtype=real)
        for step in range(steps):
            for leg in range(problem.n_legs):
                since = step - int(problem.offset[leg])
                self.age[leg] = since % 2
                if since >= 0 and since % 2 == 0:
                    self._put_down(leg, states[step])
                    event = Event(step * problem.t_des, leg, "touchdown", states[step].copy(), self.feet[leg].copy())
                    self.events.append(event)
            self.legs[:, 3] = np.asarray(problem.phase) + self.age * self.pi
            states[step + 1] = self._step(step, states[step], work[:, step])
        down_at_start = np.isin(np.arange(problem.n_legs), old)
        return Run(problem, states, self.events, down_at_start, *(work * self.energy))

    def _step(self, step: int, start: Array, work: Array) -> Array:
        """Integrate to the next touch-downs; `work` (gains, losses) is added to.

        A new leg's gap is exactly zero at first, which hides its other zeros in the same integrator step from
        heyoka's search, so the first such step is tiny.
        """
        taylor, real = self.taylor, self.integrator.real
        taylor.time = real(0)
        taylor.state[:6] = start / self.units
        taylor.state[6:] = 0
        work_before = np.zeros_like(work[0])
        for end in (real(_SETTLE), real(1)):
            while not self._advance(step, end, work, work_before):
                pass
        for leg in range(len(work_before)):
            self._add_work(work, work_before, leg, taylor.state[6 + leg])
        return np.asarray(taylor.state[:6] * self.units)

    def _advance(self, step: int, end: Any, work: Array, work_before: Array) -> bool:
        """Take one integrator step, at most to the next lift-off or the end; whether the end is reached."""
        taylor, marks = self.taylor, self.integrator.marks
        marks.clear()
        outcome, _ = taylor.step(end - taylor.time, write_tc=True)
        if outcome not in (hy.taylor_outcome.success, hy.taylor_outcome.time_limit):
            raise ArithmeticError(f"the integration failed: {outcome}")
        valid = sorted(mark for mark in marks if self.down[mark[1]])
        lifting = [(t, leg) for t, leg, is_gap in valid if is_gap and t + self.age[leg] > IGNORED]
        cut = lifting[0][0] if lifting else taylor.time
        for t, leg, _ in valid:
            if t <= cut:
                self._add_work(work, work_before, leg, taylor.update_d_output(t)[6 + leg])
        if not lifting:
            return bool(outcome == hy.taylor_outcome.time_limit)
        taylor.state[:] = taylor.update_d_output(cut)
        taylor.time = cut
        for leg in {leg for t, leg in lifting if t <= cut + _SAME}:
            self._lift_off(step, leg)
        return False

    @staticmethod
    def _add_work(work: Array, before: Array, leg: int, now: Any) -> None:
        """Count what a leg has done since its power last changed sign."""
        change = now - before[leg]
        work[0 if change > 0 else 1, leg] += change
        before[leg] = now

    def _put_down(self, leg: int, state: Array) -> None:
        self.feet[leg] = self.problem.foot(leg, state)
        self.down[leg] = True
        self.legs[leg, 0] = self.stiffness[leg]
        self.legs[leg, 6:8] = self.feet[leg] / self.length

    def _lift(self, leg: int) -> None:
        self.down[leg] = False
        self.legs[leg, 0] = 0
        self.legs[leg, 6:8] = 0, _FAR

    def _lift_off(self, step: int, leg: int) -> None:
        """Lift a leg at the integrator's present time."""
        time, state = self.taylor.time, self.taylor.state[:6] * self.units
        _, rate = self.problem.gap(leg, state, self.feet[leg], time + self.age[leg])
        t = (step + time) * self.t_des
        self.events.append(Event(t, leg, "liftoff", state, self.feet[leg].copy(), rate))
        self._lift(leg)


def central_jacobian(
    problem: Problem,
    directions: Sequence[Direction],
    strides: float = 0.5,
    step: float = 1e-3,
    levels: int = 4,
    real: Any = np.longdouble,
) -> tuple[Array, Array]:
    """Derivatives of the state after some strides, by central differences with Richardson extrapolation.

    Parameters
    ----------
    problem
        Where to differentiate.
    directions
        As in `Problem.perturbed`.
    strides
        How many, in halves.
    step
        Largest difference, in units of `Problem.scale`; each level halves it.
    levels
        Differences per direction.
    real
        Floating-point type to compute in.

    Returns
    -------
    jacobian, error
        Both of shape (6, directions) and in SI units; the error is the last correction by the
        extrapolation.

    Raises
    ------
    ValueError
        If the events are not the same, in the same order, on both sides: the map need not be smooth there.
    """
    expected = _sequence(simulate(problem, strides, real=real))

    def end(direction: Direction, amount: Any) -> Array:
        run = simulate(problem.perturbed(direction, amount), strides, real=real)
        if _sequence(run) != expected:
            raise ValueError(f"the order of events changes along {direction}; try a step smaller than {step}")
        return run.state

    columns, errors = [], []
    for direction in directions:
        table: list[Array] = []
        for level in range(levels):
            h = real(step * problem.scale(direction)) / 2**level
            row = [(end(direction, h) - end(direction, -h)) / (2 * h)]
            for order, coarser in enumerate(table, start=1):
                row.append(row[-1] + (row[-1] - coarser) / (4**order - 1))
            table = row
        columns.append(table[-1])
        errors.append(np.abs(table[-1] - table[-2]))
    return np.stack(columns, axis=1).astype(float), np.stack(errors, axis=1).astype(float)


def _sequence(run: Run) -> list[tuple[int, str]]:
    down = [(int(leg), "down") for leg in np.flatnonzero(run.down_at_start)]
    return down + [(event.leg, event.kind) for event in run.events]
