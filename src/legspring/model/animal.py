"""An animal: a body on legs, the families of gaits it may have, and how fast it means to run."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import combinations
from math import radians
from numbers import Real
from typing import Annotated, Any, Self

import numpy as np
import tomli_w
from pydantic import AfterValidator, PlainSerializer, PrivateAttr, field_validator, model_validator

from legspring.checks import shown
from legspring.model._base import Frozen, Label, ModelError, NotNegative, Positive, require_number
from legspring.model.body import Body
from legspring.model.laws import SpeedLaw, StepLaw
from legspring.model.leg import Leg
from legspring.model.scaling import scaled_fields

MOST_PAIRS = 6
"""Pairs of legs of which all ways to push and to pull can be looked at."""


class Families(Mapping[str, tuple[str, ...]]):
    """The pairs that push in each family: a mapping that can be hashed and not changed.

    Parameters
    ----------
    pushing : mapping of str to tuple of str
        Labels of the pairs that push, for each family label.
    """

    def __init__(self, pushing: Mapping[str, tuple[str, ...]]) -> None:
        self._pushing = dict(pushing)

    def __getitem__(self, family: str) -> tuple[str, ...]:
        """Return the labels of the pairs that push in a family."""
        return self._pushing[family]

    def __iter__(self) -> Iterator[str]:
        """Iterate over the families' labels."""
        return iter(self._pushing)

    def __len__(self) -> int:
        """Return the number of families."""
        return len(self._pushing)

    def __hash__(self) -> int:
        """Hash as equal mappings do, whatever their order."""
        return hash(frozenset(self._pushing.items()))

    def __repr__(self) -> str:
        """Look like the dict that it was made from."""
        return repr(self._pushing)


