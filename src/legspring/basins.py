"""Which starts lead to a gait: `legspring.basin`."""

import json
import math
import os
import time
from collections.abc import Callable, Mapping, Sequence
from itertools import product

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from legspring.checks import checked_choice, checked_whole, checked_workers, shown
from legspring.gait import Gait
from legspring.kept import gait_as_json
from legspring.kernel.walker import Floats, Ints
from legspring.layout import PLACES, START, System
from legspring.mapping import provenance
from legspring.measures.sensitivity import unit_of, value_of
from legspring.memory import Memory, digest, opened, recalled
from legspring.progress import progress_bar
from legspring.returnmap import state_names
from legspring.settling import FATES, Attractor, Settling, attractor

MEMORIES = ("kept", "rebuilt")
MOST_STRIDES, MOST_REFINED, LONGEST_AXIS = 400, 6, 10_000
FAR = 0.3
"""Farthest, between neighbouring values of a parameter, that two attractors are one."""
CHUNK = 4096
"""Starts that are followed between two ticks of the progress bar."""


def basin(
    gait: Gait,
    over: Mapping[str, ArrayLike],
    *,
    memory: str = "kept",
    most_strides: int = MOST_STRIDES,
    refine: int = 0,
    workers: int | None = None,
    store: str | os.PathLike[str] | None = None,
    progress: bool = False,
) -> xr.Dataset:
    """Find out which starts lead to a gait, and where the others go.

    A motion has settled once it is where the return map is seen to contract towards something that repeats itself: the
    gait, or whatever else is met. See :ref:`numerics-basins`.

    Parameters
    ----------
    gait
        The gait, which must be stable; all else stays as it is, its phases among it.
    over
        One or two coordinates of a start (``"speed"``, ``"heading"``, ``"Dx"``, ``"yaw_rate"``, ...; see
        `legspring.parameters`), of which one may be a parameter of the animal instead; each with rising values, in SI
        units.
    memory
        Where the feet of the step before are: ``"kept"``, where they are in the gait, or ``"rebuilt"``, as the thesis
        has it: put down by a body that has come straight ahead at the desired speed.
    most_strides
        Strides after which a motion that has not settled counts as neither.
    refine
        How often to halve the grid where neighbours go to different places; what lies between equals is filled in.
    workers
        Threads; by default one a core. The result does not depend on it.
    store
        Directory that keeps what was computed, so that one that was stopped goes on where it was.
    progress
        Whether to show a progress bar.

    Returns
    -------
    xarray.Dataset
        Over what was asked for: ``settles_on``, the number of the attractor, the gait's being 0, or below zero what
        else becomes of the start (its attributes say what); ``steps`` after which that is known; ``simulated``, false
        for what was filled in. Over ``attractor``, and the parameter, if one varies: ``attractor_speed`` (m/s),
        ``attractor_heading`` (rad), ``attractor_periods`` and ``attractor_multiplier`` of what is settled on; and
        ``area``, of the starts that do, in the units of both coordinates.

    Raises
    ------
    ValueError
        For an unknown name, values that do not rise, or a gait that is not stable.

    Examples
    --------
    >>> import legspring as ls
    >>> gait = ls.find_gaits(ls.cockroach(), slope_deg=45, heading=0.15)[0]
    >>> found = ls.basin(gait, {"speed": [0.1, 0.2, 0.3], "heading": [-0.5, 0.0, 0.5]})
    >>> bool((found["settles_on"] == 0).all())
    True
    """
    axes, parameter = checked_axes(gait, over)
    checked_choice("memory", memory, MEMORIES)
    most = checked_whole("most_strides", most_strides, 1, 1_000_000)
    levels, count = checked_whole("refine", refine, 0, MOST_REFINED), checked_workers(workers)
    begin = time.perf_counter()
    about = gait_as_json(gait), memory, list(axes), most
    starts = Starts(gait, memory, tuple(axes), parameter, most, count, opened(store, "basin", *about))
    total = math.prod(len(axis) for axis in axes.values())
    with progress_bar("following starts", total, show=progress) as tick:
        grid, fates, steps, simulated = refined(list(axes.values()), starts, levels, tick)
    axes = dict(zip(axes, grid, strict=True))
    found = as_dataset(starts, axes, fates, steps, simulated)
    at = {name: float(gait.point[gait.system.place_of(name)]) for name in axes if name != "slope_deg"}
    attributes = {
        "memory": memory,
        "most_strides": most,
        "seconds": time.perf_counter() - begin,
        "gait": json.dumps(at),
    }
    return found.assign_attrs(provenance(gait.animal) | attributes | {"title": f"Basins of {gait!r}"})


