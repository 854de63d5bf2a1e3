"""A simulation of some steps, from parameters to what is seen at its end, in SI units."""

import math

import numba

from legspring.kernel.contact import copy
from legspring.kernel.jit import formula, jit, shared
from legspring.kernel.launch import launch
from legspring.kernel.pack import STEP_DURATION
from legspring.kernel.stride import LONGEST_STEP, advance
from legspring.kernel.walker import (
    DOWN,
    DX,
    DY,
    EVENT_DRIVEN,
    HEADING,
    JET,
    OK,
    ROW,
    SLOWEST,
    SPEED,
    START_YAW,
    START_YAW_RATE,
    TAPE,
    TIME,
    TURN,
    VX,
    VY,
    WALKER,
    YAW,
    YAW_RATE,
    Floats,
    Tape,
    Walker,
    X,
    Y,
)

DURATION = 7
N_SEEN = 8
"""Observables: what a start is made of, and the time since the start."""


@jit
def observe(w: Walker, p: Floats, along: Floats, out: Floats) -> None:
    """Write the observables and their derivatives."""
    y, time = w.y, p[STEP_DURATION]
    rate, yaws = 1.0 / time, w.y.shape[0] == 6
    vx, vy = y[VX, 0], y[VY, 0]
    speed = math.hypot(vx, vy)
    for d in range(out.shape[1]):
        out[DX, d], out[DY, d] = y[X, d] - w.section[X, d], y[Y, d] - w.section[Y, d]
        out[START_YAW, d], out[START_YAW_RATE, d], out[TURN, d] = 0.0, 0.0, 0.0
        if yaws:
            out[START_YAW, d], out[START_YAW_RATE, d] = y[YAW, d], y[YAW_RATE, d] * rate
            out[TURN, d] = y[YAW, d] - w.section[YAW, d]
    out[SPEED, 0], out[HEADING, 0], out[DURATION, 0] = speed * rate, math.atan2(-vx, vy), w.clock[TIME] * time
    for d in range(1, out.shape[1]):
        # The unit of time may depend on the parameters, too.
        growth = along[d - 1, STEP_DURATION] * rate
        out[SPEED, d] = ((vx * y[VX, d] + vy * y[VY, d]) / speed - speed * growth) * rate
        out[HEADING, d] = (vx * y[VY, d] - vy * y[VX, d]) / speed**2
        out[START_YAW_RATE, d] -= out[START_YAW_RATE, 0] * growth
        out[DURATION, d] = (w.lag[d] + w.clock[TIME] * growth) * time
    if yaws:
        for d in range(out.shape[1]):
            out[HEADING, d] -= y[YAW, d]


@formula
def note(w: Walker, time: float, step: int, times: Floats, states: Floats) -> None:
    """Write time and state at the start of a step."""
    if step < times.size:
        times[step] = w.clock[TIME] * time
        for row in range(w.y.shape[0]):
            states[step, row] = w.y[row, 0] / time if row in (VX, VY, YAW_RATE) else w.y[row, 0]


@formula
def take_step(w: Walker, step: int, end: float, scale: float, tape: Tape) -> int:
    """Simulate the step of this number, counted from 1, but not beyond a time ``end``; return how it went."""
    if step > 1:
        copy(w.y, w.section)
    by_clock = w.clock[EVENT_DRIVEN] == 0.0
    latest = w.clock[TIME] + LONGEST_STEP * w.clock[SLOWEST]
    return advance(w, min(float(step), end) if by_clock else latest, scale, tape)


@shared(numba.int64, WALKER, TAPE, ROW, JET, numba.float64, numba.int64, numba.float64, ROW, ROW, JET, JET)
def walk(
    w: Walker,
    tape: Tape,
    p: Floats,
    along: Floats,
    end: float,
    watched: int,
    scale: float,
    down: Floats,
    times: Floats,
    states: Floats,
    seen: Floats,
) -> int:
    """Simulate until the clock says ``end``, or for so many steps if none goes by it; return how it went.

    Parameters
    ----------
    w, tape
        Room to work in; the derivatives' directions are packed already.
    p, along
        ``(n,)``, ``(D, n)``: parameters (see `legspring.kernel.pack`), and the directions of the derivatives.
    end
        Step durations, or steps.
    watched
        Step at whose end the observables are taken; of no step, they are those of the start.
    scale
        Largest error estimate of an integration step, m.
    down, times, states, seen
        Filled, as in `legspring.kernel.many.Ends`, where there is room.
    """
    tape.counts[0] = tape.counts[1] = 0
    launch(p, along, w)
    copy(w.contacts[:, DOWN], down)
    note(w, p[STEP_DURATION], 0, times, states)
    status, step = OK, 0
    while status == OK and step < end:
        step += 1
        status = take_step(w, step, end, scale, tape)
        if status == OK and step <= end:
            note(w, p[STEP_DURATION], step, times, states)
        if status == OK and step == watched:
            observe(w, p, along, seen)
    if status == OK and step == 0:
        observe(w, p, along, seen)
    return status