class Animal(Frozen):
    """A planar body on springy legs, with all that a simulation has to know about it.

    See :ref:`model-mechanics`.

    Parameters
    ----------
    name : str
        Name of the animal.
    summary : str
        What it is, in one line.
    source : str
        Where its numbers come from.
    body : Body
        Mass and inertia.
    legs : tuple of Leg
        The legs, one or two to a pair. Where all pairs have two that are mirror images (alike, if the animal is seen
        from the side), one step apart, the animal is symmetric, and its gaits may be so.
    families : mapping of str to tuple of str
        Labels of the pairs that push, for each family of gaits; the other pairs pull.
    speed_law : SpeedLaw
        Desired speed against slope; a plain number means a constant speed (m/s).
    step_law : StepLaw
        Step duration against desired speed; a plain number means a constant duration (s).
    gravity : float
        Acceleration g (m/s^2).
    work_weights : tuple of float
        What positive and negative work of the legs cost: b1 and b2 of the transport cost (Eq. 3.5).

    Raises
    ------
    ModelError
        If a value is not valid, or the parts do not fit together.
    """

    name: Label
    summary: str = ""
    source: str = ""
    body: Body
    legs: tuple[Leg, ...]
    families: Annotated[
        Mapping[Label, tuple[Label, ...]],
        AfterValidator(Families),
        PlainSerializer(dict),
    ]
    speed_law: SpeedLaw
    step_law: StepLaw
    gravity: Positive = 9.81
    work_weights: tuple[NotNegative, NotNegative] = (1.0, 1.0)

    @field_validator("work_weights", mode="before")
    @classmethod
    def _two_weights(cls, weights: Any) -> Any:
        if isinstance(weights, str) or not isinstance(weights, Sequence | np.ndarray) or len(weights) != 2:
            raise ValueError("must be two numbers, not negative")
        return tuple(weights)

    @field_validator("speed_law", mode="before")
    @classmethod
    def _constant_speed(cls, law: Any) -> Any:
        return {"level": law, "vertical": law} if isinstance(law, Real) else law

    @field_validator("step_law", mode="before")
    @classmethod
    def _constant_duration(cls, law: Any) -> Any:
        return {"duration": law} if isinstance(law, Real) else law

    # What follows from the legs and is often asked for.
    _pairs: tuple[str, ...] = PrivateAttr(())
    _first_legs: tuple[int, ...] = PrivateAttr(())
    _partners: tuple[int, ...] = PrivateAttr(())
    _odd_pair: str | None = PrivateAttr(None)

    @model_validator(mode="after")
    def _parts_fit(self) -> Self:
        _check_names(self.legs)
        self._pairs = tuple(dict.fromkeys(leg.pair for leg in self.legs))
        _check_rules(self.legs)
        _check_pairs(self.legs)
        _check_families(self.families, self.pairs)
        # The frequency's line has no bend but one, into a constant: good ends mean a good middle.
        for slope_deg in self.speed_law.domain_deg:
            self.step_duration(radians(slope_deg))
        self._first_legs, self._partners = _first_legs(self.legs), _partners_of(self.legs)
        self._odd_pair = _odd_pair(self.legs, self._partners)
        return self

    @property
    def pairs(self) -> tuple[str, ...]:
        """Labels of the pairs of legs, in order of first appearance."""
        return self._pairs

    @property
    def pair_of(self) -> tuple[int, ...]:
        """Index into `pairs` of each leg's pair."""
        return tuple(self.pairs.index(leg.pair) for leg in self.legs)

    @property
    def first_legs(self) -> tuple[int, ...]:
        """Index of the leg of each pair that is put down first, the one that `replace` describes."""
        return self._first_legs

    @property
    def partners(self) -> tuple[int, ...]:
        """Index of the other leg of each leg's pair; its own where it has none."""
        return self._partners

    @property
    def mirrored(self) -> bool:
        """Whether every leg has its mirror image on the other side, a step later; from the side, one that is alike."""
        return self.odd_pair is None

    @property
    def odd_pair(self) -> str | None:
        """Label of the first pair that has not two legs that are mirror images; None if there is none."""
        return self._odd_pair

    def legs_named(self, label: str) -> tuple[int, ...]:
        """Return the legs that a label means: those of a pair, or a single one.

        Parameters
        ----------
        label : str
            Of a pair or a leg.

        Returns
        -------
        tuple of int
            Indices of the legs.

        Raises
        ------
        ModelError
            If nothing has this label, or both a leg and a pair of more than that leg.
        """
        pair = tuple(i for i, leg in enumerate(self.legs) if leg.pair == label)
        single = tuple(i for i, leg in enumerate(self.legs) if leg.name == label)
        if pair and single and pair != single:
            names = ", ".join(self.legs[i].name for i in pair)
            raise ModelError(
                f"{label!r} is both the pair of legs {names} and the leg {label}: must be given another name"
            )
        if not pair and not single:
            legs = ", ".join(leg.name for leg in self.legs)
            raise ModelError(f"{shown(label)}: must be a pair ({', '.join(self.pairs)}) or a leg ({legs})")
        return pair or single

    def is_one_of_two(self, label: str) -> bool:
        """Tell whether a label means a single leg of a pair that has two."""
        legs = {i for i, leg in enumerate(self.legs) if leg.name == label and leg.pair != label}
        return any(self.partners[i] not in legs for i in legs)

    @property
    def actuation(self) -> tuple[float, ...]:
        """Amplitude abs(ldev) of each pair (m), in the order of `pairs`; that of its first leg."""
        return tuple(self.legs[i].actuation for i in self.first_legs)

    @property
    def phase(self) -> tuple[float, ...]:
        """Phase phi of each pair (rad) where it is given, 0 where it is not, in the order of `pairs`."""
        return tuple(self.legs[i].phase or 0.0 for i in self.first_legs)

    @property
    def tuned(self) -> bool:
        """Whether gaits have phases tuned to the desired speed; else they are whatever repeats itself."""
        return any(leg.actuation > 0.0 and leg.phase is None for leg in self.legs)

    @property
    def conservative(self) -> bool:
        """Whether the legs do no work, so that energy is conserved where gravity does none."""
        return all(leg.passive for leg in self.legs)

    @property
    def sagittal(self) -> bool:
        """Whether it is seen from the side, and not from above: some leg comes down to the ground."""
        return _from_the_side(self.legs)

    def functions(self, family: str) -> tuple[int, ...]:
        """Return what each pair does in a family: the signs of ldev.

        Parameters
        ----------
        family : str
            Label of the family.

        Returns
        -------
        tuple of int
            -1 for a pair that pushes, +1 for one that pulls, in the order of `pairs`.

        Raises
        ------
        ModelError
            If the animal has no such family.
        """
        if not isinstance(family, str) or family not in self.families:
            raise ModelError(f"family = {shown(family)}: must be one of {', '.join(self.families)}")
        return tuple(-1 if pair in self.families[family] else 1 for pair in self.pairs)

    def desired_speed(self, slope: float) -> float:
        """Return the speed v_des that the animal means to run at.

        Parameters
        ----------
        slope : float
            Slope sigma (rad), uphill positive.

        Returns
        -------
        float
            Desired speed (m/s).

        Raises
        ------
        ModelError
            If the slope is outside the speed law's domain.
        """
        return self.speed_law(slope)

    def step_duration(self, slope: float) -> float:
        """Return the duration t_des of a step at the desired speed.

        Parameters
        ----------
        slope : float
            Slope sigma (rad), uphill positive.

        Returns
        -------
        float
            Step duration (s), half of a stride's.

        Raises
        ------
        ModelError
            If the slope is outside the speed law's domain.
        """
        return self.step_law(self.desired_speed(slope))

    def to_toml(self) -> str:
        """Return the text of a file from which `legspring.load_animal` reads this animal, to the last digit.

        Examples
        --------
        >>> from legspring.model import cockroach
        >>> print(cockroach().replace(name="heavy", mass=3e-3).to_toml()[:14])
        name = "heavy"
        """
        return tomli_w.dumps(self.model_dump(mode="json", exclude_defaults=True, exclude_none=True))

    def replace(self, **changes: Any) -> "Animal":
        """Return a changed copy.

        Parameters
        ----------
        **changes
            New values of fields of `Animal`, of its `Body` (mass, inertia, yaw) or of its legs
            (hip, length, stiffness, angle or angle_deg, actuation, phase, function, offset, touchdown,
            follows, stance, damping, length_law). A leg's field takes one value for all pairs, or a
            sequence with one for each pair. The value is that of the leg of the pair which is put down
            first; that of its partner is in mirror image, with the angle and the hip's dx negated, unless the
            animal is seen from the side, and keeps its lag. Or a number of one pair or leg, such as
            ``"F.stiffness"`` (both legs alike, angle and hip_x in mirror image) and ``"FL.stiffness"``;
            hip_x and hip_y are numbers of their own. Or desired_speed (m/s) and step_duration (s) in place of the laws.

        Returns
        -------
        Animal
            The changed copy; the original stays as it is.

        Raises
        ------
        ModelError
            If a name is unknown or a value is not valid.

        Examples
        --------
        >>> from legspring.model import cockroach
        >>> heavier = cockroach().replace(mass=3e-3, stiffness=(1.5, 1.5, 2.0))
        >>> heavier.body.mass
        0.003
        >>> [leg.stiffness for leg in heavier.legs]
        [1.5, 1.5, 2.0, 1.5, 1.5, 2.0]
        >>> limping = cockroach().replace(**{"FL.stiffness": 0.75})
        >>> [leg.stiffness for leg in limping.legs]
        [0.75, 1.5, 1.5, 1.5, 1.5, 1.5]
        """
        single = {name: changes.pop(name) for name in list(changes) if "." in name}
        for hip in ("hip_x", "hip_y"):
            if hip in changes:
                single |= dict.fromkeys((f"{pair}.{hip}" for pair in self.pairs), changes.pop(hip))
        for name, law in (("desired_speed", "speed_law"), ("step_duration", "step_law")):
            if name in changes and law in changes:
                raise ModelError(f"{name} and {law} are both given: must be one of them")
            if name in changes:
                changes[law] = changes.pop(name)
                if law == "speed_law" and isinstance(changes[law], Real):
                    # For the slopes that the animal was for before.
                    constant = {"level": changes[law], "vertical": changes[law]}
                    changes[law] = constant | {"domain_deg": self.speed_law.domain_deg}
        own, body, leg = (_pick(changes, names) for names in _CHANGEABLE)
        if unknown := [name for name in changes if name not in own | body | leg]:
            valid = ", ".join(name for names in _CHANGEABLE for name in names)
            raise ModelError(f"cannot replace {', '.join(unknown)}: must be among {valid}")
        animal = Animal(**dict(self) | own)
        parts: dict[str, Any] = {}
        if body:
            parts["body"] = Body(**dict(animal.body) | body)
        if leg:
            parts["legs"] = _changed_legs(animal, leg)
        animal = Animal(**dict(animal) | parts) if parts else animal
        return Animal(**dict(animal) | {"legs": _with_numbers(animal, single)}) if single else animal

    def every_family(self) -> "Animal":
        """Return the animal with a family for each way in which its pairs may push and pull, its own first.

        Returns
        -------
        Animal
            A copy. The further families are named by the pairs that push, or ``"none"``.

        Raises
        ------
        ModelError
            If it has so many pairs that there are too many ways.

        Examples
        --------
        >>> from legspring.model import cockroach
        >>> list(cockroach().every_family().families)
        ['A', 'FB', 'MB', 'B', 'none', 'F', 'M', 'FM']
        """
        if len(self.pairs) > MOST_PAIRS:
            raise ModelError(f"animal = {self.name!r}: must have {MOST_PAIRS} pairs of legs at most for all families")
        families, known = dict(self.families), {frozenset(pushing) for pushing in self.families.values()}
        between = "" if all(len(pair) == 1 for pair in self.pairs) else "+"
        for count in range(len(self.pairs) + 1):
            for pushing in combinations(self.pairs, count):
                label = between.join(pushing) or "none"
                while label in families:
                    label += "*"
                if frozenset(pushing) not in known:
                    families[label] = pushing
        return Animal(**dict(self) | {"families": families})

    def scale(self, *, length: float = 1.0, mass: float = 1.0) -> "Animal":
        """Return an animal of another size that moves in the same way: dynamic similarity, in the same gravity.

        See :ref:`model-scaling`.

        Parameters
        ----------
        length : float
            By what all its lengths are multiplied; times and speeds are by the square root.
        mass : float
            By what its masses are multiplied; forces are as well.

        Returns
        -------
        Animal
            The scaled copy. Its gaits are those of the original: phases, multipliers and transport cost are the same.

        Raises
        ------
        ModelError
            If a factor is no positive number, or leads to values that are not valid.

        Examples
        --------
        A robot of ten times the length and a thousand times the mass of the cockroach:

        >>> from legspring.model import cockroach
        >>> robot = cockroach().scale(length=10, mass=1000)
        >>> robot.body.mass, robot.legs[0].length, robot.legs[0].stiffness
        (2.5, 0.32, 150.0)
        """
        for name, factor in (("length", length), ("mass", mass)):
            try:
                positive = float(require_number(factor)) > 0.0
            except ValueError as error:
                raise ModelError(f"{name} = {shown(factor)}: {error}") from None
            if not positive:
                raise ModelError(f"{name} = {shown(factor)}: must be greater than 0")
        return Animal(**dict(self) | scaled_fields(self, float(length), float(mass)))

    def without(self, *legs: str) -> "Animal":
        """Return the animal without some of its legs.

        Parameters
        ----------
        *legs : str
            Names of legs, or labels of pairs.

        Returns
        -------
        Animal
            A copy without these legs. Pairs keep their order: where the leg that stood first is gone, the other one of
            its pair stands in its place. Families that come to differ in nothing are one.

        Raises
        ------
        ModelError
            If there is no such leg, or none is left, or one that is left follows one that is not.

        Examples
        --------
        >>> from legspring.model import cockroach
        >>> injured = cockroach().without("FL")
        >>> [leg.name for leg in injured.legs], injured.pairs
        (['FR', 'MR', 'BL', 'ML', 'BR'], ('F', 'M', 'B'))
        """
        gone = {i for label in legs for i in self.legs_named(label)}
        kept: list[Leg] = []
        for i in range(len(self.legs)):
            stand_in = self.partners[i] if i in gone else i
            # A pair stands where its first leg stood.
            if stand_in not in gone and self.legs[stand_in] not in kept:
                kept.append(self.legs[stand_in])
        pairs = {leg.pair for leg in kept}
        names: dict[tuple[str, ...], str] = {}
        for name, pushing in self.families.items():
            left = tuple(pair for pair in pushing if pair in pairs)
            names[left] = name if left == pushing else names.get(left, name)
        families = {name: left for left, name in names.items()}
        return Animal(**dict(self) | {"legs": tuple(kept), "families": families})


