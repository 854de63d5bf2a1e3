"""Animals that nobody has seen: any number of legs, wherever they are, whenever they are put down."""

from __future__ import annotations

from typing import Any

import numpy as np

from legspring import Animal
from legspring.model import Body, Leg
from legspring.model.laws import SpeedLaw, StepLaw

MOST_PAIRS = 8


def random_animal(rng: np.random.Generator) -> Animal:
    """Return an animal seen from above or from the side, passive or actuated, symmetric or not, that yaws or not."""
    view = rng.choice(["above", "side"])
    return from_above(rng) if view == "above" else from_the_side(rng)


def vary(rng: np.random.Generator, least: float, most: float) -> float:
    """Return a number between two, on a scale of factors."""
    return float(np.exp(rng.uniform(np.log(least), np.log(most))))


def from_above(rng: np.random.Generator) -> Animal:
    """Return an animal like an insect, its legs put down by the clock at any times; phases are given."""
    pairs, symmetric, passive = int(rng.integers(1, MOST_PAIRS + 1)), rng.random() < 0.6, rng.random() < 0.25
    yaws, tripods = bool(rng.random() < 0.4), rng.random() < 0.3
    legs = []
    for n in range(pairs):
        place = 1.0 - 2.0 * (n + 0.5) / pairs
        length = 0.025 * vary(rng, 0.6, 1.6)
        function = "pull" if place > 0.2 else "push"
        angle = np.deg2rad(90.0 - 70.0 * place + rng.uniform(-20.0, 20.0))
        fields: dict[str, Any] = {
            "pair": f"P{n}",
            "hip": (-0.004 * vary(rng, 0.7, 1.4), 0.01 * place) if yaws else (0.0, 0.0),
            "length": length,
            "stiffness": 4.5 / pairs * vary(rng, 0.5, 2.0),
            "angle": float(angle),
            "actuation": 0.0 if passive else length * rng.uniform(0.2, 0.6),
            "phase": 0.0 if passive else float(rng.uniform(-1.0, 1.0)),
            "function": function,
            "offset": float(n % 2) if tripods else float(rng.uniform(0.0, 2.0)),
            "damping": 0.0 if rng.random() < 0.7 else 0.005 / pairs,
            "stance": float(rng.uniform(0.6, 1.7)) if rng.random() < 0.2 else None,
        }
        one = Leg(name=f"P{n}L", **fields)
        other = one.mirrored(f"P{n}R")
        if not symmetric:
            other = other.model_copy(update={"stiffness": other.stiffness * vary(rng, 0.6, 1.5)})
        legs += [one, other]
    if not symmetric and len(legs) > 2 and rng.random() < 0.5:
        del legs[int(rng.integers(len(legs)))]
    speed = float(rng.uniform(0.15, 0.4))
    return Animal(
        name="random",
        body=Body(mass=2.5e-3, inertia=2e-7 * vary(rng, 0.5, 3.0), yaw="free" if yaws else "held"),
        legs=tuple(legs),
        families={"F": tuple(dict.fromkeys(leg.pair for leg in legs if leg.function == "push"))},
        speed_law=SpeedLaw(level=speed, vertical=speed),
        step_law=StepLaw(duration=float(rng.uniform(0.03, 0.06))),
    )


def from_the_side(rng: np.random.Generator) -> Animal:
    """Return an animal on one or two pairs of legs that come down to the ground, under a point mass or a trunk."""
    pitches, passive = bool(rng.random() < 0.5), rng.random() < 0.6
    pairs, both = (2 if pitches else 1), rng.random() < 0.5
    legs = []
    for n in range(pairs):
        fields: dict[str, Any] = {
            "pair": f"P{n}",
            "hip": ((2 * n - 1) * 0.3 * vary(rng, 0.7, 1.3), 0.0) if pitches else (0.0, 0.0),
            "length": 1.0,
            "stiffness": 80.0 * 9.81 * vary(rng, 12.0, 40.0),
            "angle": float(np.deg2rad(-180.0 + rng.uniform(8.0, 26.0))),
            "actuation": 0.0 if passive else 0.02 * vary(rng, 0.5, 2.0),
            "phase": 0.0 if passive else float(rng.uniform(-3.0, 3.0)),
            "damping": 0.0 if passive else 150.0 * vary(rng, 0.5, 2.0),
            "touchdown": "ground",
            "offset": 0.5 * n,
        }
        one = Leg(name=f"P{n}L", **fields)
        legs += [one, one.mirrored(f"P{n}R", alike=True)] if both else [one]
    speed = float(rng.uniform(1.0, 6.0))
    return Animal(
        name="random",
        body=Body(mass=80.0, inertia=vary(rng, 3.0, 12.0), yaw="free" if pitches else "held"),
        legs=tuple(legs),
        families={"F": tuple(f"P{n}" for n in range(pairs))},
        speed_law=SpeedLaw(level=speed, vertical=speed),
        step_law=StepLaw(duration=0.4),
    )
