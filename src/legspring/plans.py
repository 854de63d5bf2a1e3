"""What is asked of which points: the plan of a sweep, checked, and what its result consists of."""

import json
import math
import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.stats import qmc

from legspring.asking import earlier_legs
from legspring.batches import MEASURES, OUTCOMES, UNSOLVED
from legspring.candidates import box_of
from legspring.checks import (
    LARGEST_SEED,
    MOST_STARTS,
    checked_choice,
    checked_grid,
    checked_names,
    checked_whole,
    shown,
)
from legspring.gait import Gait
from legspring.kept import gait_as_json, gait_from_json
from legspring.kernel.walker import Floats
from legspring.mapping import (
    FOLLOW,
    IMPULSE,
    MORE_STARTS,
    SEARCH,
    SHEET,
    Grid,
    about,
    coordinates,
    freed,
    provenance,
    starts_for_each,
)
from legspring.measures.registry import BY_NAME, OF_RECOVERIES, Measure, mapped
from legspring.measures.robustness import LARGEST_IMPULSE
from legspring.measures.sensitivity import checked, value_of
from legspring.model import Animal
from legspring.problem import TARGETS
from legspring.solve import Origin
from legspring.stores import Layout, Variable
from legspring.varied import parameters

SAMPLINGS = ("grid", "list", "latin", "sobol", "random", "saltelli")
BRANCHES = 4
"""Gaits that there is room for."""
FOLLOWED, SEARCHED = 4096, 16
"""Points of a block where gaits are followed, and where they are searched for, at most."""
PROBES = 64
"""Points of which one must be such that gaits can be asked for."""
FEWEST, FEW, BLOCKS = 512, 4, 16
"""Points from which on a block is worth its while, in the same order; blocks that there are to be at least, if so."""
NO_GAIT, NO_FURTHER, DOUBLE, UNASKABLE = -3, -4, -5, -6
MEANINGS = OUTCOMES | {
    NO_GAIT: "the search has found nothing",
    NO_FURTHER: "no further gait",
    DOUBLE: "the same gait as one of a smaller number",
    UNASKABLE: "there is no such animal, or nothing of the kind can be asked of it",
}
"""What may become of a gait at a point."""
METHODS_IN_WORDS = {
    "given": "followed from the given gaits",
    SEARCH: "searched for at each point",
    FOLLOW: "followed along all lines of the grid, and searched for at each point",
}
COUNTS = {
    "found": "how many gaits there are, whether there is room for them or not",
    "rejected": "how many solutions are no gaits",
    "alone": "how many gaits the search has found, and no curve that was followed",
}
"""What is counted at each point, the last where all is one block."""
QUICK = tuple(name for name in MEASURES if name in BY_NAME)
"""Measures that are made of arrays; others take some milliseconds for each gait."""


