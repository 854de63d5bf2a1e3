"""Names for everything that can vary: the one door between an animal on a slope and the kernel's numbers.

Everything stands in one vector p, in SI units (see `legspring.kernel.pack`): the start of a step, the body and its
surroundings, and the numbers of each leg, such as ``FL.stiffness``. What has a name of its own is a direction in that
space: one number; those of the two legs of a pair (``F.stiffness``), in mirror image where they have one; those of all
legs (``stiffness``); or the slope, along which desired speed and step duration move by the animal's laws. Unknown,
free, followed, varied: all of these are directions.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from legspring.checks import checked_angle, checked_number, checked_slope, checked_vector, shown
from legspring.kernel.pack import FIRST_LEG
from legspring.kernel.walker import (
    ACTUATION,
    CLOCK,
    EVEN,
    GROUND,
    LEG_DY,
    N_VARIED,
    NOW,
    OWN,
    PHASE,
    UP,
    Floats,
    Walker,
    new_walker,
)
from legspring.kernel.written import address
from legspring.model import Animal, Leg

ACCURACY = 1e-10
"""Default relative accuracy of states."""
TIGHT = 1e-12
SAME_TIME = 1e-9
"""Difference of offsets that is none."""
LEVEL = 1e-10
"""Slope, rad, below which it is rounding: gravity does less in a step than can be told."""

START = {
    "speed": ("m/s", "speed at the start of a step"),
    "heading": ("rad", "direction of motion relative to the body at the start of a step, counter-clockwise"),
    "Dx": ("m", "displacement over the step before, along x"),
    "Dy": ("m", "displacement over the step before, along y"),
    "yaw": ("rad", "yaw at the start of a step, counter-clockwise"),
    "yaw_rate": ("rad/s", "yaw rate at the start of a step"),
    "turn": ("rad", "change of yaw over the step before"),
}
BODY = {
    "slope": ("rad", "slope, uphill positive"),
    "gravity": ("m/s^2", "acceleration of gravity"),
    "mass": ("kg", "mass of the body"),
    "inertia": ("kg m^2", "moment of inertia about the centre of mass"),
    "desired_speed": ("m/s", "desired speed v_des"),
    "step_duration": ("s", "step duration t_des"),
}
LEG = {
    "hip_x": ("m", "hip, to the right of the centre of mass"),
    "hip_y": ("m", "hip, forward of the centre of mass"),
    "stiffness": ("N/m", "stiffness"),
    "length": ("m", "force-free length"),
    "actuation": ("m", "amplitude of the force-free length"),
    "phase": ("rad", "phase of the force-free length at touch-down"),
    "angle": ("rad", "angle at touch-down, counter-clockwise from straight ahead"),
    "damping": ("N s/m", "damping"),
    "stance": ("t_des", "time from touch-down to lift-off"),
    "offset": ("t_des", "time of the first touch-down"),
}
"""Units and words of the parameters, in their order in p; those of a leg in the order of its rows."""
BY_CLOCK = {
    "Dx": ("m", "displacement since touch-down, along x"),
    "Dy": ("m", "displacement since touch-down, along y"),
    "turn": ("rad", "change of yaw since touch-down"),
}
BY_EVENT = {
    "foot_x": ("m", "place of the foot, seen from the centre of mass, along x"),
    "foot_y": ("m", "place of the foot, seen from the centre of mass, along y"),
    "age": ("t_des", "time since touch-down"),
}
"""What a start may say of each foot that is down from before: of legs that go by the clock, and of others."""
MIRRORED = ("angle", "hip_x")
"""What changes its sign in a leg's mirror image."""
ROWS = {name: n for names in ([*LEG, *BY_CLOCK], [*LEG, *BY_EVENT]) for n, name in enumerate(names)}
PLACES = {name: n for n, name in enumerate([*START, *BODY])}


def slope_for(animal: Animal, slope: float | None, slope_deg: float | None) -> float:
    """Return the one slope that is given, in rad, or the only one that an animal's speed law is for.

    Seen from the side, the ground is level unless a slope is given.

    Raises
    ------
    ValueError
        If both or none are given, or it is beyond the vertical.
    """
    low, high = animal.speed_law.domain_deg
    if slope is None and slope_deg is None and low == high:
        return math.radians(low)
    if slope is None and slope_deg is None and animal.sagittal:
        return 0.0
    return checked_slope(slope, slope_deg)


