"""Recovery from a push across the way, or along it in a side view: from the animal's left, or from behind."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from legspring.checks import checked_number
from legspring.flow import REASONS, flow, flows
from legspring.kernel.many import Ends
from legspring.kernel.walker import Floats
from legspring.layout import System

if TYPE_CHECKING:
    import xarray as xr

    from legspring.drawing.film import Film
    from legspring.drawing.stage import Shot

BEGIN = 1.0 / 8.0
"""Start of the push, in step durations."""
TO_PEAK, LENGTH = 2.985e-3, 4e-3
"""Times from the push's start to its peak and to its end, s."""
ANGLE = 0.15
"""Change of heading, rad, and change of speed by v_des, that count as a distance of 1."""
BACK, SURELY_BACK = 1e-2, 1e-3
ELSEWHERE, REPEATS = 1.0, 2e-3
STEPS = 100
STAGES = 12, 40, STEPS
"""Steps after which a gait may be back, in the end."""
LARGEST_IMPULSE = 10.0
SHORTEST, LONGEST = 4, 12
"""Strides of a recovery that are simulated unless said otherwise."""


@dataclass(frozen=True)
class Recovery:
    """What became of a gait after a push.

    Attributes
    ----------
    impulse
        Sideways impulse in units of m v_des.
    steps
        Number of the step at whose end the gait was back; None if it was not within 100 steps.
    distance
        ``(101,)``: distance from the gait at the start (0) and at the end of each step.
    other_gait
        Whether it settled on another gait.
    failure
        Why the simulation could not be carried on, if it could not: such a gait is not recovered.
    system, point
        The gait: an animal on its slope, and all parameters with the start.
    """

    impulse: float
    steps: int | None
    distance: NDArray[np.float64]
    other_gait: bool
    failure: str | None
    system: System = field(repr=False)
    point: Floats = field(repr=False)

    @property
    def recovered(self) -> bool:
        """Whether the gait came back."""
        return self.steps is not None

    def simulate(self, strides: float | None = None) -> "xr.Dataset":
        """Simulate the push and what follows (see `legspring.simulate`).

        Parameters
        ----------
        strides
            How long; by default until the gait is back, but from 4 to 12 strides.
        """
        from legspring.simulation import simulation

        if strides is None:
            back = LONGEST if self.steps is None else math.ceil(self.steps / self.system.steps_per_stride) + 1
            strides = min(max(back, SHORTEST), LONGEST)
        push = push_knots(self.system, self.impulse, first_step(self.system, self.point))
        return simulation(self.system, self.point, strides, push=push)

    def shot(self, strides: float | None = None) -> "Shot":
        """Return what a film shows of it (see `simulate`)."""
        from legspring.drawing.stage import Shot

        run = self.simulate(strides)
        back = "not back" if self.steps is None else f"back after {self.steps} steps"
        about = f"\npushed by {self.impulse:g} m v_des, {back}"
        return Shot(run, 0.0, float(run["time"].values[-1]), about)

    def animate(self, strides: float | None = None, slow: float | None = None) -> "Film":
        """Make a moving picture of the push and what follows (see `legspring.animate`), which notebooks show."""
        from legspring.drawing.film import animate

        return animate(self, strides=strides, slow=slow)


def push_knots(system: System, impulse: float, step: float = 1.0) -> NDArray[np.float64]:
    """Return the push as knots (time, x, y) of an acceleration, in the kernel's units.

    A triangle in time whose area is the impulse times v_des; the first step lasts ``step`` step durations.
    """
    t_des = system.step_duration
    peak = 2.0 * impulse * system.desired_speed / LENGTH * t_des**2
    times = BEGIN * step + np.array([0.0, TO_PEAK, LENGTH]) / t_des
    return np.column_stack([times, [0.0, peak, 0.0], np.zeros(3)])


def recover(system: System, p: Floats, impulse: float) -> Recovery:
    """Push a gait sideways in its first step and follow it for 100 steps.

    Parameters
    ----------
    system, p
        The gait: an animal on its slope, and all parameters with the start.
    impulse
        In units of m v_des, > 0 to the right.

    Raises
    ------
    ValueError
        If the impulse is out of range, or the animal's legs do no work, so that it keeps what it is given.
    """
    check_pushed(system)
    valid = f"a finite number of m v_des, within +-{LARGEST_IMPULSE:g}"
    impulse = checked_number("impulse", impulse, valid, LARGEST_IMPULSE)
    unit = first_step(system, p)
    ends = after_pushes(system, p, [impulse], unit, STEPS)
    distance = distances(system, ends.states[0], section(system, p))
    steps = steps_to_recover(distance, end_of_push(system, unit))
    return Recovery(impulse, steps, distance, settled_elsewhere(distance), REASONS.get(int(ends.status[0])), system, p)


