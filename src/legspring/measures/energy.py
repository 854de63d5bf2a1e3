"""The total energy at the start of a step."""

import numpy as np

from legspring.kernel.measure import leg_series
from legspring.kernel.walker import FOOT_X, FOOT_Y, GRIP_X, YAW, Floats, Tape, X
from legspring.layout import System
from legspring.repetition import kinetic_and_spring


def reach(y: Floats, stance: Floats) -> tuple[Floats, Floats]:
    """Return where legs are, at some times, as seen from the centre of mass.

    Parameters
    ----------
    y
        ``(T, n)``: states.
    stance
        ``(T, L, 11)``: legs in stance then.

    Returns
    -------
    hips, legs
        ``(T, L, 2)`` each, m: from the centre of mass to the hips, from there to the feet.
    """
    yaw = y[:, YAW, None] if y.shape[1] > YAW else np.zeros((len(y), 1))
    cosine, sine = np.cos(yaw), np.sin(yaw)
    hip_x, hip_y = stance[:, :, GRIP_X], stance[:, :, GRIP_X + 1]
    hips = np.stack([cosine * hip_x - sine * hip_y, sine * hip_x + cosine * hip_y], axis=-1)
    return hips, stance[:, :, FOOT_X : FOOT_X + 2] - y[:, None, X : X + 2] - hips


def total_energy(system: System, tape: Tape) -> float:
    """Kinetic energy, with that of turning, energy of the springs and of the height as a tape begins, J.

    From the side, the height is that of the centre of mass above the ground. From above, it counts from where the tape
    begins, so that there it is zero.
    """
    y, stance, down = tape.y[:1, :, 0], tape.stance[:1, :, :, 0], tape.down[0] != 0.0
    free = leg_series(tape, np.zeros(1, np.int64), tape.time[:1], y)[0, :, 0]
    stretch = np.hypot(*np.moveaxis(reach(y, stance)[1][0], -1, 0)) - free
    energy = kinetic_and_spring(system, y[0], stance[0], down, stretch)
    if system.animal.sagittal:
        # The ground is the line through the foot of the first leg that is put down now.
        ground = stance[0, np.flatnonzero(system.offset == 0.0)[0], FOOT_Y]
        energy -= system.weight * float(ground)
    return energy * system.animal.body.mass / system.step_duration**2
