"""One step, or one stride, as a map, with its exact Jacobian."""

from collections.abc import Sequence

import numpy as np

from legspring.flow import SEEN, flow
from legspring.kernel.walker import Floats
from legspring.layout import ACCURACY, System

ASIDE = ("heading", "Dx", "yaw", "yaw_rate", "turn")
"""What changes its sign in a mirror image."""


def state_names(system: System, memory: bool) -> list[str]:
    """Name what the complete map maps; with or without memory of the step before."""
    names = ["speed", "heading"] + (["Dx", "Dy"] if memory else [])
    return names + (["yaw", "yaw_rate"] + (["turn"] if memory else []) if system.yaws else [])


def has_memory(system: System, p: Floats) -> bool:
    """Whether a start says where the feet of the step before are."""
    return not system.event_driven or bool(np.any(p[2:4] != 0.0))


def signs(system: System, names: Sequence[str]) -> Floats:
    """Return what a step's mirror image multiplies observables by; 1 where steps are not mirrored."""
    return np.array([-1.0 if system.mirrored and name in ASIDE else 1.0 for name in names])


def complete_map(system: System, p: Floats, *, accuracy: float = ACCURACY) -> tuple[Floats, Floats]:
    """Map the complete state at a touch-down to that one step later, mirrored.

    The state is (speed, heading, Dx, Dy), with (Dx, Dy) the displacement of the centre of mass over the last step,
    which says where the feet of the last tripod are; a yawing body adds (yaw, yaw rate, turn over the last step).
    Where a start has no displacement, because no leg of the step before is down, there are no (Dx, Dy) and no turn.
    An animal whose legs have no mirror images is not mirrored.

    See :ref:`model-return-map`.

    Returns
    -------
    state, jacobian
        ``(n,)`` and ``(n, n)``, n from 2 to 7; SI units.
    """
    names = state_names(system, has_memory(system, p))
    seen = flow(system, p, along=names, accuracy=accuracy).seen
    image = seen[[SEEN.index(name) for name in names]] * signs(system, names)[:, None]
    return image[:, 0], image[:, 1:]


def reduced_map(system: System, p: Floats, *, accuracy: float = ACCURACY) -> tuple[Floats, Floats]:
    """Map (speed, heading) to itself over a stride, every start rebuilding the old feet: the thesis's stability map.

    A yawing body adds (yaw, yaw rate).

    See :ref:`model-reduced`.

    Returns
    -------
    state, jacobian
        ``(n,)`` and ``(n, n)``, n = 2 or 4; SI units.
    """
    names = state_names(system, memory=False)
    ways = system.along(names).copy()
    if system.yaws:
        # Rebuilding the old feet, a change of yaw is one of the turn before, too.
        ways[names.index("yaw"), SEEN.index("turn")] = 2.0
    seen = flow(system, p, steps=2, along=list(ways), accuracy=accuracy).seen
    image = seen[[SEEN.index(name) for name in names]]
    return image[:, 0], image[:, 1:]