def recovery_steps(system: System, p: Floats, impulses: Sequence[float]) -> Floats:
    """Return how many steps a gait takes to recover from each of some impulses, ``(I,)``; nan where it does not.

    Most are back soon: they are not followed for as long as `recover` does.
    """
    check_pushed(system)
    found, unit = np.full(len(impulses), np.nan), first_step(system, p)
    first, undisturbed = end_of_push(system, unit), section(system, p)
    for most in STAGES:
        rest = np.flatnonzero(np.isnan(found))
        ends = after_pushes(system, p, [impulses[n] for n in rest.tolist()], unit, most)
        for n, states in zip(rest, ends.states, strict=True):
            steps = steps_to_recover(distances(system, states, undisturbed), first)
            found[n] = np.nan if steps is None else steps
    return found


def check_pushed(system: System) -> None:
    """Raise ValueError if an animal keeps what a push gives it."""
    if "energy" in system.conserved:
        raise ValueError(
            f"animal = {system.animal.name!r}: must have legs that do work, or lose some, to come back from a push; "
            "this one conserves energy and keeps what it is given"
        )


def first_step(system: System, p: Floats) -> float:
    """Return how long the first step lasts, in step durations: where it ends at a touch-down, those are a mere unit."""
    return float(flow(system, p).step_ends[1]) if system.event_driven else 1.0


def end_of_push(system: System, step: float) -> int:
    """Return the first step at whose end the push is over: nothing is back before."""
    return math.ceil(push_knots(system, 0.0, step)[-1, 0] / step)


def after_pushes(system: System, p: Floats, impulses: Sequence[float], step: float, steps: int) -> Ends:
    """Follow a gait for a number of steps after each of some pushes."""
    pushes = np.array([push_knots(system, impulse, step) for impulse in impulses]).reshape(-1, 3, 3)
    return flows(system, np.repeat(p[None], len(impulses), axis=0), steps=steps, pushes=pushes)


def section(system: System, p: Floats) -> NDArray[np.float64]:
    """Return a gait's states at the starts of the steps of a period, ``(period, n)``."""
    return flow(system, p, steps=system.period - 1).states


def distances(
    system: System, states: NDArray[np.float64], undisturbed: NDArray[np.float64] | None = None
) -> NDArray[np.float64]:
    """Distance of each touch-down's velocity from that of the gait, mirrored after odd steps.

    Where all directions are alike, there is none to come back to: the velocity is that seen from the body.

    Parameters
    ----------
    system, states
        What was followed: states at the starts of steps.
    undisturbed
        Those of the gait in a period; by default the first one, of a gait that repeats itself after a step.
    """
    velocity = velocities(system, states)
    if system.flips:
        velocity[1::2, 0] *= -1.0
    wanted = velocities(system, states[:1] if undisturbed is None else undisturbed)
    change = np.abs(velocity - wanted[np.arange(len(velocity)) % len(wanted)]) / system.desired_speed
    # From the side, x is the way ahead.
    ahead, across = (0, 1) if system.animal.sagittal else (1, 0)
    result: NDArray[np.float64] = np.maximum(change[:, across] / np.tan(ANGLE), change[:, ahead])
    return result


def velocities(system: System, states: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return velocities, ``(N, 2)``; as seen from the body, where all directions are alike."""
    velocity: NDArray[np.float64] = states[:, 2:4].copy()
    if not system.isotropic:
        return velocity
    cosine, sine = np.cos(states[:, 4]), np.sin(states[:, 4])
    return np.column_stack(
        [cosine * velocity[:, 0] + sine * velocity[:, 1], cosine * velocity[:, 1] - sine * velocity[:, 0]]
    )


def steps_to_recover(distance: NDArray[np.float64], first: int = 1) -> int | None:
    """First step, from one on, whose distance is below 1 % when the next one is closer still, or below 0.1 %."""
    for step in range(first, len(distance)):
        here = distance[step]
        follows = step + 1 < len(distance) and distance[step + 1] < here
        if here < SURELY_BACK or (here < BACK and follows):
            return step
    return None


def settled_elsewhere(distance: NDArray[np.float64]) -> bool:
    """Whether the last steps repeat at a distance above 1."""
    last = distance[-4:]
    return bool(last[-1] > ELSEWHERE and abs(last[-1] - last[-3]) < REPEATS and abs(last[-2] - last[-4]) < REPEATS)
