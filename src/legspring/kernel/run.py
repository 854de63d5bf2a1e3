"""A whole simulation in one call."""

from legspring.kernel.jit import driver, formula
from legspring.kernel.launch import launch
from legspring.kernel.stride import LONGEST_STEP, advance
from legspring.kernel.walker import EVENT_DRIVEN, OK, SLOWEST, TIME, Floats, Tape, Walker, new_tape, new_walker


def run(
    body: Floats,
    legs: Floats,
    side: Floats,
    offset: Floats,
    push: Floats,
    start: Floats,
    rows: int,
    end: float,
    scale: float,
    steps: int,
    events: int,
) -> tuple[int, Walker, Tape]:
    """Simulate from a start to time ``end`` or, where no leg goes by the clock, for so many steps.

    Parameters
    ----------
    body, legs, side, offset, push
        See `Walker`; ``body``, ``legs`` and ``start`` are jets of one width.
    start
        See `launch`.
    rows
        4 where the yaw is held, else 6.
    end
        Step durations, or steps.
    scale
        Largest error estimate of a step, m.
    steps, events
        Room on the tape; none to record touch-downs only.

    Returns
    -------
    status, walker, tape
        How it went, the end and what happened.
    """
    w = new_walker(body, legs, side, offset, push, rows)
    tape = new_tape(steps, events, 1 + int(end), w)
    return simulate(w, tape, start.copy(), end, scale), w, tape


@driver
def simulate(w: Walker, tape: Tape, start: Floats, end: float, scale: float) -> int:
    """Do the same with a walker and a tape; return how it went."""
    launch(w, start)
    note_touchdown(w, tape, 0)
    status, step = OK, 0
    while status == OK and step < end:
        step += 1
        by_clock = w.clock[EVENT_DRIVEN] == 0.0
        latest = w.clock[TIME] + LONGEST_STEP * w.clock[SLOWEST]
        status = advance(w, min(float(step), end) if by_clock else latest, scale, tape)
        if status == OK and step <= end:
            note_touchdown(w, tape, step)
    return status


@formula
def note_touchdown(w: Walker, tape: Tape, step: int) -> None:
    """Write the state, without derivatives, at the start of a step."""
    for row in range(w.y.shape[0]):
        tape.touchdowns[step, row] = w.y[row, 0]
