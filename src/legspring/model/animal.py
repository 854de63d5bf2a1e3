"""An animal: a body on legs, the families of gaits it may have, and how fast it means to run."""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from math import radians
from numbers import Real
from typing import Annotated, Any, Self

import numpy as np
from pydantic import AfterValidator, PlainSerializer, field_validator, model_validator

from legspring.checks import shown
from legspring.model._base import Frozen, Label, ModelError, Positive
from legspring.model.body import Body
from legspring.model.laws import SpeedLaw, StepLaw
from legspring.model.leg import Leg


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
        The legs. The two legs of a pair are mirror images, one step apart.
    families : mapping of str to tuple of str
        Labels of the pairs that push, for each family of gaits; the other pairs pull.
    speed_law : SpeedLaw
        Desired speed against slope; a plain number means a constant speed (m/s).
    step_law : StepLaw
        Step duration against desired speed; a plain number means a constant duration (s).
    gravity : float
        Acceleration g (m/s^2).

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

    @field_validator("speed_law", mode="before")
    @classmethod
    def _constant_speed(cls, law: Any) -> Any:
        return {"level": law, "vertical": law} if isinstance(law, Real) else law

    @field_validator("step_law", mode="before")
    @classmethod
    def _constant_duration(cls, law: Any) -> Any:
        return {"duration": law} if isinstance(law, Real) else law

    @model_validator(mode="after")
    def _parts_fit(self) -> Self:
        _check_names(self.legs)
        _check_rules(self.legs)
        _check_pairs(self.legs)
        _check_families(self.families, self.pairs)
        # The frequency's line has no bend but one, into a constant: good ends mean a good middle.
        for slope_deg in self.speed_law.domain_deg:
            self.step_duration(radians(slope_deg))
        return self

    @property
    def pairs(self) -> tuple[str, ...]:
        """Labels of the pairs of legs, in order of first appearance."""
        return tuple(dict.fromkeys(leg.pair for leg in self.legs))

    @property
    def pair_of(self) -> tuple[int, ...]:
        """Index into `pairs` of each leg's pair."""
        return tuple(self.pairs.index(leg.pair) for leg in self.legs)

    @property
    def first_legs(self) -> tuple[int, ...]:
        """Index of the leg of each pair that is put down first, the one that `replace` describes."""
        members = [[i for i, leg in enumerate(self.legs) if leg.pair == pair] for pair in self.pairs]
        return tuple(min(legs, key=lambda i: self.legs[i].offset) for legs in members)

    @property
    def partners(self) -> tuple[int, ...]:
        """Index of the other leg of each leg's pair; its own where it has none."""
        others = _partners(self.legs)
        names = [leg.name for leg in self.legs]
        return tuple(names.index(others.get(name, name)) for name in names)

    @property
    def actuation(self) -> tuple[float, ...]:
        """Amplitude abs(ldev) of each pair (m), in the order of `pairs`."""
        return tuple({leg.pair: leg.actuation for leg in self.legs}.values())

    @property
    def phase(self) -> tuple[float, ...]:
        """Phase phi of each pair (rad) where it is given, 0 where it is not, in the order of `pairs`."""
        return tuple({leg.pair: leg.phase or 0.0 for leg in self.legs}.values())

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
        return any(leg.touchdown == "ground" for leg in self.legs)

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

    def replace(self, **changes: Any) -> "Animal":
        """Return a changed copy.

        Parameters
        ----------
        **changes
            New values of fields of `Animal`, of its `Body` (mass, inertia, yaw) or of its legs
            (hip, length, stiffness, angle or angle_deg, actuation, phase, function, offset, touchdown,
            follows, stance, damping, length_law). A leg's field takes one value for all pairs, or a
            sequence with one for each pair. The value is that of the leg of the pair which is put down
            first (offset 0); its partner becomes its mirror image, with the angle and the hip's dx
            negated.

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
        """
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
        return Animal(**dict(animal) | parts) if parts else animal


_CHANGEABLE = (
    tuple(Animal.model_fields),
    tuple(Body.model_fields),
    (*(name for name in Leg.model_fields if name not in ("name", "pair")), "angle_deg"),
)


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
        return new if leg.name == first.name else new.mirrored(leg.name, partners)

    return tuple(map(changed, animal.legs))


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


def _partners(legs: tuple[Leg, ...]) -> dict[str, str]:
    """Name of the other leg of each leg's pair."""
    return {a.name: b.name for a in legs for b in legs if a.pair == b.pair and a.name != b.name}


def _check_pairs(legs: tuple[Leg, ...]) -> None:
    """Insist on mirror images, without which no gait is mirror-symmetric."""
    for pair in dict.fromkeys(leg.pair for leg in legs):
        members = [leg for leg in legs if leg.pair == pair]
        names = ", ".join(leg.name for leg in members)
        if len(members) > 2:
            raise ModelError(f"pair {pair!r} has legs {names}: must be one or two")
        if len(members) == 2 and not members[1].is_mirror_image_of(members[0], _partners(legs)):
            raise ModelError(
                f"legs {names} of pair {pair!r} must be mirror images: angle and hip's dx negated, "
                "offsets 1 apart, each following the other's image, all else equal"
            )


def _check_families(families: Mapping[str, tuple[str, ...]], pairs: tuple[str, ...]) -> None:
    if not families:
        raise ModelError("families are missing: must be one at least")
    for family, pushing in families.items():
        if not set(pushing) <= set(pairs) or len(set(pushing)) < len(pushing):
            raise ModelError(f"family {family!r} = {shown(pushing)}: must be distinct pairs out of {', '.join(pairs)}")
    if len(set(map(frozenset, families.values()))) < len(families):
        raise ModelError(f"families = {families}: should differ in the pairs that push")
