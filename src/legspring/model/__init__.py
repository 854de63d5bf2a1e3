"""What an animal is: frozen, validated data, without any numerics.

SI units throughout; angles in radians, except where a name ends in ``_deg``.
"""

from legspring.model._base import ModelError
from legspring.model.animal import Animal, Families
from legspring.model.body import Body
from legspring.model.laws import SpeedLaw, StepLaw
from legspring.model.leg import Leg
from legspring.model.load import cockroach, load_animal, presets

__all__ = [
    "Animal",
    "Body",
    "Families",
    "Leg",
    "ModelError",
    "SpeedLaw",
    "StepLaw",
    "cockroach",
    "load_animal",
    "presets",
]
