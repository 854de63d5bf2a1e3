"""Many simulations in one call: a loop over rows of parameters, and what is seen at their ends, in SI units."""

import math
from typing import NamedTuple

import numba
import numpy as np

from legspring.kernel.contact import copy, fill
from legspring.kernel.jit import driver, formula, jit, shared
from legspring.kernel.launch import launch
from legspring.kernel.length import law, phase_at
from legspring.kernel.measure import write_work
from legspring.kernel.motion import change, strut, turn
from legspring.kernel.pack import MASS, STEP_DURATION, pack_directions
from legspring.kernel.stride import LONGEST_STEP, advance
from legspring.kernel.walker import (
    BEGUN,
    CLOCK,
    DOWN,
    DX,
    DY,
    EVALUATIONS,
    EVENT_DRIVEN,
    FOOT_X,
    FOOT_Y,
    GRAVITY,
    GRAVITY_X,
    GYRATION,
    HEADING,
    JET,
    LAW,
    LIFTOFF,
    OK,
    ROW,
    SIDE_VIEW,
    SLOWEST,
    SPEED,
    SPRING,
    START_YAW,
    START_YAW_RATE,
    TIME,
    TRIGGER,
    TURN,
    VX,
    VY,
    WALKER,
    YAW,
    YAW_RATE,
    Floats,
    Ints,
    Tape,
    Walker,
    X,
    Y,
)

DURATION, WAY_X, WAY_Y, WAY, ENERGY, APEX = 7, 8, 9, 10, 11, 12
N_FEW, N_SEEN = 8, 13
"""Observables: what a start is made of, and the time since the start; if more are asked for, place (x, y) and distance
from the start, energy and apex height, and then three of each leg, as in its parameters from LEG_DX on."""


class Ends(NamedTuple):
    """What became of N simulations of S steps with D directions; what has no room is not written.

    Attributes
    ----------
    status, evaluations
        ``(N,)``: how it went; evaluations of the equations of motion.
    seen
        ``(N, 8, 1 + D)``: speed, heading relative to the body, displacement over the last step (x, y), yaw, yaw rate,
        change of yaw over the last step, and time, at the end of the step that is watched; or ``(N, 13 + 3 L, 1 + D)``:
        then place (x, y), distance from the start, energy, apex height (nan where there is no flight), and the memory
        of each leg; SI units, times since touch-downs in step durations.
    times, states
        ``(N, S + 1)``, ``(N, S + 1, n)``: of each start of a step, and the end; SI units. Nan where it did not get
        that far.
    down
        ``(N, L)``: whether legs are down at the start (1 or 0).
    liftoffs
        ``(N, L, 2)``: time of the first lift-off of each leg between start and end, and the rate of its gap there; SI
        units, nan if there is none, or no tape.
    work
        ``(N, L, 2)``: positive and negative work of each leg in the first step, J.
    """

    status: Ints
    evaluations: Ints
    seen: Floats
    times: Floats
    states: Floats
    down: Floats
    liftoffs: Floats
    work: Floats


def new_ends(count: int, steps: int, directions: int, w: Walker, work: bool = False, everything: bool = False) -> Ends:
    """Return room for what becomes of so many simulations; `many` says what is unknown."""
    n_legs, rows = w.legs.shape[0], w.y.shape[0]
    return Ends(
        np.empty(count, np.int64),
        np.empty(count, np.int64),
        np.empty((count, N_SEEN + 3 * n_legs if everything else N_FEW, 1 + directions)),
        np.empty((count, steps + 1)),
        np.empty((count, steps + 1, rows)),
        np.empty((count, n_legs)),
        np.empty((count, n_legs, 2)),
        np.empty((count, n_legs if work else 0, 2)),
    )


@shared(numba.void, WALKER, ROW, JET, JET)
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
    if out.shape[0] > N_FEW:
        observe_more(w, p, along, out)


@jit
def observe_more(w: Walker, p: Floats, along: Floats, out: Floats) -> None:
    """Write the observables after those of the start, and their derivatives."""
    y, place, stance = w.y, w.places, w.stance
    distance = math.hypot(y[X, 0], y[Y, 0])
    share = 1.0 / distance if distance > 0.0 else 0.0
    for d in range(out.shape[1]):
        out[WAY_X, d], out[WAY_Y, d] = y[X, d], y[Y, d]
        out[WAY, d] = share * (y[X, 0] * y[X, d] + y[Y, 0] * y[Y, d])
        out[APEX, d] = w.apex[d] if w.apex[0] == w.apex[0] else math.nan
        for i in range(w.legs.shape[0]):
            row = N_SEEN + 3 * i
            if w.legs[i, TRIGGER, 0] == CLOCK:
                out[row, d], out[row + 1, d] = y[X, d] - place[i, 0, d], y[Y, d] - place[i, 1, d]
                out[row + 2, d] = y[YAW, d] - place[i, 2, d] if y.shape[0] == 6 else 0.0
            else:
                out[row, d], out[row + 1, d] = stance[i, FOOT_X, d] - y[X, d], stance[i, FOOT_Y, d] - y[Y, d]
                now = w.clock[TIME] if d == 0 else w.lag[d]
                out[row + 2, d] = now - stance[i, BEGUN, d]
    measure_energy(w, out[ENERGY])
    unit, energy = p[MASS] / p[STEP_DURATION] ** 2, out[ENERGY, 0]
    for d in range(1, out.shape[1]):
        growth = along[d - 1, MASS] / p[MASS] - 2.0 * along[d - 1, STEP_DURATION] / p[STEP_DURATION]
        out[ENERGY, d] += energy * growth
    for d in range(out.shape[1]):
        out[ENERGY, d] *= unit


