"""The energy of a body on springs, where it comes from and where it goes."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from legspring.flow import NO_PUSH, Flow, Samples
from legspring.kernel.walker import Floats
from legspring.layout import System
from legspring.model import Body


def kinetic_and_spring(body: Body, state: Floats, stiffness: Floats, stretch: Floats, down: NDArray[np.bool_]) -> float:
    """Kinetic energy, with that of turning, and energy of the springs of the legs that are down, J.

    Parameters
    ----------
    body
        With its mass and inertia.
    state
        ``(6,)``: place, velocity, yaw and yaw rate.
    stiffness, stretch, down
        ``(L,)``: N/m; by how much each leg is longer than its force-free length, m; whether it is down.
    """
    energy = body.mass * np.sum(state[2:4] ** 2) + np.sum((stiffness * stretch**2)[down])
    if body.yaw == "free" and body.inertia:
        energy += body.inertia * state[5] ** 2
    return 0.5 * float(energy)


def total_energy(run: Flow) -> float:
    """Kinetic energy, with that of turning, energy of the springs and of the height where a recorded motion begins, J.

    From the side, the height is that of the centre of mass above the ground. From above, it counts from where the
    motion begins, so that there it is zero.
    """
    system, start = run.system, run.samples(np.zeros(1))
    stiffness = np.array([leg.stiffness for leg in system.animal.legs])
    stretch = np.hypot(*np.moveaxis(start.legs[0], -1, 0)) - start.free[0]
    energy = kinetic_and_spring(system.animal.body, start.states[0], stiffness, stretch, start.down[0])
    if system.animal.sagittal:
        # The ground is the line through the foot of the first leg that is put down now.
        ground = start.feet[0, np.flatnonzero(system.offset == 0.0)[0], 1]
        energy -= system.animal.body.mass * system.animal.gravity * float(ground)
    return energy


def uphill(system: System) -> Floats:
    """Return the direction against gravity in the plane that is looked at, ``(2,)``, by its share in gravity."""
    sine, cosine = math.sin(system.slope), math.cos(system.slope)
    return np.array([sine, cosine] if system.animal.sagittal else [0.0, sine])


NODES, WEIGHTS = np.polynomial.legendre.leggauss(5)


class Energies(NamedTuple):
    """Energy at T times, J; ``(T,)``, or ``(T, L)`` by legs.

    Attributes
    ----------
    kinetic
        Of motion and turning.
    height
        In the field of gravity, from where the body begins.
    springs
        In each leg.
    actuation
        Work of each leg's actuation since the beginning.
    lost
        What dampers have taken since then, and springs of legs that left the ground before their force was zero.
    push
        Work of a push since then.
    """

    kinetic: Floats
    height: Floats
    springs: Floats
    actuation: Floats
    lost: Floats
    push: Floats

    @property
    def balance(self) -> Floats:
        """What has come from nowhere since the beginning: zero, but for errors of the integration."""
        held = self.kinetic + self.height + self.springs.sum(axis=1)
        return held - held[0] - self.actuation.sum(axis=1) - self.push + self.lost


def energies(run: Flow, times: Floats, push: Floats = NO_PUSH) -> Energies:
    """Find the energies of a recorded motion at some times, rising from 0 (in step durations).

    A leg's force does the work -F dr/dt on the body. It is that of its spring, k (r - l), whose other end the actuation
    moves, with the work -k (r - l) dl/dt, and that of its damper, which takes c (dr/dt)^2.

    Parameters
    ----------
    run
        The motion.
    times
        When.
    push
        Of that motion (see `legspring.flow.flow`).
    """
    animal, seen = run.system.animal, run.samples(times)
    body, weight = animal.body, animal.body.mass * animal.gravity
    kinetic = 0.5 * body.mass * np.sum(seen.states[:, 2:4] ** 2, axis=1)
    if body.yaw == "free" and body.inertia:
        kinetic = kinetic + 0.5 * body.inertia * seen.states[:, 5] ** 2
    height = weight * (seen.states[:, :2] - seen.states[0, :2]) @ uphill(run.system)
    actuation, damped, pushed = _integrals(run, times, push)
    lost = damped + _released(run, times)
    return Energies(kinetic, height, _in_springs(run, seen), actuation, lost, pushed)


def _in_springs(run: Flow, seen: Samples) -> Floats:
    """Return the energy of each leg's spring, J, ``(T, L)``; none in swing."""
    stiffness = np.array([leg.stiffness for leg in run.system.animal.legs])
    stretch = np.hypot(seen.legs[..., 0], seen.legs[..., 1]) - seen.free
    energy: Floats = np.where(seen.down, 0.5 * stiffness * stretch**2, 0.0)
    return energy


def _integrals(run: Flow, times: Floats, push: Floats) -> tuple[Floats, Floats, Floats]:
    """Integrate the power of each leg's actuation, of all dampers and of a push from the first time on, J."""
    tape, animal = run.tape, run.system.animal
    steps = tape.time[: int(tape.counts[0]) + 1]
    inside = steps[(steps > times[0]) & (steps < times[-1])]
    # Between these, all is smooth.
    cuts = np.unique(np.concatenate([times, inside, push[:, 0] if len(push) else []]))
    cuts = cuts[(cuts >= times[0]) & (cuts <= times[-1])]
    middle, half = 0.5 * (cuts[1:] + cuts[:-1]), 0.5 * np.diff(cuts)
    nodes = middle[:, None] + half[:, None] * NODES
    index = np.repeat(np.searchsorted(steps, middle, side="right") - 1, len(NODES))
    seen = run.samples(nodes.ravel(), np.clip(index, 0, len(steps) - 2))
    damping = np.array([leg.damping for leg in animal.legs])
    # All that has no meaning in swing is left out there.
    rate = np.where(seen.down, seen.length_rate, 0.0)
    spring = np.where(seen.down, seen.force, 0.0) * animal.body.mass * animal.gravity - damping * rate
    power = np.zeros((len(seen.states), len(damping) + 2))
    power[:, :-2] = -spring * np.where(seen.down, seen.free_rate, 0.0)
    power[:, -2] = np.sum(damping * rate**2, axis=1)
    if len(push):
        # Accelerations in the kernel's units.
        pull = np.stack([np.interp(nodes.ravel(), push[:, 0], push[:, n], 0.0, 0.0) for n in (1, 2)], axis=1)
        power[:, -1] = animal.body.mass / run.unit**2 * np.sum(pull * seen.states[:, 2:4], axis=1)
    pieces = run.unit * half[:, None] * np.einsum("kjp,j->kp", power.reshape(len(middle), len(NODES), -1), WEIGHTS)
    work = np.concatenate([np.zeros((1, pieces.shape[1])), np.cumsum(pieces, axis=0)])[np.searchsorted(cuts, times)]
    return work[:, :-2], work[:, -2], work[:, -1]


def _released(run: Flow, times: Floats) -> Floats:
    """Return what springs have held that lost their hold on the ground, up to each time, J."""
    tape = run.tape
    count = int(tape.counts[0])
    at, before = tape.time[1:count], np.arange(count - 1)
    held = [_in_springs(run, run.samples(at, index)).sum(axis=1) for index in (before, before + 1)]
    released = np.concatenate([[0.0], np.cumsum(held[0] - held[1])])
    lost: Floats = released[np.searchsorted(at, times, side="right")]
    return lost - lost[0]
