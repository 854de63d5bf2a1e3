"""What the explorer asks of the package: gaits at a place, gaits nearby, and what is seen of one. Texts and arrays."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from legspring.candidates import Judge, Trial, box_of
from legspring.criteria import stability
from legspring.drawing.stage import free_legs
from legspring.following import follow
from legspring.gait import Gait
from legspring.kept import gait_as_json, gait_from_json
from legspring.kernel.walker import Floats
from legspring.measures.sensitivity import checked, value_of
from legspring.model import Animal
from legspring.problem import TARGETS
from legspring.route import limits_of
from legspring.solve import Origin, search_gaits
from legspring.varied import parameters

FRAMES = 72
"""Pictures of a stride."""
FACTS = ("family", "mean_speed", "stride_frequency", "transport_cost", "max_multiplier", "froude_number", "energy")
"""Measures that are said in words."""
ASKED = ("slope_deg", *TARGETS)
"""What an address may ask for."""
FIRST = ("slope_deg", *TARGETS, "mass", "stiffness")
"""What can be changed, in the order of its importance; then what belongs to legs."""
OF_LEGS = ("stiffness", "angle", "length", "actuation", "damping")
WIDE, TURN = 3.0, 0.6
"""Factor by which what is positive may be larger or smaller on a slider; and angle, rad, to either side."""


@dataclass(frozen=True)
class Control:
    """Something that can be changed: its name, value, ends of its slider, unit and words."""

    name: str
    value: float
    low: float
    high: float
    unit: str
    words: str


@dataclass(frozen=True)
class Sight:
    """All that is shown of a gait.

    Attributes
    ----------
    gait, branch
        Its JSON, and its number among those of the search it comes from.
    facts
        Words and values, as text.
    multipliers
        ``(k, 2)``: real and imaginary parts.
    frames
        ``body`` (F, 2), ``hip`` and ``foot`` (F, L, 2), ``force`` (F, L) with its sign (> 0: the leg pushes), ``free``
        (F, L, 2): where the foot would be without force; ``ground``: how far the animal gets in a stride, m.
    forces
        ``time`` (s), and the force of each leg, in m g.
    """

    gait: str
    branch: int
    facts: tuple[tuple[str, str], ...]
    multipliers: Floats
    frames: Mapping[str, Floats]
    forces: Mapping[str, Any]


@dataclass(frozen=True)
class Answer:
    """What comes of a question.

    Attributes
    ----------
    gaits, controls
        Of a search: gaits as (words, JSON), and what can be changed of them.
    sight
        What is seen of a gait.
    told
        Of a search: what the address says of the gait that is seen.
    words, nearest
        Where there is no gait: why, and where the nearest one is.
    """

    gaits: tuple[tuple[str, str], ...] = ()
    controls: tuple[Control, ...] = ()
    sight: Sight | None = None
    told: Mapping[str, float] = field(default_factory=dict)
    words: str = ""
    nearest: float = math.nan


def search(animal: str, asked: Mapping[str, Any], given: Mapping[str, str]) -> Answer:
    """Search for gaits of an animal, given as JSON; look at the most stable one, or at what an address is about.

    An address gives, as text, what gaits are asked for, the branch, and parameters to which the gait is then continued,
    one after the other.
    """
    numbers, unknown = read(given)
    branch, wanted = numbers.pop("branch", None), {name: numbers.pop(name) for name in ASKED if name in numbers}
    try:
        found = search_gaits(Animal.model_validate_json(animal), **{**asked, **wanted})
    except ValueError as error:
        return Answer(words=str(error))
    if not found.gaits:
        return Answer(words=found.summary())
    first = min(found.gaits, key=lambda gait: stability(gait))
    gait = next((gait for gait in found.gaits if gait.branch == branch), first)
    names, controls = tuple((name_of(one), gait_as_json(one)) for one in found.gaits), tuple(controls_of(gait))
    told = {name: float(value) for name, value in {**asked, **wanted}.items() if isinstance(value, float)}
    told["branch"] = float(gait.branch)
    sight, words = sight_of(gait), unknown
    for name, value in numbers.items():
        then = change(sight.gait, name, value)
        if then.sight is not None:
            sight, told[name] = then.sight, value
        words = words or then.words
    return Answer(names, controls, sight, told, words)


def read(given: Mapping[str, str]) -> tuple[dict[str, float], str]:
    """Return the numbers of an address, and words about what is none."""
    numbers, unknown = dict[str, float](), list[str]()
    for name, text in given.items():
        try:
            number = float(text)
        except ValueError:
            number = math.nan
        if math.isfinite(number):
            numbers[name] = number
        else:
            unknown.append(name)
    return numbers, f"{', '.join(unknown)[:100]}: must be numbers" if unknown else ""


def name_of(gait: Gait) -> str:
    """Return what tells a gait from others at the same place."""
    return f"{gait.branch}: family {gait.family}, {stability_of(gait)}"


def stability_of(gait: Gait) -> str:
    """Say whether a gait is stable."""
    return "stable" if stability(gait) < 1.0 else "unstable"


def change(text: str, name: str, value: float) -> Answer:
    """Continue a gait to another value of something; where it ends before, say how, and where the last one is."""
    gait = gait_from_json(text)
    try:
        here = value_of(gait, checked(gait, name))
        if here == value:
            return Answer(sight=sight_of(gait))
        found = near(gait, name, here, value)
        if found is not None and found.invalid() is None:
            return Answer(sight=sight_of(found))
        curve = follow(gait, name, to=value)
    except ValueError as error:
        return Answer(words=str(error))
    reached = [one for one in curve.at(value) if one.invalid() is None]
    if reached:
        return Answer(sight=sight_of(reached[0]))
    points = curve.to_dataset()
    known = points[name].values[points["valid"].values.astype(bool)]
    nearest = float(known[np.argmin(np.abs(known - value))]) if len(known) else math.nan
    return Answer(words=str(curve.ending), nearest=nearest)


def near(gait: Gait, name: str, here: float, value: float) -> Gait | None:
    """Return the gait at another value, straight on; None if it is lost on the way."""
    box = box_of([gait], {name: (min(here, value), max(here, value))})
    judge = Judge(box, (gait,), (), np.zeros(0))
    start, goal = box.place(gait), np.array([float(value > here)])
    # Most changes are small enough for one step.
    return judge.along(gait, goal, goal - start) or judge.followed(Trial(start, 0, gait), goal, strict=True)


def look(text: str) -> Answer:
    """Look at a gait."""
    return Answer(sight=sight_of(gait_from_json(text)))


def sight_of(gait: Gait) -> Sight:
    """Return all that is shown of a gait."""
    values = gait.multipliers
    return Sight(
        gait_as_json(gait),
        gait.branch,
        facts_of(gait),
        np.stack([values.real, values.imag], axis=-1),
        *seen_of(gait),
    )


def facts_of(gait: Gait) -> tuple[tuple[str, str], ...]:
    """Return the words and values of some measures; what is missing says why."""
    from legspring.measures.registry import BY_NAME

    found = []
    for name in FACTS:
        one = BY_NAME[name]
        value = one.of(gait)
        text = value if isinstance(value, str) else gait.missing.get(name) or f"{value:.4g}"
        unit = "" if isinstance(value, str) or one.unit in ("", "1") or name in gait.missing else f" {one.unit}"
        found.append((one.words, text + unit))
    return (*found, ("stability", stability_of(gait)))


def controls_of(gait: Gait) -> list[Control]:
    """Return what can be changed of a gait, the important things first."""
    found = []
    for one in parameters(gait.animal, slope_deg=gait.slope_deg, family=gait.family):
        try:
            value = value_of(gait, checked(gait, one.name))
            assert isinstance(gait.origin, Origin)
            bottom, top = limits_of(gait.origin.loosened(gait, [one.name])[0], one.name)
        except ValueError:
            continue
        if one.name == "slope" or not math.isfinite(value):
            continue
        angular = one.unit in ("rad", "deg")
        reach = math.degrees(TURN) if one.unit == "deg" else TURN
        low, high = (value - reach, value + reach) if angular or value == 0.0 else sorted((value / WIDE, value * WIDE))
        low, high = max(low, bottom), min(high, top)
        if low < high:
            found.append(Control(one.name, value, low, high, one.unit, one.words))
    return sorted(found, key=lambda control: rank(control.name, gait.animal.pairs))


def rank(name: str, pairs: Sequence[str]) -> tuple[int, int, str]:
    """Return the place of a name among all that can be changed."""
    if name in FIRST:
        return 0, FIRST.index(name), name
    leg, _, what = name.rpartition(".")
    if leg in pairs and what in OF_LEGS:
        return 1, OF_LEGS.index(what), name
    return 2 if leg in pairs or not leg else 3, 0, name


def seen_of(gait: Gait) -> tuple[dict[str, Floats], dict[str, Any]]:
    """Return pictures of a stride as numbers, and the forces of its legs."""
    shot = gait.shot(1)
    run, time = shot.run, shot.run["time"].values
    rows = np.searchsorted(time, np.linspace(shot.begin, shot.end, FRAMES, endpoint=False))
    centre = shot.camera[rows]
    hip, foot = (run[name].values[rows] - centre[:, None] for name in ("hip", "foot"))
    position = run["position"].values[rows] - centre
    force, signs = run["force"].values[rows], np.sign(np.sum((hip - foot) * run["force"].values[rows], axis=-1))
    free = hip + free_legs(hip, foot, run["free_length"].values[rows])
    way = shot.camera[np.searchsorted(time, shot.end)] - shot.camera[np.searchsorted(time, shot.begin)]
    sizes = np.hypot(*np.moveaxis(force, -1, 0)) * signs
    frames = {"body": position, "hip": hip, "foot": foot, "force": sizes, "free": free, "ground": way}
    frames["camera"] = centre - centre[0]
    forces = {"time": (time[rows] - shot.begin), "legs": [str(leg) for leg in run["leg"].values], "force": sizes}
    return frames, forces
