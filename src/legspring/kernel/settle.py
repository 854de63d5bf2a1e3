"""Motions followed, for many rows of parameters, until they settle on something that repeats itself."""

import math

from legspring.kernel.contact import copy
from legspring.kernel.jit import driver, formula, jit
from legspring.kernel.launch import launch
from legspring.kernel.many import take_step
from legspring.kernel.pack import pack_directions
from legspring.kernel.walker import EVALUATIONS, FALLEN, OK, VX, VY, YAW, YAW_RATE, Floats, Ints, Tape, Walker, X, Y

FALLS, FAILS, STOPS, RUNS_AWAY, UNDECIDED, REPEATS = -1, -2, -3, -4, -5, -6
NOT_YET = -100
NEAR = 1e-2
"""Farthest from something that counts as being back, by velocities."""
SLOWEST, FASTEST = 0.01, 100.0
"""Speeds, by the desired one, at which a motion stands still in the end, or runs away."""
SAME, ROUGHLY, LONGEST = 1e-8, 1e-5, 16
"""Difference of moments that is none; that is about none; most periods after which a motion repeats itself."""


@formula
def see(w: Walker, side: float, turns: bool, units: Floats, out: Floats) -> None:
    """Write what is seen of a motion at the end of a period: velocity, way since its beginning, yaw and yaw rate.

    Parameters
    ----------
    side
        -1 where what is seen is in mirror image.
    turns
        Whether directions are those seen from the body.
    units
        By which velocities (x, y), ways and yaw rates are divided.
    """
    y, yaws = w.y, w.y.shape[0] == 6
    cosine, sine = (math.cos(y[YAW, 0]), math.sin(y[YAW, 0])) if turns else (1.0, 0.0)
    vx, vy = y[VX, 0], y[VY, 0]
    x, h = (y[X, 0] - out[-2]) / units[2], (y[Y, 0] - out[-1]) / units[2]
    out[0], out[1] = side * (cosine * vx + sine * vy) / units[0], (cosine * vy - sine * vx) / units[1]
    out[2], out[3] = side * (cosine * x + sine * h), cosine * h - sine * x
    if yaws:
        out[4] = 0.0 if turns else side * y[YAW, 0]
        out[5] = side * y[YAW_RATE, 0] / units[3]
    out[-2], out[-1] = y[X, 0], y[Y, 0]


@jit
def nearest(seen: Floats, at: int, known: Floats, sizes: Ints, within: Floats) -> int:
    """Return which of what is known a motion is near enough to; `NOT_YET` if to none."""
    for n in range(sizes.size):
        for shift in range(sizes[n]):
            near = True
            for d in range(known.shape[2]):
                near = near and abs(seen[at, d] - known[n, shift, d]) <= within[n]
            if near:
                return n
    return NOT_YET


@jit
def first_near(seen: Floats, at: int, count: int, first: int, known: Floats, size: int) -> int:
    """Return the period since whose end a motion has had nearly the velocity of what it has settled on."""
    while count > first and count % seen.shape[0] != (at + 1) % seen.shape[0]:
        before, off = (count - 1) % seen.shape[0], math.inf
        for shift in range(size):
            gap = max(abs(seen[before, 0] - known[shift, 0]), abs(seen[before, 1] - known[shift, 1]))
            off = min(off, gap)
        if off > NEAR:
            break
        count -= 1
    return count


@jit
def is_back(seen: Floats, at: int, lag: int, nearly: float) -> bool:
    """Whether the last moments are those of so many periods before."""
    size = seen.shape[0]
    for back in range(lag):
        now, then = (at - back) % size, (at - back - lag) % size
        for d in range(seen.shape[1] - 2):
            if not abs(seen[now, d] - seen[then, d]) < nearly:
                return False
    return True


@jit
def lag_of(seen: Floats, at: int, count: int) -> int:
    """Return after how many periods a motion repeats itself, as far as is seen; 0 if it does not."""
    for lag in range(1, min(LONGEST, (count - 1) // 2) + 1):
        if is_back(seen, at, lag, SAME):
            # What swings in towards something is sooner where it was two periods before.
            for part in range(1, lag):
                if lag % part == 0 and is_back(seen, at, part, ROUGHLY):
                    return part
            return lag
    return 0


@driver
def settle(
    w: Walker,
    tape: Tape,
    p: Floats,
    push: Floats,
    first: int,
    most: int,
    period: int,
    flips: bool,
    turns: bool,
    units: Floats,
    scale: float,
    known: Floats,
    sizes: Ints,
    within: Floats,
    seen: Floats,
    fates: Ints,
    periods: Ints,
    lags: Ints,
) -> None:
    """Follow each row of parameters until it settles, ends, or so many periods have passed.

    Parameters
    ----------
    w, tape, p, push, scale
        See `legspring.kernel.many.many`.
    first, most, period
        Period from whose end on motions are judged; most periods; steps in each.
    flips, turns, units
        Whether every other period is a mirror image; see `see`.
    known, sizes, within
        ``(A, L, d)``, ``(A,)``, ``(A,)``: moments of what is known to attract, how many each has, and how near to it
        a motion surely settles.
    seen
        ``(33, d + 2)``: room for the last moments; in the last two, the place.
    fates, periods, lags
        ``(N,)``: filled with what each settles on, or else becomes of it, after how many periods that is known, and,
        for what repeats itself, after how many it does.
    """
    none = p[:0]
    pack_directions(none, w)
    for row in range(p.shape[0]):
        w.clock[EVALUATIONS] = 0.0
        tape.counts[0] = tape.counts[1] = 0
        if push.shape[0] > 0:
            copy(push[row], w.push)
        launch(p[row], none, w)
        fates[row], periods[row], lags[row] = UNDECIDED, most, 0
        seen[0, -2], seen[0, -1] = w.y[X, 0], w.y[Y, 0]
        step, at, pace = 0, 0, max(units[0], units[1])
        for count in range(1, most + 1):
            status = OK
            for _ in range(period):
                step += 1
                status = take_step(w, step, float(most * period), scale, tape)
                if status != OK:
                    break
            if status != OK:
                fates[row], periods[row] = FALLS if status == FALLEN else FAILS, count
                break
            before, at = at, count % seen.shape[0]
            seen[at, -2], seen[at, -1] = seen[before, -2], seen[before, -1]
            see(w, -1.0 if flips and count % 2 == 1 else 1.0, turns, units, seen[at])
            if count < first:
                continue
            speed = math.hypot(seen[at, 0] * units[0], seen[at, 1] * units[1]) / pace
            fate = nearest(seen, at, known, sizes, within)
            if fate == NOT_YET and speed > FASTEST:
                fate = RUNS_AWAY
            lag = lag_of(seen, at, count - first) if fate == NOT_YET else 0
            if lag > 0 or count == most:
                fate = REPEATS if lag > 0 else UNDECIDED if fate == NOT_YET else fate
                # A step in which nothing moves repeats itself as well.
                fate = STOPS if speed < SLOWEST else fate
            if fate != NOT_YET:
                since = first_near(seen, at, count, first, known[fate], sizes[fate]) if fate >= 0 else count
                fates[row], periods[row], lags[row] = fate, since, lag
                break
