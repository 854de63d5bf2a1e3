"""What gaits can be judged by, each as one number: measures, and what gaits survive."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from legspring.basins import basin
from legspring.checks import shown
from legspring.gait import Gait
from legspring.measures.registry import BY_NAME
from legspring.measures.sensitivity import EVIDENCE
from legspring.measures.stability import without
from legspring.pushing import pushes
from legspring.roughness import rough

GIVEN = "as it was given"
"""What is said of a function that somebody gave."""
PUSH = 0.5
"""Impulse from which `recovery` is, to either side, in units of m v_des."""
DIRECTIONS, MOMENTS = 8, 4
"""Of the pushes of which the least is looked for that a gait does not survive."""
SPEEDS, TURN, SIDE = (0.2, 4.0), 3.0, 12
"""Starts of a basin: speeds by the desired one, headings about the gait's, rad, and how many of each."""
SCALES, RUNS, STRIDES = tuple(float(n) for n in range(1, 31)), 40, 40
"""Noise of the slope that is tried, deg; runs, and strides of each."""


@dataclass(frozen=True)
class Criterion:
    """One number by which gaits are judged.

    Attributes
    ----------
    name, unit, words
        What it is called, its unit, and what it is.
    function
        The gait's value; nan where it has none.
    smooth
        Whether it changes smoothly with the gait, so that it has derivatives.
    """

    name: str
    unit: str
    words: str
    function: Callable[[Gait], float]
    smooth: bool = True


def stability(gait: Gait) -> float:
    """Return the largest magnitude of a multiplier, but for those of what is conserved."""
    return float(np.max(np.abs(without(gait.multipliers, [1.0] * len(gait.conserved))), initial=0.0))


def recovery(gait: Gait) -> float:
    """Return the steps that it takes to recover from a push to either side; nan if it does not."""
    return float(np.max(gait.recovery_steps((-PUSH, PUSH))))


def push(gait: Gait) -> float:
    """Return the largest impulse that is survived whatever its direction and its moment; 0 if the gait is unstable."""
    if stability(gait) >= 1.0:
        return 0.0
    return float(pushes(gait, directions=DIRECTIONS, moments=MOMENTS, workers=1)["survived"].min())


def basin_share(gait: Gait) -> float:
    """Return the share of starts, at other speeds and headings, that lead to a gait; 0 if it is unstable."""
    if stability(gait) >= 1.0:
        return 0.0
    speeds = gait.system.desired_speed * np.linspace(*SPEEDS, SIDE)
    over = {"speed": speeds, "heading": gait.heading + np.linspace(-TURN, TURN, SIDE)}
    return float((basin(gait, over, workers=1)["settles_on"] == 0).mean())


def roughness(gait: Gait) -> float:
    """Return the noise of the slope, a standard deviation in deg, that half of the runs survive; 0 if there is none."""
    survived = 0.0
    for scale in SCALES:
        found = rough(gait, {"slope_deg": 1.0}, runs=RUNS, strides=STRIDES, scales=[scale], workers=1)
        if not math.isfinite(float(found.attrs["largest_scale"])):
            break
        survived = scale
    return survived


def one_number(function: Callable[[Gait], Any], gait: Gait) -> float:
    """Return what a function of a gait that somebody gave returns; raise ValueError if that is no number."""
    value = function(gait)
    try:
        return float(value)
    except (TypeError, ValueError):
        name = getattr(function, "__name__", "function")
        raise ValueError(f"criterion = {name}: must return a number, and returns {shown(value)}") from None


OTHERS = {
    one.name: one
    for one in (
        Criterion("stability", "1", "largest magnitude of a multiplier, but for what is conserved", stability),
        Criterion(
            "recovery", "1", f"steps to recover from a push of {PUSH:g} m v_des to either side", recovery, smooth=False
        ),
        Criterion("push", "m v_des", "largest push survived in any direction, at any moment", push, smooth=False),
        Criterion(
            "basin", "1", "share of starts at other speeds and headings that lead there", basin_share, smooth=False
        ),
        Criterion("roughness", "deg", "noise of the slope that half of the runs survive", roughness, smooth=False),
    )
}
"""Criteria that are no measures."""
MEASURED = tuple(
    name for name, one in BY_NAME.items() if one.unit and name not in ("multipliers", "half_multipliers", *EVIDENCE)
)


def criterion(what: str | Callable[[Gait], float]) -> Criterion:
    """Return a criterion: by its name, a measure (of several numbers, their largest magnitude), or a function.

    Raises
    ------
    ValueError
        For a name that is none.
    """
    if callable(what):
        return Criterion(str(getattr(what, "__name__", "function")), "1", GIVEN, partial(one_number, what))
    if isinstance(what, str) and what in OTHERS:
        return OTHERS[what]
    if not isinstance(what, str) or what not in MEASURED:
        raise ValueError(f"criterion = {shown(what)}: must be one of {', '.join((*OTHERS, *MEASURED))}, or a function")
    measure = BY_NAME[what]

    def value(gait: Gait) -> float:
        found: Any = measure.of(gait)
        return float(np.max(np.abs(found))) if measure.dimensions else float(found)

    words = f"largest magnitude of: {measure.words}" if measure.dimensions else measure.words
    return Criterion(what, measure.unit, words, value)


def criteria(
    names: Sequence[str | Callable[[Gait], float]] | Callable[[Gait], float],
) -> tuple[Criterion, ...]:
    """Return several criteria, each once."""
    if isinstance(names, str) or callable(names):
        names = [names]
    if not isinstance(names, Sequence | np.ndarray):
        raise ValueError(f"criteria = {shown(names)}: must be names of measures, or functions of a gait")
    found = list[Criterion]()
    for one in (criterion(str(name) if isinstance(name, np.str_) else name) for name in names):
        twice = sum(one.name == other.name.partition(" ")[0] for other in found)
        if twice and one.words != GIVEN:
            raise ValueError(f"criterion = {shown(one.name)}: must be named once")
        found.append(replace(one, name=f"{one.name} {twice + 1}") if twice else one)
    return tuple(found)
