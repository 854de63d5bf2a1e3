"""Whether a gait comes back, and how small departures grow in it, by the oracle alone."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any

import numpy as np

from legspring import Gait

from .animals import START, before_of, walker_of
from .heyoka_rules import Before, Law, Moved, Stood, Walk, Walker, simulate
from .problem import Array

EXPECTED = 1e-8
"""Departure after a period that a residual of 1e-12 and the accuracy of both integrators may leave."""


@cache
def written(text: str) -> Law:
    """Return a length law from its formula."""
    code = compile(text, "<length law>", "eval")

    def law(m: Any, t: Any, l0: Any, ldev: Any, phi: Any) -> Any:
        names = {name: getattr(m, name) for name in ("sin", "cos", "exp")}
        return eval(code, {"__builtins__": {}, "pi": math.pi} | names, {"t": t, "l0": l0, "ldev": ldev, "phi": phi})

    return law


@dataclass(frozen=True)
class Coordinate:
    """One number of the state at the start of a period: of the body, or of what is remembered of some legs."""

    name: str
    legs: tuple[int, ...] = ()


@dataclass(frozen=True)
class Period:
    """A gait as the oracle sees it: a start, and the map of a period. The oracle's units: step durations."""

    gait: Gait

    @cached_property
    def walker(self) -> Walker:
        gait = self.gait
        legs = zip(gait.animal.legs, gait.animal.pair_of, strict=True)
        phases = {leg.name: gait.phase[pair] for leg, pair in legs}
        start = dict(zip(START, gait.point.tolist(), strict=False))
        own = gait.actuation == gait.animal.actuation
        animal = gait.animal if own else gait.animal.replace(actuation=gait.actuation)
        walker = walker_of(animal, gait.slope, gait.family, start, phases, before_of(gait) or self._even(start))
        (text,) = {leg.length_law for leg in gait.animal.legs}
        return walker if text is None else replace(walker, law=written(text))

    def _even(self, start: dict[str, float]) -> tuple[Before, ...]:
        """What a body that has moved evenly remembers of each foot put down before."""
        agos = [2.0 - leg.offset for leg in self.gait.animal.legs]
        clock = [leg.touchdown == "clock" and leg.offset > 0.0 for leg in self.gait.animal.legs]
        moved = [Moved(ago * start["Dx"], ago * start["Dy"], ago * start["turn"]) for ago in agos]
        return tuple(one if by_clock else None for one, by_clock in zip(moved, clock, strict=True))

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Of the state: feet put down at one instant by the clock have a displacement in common."""
        found = [Coordinate("speed"), Coordinate("heading")]
        found += [Coordinate("yaw"), Coordinate("yaw_rate")] if self.walker.yaws else []
        instants: dict[float, list[int]] = {}
        for leg, known in enumerate(self.walker.before):
            if isinstance(known, Moved):
                instants.setdefault(round(self.walker.offset[leg], 9), []).append(leg)
            elif isinstance(known, Stood):
                made_of = self.gait.animal.legs[leg]
                found.append(Coordinate("x", (leg,)))
                found += [] if known.y is None else [Coordinate("y", (leg,))]
                found += [] if made_of.timeless else [Coordinate("age", (leg,))]
        for legs in instants.values():
            found += [Coordinate(name, tuple(legs)) for name in ("x", "y", *(["turn"] if self.walker.yaws else []))]
        return tuple(found)

    def values(self) -> Array:
        """The coordinates at the start."""
        return np.array([self._at_start(one) for one in self.coordinates])

    def _at_start(self, one: Coordinate) -> float:
        if not one.legs:
            return float(self.walker.start[START.index(one.name)])
        return float(getattr(self.walker.before[one.legs[0]], one.name))

    def moved(self, change: Array) -> Walker:
        """The walker with other coordinates."""
        walker = self.walker
        start, before = walker.start.copy(), list(walker.before)
        for one, amount in zip(self.coordinates, change, strict=True):
            if not one.legs:
                start[START.index(one.name)] += amount
            for leg in one.legs:
                known = before[leg]
                assert known is not None
                before[leg] = replace(known, **{one.name: getattr(known, one.name) + amount})
        return replace(walker, start=start, before=tuple(before))

    def walk(self, change: Array | float = 0.0, steps: int | None = None) -> Walk:
        """Simulate a period, or so many steps, from other coordinates."""
        start = self.moved(np.broadcast_to(change, len(self.coordinates)))
        return simulate(start, self.gait.system.period if steps is None else steps)

    def image(self, walk: Walk) -> Array:
        """The coordinates at the end: of the mirror image, if the next period mirrors this one."""
        gait, (x, y, vx, vy, yaw, yaw_rate) = self.gait, walk.states[-1]
        flip = -1.0 if gait.mirrored and not gait.animal.sagittal else 1.0
        heading = math.remainder(math.atan2(-vx, vy) - yaw, 2.0 * math.pi)
        body = {"speed": math.hypot(vx, vy), "heading": flip * heading, "yaw": flip * yaw, "yaw_rate": flip * yaw_rate}
        found = []
        for one in self.coordinates:
            if not one.legs:
                found.append(body[one.name])
                continue
            leg = gait.animal.partners[one.legs[0]] if gait.mirrored else one.legs[0]
            place, foot = walk.places[leg], walk.feet[leg]
            if isinstance(self.walker.before[one.legs[0]], Moved):
                gone = {"x": flip * (x - place[0]), "y": y - place[1], "turn": flip * (yaw - place[2])}
            else:
                gone = {"x": flip * (foot[0] - x), "y": foot[1] - y, "age": walk.times[-1] - walk.since[leg]}
            found.append(gone[one.name])
        return np.array(found)

    @cached_property
    def scales(self) -> Array:
        """What is large of each coordinate."""
        speed, length = self.walker.start[0], max(leg.length for leg in self.gait.animal.legs)
        sizes = {"speed": speed, "yaw_rate": speed / length, "x": length, "y": length}
        return np.array([sizes.get(one.name, 1.0) for one in self.coordinates])

    def departure(self) -> float:
        """How far the coordinates are, after a period, from where they were; inf if other legs are down."""
        walk = self.walk()
        gait, down = self.gait, walk.down
        images = gait.animal.partners if gait.mirrored else range(len(down))
        if gait.contacts is not None:
            before = down & (walk.since < walk.times[-1])
            old = [leg.name for i, leg in enumerate(gait.animal.legs) if leg.offset > 0.0 and before[images[i]]]
            if set(old) != set(gait.contacts):
                return math.inf
        gap = self.image(walk) - self.values()
        turns = np.array([one.name in ("heading", "yaw") for one in self.coordinates])
        gap[turns] = np.remainder(gap[turns] + math.pi, 2.0 * math.pi) - math.pi
        return float(np.max(np.abs(gap) / self.scales))

    def jacobian(self, step: float = 1e-5, levels: int = 3) -> Array:
        """Derivative of the map of a period, by extrapolated central differences, in units of the scales."""
        columns = []
        for column in np.diag(self.scales):
            table: list[Array] = []
            for level in range(levels):
                h = step / 2**level
                ahead, behind = (self.image(self.walk(sign * h * column)) for sign in (1.0, -1.0))
                row = [(ahead - behind) / self.scales / (2.0 * h)]
                for order, coarser in enumerate(table, start=1):
                    row.append(row[-1] + (row[-1] - coarser) / (4**order - 1))
                table = row
            columns.append(table[-1])
        return np.array(columns).T


def largest_allowed(gait: Gait) -> float:
    """Departure that a gait may show, after a period: small ones grow as its multipliers say."""
    return EXPECTED * max(1.0, float(np.max(np.abs(gait.half_multipliers))))
