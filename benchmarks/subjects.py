"""The strides that are timed, of a point mass and of a rigid body: the six of strides.csv, and a dozen gaits."""

import csv
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from legspring.layout import System
from numpy.typing import NDArray

from legspring.kernel.launch import (
    DX,
    DY,
    HEADING,
    N_START,
    SPEED,
    START_YAW,
    START_YAW_RATE,
    TURN,
)
from legspring.kernel.walker import GRAVITY, N_BODY, N_LEG, PHASE
from legspring.model import Animal, cockroach
from legspring.returnmap import Start
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
    """A stride to be simulated."""

    name: str
    system: System
    phase: tuple[float, ...]
    start: Start

    def jets(self, derivatives: bool) -> tuple[Floats, Floats, Floats]:
        """Body, legs and a few similar starts, ``(16, 7, C)``, in the kernel's units; with eight derivatives or none.

        The derivatives are those by the start (four numbers, of a rigid body five), the phases, and, of a point mass,
        gravity.
        """
        system, width = self.system, 9 if derivatives else 1
        rigid = system.rows == 6
        body, legs = np.zeros((N_BODY, width)), np.zeros((len(system.animal.legs), N_LEG, width))
        starts = np.zeros((JITTER, N_START, width))
        body[:, 0], legs[:, :, 0] = system.body, system.legs(self.phase)
        rng = np.random.default_rng(1)
        starts[:, :, 0] = self.start.in_kernel_units(system)
        starts[1:, SPEED, 0] *= rng.uniform(0.99, 1.01, JITTER - 1)
        starts[1:, HEADING, 0] += rng.uniform(-0.01, 0.01, JITTER - 1)
        if derivatives:
            rows = (SPEED, HEADING, *((START_YAW, START_YAW_RATE, TURN) if rigid else (DX, DY)))
            for d, row in enumerate(rows, start=1):
                starts[:, row, d] = 1.0
            for leg, pair in enumerate(system.pair):
                legs[leg, PHASE, 1 + len(rows) + pair] = 1.0
            if not rigid:
                body[GRAVITY, 8] = 1.0
        return body, legs, starts

    def problem(self) -> Problem:
        """Return the same for the oracles."""
        system, animal = self.system, self.system.animal
        actuation = np.array(system.actuation)[system.pair]
        return Problem(
            mass=animal.body.mass,
            inertia=animal.body.inertia if system.rows == 6 else None,
            gravity=animal.gravity,
            slope=system.slope,
            t_des=system.step_duration,
            v_des=system.desired_speed,
            hip=np.array([leg.hip for leg in animal.legs]),
            stiffness=np.array([leg.stiffness for leg in animal.legs]),
            length=np.array([leg.length for leg in animal.legs]),
            ldev=system.side * actuation,
            phase=np.array(self.phase)[system.pair],
            angle=np.array([leg.angle for leg in animal.legs]),
            function=system.side,
            offset=system.offset,
            speed=self.start.speed,
            heading=self.start.heading,
            yaw=self.start.yaw,
            yaw_rate=self.start.yaw_rate,
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
                subjects.append(Subject(name, found.system, found.phase, found.start))
    return subjects


def rows(name: str) -> list[dict[str, str]]:
    """Read a reference table."""
    with (REFERENCE / f"{name}.csv").open() as file:
        return list(csv.DictReader(file))


def stride(animal: Animal, row: Mapping[str, str]) -> Subject:
    """Return a row of strides.csv."""
    functions = [1 - 2 * int(row[f"push_{pair}"]) for pair in animal.pairs]
    system = System(animal, math.radians(float(row["slope_deg"])), functions)
    phase = tuple(float(row[f"phi_{pair}"]) for pair in animal.pairs)
    return Subject(f"stride {row['case']}", system, phase, Start(float(row["v0"]), float(row["heading"])))


def gait(animal: Animal, row: Mapping[str, str]) -> Subject:
    """Return a row of gaits.csv."""
    family, slope_deg, heading = row["family"], float(row["slope_deg"]), float(row["heading"])
    system = System(animal, math.radians(slope_deg), animal.functions(family))
    phase = tuple(math.radians(float(row[f"phi_{pair}_deg"])) for pair in animal.pairs)
    name = f"gait {family} {slope_deg:g} deg {heading:g} rad"
    return Subject(name, system, phase, Start(float(row["v0"]), heading))
