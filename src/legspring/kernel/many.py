"""Many simulations in one call: a loop over rows of parameters, and what is seen at their ends, in SI units."""

import math
from typing import NamedTuple

import numpy as np

from legspring.kernel.contact import copy, fill
from legspring.kernel.jit import driver, formula
from legspring.kernel.measure import write_work
from legspring.kernel.pack import MASS, STEP_DURATION, pack_directions
from legspring.kernel.walk import N_SEEN, walk
from legspring.kernel.walker import EVALUATIONS, LIFTOFF, OK, TIME, Floats, Ints, Tape, Walker


class Ends(NamedTuple):
    """What became of N simulations of S steps with D directions; what has no room is not written.

    Attributes
    ----------
    status, evaluations
        ``(N,)``: how it went; evaluations of the equations of motion.
    seen
        ``(N, 8, 1 + D)``: speed, heading relative to the body, displacement over the last step (x, y), yaw, yaw rate,
        change of yaw over the last step, and time, at the end of the step that is watched; SI units.
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


def new_ends(count: int, steps: int, directions: int, w: Walker, work: bool = False) -> Ends:
    """Return room for what becomes of so many simulations; `many` says what is unknown."""
    n_legs, rows = w.legs.shape[0], w.y.shape[0]
    return Ends(
        np.empty(count, np.int64),
        np.empty(count, np.int64),
        np.empty((count, N_SEEN, 1 + directions)),
        np.empty((count, steps + 1)),
        np.empty((count, steps + 1, rows)),
        np.empty((count, n_legs)),
        np.empty((count, n_legs, 2)),
        np.empty((count, n_legs if work else 0, 2)),
    )


@formula
def note_liftoffs(tape: Tape, time: float, end: float, out: Floats) -> None:
    """Write the first lift-off of each leg after the start and before the end."""
    for n in range(tape.counts[1] - 1, -1, -1):
        event = tape.events[n]
        if event[2] == LIFTOFF and 0.0 < event[0] < end:
            leg = int(event[1])
            out[leg, 0], out[leg, 1] = event[0] * time, event[4] / time


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
        w.clock[EVALUATIONS] = 0.0
        if push.shape[0] > 0:
            copy(push[row], w.push)
        for array in (out.seen, out.states, out.liftoffs, out.work):
            fill(array[row], math.nan)
        fill(out.times[row], math.nan)
        time, mass = p[row, STEP_DURATION], p[row, MASS]
        times, seen = out.times[row], out.seen[row]
        status = walk(w, tape, p[row], along, end, watched, scale, out.down[row], times, out.states[row], seen)
        out.status[row], out.evaluations[row] = status, int(w.clock[EVALUATIONS])
        if status != OK:
            fill(seen, math.nan)
            continue
        note_liftoffs(tape, time, w.clock[TIME], out.liftoffs[row])
        if work:
            write_work(tape, 0.0, times[1] / time, w.room, w.struts, out.work[row])
            for i in range(w.legs.shape[0]):
                for sign in range(2):
                    out.work[row, i, sign] *= mass / time**2
