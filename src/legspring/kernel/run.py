"""A whole simulation in one call."""

from legspring.kernel.jit import driver
from legspring.kernel.launch import launch
from legspring.kernel.stride import advance
from legspring.kernel.walker import Floats, Tape, Walker, new_tape, new_walker


@driver
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
    """Simulate from a start to time ``end``.

    Parameters
    ----------
    body, legs, side, offset, push
        See `Walker`; ``body``, ``legs`` and ``start`` are jets of one width.
    start
        See `launch`.
    rows
        4 where the yaw is held, else 6.
    end
        Step durations.
    scale
        Largest error estimate of a step, m.
    steps, events
        Room on the tape; none for no tape.

    Returns
    -------
    status, walker, tape
        How it went, the end and what happened.
    """
    w = new_walker(body, legs, side, offset, push, rows)
    tape = new_tape(steps, events, w)
    launch(w, start)
    return advance(w, end, scale, tape), w, tape


@driver
def touchdown_states(w: Walker, start: Floats, scale: float, states: Floats) -> int:
    """Write the state at the start of every step into the rows of ``states``; return how it went."""
    tape = new_tape(0, 0, w)
    launch(w, start)
    for n in range(states.shape[0]):
        status = advance(w, float(n), scale, tape)
        if status != 0:
            return status
        states[n] = w.y[:, 0]
    return 0
