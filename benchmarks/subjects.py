"""The strides that are timed, of a point mass and of a rigid body: the six of strides.csv, and a dozen gaits."""

import csv
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from legspring.layout import PLACES, START, System
from legspring.model import Animal, cockroach
from legspring.solve import find_gaits
from tests.oracle.problem import Problem

Floats = NDArray[np.float64]

REFERENCE = Path(__file__).resolve().parent.parent / "tests" / "reference"
GAITS = 12
JITTER = 16
"""Starts of each subject: all slightly different, so that no timing profits from a stride known by heart."""
HIP = 1e-3 * np.array([(-3.5, 14.0), (3.5, 7.0), (-3.5, 0.0)])
INERTIA = 2.04e-7


@dataclass(frozen=True)
class Subject:
    """A stride to be simulated: an animal on its slope, and all parameters with the start."""

    name: str
    system: System
    p: Floats

    def points(self) -> Floats:
        """Return a few similar starts, ``(16, n)``."""
        rng, points = np.random.default_rng(1), np.repeat(self.p[None], JITTER, axis=0)
        points[1:, PLACES["speed"]] *= rng.uniform(0.99, 1.01, JITTER - 1)
        points[1:, PLACES["heading"]] += rng.uniform(-0.01, 0.01, JITTER - 1)
        return points

    def names(self, count: int) -> list[str]:
        """Return up to eight parameters: of the start, phases, and more of the legs."""
        start = ["yaw", "yaw_rate", "turn"] if self.system.yaws else ["Dx", "Dy"]
        phases = [f"{pair}.phase" for pair in self.system.animal.pairs]
        return ["speed", "heading", *start, *phases, "gravity"][:count]

    def problem(self) -> Problem:
        """Return the same for the oracles."""
        system, animal = self.system, self.system.animal
        actuation = np.array(system.magnitudes)[system.pair]
        start = dict(zip(START, self.p.tolist(), strict=False))
        return Problem(
            mass=animal.body.mass,
            inertia=animal.body.inertia if system.yaws else None,
            gravity=animal.gravity,
            slope=system.slope,
            t_des=system.step_duration,
            v_des=system.desired_speed,
            hip=np.array([leg.hip for leg in animal.legs]),
            stiffness=np.array([leg.stiffness for leg in animal.legs]),
            length=np.array([leg.length for leg in animal.legs]),
            ldev=system.side * actuation,
            phase=np.array([self.p[system.place(leg, "phase")] for leg in range(len(animal.legs))]),
            angle=np.array([leg.angle for leg in animal.legs]),
            function=system.side,
            offset=system.offset,
            **{name: start[name] for name in ("speed", "heading", "yaw", "yaw_rate")},
        )


def rigid_cockroach() -> Animal:
    """Return the cockroach with hips off its centre and free to yaw, its nominal feet where they were."""
    animal = cockroach()
    first = animal.legs[: len(HIP)]
    nominal = np.array([(-leg.length * math.sin(leg.angle), leg.length * math.cos(leg.angle)) for leg in first])
    leg = nominal - HIP
    return animal.replace(
        yaw="free",
        inertia=INERTIA,
        hip=HIP.tolist(),
        length=np.hypot(leg[:, 0], leg[:, 1]).tolist(),
        angle=np.arctan2(-leg[:, 0], leg[:, 1]).tolist(),
    )


def point_masses() -> list[Subject]:
    """Return the strides of a point mass."""
    animal = cockroach()
    gaits = rows("gaits")
    chosen = gaits[:: len(gaits) // GAITS][:GAITS]
    return [stride(animal, row) for row in rows("strides")] + [gait(animal, row) for row in chosen]


def rigid_bodies() -> list[Subject]:
    """Return the strides of a rigid body: its gaits, since it soon falls otherwise, and the six strides."""
    animal = rigid_cockroach()
    subjects = [stride(animal, row) for row in rows("strides")]
    for slope_deg in (0.0, 30.0, 60.0, 90.0):
        for heading in (0.05, 0.15, 0.30):
            for found in find_gaits(animal, slope_deg=slope_deg, heading=heading)[:1]:
                name = f"gait {found.family} {slope_deg:g} deg {heading:g} rad"
                subjects.append(Subject(name, found.system, found.point))
    return subjects


def rows(name: str) -> list[dict[str, str]]:
    """Read a reference table."""
    with (REFERENCE / f"{name}.csv").open() as file:
        return list(csv.DictReader(file))


def stride(animal: Animal, row: Mapping[str, str]) -> Subject:
    """Return a row of strides.csv."""
    pushing = tuple(pair for pair in animal.pairs if int(row[f"push_{pair}"]))
    system = System(
        animal.replace(families={"of the row": pushing}), math.radians(float(row["slope_deg"])), "of the row"
    )
    phase = [float(row[f"phi_{pair}"]) for pair in animal.pairs]
    p = system.point(phase, speed=float(row["v0"]), heading=float(row["heading"]))
    return Subject(f"stride {row['case']}", system, p)


def gait(animal: Animal, row: Mapping[str, str]) -> Subject:
    """Return a row of gaits.csv."""
    family, slope_deg, heading = row["family"], float(row["slope_deg"]), float(row["heading"])
    system = System(animal, math.radians(slope_deg), family)
    phase = [math.radians(float(row[f"phi_{pair}_deg"])) for pair in animal.pairs]
    p = system.point(phase, speed=float(row["v0"]), heading=heading)
    return Subject(f"gait {family} {slope_deg:g} deg {heading:g} rad", system, p)
