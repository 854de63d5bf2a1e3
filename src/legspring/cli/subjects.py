"""What a command is about: gaits that are searched for, and starts that are none."""

import inspect
import math
import sys
from collections.abc import Callable
from functools import partial, wraps
from typing import TYPE_CHECKING, Any

import legspring
from legspring.cli.options import (
    Actuation,
    AnimalName,
    ApexHeight,
    Asymmetric,
    Branch,
    Energy,
    Family,
    Free,
    Heading,
    LateralDrift,
    MeanSpeed,
    Slope,
    Speed,
    check_slope,
    load_weighing,
    parse_names,
    parse_numbers,
    parse_phase,
)
from legspring.cli.program import NO_GAIT, fail, patience

FindGait = partial["Gait"]
"""What finds the gait that a command is about; its keywords are what was said of that."""

if TYPE_CHECKING:
    import xarray as xr

    from legspring.gait import Gait
    from legspring.solve import Search


def search_at(
    animal: str,
    slope: float | None,
    heading: float | None,
    family: str | None,
    actuation: str | None,
    free: str | None = None,
    asymmetric: bool = False,
    work_weights: str | None = None,
    **targets: float | None,
) -> "Search":
    """Search for the gaits that a command is about; targets are those of `search_gaits`."""
    creature, magnitudes = load_weighing(animal, work_weights), parse_numbers("--actuation", actuation)
    check_slope(creature, slope)
    if magnitudes is not None and not creature.tuned:
        raise ValueError(f"--actuation = {actuation!r}: must be left out; gaits of {creature.name} have the animal's")
    with patience("loading"):
        from legspring.solve import search_gaits
    return search_gaits(
        creature,
        slope_deg=slope,
        heading=heading,
        family=family,
        actuation=magnitudes,
        free=parse_names(free),
        mirrored=False if asymmetric else None,
        progress=sys.stderr.isatty(),
        **targets,  # type: ignore[arg-type]  # of those names only
    )


def choose_gait(search: "Search", slope: float | None, heading: float | None, branch: int | None) -> "Gait":
    """Return the gait of a branch, by default the first; exit if there is none at all."""
    if not search.gaits:
        fail(no_gait(search, slope, heading), NO_GAIT)
    if branch is None:
        return search.gaits[0]
    for gait in search.gaits:
        if gait.branch == branch:
            return gait
    offered = ", ".join(str(gait.branch) for gait in search.gaits)
    raise ValueError(f"--branch = {branch}: must be one of {offered}")


def find_gait(
    animal: AnimalName,
    slope: Slope = None,
    heading: Heading = None,
    branch: Branch = None,
    family: Family = None,
    actuation: Actuation = None,
    speed: Speed = None,
    mean_speed: MeanSpeed = None,
    energy: Energy = None,
    apex_height: ApexHeight = None,
    lateral_drift: LateralDrift = None,
    free: Free = None,
    asymmetric: Asymmetric = False,
) -> "Gait":
    """Search for the gait that options name."""
    targets: Any = {"speed": speed, "mean_speed": mean_speed, "energy": energy, "apex_height": apex_height}
    targets["lateral_drift"] = lateral_drift
    found = search_at(animal, slope, heading, family, actuation, free, asymmetric, **targets)
    return choose_gait(found, slope, heading, branch)


def about_gait(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command the options that say which gait it is about, before its own.

    It is handed what finds that gait, to be called once all else is known to be right.
    """
    about, own = (inspect.signature(one).parameters for one in (find_gait, command))
    mine = [one for name, one in own.items() if name != "found"]

    @wraps(command)
    def run(**given: Any) -> None:
        which = {name: given.pop(name) for name in about}
        command(partial(find_gait, **which), **given)

    options = [one.replace(kind=inspect.Parameter.KEYWORD_ONLY) for one in (*about.values(), *mine)]
    run.__signature__ = inspect.Signature(options)  # type: ignore[attr-defined]
    run.__annotations__ = {one.name: one.annotation for one in options}
    return run


def no_gait(search: "Search", slope: float | None, heading: float | None) -> str:
    """Say that there is no gait, and why."""
    return f"no gait{where(slope, heading)}; {search.summary()}"


def where(slope: float | None, heading: float | None) -> str:
    """Say where gaits were looked for."""
    slopes = [] if slope is None else [f"slope {slope:g} deg"]
    headings = [] if heading is None else [f"heading {heading:g} rad"]
    return f" at {' and '.join(slopes + headings)}" if slopes or headings else ""


def check_strides(name: str, strides: float) -> None:
    """Make sure that an animal can be simulated for so many strides."""
    from legspring.model import load_animal

    animal = load_animal(name)
    with patience("loading"):
        from legspring.layout import System
        from legspring.simulation import steps_in

    slope_deg = 0.0 if animal.sagittal else animal.speed_law.domain_deg[0]
    steps_in(System(animal, math.radians(slope_deg), next(iter(animal.families))), strides)


def simulate_start(
    animal: str,
    *,
    slope: float | None,
    heading: float | None,
    speed: float | None,
    phase: str | None,
    family: str | None,
    actuation: str | None,
    strides: float,
) -> "xr.Dataset":
    """Simulate a start that need not be a gait; phases in degrees."""
    from legspring.model import load_animal

    creature = load_animal(animal)
    if speed is None or heading is None:
        raise ValueError("a start that is no gait must have --speed and --heading")
    if creature.tuned and (phase is None or family is None):
        raise ValueError(
            f"a start of {creature.name} that is no gait must have --speed, --heading, --phase and --family"
        )
    check_slope(creature, slope)
    with patience("simulating"):
        return legspring.simulate(
            creature,
            slope_deg=slope,
            heading=heading,
            speed=speed,
            phase=None if phase is None else parse_phase(creature, phase),
            family=family,
            actuation=parse_numbers("--actuation", actuation),
            strides=strides,
        )
