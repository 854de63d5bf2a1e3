"""What can vary: names, values, units and meaning."""

import math
from typing import NamedTuple

from legspring.layout import BODY, LEG, MIRRORED, PLACES, START, System, slope_for
from legspring.model import Animal


class Parameter(NamedTuple):
    """Something that can vary: its name, value (nan where it is not given, but found or chosen), unit and meaning."""

    name: str
    value: float
    unit: str
    words: str


def parameters(
    animal: Animal,
    *,
    slope: float | None = None,
    slope_deg: float | None = None,
    family: str | None = None,
) -> list[Parameter]:
    """List everything of an animal that can vary at a slope: what gaits depend on, and what a start consists of.

    See :ref:`numerics-parameters`.

    Parameters
    ----------
    animal
        The animal.
    slope, slope_deg
        Either of them; rad or degrees. Not needed where the animal's speed law is for one slope only.
    family
        Of the gaits in question; by default the animal's first.

    Returns
    -------
    list of Parameter
        Name, value, unit and words of each: the start of a step, whose values a gait or a simulation has; the body and
        its surroundings; what all legs have alike; then every pair of legs, and every single leg where that is
        something else. A name may be given to `Animal.replace`, but for the start's and the slope.

    Raises
    ------
    ValueError
        For a slope out of range, or an unknown family.

    Examples
    --------
    >>> import legspring as ls
    >>> found = {p.name: p for p in ls.parameters(ls.cockroach(), slope_deg=45)}
    >>> found["F.stiffness"]
    Parameter(name='F.stiffness', value=1.5, unit='N/m', words='stiffness (FL, FR)')
    >>> round(found["desired_speed"].value, 3), "FL.stiffness" in found, "inertia" in found
    (0.275, True, False)
    """
    label = next(iter(animal.families)) if family is None else family
    system = System(animal, slope_for(animal, slope, slope_deg), label)
    found = [Parameter(name, math.nan, *words) for name, words in START.items() if system.has(name)]
    found += [
        Parameter(name, float(system.values[PLACES[name]]), *words) for name, words in BODY.items() if system.has(name)
    ]
    degrees = math.degrees(system.slope)
    found.insert(
        1 + [one.name for one in found].index("slope"), Parameter("slope_deg", degrees, "deg", BODY["slope"][1])
    )
    if len(animal.pairs) > 1:
        found += [p for name in LEG if (p := _of_all(system, name)) is not None]
    singles = [leg.name for leg in animal.legs if animal.legs_named(leg.name) != animal.legs_named(leg.pair)]
    for owner in (*animal.pairs, *singles):
        legs = animal.legs_named(owner)
        found += [p for name in LEG if (p := _of_legs(system, owner, legs, name)) is not None]
    return [_with_kink(system, one) for one in found]


def _of_all(system: System, name: str) -> Parameter | None:
    """Return what all legs have alike; None where they differ in it, or have it not, or gaits choose it."""
    each = [_of_legs(system, pair, system.animal.legs_named(pair), name) for pair in system.animal.pairs]
    values = [math.nan if one is None else one.value for one in each]
    if not all(math.isclose(value, values[0], rel_tol=1e-12, abs_tol=1e-15) for value in values):
        return None
    unit, words = LEG[name]
    return Parameter(name, values[0], unit, f"{words} (all legs)")


def _of_legs(system: System, owner: str, legs: tuple[int, ...], name: str) -> Parameter | None:
    """Return a parameter of a pair or leg; None where it has none, or the legs of a pair differ in it."""
    animal = system.animal
    first = next((leg for leg in legs if leg in animal.first_legs), legs[0])
    leg, values = animal.legs[first], [system.values[system.place(i, name)] for i in legs]
    if (name == "stance" and leg.stance is None) or (name == "offset" and leg.touchdown != "clock"):
        return None
    signs = [-1.0 if name in MIRRORED and i != first else 1.0 for i in legs]
    same = [sign * value for sign, value in zip(signs, values, strict=True)]
    if name != "offset" and not all(math.isclose(one, same[0], rel_tol=1e-12, abs_tol=1e-15) for one in same):
        return None
    open_phase = name == "phase" and leg.phase is None and animal.tuned
    unit, words = LEG[name]
    whose = ", ".join(animal.legs[i].name for i in legs)
    value = math.nan if open_phase else float(system.values[system.place(first, name)])
    return Parameter(f"{owner}.{name}", value, unit, f"{words} ({whose})")


def _with_kink(system: System, one: Parameter) -> Parameter:
    """Add to a parameter's words that its derivatives hold on one side only, if they do."""
    reason = system.one_sided(one.name)
    return one if reason is None else one._replace(words=f"{one.words}; {reason}")
