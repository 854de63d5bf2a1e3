"""One step, or one stride, as a map, with its exact Jacobian."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from legspring.flow import SEEN, flow
from legspring.kernel.many import N_SEEN
from legspring.kernel.walker import Floats
from legspring.layout import ACCURACY, LEG, ROWS, System

ASIDE = ("heading", "Dx", "yaw", "yaw_rate", "turn", "foot_x")
"""What changes its sign in a mirror image."""


def state_names(system: System, p: Floats) -> list[str]:
    """Name what the complete map maps from a start.

    Of feet that are up nothing is remembered. Where legs do not go by the clock, a start without a displacement says
    that all legs of the step before are up.
    """
    if system.contacts is None:
        even = ("Dx", "Dy", *(["turn"] if system.yaws else [])) if np.any(p[2:4] != 0.0) else ()
        yaw = ("yaw", "yaw_rate") if system.yaws else ()
        return list(system.state) if not system.event_driven else ["speed", "heading", *even[:2], *yaw, *even[2:]]
    names = [leg.name for leg in system.animal.legs]
    down = flow(system, p, steps=0).contacts().down
    gone = {
        name
        for name in system.memory
        if not any(down[leg] for leg in system.together(names.index(name.rpartition(".")[0])))
    }
    return [name for name in system.state if name not in gone]


def signs(system: System, names: Sequence[str]) -> Floats:
    """Return what a step's mirror image multiplies observables by; 1 where steps are not mirrored."""
    return np.array([-1.0 if system.flips and name.rpartition(".")[2] in ASIDE else 1.0 for name in names])


def seen_at(system: System, name: str) -> int:
    """Return where among the observables at the end of a period a coordinate of the state, or of its image, is."""
    if name in SEEN:
        return SEEN.index(name)
    owner, _, quantity = name.rpartition(".")
    leg = [leg.name for leg in system.animal.legs].index(owner)
    image = system.animal.partners[leg] if system.mirrored else leg
    return N_SEEN + 3 * image + ROWS[quantity] - len(LEG)


def complete_map(system: System, p: Floats, *, accuracy: float = ACCURACY) -> tuple[Floats, Floats]:
    """Map the complete state at a touch-down to that one period later: a step, mirrored, or a stride.

    The state is (speed, heading) with what is remembered of the time before: where steps mirror one another and legs
    of a pair are a step apart, (Dx, Dy), the displacement of the centre of mass over the last step, which says where
    the feet of the last tripod are; else one such displacement for each instant at which a foot that is still down
    was put down, or the place of that foot (see ``legspring.layout.System.memory``). A yawing body adds (yaw, yaw rate)
    and the turn since each of these instants. A foot that is up is not remembered.

    See :ref:`model-return-map`.

    Returns
    -------
    state, jacobian
        ``(n,)`` and ``(n, n)``; SI units, and step durations.
    """
    names = state_names(system, p)
    seen = flow(system, p, steps=system.period, along=names, everything=bool(system.contacts), accuracy=accuracy).seen
    image = seen[[seen_at(system, name) for name in names]] * signs(system, names)[:, None]
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
    system = replace(system, contacts=None)
    names = [name for name in system.state if name not in system.memory]
    ways = system.along(names).copy()
    if system.yaws:
        # Rebuilding the old feet, a change of yaw is one of the turn before, too.
        ways[names.index("yaw"), SEEN.index("turn")] = 2.0
    seen = flow(system, p, steps=2, along=list(ways), accuracy=accuracy).seen
    image = seen[[SEEN.index(name) for name in names]]
    return image[:, 0], image[:, 1:]