def checked_axes(gait: Gait, over: Mapping[str, ArrayLike]) -> tuple[dict[str, Floats], str | None]:
    """Return the coordinates, and which of them is a parameter, if one is."""
    if not isinstance(over, Mapping) or not 1 <= len(over) <= 2:
        raise ValueError(f"over = {shown(over)}: must be one or two coordinates with their values")
    axes, parameters, state = {}, [], state_names(gait.system, gait.point)
    for name, values in over.items():
        axis = np.asarray(values, dtype=float) if _is_numbers(values) else np.zeros(0)
        if axis.ndim != 1 or not 1 <= len(axis) <= LONGEST_AXIS or not np.all(np.diff(axis) > 0.0):
            raise ValueError(f"over[{name!r}] = {shown(values)}: must be rising numbers")
        if not np.all(np.isfinite(axis)) or (name == "speed" and axis[0] <= 0.0):
            raise ValueError(f"over[{name!r}] = {shown(values)}: must be finite numbers, speeds above 0")
        if name in START and name not in state:
            raise ValueError(f"over: {name!r} must be one of {', '.join(state)}, or a parameter")
        if name not in state:
            for value in (float(axis[0]), float(axis[-1])):
                check_possible(gait, str(name), value)
            parameters.append(name)
        axes[str(name)] = axis
    if len(parameters) > 1:
        raise ValueError(f"over = {', '.join(parameters)}: must be a coordinate of the start, at least one of them")
    return axes, parameters[0] if parameters else None


def check_possible(gait: Gait, name: str, value: float) -> None:
    """Raise ValueError if there is no animal with a value of a parameter."""
    if name in ("slope", "slope_deg"):
        gait.animal.desired_speed(math.radians(value) if name == "slope_deg" else value)
    else:
        gait.system.direction(name)
        gait.animal.replace(**{name: value})


def _is_numbers(values: ArrayLike) -> bool:
    try:
        return np.asarray(values).dtype.kind in "iuf"
    except ValueError:
        return False


def with_value(system: System, p: Floats, name: str, value: float) -> Floats:
    """Return all parameters with another value of one, SI units, and what the animal's laws tie to it."""
    direction, changed = system.direction(name), p.copy()
    if name in ("slope", "slope_deg", "desired_speed"):
        animal, slope = system.animal, math.radians(value) if name == "slope_deg" else value
        if name != "desired_speed":
            changed[PLACES["slope"]], value = slope, animal.desired_speed(slope)
        changed[PLACES["desired_speed"]] = value
        changed[PLACES["step_duration"]] = animal.step_law(value)
        return changed
    return changed + direction * (value - p[system.place_of(name)])


