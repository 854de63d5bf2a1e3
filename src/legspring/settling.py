"""Where motions settle: on a gait, on something else that repeats itself, or nowhere.

A motion is looked at once a period. Around everything that attracts there is a neighbourhood in which the map is seen
to contract: whoever comes into it stays, and that is when a motion counts as settled, however many strides it took.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from legspring.flow import NO_PUSH, NO_PUSHES, flow, flows
from legspring.kernel.pack import DESIRED_SPEED, STEP_DURATION
from legspring.kernel.settle import FAILS, FALLS, LONGEST, NEAR, REPEATS, RUNS_AWAY, STOPS, UNDECIDED, settle
from legspring.kernel.walker import OK, Floats, Ints, new_tape
from legspring.layout import System
from legspring.measures.robustness import ANGLE
from legspring.measures.stability import without
from legspring.parallel import in_threads
from legspring.returnmap import seen_at, signs, state_names

if TYPE_CHECKING:
    import xarray as xr

OTHER_ENERGY = -7
FATES = {
    FALLS: "falls",
    FAILS: "cannot be simulated",
    STOPS: "stops",
    RUNS_AWAY: "runs away",
    UNDECIDED: "neither",
    OTHER_ENERGY: "keeps another energy",
}
"""What becomes of motions that do not settle."""
RADII = (1.0, 0.3, 0.1, 0.03, 0.01, 1e-3)
"""Neighbourhoods that are tried, by that."""
SAMPLES, SEED = 128, 0
"""Motions from which a neighbourhood is known."""
ACCURACY = 1e-8
"""Of simulations: what is near is told from what is not at a hundredth."""
ALIKE = 1e-6
"""Difference of gaits that are one."""


@dataclass(frozen=True)
class Attractor:
    """Something that repeats itself.

    Attributes
    ----------
    moments
        ``(L, d)``: what is seen at the start of each period until it is back.
    within
        How near to it a motion surely settles on it; 0 if it is not stable.
    point
        All parameters, with the start.
    multipliers
        Of the map of these periods, without those of what is conserved, largest first.
    """

    moments: Floats
    within: float
    point: Floats = field(repr=False)
    multipliers: NDArray[np.complex128]


def moments(system: System, p: Floats, states: Floats) -> Floats:
    """Return what is seen of motions at the ends of periods, as if their steps mirrored one another: ``(N, K, d)``.

    Velocity, displacement over the period, and yaw and yaw rate, in the units of one set of parameters (see
    `units_of`); where all directions are alike, as seen from the body.
    """
    every, units = states[:, :: system.period], units_of(system, p)
    velocity, way = every[:, 1:, 2:4], np.diff(every[:, :, :2], axis=1)
    turns = [every[:, 1:, 4], every[:, 1:, 5] / units[3]] if system.yaws else []
    if system.isotropic:
        cosine, sine = np.cos(turns[0])[..., None], np.sin(turns[0])[..., None]
        turns[0] = np.zeros_like(turns[0])
        velocity, way = (
            np.concatenate([cosine * a[..., :1] + sine * a[..., 1:], cosine * a[..., 1:] - sine * a[..., :1]], axis=-1)
            for a in (velocity, way)
        )
    velocity, way = velocity / units[:2], way / units[2]
    seen = np.concatenate([velocity, way, *(turn[..., None] for turn in turns)], axis=-1)
    if system.flips:
        mirrored = np.array([-1.0, 1.0, -1.0, 1.0, *[-1.0] * len(turns)])
        seen[:, ::2] *= mirrored
    return seen


def units_of(system: System, p: Floats) -> Floats:
    """Return the units of velocities (x, y), ways and yaw rates, SI.

    Speeds are counted by the desired one, and across the way by the part of it that a change of heading by 0.15 rad
    is, as recoveries count distances.
    """
    speed, duration = float(p[DESIRED_SPEED]), float(p[STEP_DURATION])
    across = speed * math.tan(ANGLE)
    velocity = [speed, across] if system.animal.sagittal else [across, speed]
    return np.array([*velocity, system.period * speed * duration, 1.0 / duration])


def attractor(system: System, p: Floats, periods: int = 1) -> Attractor:
    """Describe something that repeats itself after so many periods."""
    states = flow(system, p, steps=periods * system.period).states
    names = state_names(system, p)
    jacobian = image(system, p, names, periods)[1]
    found = np.linalg.eigvals(jacobian).astype(complex)
    odd = system.flips and periods % 2
    found = without(found, [-1.0 if odd and what != "energy" else 1.0 for what in system.conserved])
    multipliers = found[np.argsort(-np.abs(found))]
    bare = Attractor(moments(system, p, states[None])[0], 0.0, p, multipliers)
    return Attractor(bare.moments, neighbourhood(system, bare, names), p, multipliers)


def image(
    system: System, p: Floats, names: Sequence[str], periods: int, push: Floats = NO_PUSHES
) -> tuple[Floats, Floats]:
    """Map the complete state over some periods, after a push if there is one; return it, and the Jacobian."""
    steps, everything = periods * system.period, bool(system.contacts)
    knots = push[0] if len(push) else NO_PUSH
    seen = flow(system, p, steps=steps, along=list(names), everything=everything, push=knots).seen
    out = seen[[seen_at(system, name) for name in names]] * signs(system, names)[:, None] ** periods
    return out[:, 0], out[:, 1:]


def neighbourhood(system: System, one: Attractor, names: Sequence[str]) -> float:
    """Return how near to something a motion surely settles on it: as far as the map is seen to contract.

    Where energy is conserved, motions beside settle on something else: only what is as near as rounding lets see.
    """
    largest = float(np.max(np.abs(one.multipliers), initial=0.0))
    if largest >= 1.0:
        return 0.0
    if "energy" in system.conserved:
        return ALIKE
    # What goes in the end may grow before: the time for a hundredth, and not that for a half.
    periods = len(one.moments) * (3 + math.ceil(math.log(0.01) / math.log(max(largest, 1e-3))))
    units = np.array([unit_of(one.point, name) for name in names])[:, None] * system.along(names)
    rng = np.random.default_rng(SEED)
    beside = rng.uniform(-1.0, 1.0, (SAMPLES, len(names)))
    beside[: SAMPLES // 2] /= np.max(np.abs(beside[: SAMPLES // 2]), axis=1, keepdims=True)
    for radius in RADII:
        within = radius * NEAR
        p = one.point + within * beside @ units
        ends = flows(system, p, steps=periods * system.period)
        off = distance(moments(system, one.point, ends.states), one)[:, -len(one.moments) :]
        if np.all(ends.status == OK) and np.max(off) < 0.5 * within:
            return within
    return 0.0


def unit_of(p: Floats, name: str) -> float:
    """Return the unit in which moments count a coordinate of the state."""
    quantity, speed, duration = name.rpartition(".")[2], float(p[DESIRED_SPEED]), float(p[STEP_DURATION])
    lengths = dict.fromkeys(("Dx", "Dy", "foot_x", "foot_y"), speed * duration)
    return (lengths | {"speed": speed, "heading": math.tan(ANGLE), "yaw_rate": 1.0 / duration}).get(quantity, 1.0)


def distance(seen: Floats, one: Attractor) -> Floats:
    """Return how far motions are from something that repeats itself, at each moment, ``(N, K)``; nan where unknown."""
    size, count = len(one.moments), seen.shape[1]
    found = np.full(seen.shape[:2], np.inf)
    for shift in range(size):
        wanted = one.moments[(np.arange(count) + shift) % size]
        found = np.minimum(found, np.max(np.abs(seen - wanted), axis=2))
    return found


class Settling:
    """Finds out where motions settle, and what else there is to settle on.

    Parameters
    ----------
    system, known
        Whose motions; what is known that attracts.
    most
        Most strides.
    workers
        Threads.
    """

    def __init__(self, system: System, known: Sequence[Attractor], most: int, workers: int = 1) -> None:
        self.system, self.found, self.workers = system, list(known), workers
        self.most = most * system.cycle // system.period

    def __call__(self, p: Floats, pushes: Floats = NO_PUSHES, first: int = 1) -> tuple[Ints, Ints]:
        """Return on what each of some starts settles, or its fate, and after how many steps that is known.

        Each may be pushed; it is judged from the end of the first period on, or of another one.
        """
        fates, periods, lags = self._followed(p, pushes, first)
        while len(rest := np.flatnonzero(fates == REPEATS)):
            if "energy" in self.system.conserved:
                fates[rest] = OTHER_ENERGY
                break
            # What the first of them settles on is known from now on: whoever else does is judged by that.
            row = int(rest[0])
            push = pushes[row : row + 1]
            self.found.append(self._met(p[row], push, int(periods[row]), int(lags[row])))
            fates[rest], periods[rest], lags[rest] = self._followed(p[rest], pushes[rest] if len(push) else push, first)
            if fates[row] == REPEATS:
                fates[row] = len(self.found) - 1
        return fates, periods * self.system.period

    def _met(self, p: Floats, push: Floats, periods: int, lag: int) -> Attractor:
        """Return what a motion has settled on after so many periods; it begins where it is fastest."""
        system, start = self.system, p.copy()
        names = state_names(system, p)
        states = [image(system, p, names, periods - back, push)[0] for back in range(lag)]
        fastest = int(np.argmax([state[0] for state in states]))
        for name, value in zip(names, states[fastest], strict=True):
            start[system.direction(name) != 0.0] = value
        return attractor(system, start, lag)

    def _followed(self, p: Floats, pushes: Floats, first: int) -> tuple[Ints, Ints, Ints]:
        """Follow some starts."""
        count = max(1, min(self.workers, len(p)))
        cuts = [len(p) * n // count for n in range(count + 1)]

        def follow(rows: slice) -> tuple[Ints, Ints, Ints]:
            return self._follow(p[rows], pushes[rows], first)

        parts = in_threads(follow, [slice(*ends) for ends in pairwise(cuts)], count)
        fates, periods, lags = (np.concatenate(some) for some in zip(*parts, strict=True))
        return fates, periods, lags

    def _follow(self, p: Floats, pushes: Floats, first: int) -> tuple[Ints, Ints, Ints]:
        system, size = self.system, 6 if self.system.yaws else 4
        sizes = np.array([len(one.moments) for one in self.found], dtype=np.int64)
        known = np.zeros((len(sizes), int(max(sizes, default=1)), size))
        for one, room in zip(self.found, known, strict=True):
            room[: len(one.moments)] = one.moments
        within = np.array([one.within for one in self.found], dtype=float)
        walker = system.walker(0, np.zeros(pushes.shape[1:]))
        # The kernel counts time in step durations.
        units = units_of(system, p[0]) * np.array([p[0, STEP_DURATION]] * 2 + [1.0, p[0, STEP_DURATION]])
        fates, periods, lags = (np.zeros(len(p), np.int64) for _ in range(3))
        settle(
            walker,
            new_tape(0, 0, walker),
            np.ascontiguousarray(p),
            np.ascontiguousarray(pushes),
            first,
            self.most,
            system.period,
            system.flips,
            system.isotropic,
            units,
            system.error_scale(ACCURACY),
            known,
            sizes,
            within,
            np.zeros((2 * LONGEST + 1, size + 2)),
            fates,
            periods,
            lags,
        )
        return fates, periods, lags


def words_of(dataset: "xr.Dataset", number: int) -> str:
    """Say what a number in a dataset of basins means."""
    if number < 0:
        flags = dataset["settles_on"].attrs
        values = np.atleast_1d(flags["flag_values"]).tolist()
        return str(flags["flag_meanings"]).split("; ")[values.index(number)]
    if number == 0:
        return "the gait"
    periods = float(np.nanmax(dataset["attractor_periods"].sel(attractor=number).values))
    return f"attractor {number}" + (f", back after {periods:.0f} periods" if periods > 1 else "")