@jit
def measure_energy(w: Walker, out: Floats) -> None:
    """Write the energy by the mass, in the kernel's units: of motion, of height (from the side) and of the springs."""
    y, s, yaws = w.y, w.clock[TIME], w.y.shape[0] == 6
    lean, phase, mobility = turn(y), phase_at(s), w.body[GYRATION, 0]
    for d in range(out.size):
        half = 0.5 if d == 0 else 1.0
        out[d] = half * (y[VX, 0] * y[VX, d] + y[VY, 0] * y[VY, d])
        if yaws:
            out[d] += half * y[YAW_RATE, 0] * y[YAW_RATE, d] / mobility
            if d > 0:
                out[d] -= 0.5 * (y[YAW_RATE, 0] / mobility) ** 2 * w.body[GYRATION, d]
        if w.clock[SIDE_VIEW] != 0.0:
            # All of gravity counts, whatever the slope.
            into, along = w.body[GRAVITY], w.body[GRAVITY_X]
            weight = math.hypot(into[0], along[0])
            out[d] += weight * (y[Y, d] - w.ground[d])
            if d > 0 and weight > 0.0:
                growth = (into[0] * into[d] + along[0] * along[d]) / weight
                out[d] += growth * (y[Y, 0] - w.ground[0])
    for i in range(w.contacts.shape[0]):
        if w.contacts[i, DOWN] == 0.0:
            continue
        numbers = law(s, w.stance, i, phase)
        leg = strut(y, w.stance, i, lean, numbers[0])
        tension = w.stance[i, SPRING, 0] * leg.gap
        out[0] += 0.5 * tension * leg.gap
        for d in range(1, out.size):
            rx, ry, _, _, _ = change(y, w.stance, i, d, lean, leg, numbers)
            # The state is that at a time which may move, and the law with it.
            gap = (leg.rx * rx + leg.ry * ry) / leg.r - numbers[1] * w.lag[d]
            for n in range(4):
                gap -= numbers[3 + n] * w.stance[i, LAW + n, d]
            out[d] += tension * gap + 0.5 * leg.gap**2 * w.stance[i, SPRING, d]


@formula
def note(w: Walker, time: float, step: int, times: Floats, states: Floats) -> None:
    """Write time and state at the start of a step."""
    if step < times.size:
        times[step] = w.clock[TIME] * time
        for row in range(w.y.shape[0]):
            states[step, row] = w.y[row, 0] / time if row in (VX, VY, YAW_RATE) else w.y[row, 0]


@formula
def note_liftoffs(tape: Tape, time: float, end: float, out: Floats) -> None:
    """Write the first lift-off of each leg after the start and before the end."""
    for n in range(tape.counts[1] - 1, -1, -1):
        event = tape.events[n]
        if event[2] == LIFTOFF and 0.0 < event[0] < end:
            leg = int(event[1])
            out[leg, 0], out[leg, 1] = event[0] * time, event[4] / time


@formula
def take_step(w: Walker, step: int, end: float, scale: float, tape: Tape) -> int:
    """Simulate the step of this number, counted from 1, but not beyond a time ``end``; return how it went."""
    if step > 1:
        copy(w.y, w.section)
    by_clock = w.clock[EVENT_DRIVEN] == 0.0
    latest = w.clock[TIME] + LONGEST_STEP * w.clock[SLOWEST]
    return advance(w, min(float(step), end) if by_clock else latest, scale, tape)


@driver
def many(
    w: Walker,
    tape: Tape,
    p: Floats,
    along: Floats,
    push: Floats,
    end: float,
    watched: int,
    scale: float,
    work: bool,
    out: Ends,
) -> None:
    """Simulate from each row of parameters, until the clock says ``end``, or for so many steps if none goes by it.

    Parameters
    ----------
    w, tape
        Room to work in, with what is no number (see `legspring.kernel.walker.new_walker`).
    p, along
        ``(N, n)``, ``(D, n)``: parameters (see `legspring.kernel.pack`), and the directions of the derivatives.
    push
        ``(N, P, 3)``: one for each row, or ``(0, P, 3)``: what is in the walker.
    end
        Step durations, or steps.
    watched
        Step at whose end the observables are taken; of no step, they are those of the start.
    scale
        Largest error estimate of an integration step, m.
    work
        Whether to measure the work of legs, for which the tape needs room.
    out
        Filled.
    """
    pack_directions(along, w)
    for row in range(p.shape[0]):
        tape.counts[0] = tape.counts[1] = 0
        w.clock[EVALUATIONS] = 0.0
        if push.shape[0] > 0:
            copy(push[row], w.push)
        for array in (out.seen, out.states, out.liftoffs, out.work):
            fill(array[row], math.nan)
        fill(out.times[row], math.nan)
        time, mass = p[row, STEP_DURATION], p[row, MASS]
        launch(p[row], along, w)
        copy(w.contacts[:, DOWN], out.down[row])
        note(w, time, 0, out.times[row], out.states[row])
        status, step = OK, 0
        while status == OK and step < end:
            step += 1
            status = take_step(w, step, end, scale, tape)
            if status == OK and step <= end:
                note(w, time, step, out.times[row], out.states[row])
            if status == OK and step == watched:
                observe(w, p[row], along, out.seen[row])
        out.status[row], out.evaluations[row] = status, int(w.clock[EVALUATIONS])
        if status != OK:
            fill(out.seen[row], math.nan)
            continue
        if step == 0:
            observe(w, p[row], along, out.seen[row])
        note_liftoffs(tape, time, w.clock[TIME], out.liftoffs[row])
        if work:
            write_work(tape, 0.0, out.times[row, 1] / time, w.room, w.struts, out.work[row])
            for i in range(w.legs.shape[0]):
                for sign in range(2):
                    out.work[row, i, sign] *= mass / time**2
