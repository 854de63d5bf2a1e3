"""Start of a simulation: a walker at the moment of a touch-down."""

import math

import numpy as np

from legspring.kernel.jit import driver
from legspring.kernel.motion import measure_gaps
from legspring.kernel.stride import FIRST_STEP, put_down
from legspring.kernel.walker import (
    DOWN,
    LENGTH,
    LEVER,
    NEXT_STEP,
    OFFSET,
    SIDE,
    SIGN,
    TIME,
    VX,
    VY,
    YAW,
    YAW_RATE,
    Floats,
    Walker,
    X,
    Y,
)

# Rows of a start jet.
SPEED, HEADING, DX, DY, START_YAW, START_YAW_RATE, TURN = 0, 1, 2, 3, 4, 5, 6
N_START = 7


@driver
def launch(w: Walker, start: Floats) -> None:
    """Set a walker to the start of a step (model: start of a simulation).

    Parameters
    ----------
    w
        Changed in place.
    start
        ``(7, C)``: speed (m per step duration), heading relative to the body, displacement of the centre of mass
        over the last step (x, y), yaw, yaw rate, and change of yaw over the last step.
    """
    rows, width = w.y.shape
    set_motion(w, start)
    old = w.ahead
    for i in range(w.contacts.shape[0]):
        if w.contacts[i, OFFSET] == 0.0:
            put_down(0.0, w.y, w.legs, i, w.stance, w.contacts)
            continue
        # The leg was put down by the body as it was then: back by so much of the last step.
        ago = 2.0 - w.contacts[i, OFFSET]
        old[:] = 0.0
        for d in range(width):
            old[X, d] = -ago * start[DX, d]
            old[Y, d] = -ago * start[DY, d]
            if rows == 6:
                old[YAW, d] = start[START_YAW, d] - ago * start[TURN, d]
        put_down(-ago, old, w.legs, i, w.stance, w.contacts)
        w.contacts[i, SIGN] = w.contacts[i, SIDE]
    measure_gaps(0.0, w.y, w.k[0], w.stance, w.contacts, w.gaps[0])
    for i in range(w.contacts.shape[0]):
        if w.contacts[i, SIGN] * w.gaps[0, i, 0] < 0.0:
            w.contacts[i, DOWN] = 0.0
    w.clock[TIME] = 0.0
    w.clock[NEXT_STEP] = FIRST_STEP
    # With three leg lengths a body that yaws comes out as accurate as one that does not.
    w.clock[LEVER] = 3.0 * np.max(w.legs[:, LENGTH, 0])


@driver
def set_motion(w: Walker, start: Floats) -> None:
    """Set the state: at the origin, moving with the start's speed in its direction."""
    rows, width = w.y.shape
    direction = start[HEADING, 0] + (start[START_YAW, 0] if rows == 6 else 0.0)
    sine, cosine, speed = math.sin(direction), math.cos(direction), start[SPEED, 0]
    w.y[:] = 0.0
    for d in range(1, width):
        turn = speed * (start[HEADING, d] + (start[START_YAW, d] if rows == 6 else 0.0))
        w.y[VX, d] = -start[SPEED, d] * sine - turn * cosine
        w.y[VY, d] = start[SPEED, d] * cosine - turn * sine
    w.y[VX, 0] = -speed * sine
    w.y[VY, 0] = speed * cosine
    if rows == 6:
        for d in range(width):
            w.y[YAW, d] = start[START_YAW, d]
            w.y[YAW_RATE, d] = start[START_YAW_RATE, d]