_CHANGEABLE = (
    tuple(Animal.model_fields),
    tuple(Body.model_fields),
    (*(name for name in Leg.model_fields if name not in ("name", "pair")), "angle_deg"),
)
_NUMBERS = (
    *("hip_x", "hip_y", "length", "stiffness", "angle", "angle_deg", "actuation", "phase", "offset", "stance"),
    "damping",
)
"""What a single leg, or pair, may have a number of."""
_MIRRORED = ("hip_x", "angle", "angle_deg")


def _pick(changes: Mapping[str, Any], names: tuple[str, ...]) -> dict[str, Any]:
    return {name: value for name, value in changes.items() if name in names}


def _changed_legs(animal: Animal, changes: Mapping[str, Any]) -> tuple[Leg, ...]:
    by_pair = {name: _by_pair(name, value, animal.pairs) for name, value in changes.items()}
    partners = _partners(animal.legs)

    firsts = {animal.legs[i].pair: animal.legs[i] for i in animal.first_legs}

    def changed(leg: Leg) -> Leg:
        first = firsts[leg.pair]
        kept = {name: value for name, value in first if f"{name}_deg" not in changes}
        new = Leg(**kept | {name: values[leg.pair] for name, values in by_pair.items()})
        if leg.name == first.name:
            return new
        image = new.mirrored(leg.name, partners, alike=animal.sagittal, later=leg.offset - first.offset)
        return Leg(**dict(leg) | {name: value for name, value in image if {name, f"{name}_deg"} & set(changes)})

    return tuple(map(changed, animal.legs))


