"""An animal on a slope, in the kernel's units (see `legspring.kernel.walker`)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from legspring.checks import checked_angle, checked_number, checked_slope, checked_vector, shown
from legspring.kernel.walker import CLOCK, GROUND, N_LEG, Floats
from legspring.kernel.written import address
from legspring.model import Animal, Leg

ACCURACY = 1e-10
"""Default relative accuracy of states."""
TIGHT = 1e-12
LEVEL = 1e-10
"""Slope, rad, below which it is rounding: gravity does less in a step than can be told."""


def slope_for(animal: Animal, slope: float | None, slope_deg: float | None) -> float:
    """Return the one slope that is given, in rad, or the only one that an animal's speed law is for.

    Raises
    ------
    ValueError
        If both or none are given, or it is beyond the vertical.
    """
    low, high = animal.speed_law.domain_deg
    if slope is None and slope_deg is None and low == high:
        return math.radians(low)
    return checked_slope(slope, slope_deg)


def trigger(leg: Leg, names: Sequence[str]) -> float:
    """Return the kernel's number for what makes a leg touch down, given the names of all legs."""
    if leg.follows is not None:
        return names.index(leg.follows) + 1.0
    return float(GROUND if leg.touchdown == "ground" else CLOCK)


@dataclass(frozen=True)
class System:
    """An animal on a slope, with a function for each pair of legs and an actuation.

    Parameters
    ----------
    animal
        The animal.
    slope
        rad, from -pi/2 to pi/2.
    functions
        -1 (push) or +1 (pull) for each pair of legs.
    actuation
        Magnitude of the actuation of each pair, m; by default the animal's.

    Raises
    ------
    ValueError
        If the slope is out of range, out of the speed law's domain or none for a side view, or the actuation does not
        fit the legs.
    """

    animal: Animal
    slope: float
    functions: tuple[int, ...]
    actuation: tuple[float, ...]

    def __init__(
        self, animal: Animal, slope: float, functions: Sequence[int], actuation: ArrayLike | None = None
    ) -> None:
        given = animal.actuation if actuation is None else actuation
        magnitudes = checked_vector("actuation", given, len(animal.pairs))
        object.__setattr__(self, "animal", animal)
        object.__setattr__(self, "slope", checked_angle("slope", slope, math.pi / 2))
        if animal.sagittal and not math.isclose(self.slope, math.pi / 2):
            raise ValueError(
                f"slope = {math.degrees(self.slope):g} deg: must be 90 deg for {animal.name!r}, which is seen from the "
                "side: gravity acts along -y, across level ground; there is no sloping ground yet"
            )
        object.__setattr__(self, "functions", tuple(int(side) for side in functions))
        object.__setattr__(self, "actuation", tuple(float(value) for value in magnitudes))
        for leg, pair in zip(animal.legs, animal.pair_of, strict=True):
            if not 0.0 <= magnitudes[pair] < leg.length:
                raise ValueError(
                    f"actuation = {magnitudes[pair]:g} m for pair {leg.pair}: must be from 0 to below the leg's "
                    f"length, {leg.length:g} m"
                )

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
    def axes(self) -> tuple[str, str]:
        """Names of the directions x and y."""
        return ("horizontal", "vertical") if self.animal.sagittal else ("lateral", "fore_aft")

    @property
    def rows(self) -> int:
        """Size of the state: 4, or 6 where the body yaws."""
        return 6 if self.animal.body.yaw == "free" else 4

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
    def body(self) -> Floats:
        """Gravity along the plane (m per step duration squared) and m/I (1/m^2; 0 where the yaw is held)."""
        animal = self.animal
        gravity = animal.gravity * math.sin(self.slope) * self.step_duration**2
        inertia = animal.body.inertia
        return np.array([gravity, animal.body.mass / inertia if self.rows == 6 and inertia else 0.0])

    def legs(self, phase: ArrayLike) -> Floats:
        """Return the kernel's parameters of the legs, ``(L, 11)``, for the phase (rad) of each pair."""
        angles = checked_vector("phase", phase, len(self.animal.pairs))
        if np.any(np.abs(angles) > 1e3):
            raise ValueError(f"phase = {shown(phase)}: must be angles in rad, of at most 1000")
        time, mass = self.step_duration, self.animal.body.mass
        names = [leg.name for leg in self.animal.legs]
        rows = [
            (
                *leg.hip,
                leg.stiffness * (time**2 / mass),
                leg.length,
                side * self.actuation[pair],
                angles[pair],
                leg.angle,
                leg.damping * (time / mass),
                trigger(leg, names),
                leg.stance or 0.0,
                address(leg.length_law),
            )
            for leg, pair, side in zip(self.animal.legs, self.animal.pair_of, self.side, strict=True)
        ]
        return np.array(rows, dtype=float).reshape(-1, N_LEG)

    @property
    def event_driven(self) -> bool:
        """Whether no leg touches down by the clock, so that steps end at events."""
        return all(leg.touchdown != "clock" for leg in self.animal.legs)

    @property
    def mirrored(self) -> bool:
        """Whether every other step is the mirror image of the one before: legs have images on the other side."""
        return len(self.animal.legs) == 2 * len(self.animal.pairs)

    @property
    def isotropic(self) -> bool:
        """Whether all directions are alike: for a body that yaws on the level."""
        return self.rows == 6 and not self.animal.sagittal and self.level

    @property
    def level(self) -> bool:
        """Whether gravity does no work along the ground."""
        return self.animal.sagittal or abs(self.slope) < LEVEL

    @property
    def conserved(self) -> tuple[str, ...]:
        """What no step changes: energy, the direction where all are alike, how a body turns that no leg turns."""
        turned = any(coordinate for leg in self.animal.legs for coordinate in leg.hip)
        found = {
            "energy": self.animal.conservative and self.level,
            "direction": self.isotropic,
            "yaw_rate": self.rows == 6 and not turned,
            "yaw": self.rows == 6 and not turned and not self.isotropic,
        }
        return tuple(name for name, is_so in found.items() if is_so)

    @property
    def steps_per_stride(self) -> int:
        """Steps after which all repeats itself: one where no step mirrors another, else two."""
        return 1 if self.event_driven and not self.mirrored else 2

    @property
    def weight(self) -> float:
        """Gravity, g, in m per step duration squared: the unit of forces, m g, in the kernel's units."""
        return self.animal.gravity * self.step_duration**2

    def error_scale(self, accuracy: float = ACCURACY) -> float:
        """Largest error estimate of a step (m) for the states to be accurate to the given relative accuracy.

        The errors that a stride ends with are up to twice as large as the estimate of a step.
        """
        valid = "from 1e-14 to 1e-3"
        number = checked_number("accuracy", accuracy, valid, 1e-3)
        if number < 1e-14:
            raise ValueError(f"accuracy = {shown(accuracy)}: must be {valid}")
        return 0.4 * number * max(leg.length for leg in self.animal.legs)
