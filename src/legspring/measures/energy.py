"""The energy of a body on springs."""

import numpy as np
from numpy.typing import NDArray

from legspring.flow import Flow
from legspring.kernel.walker import Floats
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
