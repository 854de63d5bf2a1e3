"""Animals of the package as the oracle's walkers, by arithmetic of its own."""

import math

import numpy as np

from legspring import Animal, Gait
from legspring.model import Leg
from tests.oracle import heyoka_rules
from tests.oracle.problem import Array

START = ("speed", "heading", "Dx", "Dy", "yaw", "yaw_rate", "turn")


def duration_of(animal: Animal, slope: float) -> float:
    """Step duration on a slope (rad), even a little beyond the vertical."""
    law = animal.speed_law
    return animal.step_law(law.level + math.degrees(slope) / 90.0 * (law.vertical - law.level))


def walker_of(
    animal: Animal,
    slope: float,
    family: str,
    start: dict[str, float],
    phase: dict[str, float],
    before: tuple[heyoka_rules.Before, ...] = (),
) -> heyoka_rules.Walker:
    """Return the oracle's walker; a start by `START`, SI units, and the phase of each leg by its name."""
    time, mass = duration_of(animal, slope), animal.body.mass
    side = {pair: -1.0 if pair in animal.families[family] else 1.0 for pair in animal.pairs}
    names = [leg.name for leg in animal.legs]
    rows = []
    for leg in animal.legs:
        trigger = -1.0 if leg.touchdown == "ground" else 0.0
        trigger = names.index(leg.follows) + 1.0 if leg.follows else trigger
        stiffness, ldev = leg.stiffness * time**2 / mass, side[leg.pair] * leg.actuation
        row = [*leg.hip, stiffness, leg.length, ldev, phase[leg.name], leg.angle, leg.damping * time / mass]
        rows.append([*row, trigger, leg.stance or 0.0])
    mobility = mass / animal.body.inertia if animal.body.yaw == "free" and animal.body.inertia else 0.0
    weight, (sine, cosine) = animal.gravity * time**2, (np.sin(slope), np.cos(slope))
    side_view = any(leg.touchdown == "ground" for leg in animal.legs)
    body = np.array([weight * cosine, mobility, weight * sine] if side_view else [weight * sine, mobility, 0.0])
    numbers = [start[name] * (time if name in ("speed", "yaw_rate") else 1.0) for name in START]
    signs, offsets = [side[leg.pair] for leg in animal.legs], [leg.offset for leg in animal.legs]
    return heyoka_rules.Walker(
        body,
        np.array(rows),
        np.array(signs),
        np.array(offsets),
        np.array(numbers),
        animal.body.yaw == "free",
        before=before,
    )


def held(leg: Leg, gait: Gait) -> tuple[float, ...]:
    """Where a leg without actuation holds its foot; only how high, if the body does not pitch."""
    place = leg.hip[0] - leg.length * math.sin(leg.angle), leg.hip[1] + leg.length * math.cos(leg.angle)
    pitches = gait.animal.body.yaw == "free"
    law = leg.actuation, leg.phase or 0.0
    return tuple(round(one, 9) for one in (*(place if pitches else place[1:]), *law))


def before_of(gait: Gait) -> tuple[heyoka_rules.Before, ...]:
    """Return what a gait says of each leg before its start."""
    if gait.contacts is None:
        return ()
    found: list[heyoka_rules.Before] = []
    numbers = gait.point[13:].reshape(len(gait.animal.legs), -1)
    for leg, row in zip(gait.animal.legs, numbers, strict=True):
        x, y, last = (float(value) for value in row[10:13])
        if leg.name not in gait.contacts:
            # One whose foot is held where another's is lands with it.
            beside = [one for one in gait.animal.legs if one.offset == 0.0 and held(one, gait) == held(leg, gait)]
            found.append(heyoka_rules.Lands() if beside and leg.touchdown == "ground" else None)
        elif leg.touchdown == "clock":
            found.append(heyoka_rules.Moved(x, y, last))
        else:
            found.append(heyoka_rules.Stood(x, None if gait.animal.sagittal else y, last))
    return tuple(found)


def states_of(
    animal: Animal,
    slope: float,
    family: str,
    start: dict[str, float],
    phase: dict[str, float],
    steps: int,
    before: tuple[heyoka_rules.Before, ...] = (),
) -> Array:
    """Simulate: x, y, vx, vy, yaw, yaw rate and time at the starts of steps, ``(steps + 1, 7)``, in SI units."""
    walker, time = walker_of(animal, slope, family, start, phase, before), duration_of(animal, slope)
    # What is put down a little later than a step begins was up before.
    up = [i for i, leg in enumerate(animal.legs) if leg.touchdown == "clock" and 0.0 < leg.offset < 0.5]
    walk = heyoka_rules.simulate(walker, steps, up)
    return np.column_stack([walk.states, walk.times]) * [1.0, 1.0, 1.0 / time, 1.0 / time, 1.0, 1.0 / time, time]