def _with_numbers(animal: Animal, changes: Mapping[str, Any]) -> tuple[Leg, ...]:
    """Change numbers of single pairs and legs, by names such as ``F.stiffness``."""
    fields: list[dict[str, Any]] = [dict(leg) for leg in animal.legs]
    for name, value in changes.items():
        owner, _, number = name.rpartition(".")
        if number not in _NUMBERS:
            raise ModelError(f"cannot replace {shown(name)}: must be a pair or leg and one of {', '.join(_NUMBERS)}")
        legs = animal.legs_named(owner)
        for i in legs:
            first = next((j for j in legs if j in animal.first_legs), i)
            later = animal.legs[i].offset - animal.legs[first].offset
            _set_number(fields[i], number, value if i == first else _image(number, value, later, animal.sagittal))
    return tuple(Leg(**leg) for leg in fields)


def _set_number(leg: dict[str, Any], number: str, value: Any) -> None:
    if number == "angle_deg":
        del leg["angle"]
    if number in ("hip_x", "hip_y"):
        x, y = leg["hip"]
        number, value = "hip", (value, y) if number == "hip_x" else (x, value)
    leg[number] = value


def _image(number: str, value: Any, later: float, alike: bool) -> Any:
    """Return a number of the other leg of a pair; what is no number is left for the check to come."""
    if not isinstance(value, Real):
        return value
    value = float(value)
    if number == "offset":
        return (value + later) % 2.0
    return 0.0 - value if number in _MIRRORED and not alike else value