def trigger(leg: Leg, names: Sequence[str]) -> float:
    """Return the kernel's number for what makes a leg touch down, given the names of all legs."""
    if leg.follows is not None:
        return names.index(leg.follows) + 1.0
    return float(GROUND if leg.touchdown == "ground" else CLOCK)


ONE_SIDED: dict[str, tuple[Callable[[float], bool], str]] = {
    "offset": (
        lambda offset: offset == 0.0,
        "a step begins with this touch-down: derivatives are those of a later one, in the same step",
    ),
    "stance": (
        lambda stance: stance > 0.0 and stance % 1.0 == 0.0,
        "the stance ends with a step: derivatives are those of a shorter one",
    ),
    "damping": (lambda damping: damping == 0.0, "it cannot be less: derivatives are those of more"),
    "actuation": (
        lambda actuation: actuation == 0.0,
        "it cannot be less: derivatives are those of more",
    ),
}
"""Quantities of legs that have a kink: at which values, and what holds there."""


def unit_and_words(name: str) -> tuple[str, str]:
    """Return the unit of a parameter and what it is, by name: of all legs, of a pair or of a single leg."""
    owner, _, quantity = name.rpartition(".")
    unit, words = (START | BODY | LEG)[quantity]
    return unit, f"{words} ({owner})" if owner else words