class Starts:
    """Starts in the plane of some coordinates, and where they settle.

    Parameters
    ----------
    gait, memory
        See `basin`.
    names, parameter
        The coordinates, and which of them is a parameter.
    most, workers
        Most strides; threads.
    kept
        What is known already of some starts; None to keep nothing.
    """

    def __init__(
        self,
        gait: Gait,
        memory: str,
        names: Sequence[str],
        parameter: str | None,
        most: int,
        workers: int,
        kept: Memory | None = None,
    ) -> None:
        self.kept = kept
        self.system, self.names, self.parameter, self.most, self.workers = gait.system, names, parameter, most, workers
        self.start = gait.point.copy()
        self.value = value_of(gait, parameter) if parameter else 0.0
        if memory == "rebuilt" and "Dx" in self.system.state:
            self.start[[PLACES["Dx"], PLACES["Dy"]]] = 0.0, self.system.step_length
        self.gait = attractor(self.system, gait.point)
        if not self.gait.within:
            size = float(np.max(np.abs(self.gait.multipliers)))
            raise ValueError(f"gait: must be stable, for starts to lead there; its largest multiplier is {size:.4g}")
        self.by_value: dict[float, Settling] = {}

    def settling(self, value: float) -> Settling:
        """Return what settles motions at a value of the parameter; what the gait's own start leads to is first."""
        if value not in self.by_value:
            known = [] if self.parameter else [self.gait]
            self.by_value[value] = Settling(self.system, known, self.most, self.workers)
            if self.parameter:
                self.by_value[value](self.at(value, self.start)[None])
        return self.by_value[value]

    def at(self, value: float, start: Floats) -> Floats:
        """Return a start at a value of the parameter."""
        return start if self.parameter is None else with_value(self.system, start, self.parameter, value)

    def __call__(self, points: Floats, tick: Callable[[int], None]) -> tuple[Ints, Ints]:
        """Return where some points, ``(M, D)``, settle, and after how many steps that is known."""
        fates, steps = np.zeros(len(points), np.int64), np.zeros(len(points), np.int64)
        column = self.names.index(self.parameter) if self.parameter else -1
        values = points[:, column] if self.parameter else np.zeros(len(points))
        for value in np.unique(values):
            rows = np.flatnonzero(values == value)
            for some in np.split(rows, range(CHUNK, len(rows), CHUNK)):
                p = np.repeat(self.at(float(value), self.start)[None], len(some), axis=0)
                for n, name in enumerate(self.names):
                    if name != self.parameter:
                        p[:, self.system.direction(name) != 0.0] = points[some, n, None]
                fates[some], steps[some] = self._settled(self.settling(float(value)), p)
                tick(len(some))
        return fates, steps

    def _settled(self, settling: Settling, p: Floats) -> tuple[Ints, Ints]:
        """Return where some starts settle, which may be known, and what else was met on the way as well."""
        before = len(settling.found)

        def work() -> tuple[Ints, Ints, list[tuple[Floats, int]]]:
            fates, steps = settling(p)
            return fates, steps, [(one.point, len(one.moments)) for one in settling.found[before:]]

        fates, steps, met = recalled(self.kept, work, "starts", digest(p), before)
        for point, periods in met[len(settling.found) - before :]:
            settling.found.append(attractor(self.system, point, periods))
        return fates, steps


def refined(
    axes: list[Floats], starts: Starts, levels: int, tick: Callable[[int], None]
) -> tuple[list[Floats], Ints, Ints, NDArray[np.bool_]]:
    """Follow all points of a grid, and then those between neighbours that differ, halving it so often."""
    shape = tuple(map(len, axes))
    fates, steps = (a.reshape(shape) for a in starts(grid_of(axes), tick))
    simulated = np.ones(shape, dtype=bool)
    for _ in range(levels):
        between = [np.sort(np.append(axis, 0.5 * (axis[1:] + axis[:-1]))) for axis in axes]
        index = [np.arange(len(axis)) for axis in between]
        sides = [[i // 2, (i + 1) // 2] for i in index]
        corners = [np.ix_(*choice) for choice in product(*sides)]
        around = np.array([fates[corner] for corner in corners])
        known = np.zeros(tuple(map(len, between)), dtype=bool)
        known[tuple(slice(None, None, 2) for _ in axes)] = True
        todo = ~known & np.any(around != around[0], axis=0)
        simulated = np.where(known, simulated[corners[0]], todo)
        steps = np.ceil(np.mean([steps[corner] for corner in corners], axis=0)).astype(np.int64)
        fates, axes = around[0], between
        fates[todo], steps[todo] = starts(grid_of(axes)[todo.ravel()], tick)
    return axes, fates, steps, simulated


def grid_of(axes: Sequence[Floats]) -> Floats:
    """Return the points of a grid, ``(M, D)``."""
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))


def numbered(starts: Starts, values: Sequence[float]) -> tuple[list[dict[int, Attractor]], list[dict[int, int]]]:
    """Give attractors at neighbouring values of a parameter the same number, where they are close.

    From the value next to the gait's on, both ways: what is close to the gait there has number 0.

    Returns
    -------
    table, names
        At each value, the attractors by number; and the number of each of its own.
    """
    table: list[dict[int, Attractor]] = [{} for _ in values]
    names: list[dict[int, int]] = [{} for _ in values]
    first = int(np.argmin(np.abs(np.array(values) - starts.value))) if starts.parameter else 0
    count = 1
    for way in (range(first, len(values)), range(first - 1, -1, -1)):
        # Each way begins with what there is at the first value.
        latest = dict(table[first]) or {0: starts.gait}
        for place in way:
            for own, one in enumerate(starts.settling(values[place]).found):
                off = {number: gap(one, other) for number, other in latest.items() if number not in table[place]}
                number = min(off, key=lambda key: off[key], default=count)
                if off.get(number, math.inf) > FAR:
                    number = count
                count = max(count, number + 1)
                table[place][number], names[place][own] = one, number
            latest |= table[place]
    return table, names