def _by_pair(name: str, value: Any, pairs: tuple[str, ...]) -> dict[str, Any]:
    """Give each pair its value: the only one, or its own out of a sequence."""
    dimensions, array = 1 if name == "hip" else 0, None
    if isinstance(value, range):
        # It may be too long to be made an array.
        value = [*value[: len(pairs) + 3]]
    # Lists too deep for an array are none of these, and what is masked is missing.
    if not np.ma.is_masked(value):
        with suppress(ValueError):
            array = np.asarray(value, dtype=object)
    if array is not None and array.ndim == dimensions:
        return dict.fromkeys(pairs, array.tolist())
    if array is not None and array.ndim == dimensions + 1 and len(array) == len(pairs):
        return dict(zip(pairs, array.tolist(), strict=True))
    raise ModelError(f"{name} = {shown(value)}: must be one value, or one for each pair ({', '.join(pairs)})")


def _check_names(legs: tuple[Leg, ...]) -> None:
    if not legs:
        raise ModelError("legs are missing: must be one at least")
    names = [leg.name for leg in legs]
    if twice := [name for name in dict.fromkeys(names) if names.count(name) > 1]:
        raise ModelError(f"legs named {', '.join(twice)} occur more than once; names must be unique")


def _check_rules(legs: tuple[Leg, ...]) -> None:
    names = [leg.name for leg in legs]
    for leg in legs:
        if leg.follows is not None and leg.follows not in names:
            raise ModelError(f"leg {leg.name!r}: follows = {leg.follows!r}: must be one of {', '.join(names)}")
    if any(leg.touchdown != "clock" for leg in legs) and all(leg.offset != 0.0 for leg in legs):
        raise ModelError("no leg has offset 0: must be one that is put down at the start, unless all go by the clock")


