"""Many gaits at once: of animals that differ in their numbers, continued from those that are known, and measured.

What `legspring.candidates` does for one gait after another is done here in arrays, without Python in between; the same
conditions, and the same verdict on what is no gait.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from legspring.candidates import Box, agree
from legspring.flow import Simulator
from legspring.footing import Feet, Traits, departs, wrongs
from legspring.gait import LEAST_ISOLATION, Gait, Invalid
from legspring.kernel.footfalls import LEAVING, STANCE, TOUCH
from legspring.kernel.pack import GRAVITATION, MASS, STEP_DURATION
from legspring.kernel.walker import Floats, Ints
from legspring.layout import PLACES, TIGHT
from legspring.measures.cost import weighed
from legspring.problem import GaitProblem
from legspring.returnmap import seen_at, signs, state_names
from legspring.route import Piece, kinks_of, piece_of
from legspring.solve import GOAL, Origin, solve

SAME = 1e-12
"""Difference of parameters, by their sizes, that is none."""
PROBES, SEED = 8, 0
"""Places at which it is checked that parameters are what they are taken for."""
STEPS = 10
"""Steps in which a gait is followed through the whole of a range."""
OF_RATES = 1e-9
"""Accuracy of the rates at which solutions move with places."""
PARTS = (1, 4, 16)
"""In how many parts a step from a known gait to another place is made where it is not plausible in fewer."""
REASONS: tuple[Invalid, ...] = tuple(Invalid)
GAIT, NOT_REACHED, UNSOLVED = 0, -1, -2
OUTCOMES = {
    GAIT: "a gait",
    NOT_REACHED: "not reached: no solution can be followed there",
    UNSOLVED: "not looked at yet",
} | {n: str(reason) for n, reason in enumerate(REASONS, start=1)}
"""What may become of a gait at a place."""


@dataclass(frozen=True)
class Solved:
    """Solutions at N places.

    Attributes
    ----------
    z
        ``(N, n)``: unknowns; nan where there is none.
    rates
        ``(N, D, n)``: how they move with places.
    """

    z: Floats
    rates: Floats

    @property
    def there(self) -> NDArray[np.bool_]:
        """Where there is a solution."""
        return np.isfinite(self.z[:, 0])

    def rows(self, rows: NDArray[Any]) -> "Solved":
        """Return some of them."""
        return Solved(self.z[rows], self.rates[rows])

    def put(self, rows: NDArray[Any], found: "Solved") -> None:
        """Write some of them that there were not yet."""
        self.z[rows], self.rates[rows] = found.z, found.rates


class Batch:
    """The gaits that one gait becomes where its animal's numbers, or what it was asked for, are others.

    Parameters
    ----------
    gait
        The gait.
    box
        What varies, and its ranges, within which the conditions stay the same (see `is_plain`).
    """

    def __init__(self, gait: Gait, box: Box) -> None:
        assert isinstance(gait.origin, Origin)
        self.gait, self.box = gait, box
        self.problem = gait.origin.loosened(gait, box.names)[0]
        self.system = self.problem.system
        self.here = box.place(gait)
        self.names = state_names(gait.system, gait.point)
        self._origin, self._along, self._bent, self._pieces = self._bases()

    @staticmethod
    def is_plain(gait: Gait, box: Box) -> bool:
        """Whether the conditions of gaits all over a box differ in parameters only, so that arrays say it all."""
        assert isinstance(gait.origin, Origin)
        problem = gait.origin.loosened(gait, box.names)[0]
        if problem.targets or problem.system.period != 1 or any(name.endswith("offset") for name in box.names):
            return False
        ends = [box.problem(gait, np.full(len(box.names), share)) for share in (0.0, 0.5, 1.0)]
        alike = {(one.unknowns, one.conditions, one.system.conserved) for one in ends}
        return len(alike) == 1

    def _bases(self) -> tuple[Floats, Floats, int | None, list[Piece]]:
        """Find out how parameters depend on the place: linearly, but for one that laws may bend."""
        own, size = np.full(len(self.box.names), 0.5), len(self.box.names)

        def base(place: Floats) -> Floats:
            return self.box.problem(self.gait, place).base

        origin, along, bent = base(own), np.zeros((size, len(self.problem.base))), list[int]()
        for n in range(size):
            ends = [np.where(np.arange(size) == n, share, own) for share in (0.0, 0.25, 1.0)]
            low, quarter, high = (base(end) for end in ends)
            # What is infinite, as the inertia of a body that does not turn, stays as it is.
            along[n] = np.subtract(high, low, out=np.zeros(len(high)), where=high != low)
            moving = np.flatnonzero((low != high) | (low != quarter))
            off = sum(
                np.abs((low + x * along[n])[moving] - there[moving]) for x, there in ((0.25, quarter), (0.5, origin))
            )
            if np.any(off > SAME * (np.abs(high) + np.abs(low))[moving]):
                bent.append(n)
        pieces = self._bend(base, own, bent[0]) if len(bent) == 1 else []
        for n in bent:
            along[n] = 0.0
        return origin, along, bent[0] if pieces else None, pieces

    def _bend(self, base: Callable[[Floats], Floats], own: Floats, axis: int) -> list[Piece]:
        """Return the pieces in which parameters are polynomials of one coordinate of the place."""

        def problem_at(share: float) -> GaitProblem:
            return self.box.problem(self.gait, np.where(np.arange(len(own)) == axis, share, own))

        width = self.box.high[axis] - self.box.low[axis]
        kinks = [(kink - self.box.low[axis]) / width for kink in kinks_of(self.system, self.box.names[axis])]
        cuts = [0.0, *sorted(kink for kink in kinks if 0.0 < kink < 1.0), 1.0]
        try:
            return [piece_of(problem_at, low, high) for low, high in pairwise(cuts)]
        except ValueError:
            return []

    @cached_property
    def is_exact(self) -> bool:
        """Whether parameters are what they are taken for, as a few places at random tell."""
        rng = np.random.default_rng(SEED)
        places = rng.random((PROBES * max(1, len(self._pieces)), len(self.box.names)))
        if self._bent is not None:
            # Some in each piece, however narrow.
            ends = np.repeat([(piece.low, piece.high) for piece in self._pieces], PROBES, axis=0)
            places[:, self._bent] = ends[:, 0] + places[:, self._bent] * (ends[:, 1] - ends[:, 0])
        known = np.array([self.box.problem(self.gait, place).base for place in places])
        finite = np.isfinite(self._origin)
        off = np.abs(self._quick(places)[:, finite] - known[:, finite])
        return bool(np.all(off <= 10.0 * SAME * (np.max(np.abs(known[:, finite]), axis=0) + 1e-30)))

    def bases(self, places: Floats) -> Floats:
        """Return all parameters where the unknowns are zero, ``(N, n)``, at places ``(N, D)``."""
        if self.is_exact:
            return self._quick(places)
        some = [self.box.problem(self.gait, place).base for place in places]
        return np.array(some).reshape(len(places), len(self._origin))

    def _quick(self, places: Floats) -> Floats:
        base = self._origin + (places - 0.5) @ self._along
        if self._bent is None:
            return base
        share, edges = places[:, self._bent], [piece.high for piece in self._pieces[:-1]]
        which = np.searchsorted(edges, share, side="left")
        size = len(self._origin)
        finite = np.isfinite(self._origin)
        for n, piece in enumerate(self._pieces):
            rows, own = np.flatnonzero(which == n), piece.moving < size
            half = 0.5 * (piece.high - piece.low)
            powers = np.vander((share[rows] - piece.low) / half - 1.0, len(piece.factors), increasing=True)
            there = np.broadcast_to(piece.fixed[:size], (len(rows), size)).copy()
            there[:, piece.moving[own]] = powers @ piece.factors[:, own]
            # What moves in one piece may stand still in another.
            base[np.ix_(rows, finite)] += there[:, finite] - self._origin[finite]
        return base

    def directions(self, place: Floats) -> Floats:
        """Return how parameters move with each coordinate of the place, ``(D, n)``, about there."""
        size, step = len(place), 1e-4
        ends = np.clip(place + step * np.vstack([np.eye(size), -np.eye(size)]), 0.0, 1.0)
        base, width = self.bases(ends), np.diag(ends[:size] - ends[size:])
        high, low = base[:size], base[size:]
        return np.subtract(high, low, out=np.zeros_like(high), where=high != low) / width[:, None]

    # Solutions -------------------------------------------------------------------------------------------------

    def solved(self, places: Floats, z: Floats) -> Solved:
        """Solve at places, from unknowns that are near."""
        base = self.bases(places)
        found = solve(self.problem, z, TIGHT, GOAL, base)
        good = found.residuals < 100.0 * GOAL
        z = np.where(good[:, None], found.z, np.nan)
        n, d = self.problem.size, places.shape[1]
        rates = np.full((len(z), d, n), np.nan)
        rows = np.flatnonzero(good)
        if len(rows):
            along = self.directions(np.mean(places, axis=0))
            by = self.problem.residual(z[rows], list(along), base=base[rows], accuracy=OF_RATES)[1]
            fine = np.all(np.isfinite(by), axis=(1, 2))
            rows, by = rows[fine], by[fine]
            regular = np.linalg.svd(by[:, :, :n], compute_uv=False)[:, -1] > LEAST_ISOLATION
            rows, by = rows[regular], by[regular]
            rates[rows] = -np.swapaxes(np.linalg.solve(by[:, :, :n], by[:, :, n:]), 1, 2)
        lost = ~np.isfinite(rates[:, :1, :1]).all(axis=(1, 2))
        z[lost] = np.nan
        return Solved(z, rates)

    def nowhere(self, count: int) -> Solved:
        """Return room for so many solutions, none of which is there."""
        n, d = self.problem.size, len(self.box.names)
        return Solved(np.full((count, n), np.nan), np.full((count, d, n), np.nan))

    def first(self, place: Floats) -> Solved:
        """Return the gait itself, followed to a place: straight, or else one coordinate after the other."""
        size = len(place)
        for order in ((), tuple(range(size)), tuple(reversed(range(size)))) if size > 1 else ((),):
            corners = [np.where(np.isin(np.arange(size), order[: n + 1]), place, self.here) for n in range(len(order))]
            at, here = self.solved(self.here[None], self.problem.z_of(self.gait)[None]), self.here
            for corner in corners or [place]:
                start, steps = here, max(1, math.ceil(STEPS * float(np.max(np.abs(corner - here)))))
                for step in range(1, steps + 1):
                    there = start + (corner - start) * step / steps
                    at, here = self.advanced(at, here[None], there[None]), there
                    if not at.there[0]:
                        break
                if not at.there[0]:
                    break
            if at.there[0]:
                break
        return at

    def advanced(self, known: Solved, here: Floats, there: Floats, across: Solved | None = None) -> Solved:
        """Continue solutions from places to others, ``(N, D)``, in parts where one step is not plausible.

        Where a place is halfway between two, ``across`` are the solutions on its other side.
        """
        out = self.nowhere(len(known.z))
        todo = np.flatnonzero(known.there)
        for parts in PARTS:
            if not len(todo):
                break
            at = known.rows(todo)
            going, places = np.arange(len(todo)), here[todo].copy()
            for part in range(1, parts + 1):
                if not len(going):
                    break
                goal = here[todo[going]] + (there[todo[going]] - here[todo[going]]) * part / parts
                way = goal - places[going]
                move = np.einsum("ndk,nd->nk", at.rates, way)
                near = at.z + move
                if parts == 1 and across is not None:
                    near = self._between(at, across.rows(todo), way, near)
                found = self.solved(goal, near)
                gone = self.problem.wrapped(found.z - at.z)
                after = np.einsum("ndk,nd->nk", found.rates, way)
                fine = found.there & agree(gone, move, after)
                places[going[fine]] = goal[fine]
                going = going[fine]
                at = found.rows(fine)
            out.put(todo[going], at)
            todo = np.delete(todo, going)
        return out

    def _between(self, one: Solved, other: Solved, way: Floats, near: Floats) -> Floats:
        """Return what is halfway between solutions, by a cubic, where both are of one sheet; what is near elsewhere."""
        gone, before, after = other.z - one.z, *(np.einsum("ndk,nd->nk", it.rates, 2.0 * way) for it in (one, other))
        whole = self.problem.wrapped(gone)
        alike = agree(whole, before, after) & np.any(gone != 0.0, axis=1)
        return np.where(alike[:, None], one.z + 0.5 * whole + 0.125 * (before - after), near)

    # Measures --------------------------------------------------------------------------------------------------

    def measured(self, places: Floats, found: Solved) -> "Measured":
        """Look at solutions as `Gait` does, all at once."""
        z = found.z
        p = self.problem.points(z, self.bases(places))
        seen = self._simulator(np.ascontiguousarray(p))
        maps = seen.seen[:, [seen_at(self.system, name) for name in self.names]]
        maps = (maps * signs(self.system, self.names)[None, :, None])[:, :, 1:]
        whole = np.all(np.isfinite(maps), axis=(1, 2))
        maps = np.where(whole[:, None, None], maps, np.eye(len(self.names)))
        feet = self._feet
        work = np.full((len(p), len(self.system.animal.legs), 2), np.nan)
        traits = Traits(self.system, p, feet.trivial.free(maps), *feet.seen(p, work))
        outcomes = np.zeros(len(p), dtype=np.int64)
        away = departs(traits)
        for reason, _, where in wrongs(traits):
            outcomes[where & (outcomes == GAIT)] = 1 + REASONS.index(reason)
        outcomes[(outcomes == GAIT) & (away | ~whole)] = 1 + REASONS.index(Invalid.DEPARTS)
        return Measured(self, p, outcomes, maps, traits, work, seen.seen[:, :, 0])

    @cached_property
    def _simulator(self) -> Simulator:
        along = self.system.along(self.names)
        return Simulator(self.system, steps=1, along=along, everything=True, accuracy=TIGHT)

    @cached_property
    def _feet(self) -> Feet:
        return Feet(self.system)


@dataclass(frozen=True)
class Measured:
    """What is said of solutions, a row each, in the words of `Gait`.

    Attributes
    ----------
    batch, p, outcomes
        Whose they are; all parameters; and whether they are gaits (see `OUTCOMES`).
    maps, traits, work, seen
        Jacobians of the map of a period; what legs do; work of legs in it, J; and what is seen at its end.
    """

    batch: Batch
    p: Floats
    outcomes: Ints
    maps: Floats
    traits: Traits
    work: Floats
    seen: Floats

    def __getitem__(self, name: str) -> Floats:
        """Return a measure, as `Gait` has it, ``(N, ...)``."""
        values: Floats = MEASURES[name](self)
        return values

    @cached_property
    def multipliers(self) -> NDArray[np.complex128]:
        """Floquet multipliers of a stride, largest first, ``(N, k)``."""
        found = np.linalg.eigvals(self.maps).astype(complex)
        order = np.argsort(-np.abs(found), axis=1, kind="stable")
        power = 2 if self.batch.system.mirrored else 1
        return np.take_along_axis(found, order, axis=1) ** power

    @cached_property
    def durations(self) -> Floats:
        """Duration of a step, s."""
        return self.traits.times * self.p[:, STEP_DURATION] / self.batch.system.cycle

    @cached_property
    def distances(self) -> Floats:
        """How far a step gets, m."""
        x, y = self.seen[:, 8], self.seen[:, 9]
        return np.abs(y) if self.batch.system.flips else np.hypot(x, y)

    @cached_property
    def firsts(self) -> list[int]:
        """The leg of each pair that is put down first."""
        return list(self.batch.system.animal.first_legs)

    def cost(self) -> Floats:
        """Return transport costs."""
        animal = self.batch.system.animal
        weights = self.p[:, MASS] * self.p[:, GRAVITATION]
        return weighed(self.work, animal.work_weights) / (weights * self.distances)

    def liftoffs(self) -> Floats:
        """Return times from touch-down to lift-off of each pair, in step durations."""
        times = self.traits.feet[:, self.firsts, STANCE] * self.p[:, STEP_DURATION, None]
        return times / self.durations[:, None]

    def phases(self) -> Floats:
        """Return the phase of each pair."""
        system = self.batch.system
        return self.p[:, [system.place(leg, "phase") for leg in self.firsts]]

    def froude(self) -> Floats:
        """Return Froude numbers."""
        system = self.batch.system
        lengths = self.p[:, [system.place(leg, "length") for leg in range(len(system.animal.legs))]].mean(axis=1)
        return (self.distances / self.durations) ** 2 / (self.p[:, GRAVITATION] * lengths)

    def lags(self) -> Floats:
        """Return touch-downs after that of the first leg, as shares of a stride."""
        touch = self.traits.feet[:, :, TOUCH]
        lag = (touch - touch[:, :1]) / self.traits.times[:, None] % 1.0
        return np.where(1.0 - lag < 1e-9, 0.0, lag)

    def grazing(self) -> Floats:
        """Return the smallest rates at which legs pass through zero force, m/s."""
        legs = [n for n, leg in enumerate(self.batch.system.animal.legs) if leg.stance is None]
        rates = np.abs(self.traits.feet[:, legs, LEAVING]) / self.p[:, STEP_DURATION, None]
        return np.min(rates, axis=1) if legs else np.full(len(self.p), np.nan)


def _strides(found: Measured) -> Floats:
    return 1.0 / (found.batch.system.steps_per_stride * found.durations)


MEASURES: dict[str, Callable[[Measured], Floats]] = {
    "speed": lambda found: found.p[:, PLACES["speed"]],
    "heading": lambda found: found.p[:, PLACES["heading"]],
    "yaw": lambda found: found.p[:, PLACES["yaw"]],
    "yaw_rate": lambda found: found.p[:, PLACES["yaw_rate"]],
    "mean_speed": lambda found: found.distances / found.durations,
    "step_duration": lambda found: found.durations,
    "stride_frequency": _strides,
    "stride_length": lambda found: found.batch.system.steps_per_stride * found.distances,
    "froude_number": Measured.froude,
    "phase": Measured.phases,
    "liftoff": Measured.liftoffs,
    "phase_lag": Measured.lags,
    "grazing": Measured.grazing,
    "max_multiplier": lambda found: np.abs(found.multipliers[:, 0]),
    "transport_cost": Measured.cost,
}
"""Measures that are known of many gaits at once; others are those of each `Gait`."""


def gait_of(batch: Batch, place: Floats, p: Floats) -> Gait:
    """Return the gait at a place of which these are all parameters."""
    problem = batch.box.problem(batch.gait, place)
    # Units of unknowns depend on the animal.
    z = p[[problem.places[name] for name in problem.unknowns]] / problem.units
    return replace(problem.gait(z), origin=Origin(problem))