@dataclass(frozen=True)
class Plan:
    """What is asked of which points: all that a block depends on, as text.

    Attributes
    ----------
    animal, gaits
        JSON: the animal; the gaits that are followed, none where gaits are searched for.
    names, values
        What varies; the values of each: along its axis of a grid, or of each point.
    grid
        Whether points are a grid.
    asked, starts, branches
        What gaits are asked for everywhere, as JSON; starts of a search; room for gaits.
    measures
        What is said of them.
    low, high
        Ranges within which gaits are followed.
    width
        Points of a block along each dimension; None for what seems best.
    impulses
        Sideways, from which gaits are to recover; none: no recovery.
    method
        Of the search: within a block, ``"search"``; or ``"follow"``, for which all points of a grid are one block.
    """

    animal: str
    gaits: tuple[str, ...]
    names: tuple[str, ...]
    values: tuple[tuple[float, ...], ...]
    grid: bool
    asked: str
    starts: int
    branches: int
    measures: tuple[str, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    width: tuple[int, ...] | None = None
    impulses: tuple[float, ...] = ()
    method: str = SEARCH

    @cached_property
    def sizes(self) -> dict[str, int]:
        """Points along each of their dimensions."""
        if self.grid:
            return {name: len(values) for name, values in zip(self.names, self.values, strict=True)}
        return {"point": len(self.values[0])}

    @cached_property
    def block(self) -> tuple[int, ...]:
        """Points of a block along each dimension: about as many one way as the other."""
        if self.width is not None:
            return self.width
        sizes = list(self.sizes.values())
        if self.method == FOLLOW:
            return tuple(sizes)
        most, least = (FOLLOWED, FEWEST) if self.gaits else (SEARCHED, FEW)
        most = min(most, max(least, math.prod(sizes) // BLOCKS))
        widths, left = [1] * len(sizes), float(most)
        for n, axis in enumerate(sorted(range(len(sizes)), key=lambda axis: sizes[axis])):
            widths[axis] = max(1, min(sizes[axis], round(left ** (1.0 / (len(sizes) - n)))))
            left = max(1.0, left / widths[axis])
        return tuple(widths)

    def part(self, where: tuple[slice, ...]) -> "Plan":
        """Return the plan of some of the points: all that what is said of them depends on."""
        parts = where if self.grid else where * len(self.values)
        cut = tuple(values[part] for values, part in zip(self.values, parts, strict=True))
        return replace(self, values=cut, width=None)

    @cached_property
    def points(self) -> Floats:
        """The values at all points, ``(M, D)``."""
        if not self.grid:
            return np.array(self.values).T
        axes = [np.array(values) for values in self.values]
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))

    @cached_property
    def creature(self) -> Animal:
        """The animal."""
        return Animal.model_validate_json(self.animal)

    @cached_property
    def followed(self) -> list[Gait]:
        """The gaits that are followed."""
        return [gait_from_json(text) for text in self.gaits]

    @cached_property
    def families(self) -> list[str]:
        """Labels of the families that there may be."""
        return list(dict.fromkeys([*self.creature.families, *(gait.family for gait in self.followed)]))

    @cached_property
    def multipliers(self) -> int:
        """For how many multipliers there is room."""
        if self.gaits:
            return max(len(gait.multipliers) for gait in self.followed)
        yaws, legs = self.creature.body.yaw == "free", earlier_legs(self.creature)
        each = 3 if yaws else 2
        return 2 * each + (each - 2) if legs is None else 2 * (each - 1) + 3 * len(self.creature.legs)

    @cached_property
    def about(self) -> tuple[Measure, ...]:
        """What is said of gaits."""
        return tuple(BY_NAME[name] for name in self.measures)

    @cached_property
    def freed(self) -> tuple[Measure, ...]:
        """Parameters that were let go and are not among the measures, of which the values found are said."""
        free = [*json.loads(self.asked).get("free", ()), *(name for gait in self.followed for name in gait.freed)]
        return freed(tuple(dict.fromkeys(name for name in free if name not in self.measures)))

    @cached_property
    def grids(self) -> list[Grid]:
        """All points, in their order, as grids: one, or one for each point of a list."""
        asked = json.loads(self.asked)
        if self.grid:
            return [Grid(self.creature, dict(zip(self.names, self.values, strict=True)), asked)]
        each = (dict(zip(self.names, zip(point, strict=True), strict=True)) for point in self.points.tolist())
        return [Grid(self.creature, over, asked) for over in each]


def checked_over(
    over: Mapping[str, Any], samples: int | None, sampling: str, seed: int
) -> dict[str, tuple[float, ...]]:
    """Return what varies, with its values: along each axis, or of each point.

    Raises
    ------
    ValueError
        For what is none.
    """
    checked_choice("sampling", sampling, SAMPLINGS)
    if not isinstance(over, Mapping) or not over:
        raise ValueError(f"over = {shown(over)}: must map parameters to values, as in {{'slope_deg': [0, 10]}}")
    found: dict[str, tuple[float, ...]] = {}
    for name, values in over.items():
        key = f"over[{shown(name)}]"
        numbers = numbers_of(values)
        if numbers.ndim != 1 or not len(numbers) or not np.all(np.isfinite(numbers)):
            raise ValueError(f"{key} = {shown(values)}: must be finite numbers")
        if sampling == "grid" and np.any(np.diff(numbers) <= 0.0):
            raise ValueError(f"{key} = {shown(values)}: must be rising numbers")
        found[str(name)] = tuple(numbers.tolist())
    if sampling in ("grid", "list"):
        if samples is not None:
            raise ValueError(f"samples = {shown(samples)}: must be left out for a {sampling}")
        if sampling == "list" and len({len(values) for values in found.values()}) > 1:
            raise ValueError("over: must have as many values of each parameter, one for each point of the list")
        return found
    if samples is None:
        raise ValueError(f"samples is missing: must be how many points, for sampling = {sampling!r}")
    count, luck = checked_whole("samples", samples, 1, 100_000_000), checked_whole("seed", seed, 0, LARGEST_SEED)
    for name, values in found.items():
        if len(values) != 2 or not values[0] < values[1]:
            raise ValueError(f"over[{shown(name)}] = {shown(over[name])}: must be a range, (low, high)")
    if sampling == "saltelli" and count & (count - 1):
        raise ValueError(f"samples = {count}: must be a power of two, for sampling = 'saltelli'")
    low, high = np.array(list(found.values())).T
    shares = sampled(sampling, count, len(found), luck)
    return {name: tuple(column) for name, column in zip(found, (low + shares * (high - low)).T.tolist(), strict=True)}


def numbers_of(values: Any) -> Floats:
    """Return values as an array; one without any if they are no numbers."""
    try:
        array = np.asarray(values)
    except ValueError:
        return np.zeros(0)
    return array.astype(float) if array.dtype.kind in "iuf" else np.zeros(0)


def sampled(sampling: str, count: int, size: int, seed: int) -> Floats:
    """Return points of the unit cube, ``(count, size)``, or more for Sobol indices."""
    if sampling == "random":
        return np.random.default_rng(seed).random((count, size))
    if sampling == "saltelli":
        first, second = np.split(qmc.Sobol(2 * size, rng=seed).random_base2(round(math.log2(count))), 2, axis=1)
        mixed = [np.where(np.arange(size) == n, second, first) for n in range(size)]
        return np.vstack([first, second, *mixed])
    if sampling == "latin":
        return qmc.LatinHypercube(size, rng=seed).random(count)
    # A power of two is what the sequence is made for.
    return qmc.Sobol(size, rng=seed).random_base2(max(0, math.ceil(math.log2(count))))[:count]


def plan_of(
    animal: Animal,
    over: Mapping[str, tuple[float, ...]],
    grid: bool,
    gaits: Sequence[Gait],
    asked: Mapping[str, Any],
    measures: Sequence[str] | None,
    starts: int | None,
    branches: int,
    width: tuple[int, ...] | None,
    impulses: Sequence[float] = (),
    method: str = SEARCH,
) -> Plan:
    """Return what is asked, checked.

    Raises
    ------
    ValueError
        If it does not fit the animal, or together.
    """
    known = ["heading", *(one.name for one in mapped(animal) if one.unit)]
    names = tuple(n for n in QUICK if n in known) if measures is None else checked_names("measures", measures)
    if bad := [name for name in names if name not in known]:
        raise ValueError(f"measures = {shown(bad[0])}: must be one of {', '.join(known)}")
    names = tuple(name for name in names if name not in over)
    if both := [name for name in over if name in asked]:
        raise ValueError(f"{both[0]} = {shown(asked[both[0]])}: must be left out, as it varies")
    if both := [name for name in over if name in asked.get("free", ())]:
        raise ValueError(f"free = {both[0]!r}: must be left out, as it varies")
    low, high = ([end(values) for values in over.values()] for end in (min, max))
    if starts is None:
        starts = starts_for_each(animal) if grid else MORE_STARTS
    room = checked_whole("branches", branches, 1, 100)
    if gaits:
        for gait in gaits:
            own_animal = gait.origin.problem.system.animal if isinstance(gait.origin, Origin) else gait.animal
            if animal not in (gait.animal, own_animal):
                raise ValueError(f"animal = {animal.name!r}: must be the one whose gaits are followed")
        if asked:
            raise ValueError(f"{next(iter(asked))}: must be left out: gaits that are followed were asked for theirs")
        room = len(gaits)
        # The gaits must be within; what lies outside of the points is followed through.
        own = [[value_within(gait, name) for gait in gaits] for name in over]
        low = [min(least, *some) for least, some in zip(low, own, strict=True)]
        high = [max(most, *some) for most, some in zip(high, own, strict=True)]
        high = [b if b > a else a + 1e-6 * (abs(a) or 1.0) for a, b in zip(low, high, strict=True)]
        box_of(gaits, dict(zip(over, zip(low, high, strict=True), strict=True)))
    else:
        check_some(animal, over, grid, asked)
    return Plan(
        animal.model_dump_json(),
        tuple(gait_as_json(gait) for gait in gaits),
        tuple(over),
        tuple(over.values()),
        grid,
        json.dumps(dict(asked)),
        checked_whole("starts", starts, 1, MOST_STARTS),
        room,
        names,
        tuple(low),
        tuple(high),
        width,
        checked_grid("impulses", impulses, LARGEST_IMPULSE, least=0),
        method,
    )


def check_some(animal: Animal, over: Mapping[str, tuple[float, ...]], grid: bool, asked: Mapping[str, Any]) -> None:
    """Raise ValueError if gaits can be searched for at none of some points; one that is none is said in the result."""
    known = ("slope_deg", *TARGETS)
    own = {one.name for one in parameters(animal, slope_deg=animal.speed_law.domain_deg[0])}
    if bad := [name for name in over if name not in known and name not in own]:
        raise ValueError(f"over[{bad[0]!r}]: must be one of {', '.join(known)}, or of ls.parameters, as F.stiffness")
    sizes = tuple(len(values) for values in over.values())
    count = math.prod(sizes) if grid else sizes[0]
    errors = []
    for number in np.unique(np.linspace(0, count - 1, PROBES).astype(int)).tolist():
        place = np.unravel_index(number, sizes) if grid else (number,) * len(sizes)
        point = {name: values[int(n)] for (name, values), n in zip(over.items(), place, strict=True)}
        try:
            for family in animal.families:
                Grid(animal, {name: (value,) for name, value in point.items()}, dict(asked)).problems(
                    (0,) * len(point), family
                )
            return
        except ValueError as error:
            errors.append(error)
    raise errors[0]


def value_within(gait: Gait, name: str) -> float:
    """Return the value that a gait has of something that varies."""
    return value_of(gait, checked(gait, name))


def layout_of(plan: Plan, more: Mapping[str, Any]) -> Layout:
    """Return what the result of a plan consists of."""
    animal = plan.creature
    sizes, dims = plan.sizes, (*plan.sizes, "branch")
    shape, own = (*sizes.values(), plan.branches), coordinates(animal, {})
    coords: dict[str, tuple[Any, ...]] = {}
    for name, values in zip(plan.names, plan.values, strict=True):
        coords[name] = (name if plan.grid else "point", np.array(values), about(name))
    coords["branch"] = ("branch", np.arange(plan.branches), {"long_name": "number of the gait"})
    variables = {}
    own["impulse"] = ("impulse", np.array(plan.impulses), IMPULSE)
    lengths = {name: len(values) for name, (_, values, *_) in own.items()}
    recoveries = OF_RECOVERIES if plan.impulses else ()
    for one in (*plan.about, *plan.freed, *recoveries):
        whole = (*shape, *(lengths[dim] for dim in one.dimensions))
        variables[one.name] = Variable((*dims, *one.dimensions), whole, "float64", math.nan, one.attributes)
        coords |= {dim: own[dim] for dim in one.dimensions}
    coords["part"] = ("part", ["real", "imaginary"], {})
    variables["multipliers"] = Variable(
        (*dims, "multiplier", "part"),
        (*shape, plan.multipliers, 2),
        "float64",
        math.nan,
        {"long_name": "Floquet multipliers of a stride, largest first", "units": "1"},
    )
    flags = {"flag_values": list(range(len(plan.families))), "flag_meanings": "; ".join(plan.families)}
    variables["family"] = Variable(dims, shape, "int16", -1, {"long_name": "pairs of legs that push"} | flags)
    flags = {"flag_values": list(MEANINGS), "flag_meanings": "; ".join(MEANINGS.values())}
    variables["outcome"] = Variable(dims, shape, "int16", UNSOLVED, {"long_name": "what became of a gait"} | flags)
    for name, words in COUNTS.items():
        if name == "alone" and plan.method != FOLLOW:
            continue
        variables[name] = Variable(dims[:-1], shape[:-1], "int16", -1, {"long_name": words, "units": "1"})
    if plan.method == FOLLOW:
        variables["sheet"] = Variable(dims, shape, "int32", -1, SHEET)
    attrs = (
        provenance(animal, list(plan.names))
        | dict(more)
        | {
            "method": METHODS_IN_WORDS["given" if plan.gaits else plan.method],
            "machine": f"{platform.machine()}, {platform.system()}, Python {platform.python_version()}",
            "settings": json.dumps({"asked": json.loads(plan.asked), "starts": plan.starts, "measures": plan.measures}),
            "given_gaits": json.dumps(plan.gaits),
        }
    )
    return Layout(sizes, plan.block, variables, coords, attrs)