def _from_the_side(legs: tuple[Leg, ...]) -> bool:
    return any(leg.touchdown == "ground" for leg in legs)


def _partners(legs: tuple[Leg, ...]) -> dict[str, str]:
    """Name of the other leg of each leg's pair."""
    return {a.name: b.name for a in legs for b in legs if a.pair == b.pair and a.name != b.name}


def _first_legs(legs: tuple[Leg, ...]) -> tuple[int, ...]:
    """Index of the leg of each pair that is put down first."""
    pairs: dict[str, list[int]] = {}
    for i, leg in enumerate(legs):
        pairs.setdefault(leg.pair, []).append(i)
    return tuple(min(members, key=lambda i: legs[i].offset) for members in pairs.values())


def _partners_of(legs: tuple[Leg, ...]) -> tuple[int, ...]:
    """Index of the other leg of each leg's pair; its own where it has none."""
    others, names = _partners(legs), [leg.name for leg in legs]
    return tuple(names.index(others.get(name, name)) for name in names)


def _odd_pair(legs: tuple[Leg, ...], partners: tuple[int, ...]) -> str | None:
    """Label of the first pair that has not two legs that are mirror images; None if there is none."""
    names, alike = _partners(legs), _from_the_side(legs)
    for i, n in enumerate(partners):
        if n == i or not legs[n].is_mirror_image_of(legs[i], names, alike=alike):
            return legs[i].pair
    return None


def _check_pairs(legs: tuple[Leg, ...]) -> None:
    """Insist on pairs of one or two legs."""
    for pair in dict.fromkeys(leg.pair for leg in legs):
        names = [leg.name for leg in legs if leg.pair == pair]
        if len(names) > 2:
            raise ModelError(f"pair {pair!r} has legs {', '.join(names)}: must be one or two")


def _check_families(families: Mapping[str, tuple[str, ...]], pairs: tuple[str, ...]) -> None:
    if not families:
        raise ModelError("families are missing: must be one at least")
    for family, pushing in families.items():
        if not set(pushing) <= set(pairs) or len(set(pushing)) < len(pushing):
            raise ModelError(f"family {family!r} = {shown(pushing)}: must be distinct pairs out of {', '.join(pairs)}")
    if len(set(map(frozenset, families.values()))) < len(families):
        raise ModelError(f"families = {families}: should differ in the pairs that push")