def gap(one: Attractor, other: Attractor) -> float:
    """Return how far two attractors are apart, wherever each begins; infinite if they take different times."""
    if len(one.moments) != len(other.moments):
        return math.inf
    shifted = [np.roll(one.moments, shift, axis=0) for shift in range(len(one.moments))]
    return min(float(np.max(np.abs(moments - other.moments))) for moments in shifted)


def relabelled(starts: Starts, dims: Sequence[str], fates: Ints, names: Sequence[dict[int, int]]) -> Ints:
    """Return fates with the numbers that attractors have for all values of the parameter."""
    which, column = fates.copy(), dims.index(starts.parameter) if starts.parameter else 0
    old, new = (np.moveaxis(some, column, 0) if starts.parameter else some[None] for some in (fates, which))
    for before, after, own in zip(old, new, names, strict=True):
        for local, number in own.items():
            after[before == local] = number
    return which


def cells_of(axes: Mapping[str, Floats]) -> Floats:
    """Return how much of the plane, or the line, each start stands for."""
    sizes = []
    for axis in axes.values():
        edges = np.concatenate([axis[:1], 0.5 * (axis[1:] + axis[:-1]), axis[-1:]])
        sizes.append(np.diff(edges) if len(axis) > 1 else np.ones(1))
    return sizes[0] if len(sizes) == 1 else sizes[0][:, None] * sizes[1]


OF_ATTRACTORS: dict[str, tuple[Callable[[Attractor], float], str, str]] = {
    "speed": (lambda one: float(one.point[PLACES["speed"]]), "m/s", "speed at the start of a step"),
    "heading": (lambda one: float(one.point[PLACES["heading"]]), "rad", "heading at the start of a step"),
    "periods": (lambda one: len(one.moments), "1", "periods after which it repeats itself"),
    "multiplier": (lambda one: float(np.max(np.abs(one.multipliers), initial=0.0)), "1", "largest multiplier"),
}
"""What is said of attractors: from what, unit, words."""


def as_dataset(
    starts: Starts, axes: dict[str, Floats], fates: Ints, steps: Ints, simulated: NDArray[np.bool_]
) -> xr.Dataset:
    """Return what was found out, as a dataset."""
    parameter, dims, cells = starts.parameter, tuple(axes), cells_of(axes)
    table, names = numbered(starts, axes[parameter].tolist() if parameter else [0.0])
    which = relabelled(starts, dims, fates, names)
    numbers = range(1 + max(number for here in table for number in (0, *here)))
    areas = [float(cells[which == n].sum()) for n in numbers]
    over = ("attractor", parameter) if parameter else ("attractor",)
    found = {}
    for name, (of, unit, about) in OF_ATTRACTORS.items():
        values = np.array([[of(here[n]) if n in here else math.nan for here in table] for n in numbers])
        found[f"attractor_{name}"] = (over, values if parameter else values[:, 0], {"units": unit, "long_name": about})
    flags = {"flag_values": list(FATES), "flag_meanings": "; ".join(FATES.values())}
    words = "number of the attractor; below zero, " + ", ".join(f"{n}: {word}" for n, word in FATES.items())
    return xr.Dataset(
        {
            "settles_on": (dims, which.astype(np.int16), {"long_name": words} | flags),
            "steps": (dims, steps.astype(np.int32), {"units": "1", "long_name": "steps after which that is known"}),
            "simulated": (dims, simulated, {"long_name": "whether it was simulated, and not filled in"}),
            **found,
            "area": ("attractor", areas, {"long_name": "area of the starts that settle on it"}),
        },
        {name: (name, axis, {"units": unit_of(name), "long_name": name}) for name, axis in axes.items()},
    )
