"""Dynamic similarity: an animal of another size that moves in the same way (section 2.4 of the thesis)."""

import re
from math import sqrt
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from legspring.model.animal import Animal
    from legspring.model.laws import SpeedLaw, StepLaw
    from legspring.model.leg import Leg


def scaled_fields(animal: "Animal", length: float, mass: float) -> dict[str, Any]:
    """Return the fields of an animal whose lengths and masses are so many times as large, in the same gravity.

    Times grow as the square root of lengths, and so do speeds; forces grow as weights.
    """
    time = sqrt(length)
    body = dict(animal.body) | {"mass": mass * animal.body.mass}
    if animal.body.inertia is not None:
        body["inertia"] = mass * length**2 * animal.body.inertia
    return {
        "body": body,
        "legs": [_leg(leg, length, mass, time) for leg in animal.legs],
        "speed_law": _speeds(animal.speed_law, time),
        "step_law": _durations(animal.step_law, time),
    }


def _leg(leg: "Leg", length: float, mass: float, time: float) -> dict[str, Any]:
    fields = dict(leg) | {
        "hip": tuple(length * part for part in leg.hip),
        "length": length * leg.length,
        "actuation": length * leg.actuation,
        "stiffness": mass / length * leg.stiffness,
        "damping": mass / time * leg.damping,
    }
    if leg.length_law is not None:
        # Numbers in it are lengths of the leg as it was.
        before = re.sub(r"\b(l0|ldev)\b", rf"(\1/{length!r})", leg.length_law)
        fields["length_law"] = f"{length!r}*({before})"
    return fields


def _speeds(law: "SpeedLaw", time: float) -> dict[str, Any]:
    return dict(law) | {"level": time * law.level, "vertical": time * law.vertical}


def _durations(law: "StepLaw", time: float) -> dict[str, Any]:
    fields = dict(law) | {"points": [(time * speed, frequency / time) for speed, frequency in law.points]}
    for name in ("constant_above", "duration"):
        if fields[name] is not None:
            fields[name] = time * fields[name]
    return fields
