"""From a vector of parameters, in SI units, to the numbers that the kernel works on, with exact derivatives.

Everything that can vary stands in the vector p: the start of a step, then the body and its surroundings, then
thirteen numbers of each leg. Directions are vectors in that space. What the kernel works on are products of powers of
these, written here once, with their derivatives beside them.
"""

import math

from legspring.kernel.jit import formula
from legspring.kernel.walker import (
    ACTUATION,
    DAMPING,
    GRAVITY,
    GRAVITY_X,
    GYRATION,
    N_VARIED,
    SIDE,
    SIDE_VIEW,
    SPEED,
    START_YAW_RATE,
    STIFFNESS,
    Floats,
    Walker,
)

# Places in p after the start's seven: the body and its surroundings.
SLOPE, GRAVITATION, MASS, INERTIA, DESIRED_SPEED, STEP_DURATION = range(7, 13)
FIRST_LEG = 13
"""Place of the first leg's numbers, in the order of the rows of the walker's legs."""


@formula
def pack_directions(along: Floats, w: Walker) -> None:
    """Write what does not depend on the parameters: the derivatives, along directions, of what is taken as it is."""
    for d in range(along.shape[0]):
        for row in range(w.start.shape[0]):
            w.start[row, 1 + d] = along[d, row]
        for i in range(w.legs.shape[0]):
            first = FIRST_LEG + N_VARIED * i
            for row in range(N_VARIED):
                w.legs[i, row, 1 + d] = along[d, first + row]
            w.legs[i, ACTUATION, 1 + d] *= w.contacts[i, SIDE]


@formula
def pack(p: Floats, along: Floats, w: Walker) -> None:
    """Write the numbers of ``p``, ``(n,)``, and their derivatives along directions, ``(D, n)``, into a walker.

    After `pack_directions` for the same directions.
    """
    pack_start(p, along, w)
    pack_body(p, along, w)
    pack_legs(p, along, w)


@formula
def pack_start(p: Floats, along: Floats, w: Walker) -> None:
    """Write the start: rates per step duration."""
    time = p[STEP_DURATION]
    for row in range(w.start.shape[0]):
        w.start[row, 0] = p[row]
    for row in (SPEED, START_YAW_RATE):
        w.start[row, 0] = p[row] * time
        for d in range(along.shape[0]):
            w.start[row, 1 + d] = along[d, row] * time + p[row] * along[d, STEP_DURATION]


@formula
def pack_body(p: Floats, along: Floats, w: Walker) -> None:
    """Write gravity along the axes and m / I; from above -y is downhill, from the side it is into the ground."""
    yaws, sine, cosine = w.y.shape[0] == 6, math.sin(p[SLOPE]), math.cos(p[SLOPE])
    if w.clock[SIDE_VIEW] != 0.0:
        weigh(w.body[GRAVITY], cosine, -sine, p, along)
        weigh(w.body[GRAVITY_X], sine, cosine, p, along)
    else:
        weigh(w.body[GRAVITY], sine, cosine, p, along)
    w.body[GYRATION, 0] = p[MASS] / p[INERTIA] if yaws else 0.0
    for d in range(along.shape[0]):
        change = along[d]
        by_mass = change[MASS] - w.body[GYRATION, 0] * change[INERTIA]
        w.body[GYRATION, 1 + d] = by_mass / p[INERTIA] if yaws else 0.0


@formula
def weigh(jet: Floats, part: float, rate: float, p: Floats, along: Floats) -> None:
    """Write the part of gravity along an axis, g part t^2; the part grows with the slope at the rate."""
    g, time = p[GRAVITATION], p[STEP_DURATION]
    jet[0] = g * part * time**2
    for d in range(along.shape[0]):
        change = along[d]
        pull = change[GRAVITATION] * part + g * rate * change[SLOPE]
        jet[1 + d] = pull * time**2 + 2.0 * g * part * time * change[STEP_DURATION]


@formula
def pack_legs(p: Floats, along: Floats, w: Walker) -> None:
    """Write the legs: stiffness k t^2 / m, damping c t / m, actuation with its sign, all else as it is."""
    time, mass = p[STEP_DURATION], p[MASS]
    for i in range(w.legs.shape[0]):
        first = FIRST_LEG + N_VARIED * i
        for row in range(N_VARIED):
            w.legs[i, row, 0] = p[first + row]
        w.legs[i, ACTUATION, 0] *= w.contacts[i, SIDE]
        rescale(w.legs[i, STIFFNESS], first + STIFFNESS, 2.0, time**2 / mass, p, along)
        rescale(w.legs[i, DAMPING], first + DAMPING, 1.0, time / mass, p, along)


@formula
def rescale(jet: Floats, place: int, power: float, unit: float, p: Floats, along: Floats) -> None:
    """Write the number at a place in p in units of m / t^power; ``unit`` is t^power / m."""
    jet[0] = p[place] * unit
    for d in range(along.shape[0]):
        growth = power * along[d, STEP_DURATION] / p[STEP_DURATION] - along[d, MASS] / p[MASS]
        jet[1 + d] = (along[d, place] + p[place] * growth) * unit
