"""Problems from what gaits are asked for: what is given and what is free, counted, for one animal or another."""

import math
from collections.abc import Mapping, Sequence
from functools import partial
from itertools import combinations
from types import MappingProxyType

from numpy.typing import ArrayLike

from legspring.checks import checked_angle, checked_number, checked_vector, shown
from legspring.layout import System
from legspring.model import Animal
from legspring.problem import TARGETS, GaitProblem
from legspring.starts import contacts_met

NOTHING: Mapping[str, float | str] = MappingProxyType({})
MOST_EARLIER = 6
"""Legs that events put down, beside those that land as a step begins, of which all sets are looked at."""


def check_tuned(animal: Animal, purpose: str) -> None:
    """Raise ValueError unless an animal's legs are tuned to its desired speed."""
    if not animal.tuned:
        raise ValueError(
            f"animal = {animal.name!r}: must have actuated legs whose phases are not given {purpose}; this one's gaits "
            "have speeds and headings of their own"
        )


def open_phases(animal: Animal) -> tuple[str, ...]:
    """Name the phases that gaits choose: those of actuated legs that are not given."""
    firsts = (animal.legs[i] for i in animal.first_legs)
    return tuple(f"{leg.pair}.phase" for leg in firsts if animal.tuned and leg.phase is None and leg.actuation > 0.0)


def earlier_legs(animal: Animal) -> tuple[str, ...] | None:
    """Return the legs by the clock that may be down from before when a step begins; None if one memory does for all.

    The latter where all legs go by the clock and are put down as steps begin.
    """
    if all(leg.touchdown == "clock" for leg in animal.legs):
        if all(leg.offset in (0.0, 1.0) for leg in animal.legs):
            return None
        return tuple(leg.name for leg in animal.legs if leg.offset > 0.0)
    return tuple(leg.name for leg in animal.legs if leg.offset > 0.0 and leg.touchdown == "clock")


def checked_targets(targets: Mapping[str, float | None]) -> dict[str, float | str]:
    """Return the targets that are given, checked.

    Raises
    ------
    ValueError
        For one that is no such number.
    """
    given: dict[str, float | str] = {}
    for name, value in targets.items():
        if name not in TARGETS:
            raise ValueError(f"target = {shown(name)}: must be one of {', '.join(TARGETS)}")
        if value is None:
            continue
        if name == "heading":
            given[name] = checked_angle(name, value, math.pi)
        elif name == "lateral_drift":
            given[name] = checked_number(name, value, "a finite number (m/s)")
        else:
            number = checked_number(name, value, f"a positive number ({TARGETS[name]})")
            if number <= 0.0:
                raise ValueError(f"{name} = {shown(value)}: must be a positive number ({TARGETS[name]})")
            given[name] = number
    return given


def problem_for(
    animal: Animal,
    slope: float,
    family: str,
    given: Mapping[str, float | str] = NOTHING,
    free: Sequence[str] = (),
    *,
    actuation: ArrayLike | None = None,
    mirrored: bool | None = None,
    contacts: Sequence[str] = (),
) -> GaitProblem:
    """Return the problem of a gait of one family.

    Parameters
    ----------
    animal, slope, family, actuation
        See `legspring.layout.System`.
    given, free
        What is asked for (see `TARGETS`), and parameters that are let go, beside the phases that are open. If that
        leaves unknowns without a condition, a tuned animal is asked for its desired speed and no lateral drift, and
        one that keeps its energy for the desired speed at the start.
    mirrored
        Whether steps mirror one another; by default if the animal is such that they may.
    contacts
        Of the legs that do not go by the clock: which of those put down before are still down as a step begins.

    Raises
    ------
    ValueError
        If what is asked for, or what is free, does not fit the animal or one another.
    """
    if actuation is not None:
        if not animal.tuned:
            raise ValueError(f"actuation = {shown(actuation)}: must be left out for {animal.name!r}, which has its own")
        actuation = tuple(checked_vector("actuation", actuation, len(animal.pairs)).tolist())
    if mirrored and not animal.mirrored:
        raise ValueError(
            f"mirrored = True: must be left out, as pair {animal.odd_pair!r} of animal {animal.name!r} has not two "
            "legs that are mirror images, one step apart"
        )
    clock = earlier_legs(animal)
    both = None if clock is None else (*clock, *contacts)
    # With another value of one leg only, steps mirror one another no more.
    symmetric = mirrored is not False and not any(animal.is_one_of_two(name.rpartition(".")[0]) for name in free)
    system = System(animal, slope, family, actuation, both, symmetric=symmetric)
    given = dict(given)
    for name in free:
        # An unknown name is told before anything is counted.
        try:
            system.direction(name)
        except ValueError as error:
            raise ValueError(str(error).replace("parameter =", "free =", 1)) from None
    free = (*open_phases(animal), *(name for name in free if name not in open_phases(animal)))
    defaults: list[tuple[str, float | str]] = []
    # A body that nothing turns may have any yaw, and so may one for which all directions are alike.
    if "yaw_rate" in system.conserved:
        given |= {"yaw": 0.0, "yaw_rate": 0.0}
    elif system.isotropic and not system.flips:
        given["yaw"] = 0.0
    if animal.tuned:
        defaults = [("mean_speed", "desired_speed"), ("lateral_drift", 0.0)]
    elif "energy" in system.conserved:
        defaults = [("speed", "desired_speed")]
    spare = -Counted(system, free, given).excess
    for name, value in defaults:
        if spare > 0 and name not in given:
            given[name] = value
            spare -= 1
    if animal.tuned and spare > 0:
        raise ValueError(too_few(animal, free, given, spare))
    return GaitProblem(system, free, given)