@dataclass(frozen=True)
class System:
    """An animal on a slope, with the legs of one family and an actuation.

    Parameters
    ----------
    animal
        The animal.
    slope
        rad, from -pi/2 to pi/2.
    family
        Which pairs push, by the animal's label.
    actuation
        Magnitude of the actuation of each pair, m; by default the animal's.
    contacts
        Names of the legs that were put down before a start and may still be down then; all others are up or land, and
        what is remembered of each foot is a parameter of its own. By default legs that go by the clock may be down,
        under a body that has moved evenly since, and no others are.
    symmetric
        Whether what happens in a step mirrors the step before, if the animal is such that it can.
    apart
        Whether feet that were put down at one instant are remembered each for itself: as they must be where their
        offsets vary.
    strides
        After how many strides a gait repeats itself, where steps do not mirror one another.

    Raises
    ------
    ValueError
        If the slope is out of range or out of the speed law's domain, there is no such family or leg, or the actuation
        does not fit the legs.
    """

    animal: Animal
    slope: float
    family: str
    actuation: tuple[float, ...] | None = None
    contacts: tuple[str, ...] | None = None
    symmetric: bool = True
    apart: bool = False
    strides: int = 1

    def __post_init__(self) -> None:
        """Check what is given."""
        animal = self.animal
        checked_angle("slope", self.slope, math.pi / 2)
        animal.functions(self.family)
        before = [leg.name for leg in animal.legs if leg.offset != 0.0]
        if unknown := [name for name in self.contacts or () if name not in before]:
            raise ValueError(f"contacts = {shown(unknown[0])}: must be legs of offsets above 0: {', '.join(before)}")
        if self.actuation is None:
            return
        magnitudes = checked_vector("actuation", self.actuation, len(animal.pairs))
        for leg, pair in zip(animal.legs, animal.pair_of, strict=True):
            if not 0.0 <= magnitudes[pair] < leg.length:
                raise ValueError(
                    f"actuation = {magnitudes[pair]:g} m for pair {leg.pair}: must be from 0 to below the leg's "
                    f"length, {leg.length:g} m"
                )

    # What it is ------------------------------------------------------------------------------------------------

    @cached_property
    def desired_speed(self) -> float:
        """v_des, m/s."""
        return self.animal.desired_speed(self.slope)

    @cached_property
    def step_duration(self) -> float:
        """t_des, s."""
        return self.animal.step_duration(self.slope)

    @property
    def step_length(self) -> float:
        """Desired displacement of a step, v_des t_des, m."""
        return self.desired_speed * self.step_duration

    @property
    def magnitudes(self) -> tuple[float, ...]:
        """Magnitude of the actuation of each pair, m."""
        return self.animal.actuation if self.actuation is None else self.actuation

    @cached_property
    def functions(self) -> tuple[int, ...]:
        """-1 (push) or +1 (pull) for each pair of legs."""
        return self.animal.functions(self.family)

    @property
    def axes(self) -> tuple[str, str]:
        """Names of the directions x and y."""
        return ("horizontal", "vertical") if self.animal.sagittal else ("lateral", "fore_aft")

    @cached_property
    def yaws(self) -> bool:
        """Whether the body yaws."""
        return self.animal.body.yaw == "free"

    @property
    def rows(self) -> int:
        """Size of the state: 4, or 6 where the body yaws."""
        return 6 if self.yaws else 4

    @cached_property
    def pair(self) -> NDArray[np.int64]:
        """Index of each leg's pair."""
        return np.array(self.animal.pair_of, dtype=np.int64)

    @cached_property
    def side(self) -> Floats:
        """-1 for each leg that pushes, +1 for each that pulls."""
        return np.array(self.functions, dtype=float)[self.pair]

    @cached_property
    def offset(self) -> Floats:
        """Time of each leg's first touch-down, in step durations."""
        return np.array([leg.offset for leg in self.animal.legs])

    @cached_property
    def lands(self) -> NDArray[np.bool_]:
        """Which legs are put down as a step begins, ``(L,)``.

        Those of offset 0; and those that wait for the ground beside one of them, with the foot held at the same place
        (where the body does not pitch, at the same height), unless they have been put down before.
        """
        legs, down = self.animal.legs, self.contacts or ()
        if not self.animal.sagittal:
            return self.offset == 0.0
        held = [held_at(leg, pair, self) for leg, pair in zip(legs, self.animal.pair_of, strict=True)]
        landing = [place for leg, place in zip(legs, held, strict=True) if leg.offset == 0.0 and place]
        beside = [place is not None and place in landing for place in held]
        return (self.offset == 0.0) | (np.array(beside) & np.array([leg.name not in down for leg in legs]))

    @cached_property
    def event_driven(self) -> bool:
        """Whether no leg touches down by the clock, so that steps end at events."""
        return all(leg.touchdown != "clock" for leg in self.animal.legs)

    @cached_property
    def mirrored(self) -> bool:
        """Whether every other step is the image of the one before, legs changing places with their partners.

        As seen from above, the mirror image; from the side, where partners are alike, a step is like the one before.
        """
        return self.symmetric and self.animal.mirrored

    @cached_property
    def flips(self) -> bool:
        """Whether every other step is the one before with left and right exchanged."""
        return self.mirrored and not self.animal.sagittal

    @property
    def isotropic(self) -> bool:
        """Whether all directions are alike: for a body that yaws on the level."""
        return self.yaws and not self.animal.sagittal and self.level

    @property
    def level(self) -> bool:
        """Whether gravity does no work along the ground."""
        return abs(self.slope) < LEVEL

    @cached_property
    def conserved(self) -> tuple[str, ...]:
        """What no step changes: energy, the direction where all are alike, how a body turns that no leg turns."""
        turned = any(coordinate for leg in self.animal.legs for coordinate in leg.hip)
        found = {
            "energy": self.animal.conservative and self.level,
            "direction": self.isotropic,
            "yaw_rate": self.yaws and not turned,
            "yaw": self.yaws and not turned and not self.isotropic,
        }
        return tuple(name for name, is_so in found.items() if is_so)

    @property
    def steps_per_stride(self) -> int:
        """Steps in a stride: two; one where they end at the touch-downs of legs of one offset only."""
        return len({leg.offset for leg in self.animal.legs} & {0.0, 1.0}) if self.event_driven else 2

    @property
    def period(self) -> int:
        """Steps after which a gait repeats itself, or its image."""
        return 1 if self.mirrored else self.cycle

    @property
    def cycle(self) -> int:
        """Steps after which a gait repeats itself, not its image: those of a stride, or of several."""
        return self.steps_per_stride * self.strides

    # What it remembers -----------------------------------------------------------------------------------------

    @cached_property
    def memory(self) -> tuple[str, ...]:
        """What is remembered of the time before a start: one displacement, or what is known of each foot.

        Feet of legs that go by the clock and were put down at one instant have the displacement since then in common
        (and the change of yaw); it bears the name of the first of these legs. Other feet have a place, and an age if
        their force depends on it.
        """
        if self.contacts is None:
            return () if self.event_driven else ("Dx", "Dy", *(["turn"] if self.yaws else []))
        names: list[str] = []
        for i, leg in enumerate(self.animal.legs):
            if leg.name in self.contacts and self.together(i)[0] == i:
                names += [f"{leg.name}.{what}" for what in self._remembered_of(leg)]
        return tuple(names)

    def _remembered_of(self, leg: Leg) -> list[str]:
        if leg.touchdown == "clock":
            return ["Dx", "Dy", *(["turn"] if self.yaws else [])]
        place = ["foot_x"] if self.animal.sagittal else ["foot_x", "foot_y"]
        return place if leg.timeless else [*place, "age"]

    def together(self, leg: int) -> tuple[int, ...]:
        """Return the legs, of those that may be down at a start, whose feet were put down at one time with a leg's."""
        legs, offset = self.animal.legs, self.animal.legs[leg].offset
        if self.apart or legs[leg].touchdown != "clock":
            return (leg,)
        alike = [i for i, one in enumerate(legs) if one.touchdown == "clock" and abs(one.offset - offset) < SAME_TIME]
        return tuple(i for i in alike if legs[i].name in (self.contacts or ())) or (leg,)

    @cached_property
    def state(self) -> tuple[str, ...]:
        """Names of what a complete state consists of."""
        common = [name for name in self.memory if "." not in name]
        own = [name for name in self.memory if "." in name]
        yaw = ["yaw", "yaw_rate"] if self.yaws else []
        return ("speed", "heading", *common[:2], *yaw, *common[2:], *own)

    @property
    def weight(self) -> float:
        """Gravity, g, in m per step duration squared: the unit of forces, m g, in the kernel's units."""
        return self.animal.gravity * self.step_duration**2

    # Its parameters --------------------------------------------------------------------------------------------

    @cached_property
    def values(self) -> Floats:
        """All parameters, ``(n,)``: of a step that starts straight ahead at the desired speed.

        Phases that are not given are 0. Of an animal of which no leg goes by the clock all legs of the step before are
        up; else it went straight ahead at the desired speed.
        """
        animal, body = self.animal, self.animal.body
        memory = 0.0 if self.event_driven else self.step_length
        start = [self.desired_speed, 0.0, 0.0, memory, 0.0, 0.0, 0.0]
        surroundings = [self.slope, animal.gravity, body.mass, body.inertia or math.inf]
        surroundings += [self.desired_speed, self.step_duration]
        legs = np.array([numbers_of(leg) for leg in animal.legs])
        remembered = self.contacts or ()
        ahead = [n for n, leg in enumerate(animal.legs) if leg.touchdown == "clock" and leg.name in remembered]
        legs[ahead, LEG_DY] = self.step_length * (2.0 - self.offset[ahead])
        if self.actuation is not None:
            legs[:, ACTUATION] = np.array(self.actuation)[self.pair]
        p = np.concatenate([start, surroundings, legs.ravel()])
        p.flags.writeable = False
        return p

    def point(
        self,
        phase: ArrayLike | None = None,
        *,
        speed: float,
        heading: float,
        displacement: Sequence[float] | None = None,
        yaw: float = 0.0,
        yaw_rate: float = 0.0,
        turn: float | None = None,
        memory: Sequence[float] = (),
    ) -> Floats:
        """Return the parameters with a start, ``(n,)``.

        Parameters
        ----------
        phase
            Of each pair of legs, rad; by default the animal's.
        speed, heading
            m/s, and rad counter-clockwise relative to the body.
        displacement
            Of the centre of mass over the step before (x, y), m, which says where the legs that are still down were put
            down; by default straight ahead at the desired speed. For an animal of which no leg goes by the clock the
            default is that all legs of the step before are up.
        yaw, yaw_rate
            rad, rad/s; zero for a body whose yaw is held.
        turn
            Change of yaw over the step before, rad; by default twice the yaw, as in a gait whose steps mirror one
            another.
        memory
            What is remembered of each foot, in the order of `memory`; by default that the body moved straight ahead.

        Raises
        ------
        ValueError
            For a start that is not one, or phases that are none.
        """
        p = self.values.copy()
        p[:2] = speed, heading
        if displacement is not None:
            p[2:4] = displacement
        p[4:7] = yaw, yaw_rate, 2.0 * yaw if turn is None else turn
        if not np.all(np.isfinite(p[:7])) or p[0] <= 0.0:
            start = ", ".join(f"{name} = {value:g}" for name, value in zip(START, p, strict=False))
            raise ValueError(f"{start}: must have a positive speed and finite numbers")
        if not self.yaws and np.any(p[4:7] != 0.0):
            raise ValueError(f"yaw = {yaw!r}, yaw_rate = {yaw_rate!r}: must be 0 for a body whose yaw is held")
        for name, value in zip((name for name in self.memory if "." in name), memory, strict=False):
            p[self.direction(name) != 0.0] = value
        if phase is not None:
            angles = checked_vector("phase", phase, len(self.animal.pairs))
            if np.any(np.abs(angles) > 1e3):
                raise ValueError(f"phase = {shown(phase)}: must be angles in rad, of at most 1000")
            p[FIRST_LEG + PHASE :: N_VARIED] = angles[self.pair]
        return p

    def place(self, leg: int, name: str) -> int:
        """Return where in p a parameter of a leg is."""
        return FIRST_LEG + N_VARIED * leg + ROWS[name]

    def place_of(self, name: str) -> int:
        """Return where in p a parameter is; of several legs, the first one's."""
        if name in PLACES:
            return PLACES[name]
        return self.place(next(iter(self.legs_of(name))), name.rpartition(".")[2])

    @cached_property
    def _directions(self) -> dict[tuple[object, ...], Floats]:
        return {}

    def along(self, names: Sequence[str]) -> Floats:
        """Return the directions of some parameters, ``(D, n)`` (see `direction`)."""
        key = tuple(names)
        if key not in self._directions:
            rows = [self.direction(name) for name in names]
            self._directions[key] = np.array(rows).reshape(len(rows), len(self.values))
        return self._directions[key]

    def direction(self, name: str, pinned: Sequence[str] = ()) -> Floats:
        """Return the direction along which a parameter grows, by 1 in SI units, ``(n,)``.

        Parameters
        ----------
        name
            Of a start or of the body and its surroundings; a leg's (``FL.stiffness``), a pair's (``F.stiffness``: both
            legs alike, in mirror image where it has one), or all legs' (``stiffness``). Along the slope desired
            speed and step duration move by the animal's laws, and the step duration along the desired speed; where a
            law has a kink the derivative is one-sided, that of a growing parameter (see `one_sided`).
        pinned
            What does not move with it: ``"desired_speed"``, ``"step_duration"``.

        Raises
        ------
        ValueError
            For an unknown name, or one with two meanings.
        """
        direction = np.zeros(len(self.values))
        if name in PLACES or name == "slope_deg":
            self._move_by_laws(direction, name, pinned)
            return direction
        quantity = name.rpartition(".")[2]
        for leg, sign in self.legs_of(name).items():
            for one in self.together(leg) if quantity in BY_CLOCK else (leg,):
                direction[self.place(one, quantity)] = sign
        return direction

    def _move_by_laws(self, direction: Floats, name: str, pinned: Sequence[str]) -> None:
        """Write a direction along something other than the legs, with what moves by the animal's laws."""
        animal, amount = self.animal, math.radians(1.0) if name == "slope_deg" else 1.0
        direction[PLACES["slope" if name == "slope_deg" else name]] = amount
        speed, duration = PLACES["desired_speed"], PLACES["step_duration"]
        if name.startswith("slope") and "desired_speed" not in pinned:
            direction[speed] = animal.speed_law.rate * amount
        if direction[speed] and "step_duration" not in pinned:
            direction[duration] = animal.step_law.rate(self.desired_speed, direction[speed]) * direction[speed]

    def one_sided(self, name: str) -> str | None:
        """Say why derivatives along a parameter hold for its growth only; None where they hold both ways."""
        falls = self.animal.speed_law.rate < 0.0 if name.startswith("slope") else False
        if name in ("slope", "slope_deg", "desired_speed") and self.animal.step_law.has_kink(self.desired_speed):
            if name != "desired_speed" and self.animal.speed_law.rate == 0.0:
                return None
            side = "below" if falls else "above"
            return f"the step law has a kink at {self.desired_speed:g} m/s: derivatives are those {side} it"
        quantity = name.rpartition(".")[2]
        if quantity not in ONE_SIDED:
            return None
        at_kink, words = ONE_SIDED[quantity]
        return words if any(at_kink(self.values[self.place(leg, quantity)]) for leg in self.legs_of(name)) else None

    def legs_of(self, name: str) -> dict[int, float]:
        """Return the legs that a parameter is about, and the sign with which each takes part.

        Raises
        ------
        ValueError
            For an unknown name, or one with two meanings.
        """
        if not isinstance(name, str):
            raise ValueError(f"parameter = {shown(name)}: must be a name")
        owner, _, quantity = name.rpartition(".")
        if quantity in (*BY_CLOCK, *BY_EVENT) and name in self.memory:
            return {[leg.name for leg in self.animal.legs].index(owner): 1.0}
        if quantity not in LEG:
            raise ValueError(f"parameter = {shown(name)}: must be one of {', '.join(self._valid_names())}")
        legs = self.animal.legs_named(owner) if owner else tuple(range(len(self.animal.legs)))
        firsts = set(self.animal.first_legs) | ({legs[0]} if len(legs) == 1 else set())
        alike = quantity not in MIRRORED or self.animal.sagittal
        signs = {leg: 1.0 if leg in firsts or alike else -1.0 for leg in legs}
        first, *others = (sign * self.values[self.place(leg, quantity)] for leg, sign in signs.items())
        if quantity == "offset":
            # The legs of a pair are a step apart.
            first, *others = (one % 1.0 for one in (first, *others))
        if not owner and any(not math.isclose(first, other, rel_tol=1e-12) for other in others):
            raise ValueError(
                f"parameter = {name!r}: must be that of one pair or leg, such as {self.animal.pairs[0]}.{quantity}, as "
                "the legs differ in it"
            )
        return signs

    def _valid_names(self) -> list[str]:
        return [
            *(name for name in PLACES if self.has(name)),
            "slope_deg",
            *(f"{self.animal.pairs[0]}.{name}" for name in LEG),
        ]

    def has(self, name: str) -> bool:
        """Whether a parameter that is none of a leg has a meaning."""
        memory = name in ("Dx", "Dy", "turn")
        yaw = name in ("yaw", "yaw_rate", "turn", "inertia")
        return not (memory and self.event_driven) and not (yaw and not self.yaws)

    # Its place in the kernel ------------------------------------------------------------------------------------

    @cached_property
    def _topology(self) -> tuple[Floats, Floats, Floats, Floats]:
        legs = self.animal.legs
        names = [leg.name for leg in legs]
        triggers = np.array([trigger(leg, names) for leg in legs])
        memory = np.full(len(legs), EVEN)
        if self.contacts is not None:
            memory = np.array([OWN if name in self.contacts else UP for name in names])
        memory[self.lands & (self.offset != 0.0)] = NOW
        return self.side, triggers, np.array([address(leg.length_law) for leg in legs]), memory

    @cached_property
    def _longest(self) -> float:
        return max(leg.length for leg in self.animal.legs)

    def walker(self, directions: int, push: Floats) -> Walker:
        """Return a walker of the kernel for this animal, with room for derivatives along so many directions."""
        return new_walker(*self._topology, push, self.rows, directions)

    def error_scale(self, accuracy: float = ACCURACY) -> float:
        """Largest error estimate of a step (m) for the states to be accurate to the given relative accuracy.

        The errors that a stride ends with are up to twice as large as the estimate of a step.
        """
        valid = "from 1e-14 to 1e-3"
        number = checked_number("accuracy", accuracy, valid, 1e-3)
        if number < 1e-14:
            raise ValueError(f"accuracy = {shown(accuracy)}: must be {valid}")
        return 0.4 * number * self._longest


def held_at(leg: Leg, pair: int, system: System) -> tuple[object, ...] | None:
    """Say where a leg that waits for the ground holds its foot, as far as it matters; None for one that does not."""
    if leg.touchdown != "ground":
        return None
    ldev = system.functions[pair] * system.magnitudes[pair]
    reach = leg.length - ldev * math.sin(leg.phase or 0.0)
    place = (leg.hip[0] - reach * math.sin(leg.angle), leg.hip[1] + reach * math.cos(leg.angle))
    rounded = tuple(round(one, 12) for one in place)
    return (*(rounded if system.yaws else rounded[1:]), leg.length_law)


def numbers_of(leg: Leg) -> list[float]:
    """Return the parameters of a leg, in the order of `LEG`."""
    return [
        *leg.hip,
        leg.stiffness,
        leg.length,
        leg.actuation,
        leg.phase or 0.0,
        leg.angle,
        leg.damping,
        leg.stance or 0.0,
        leg.offset,
        0.0,
        0.0,
        0.0,
    ]