class Counted(GaitProblem):
    """A problem whose unknowns and conditions need not match."""

    def __post_init__(self) -> None:
        """Count nothing."""


def too_few(animal: Animal, free: Sequence[str], given: Mapping[str, float | str], spare: int) -> str:
    """Say that less is asked of a tuned animal than it has phases open."""
    if "heading" not in given and spare == 1:
        return "heading is missing: must be an angle in rad, within +-pi/2"
    phases, extra = open_phases(animal), [name for name in free if name not in open_phases(animal)]
    fewer = f"{spare} more phase{'s' if spare > 1 else ''} given,"
    if extra:
        fewer = f"{spare} name{'s' if spare > 1 else ''} less in free, or {fewer}"
    more = ", ".join(name for name in TARGETS if name not in given and (animal.sagittal or name != "apex_height"))
    return (
        f"animal = {animal.name!r}: has {len(free)} unknowns of its own ({', '.join(free)}) for {len(given)} targets "
        f"({', '.join(given)}): must have {fewer} as in replace(**{{{phases[-1]!r}: 0.5}}), or {spare} more of the "
        f"targets {more}"
    )


def tuned(animal: Animal, slope: float, heading: float, family: str, actuation: ArrayLike | None = None) -> GaitProblem:
    """Return the problem of a gait at a given heading, straight up at the desired speed: phases are free."""
    check_tuned(animal, "for a gait at a given heading")
    return problem_for(
        animal, slope, family, {"heading": checked_angle("heading", heading, math.pi / 2)}, actuation=actuation
    )


def earlier_by_events(animal: Animal) -> list[str]:
    """Return the legs, of those that do not go by the clock, that may be down from before as a step begins."""
    # One whose lift-off begins the step is up.
    lifted = {leg.follows for leg in animal.legs if leg.offset == 0.0}
    others = [leg for leg in animal.legs if leg.offset > 0.0 and leg.touchdown != "clock"]
    return [leg.name for leg in others if leg.name not in lifted]


def contact_sets(animal: Animal) -> list[tuple[str, ...]] | None:
    """Return all sets of these legs; None if there are too many for all of them to be looked at."""
    legs = earlier_by_events(animal)
    if len(legs) > MOST_EARLIER:
        return None
    return [some for count in range(len(legs) + 1) for some in combinations(legs, count)]


def problems_for(
    animal: Animal,
    slope: float,
    family: str,
    given: Mapping[str, float | str],
    free: Sequence[str] = (),
    actuation: ArrayLike | None = None,
    mirrored: bool | None = None,
) -> list[GaitProblem]:
    """Return the problems whose solutions are the gaits of one family: one for each set of contacts.

    Where gaits that are not symmetric are looked for as well, those that are come first. Where there are too many sets
    for all to be looked at, those that are met.
    """

    def ask(some: tuple[str, ...], way: bool | None) -> GaitProblem:
        return problem_for(animal, slope, family, given, free, actuation=actuation, mirrored=way, contacts=some)

    ways, sets = (True, False) if mirrored is False and animal.mirrored else (mirrored,), contact_sets(animal)
    legs = earlier_by_events(animal)
    return [ask(some, way) for way in ways for some in sets or contacts_met(partial(ask, way=way), legs)]
