"""Where animals have gaits."""

from typing import Any

from legspring import Animal


def place_of(animal: Animal, slope_deg: float = 45.0) -> dict[str, Any]:
    """Return a slope, level if the animal is seen from the side, and a heading where it needs one."""
    low, high = animal.speed_law.domain_deg
    slope = low if low == high else 0.0 if animal.sagittal else slope_deg
    # With one pair the heading is left to the gait.
    return {"slope_deg": slope} | ({"heading": 0.15} if animal.tuned and len(animal.pairs) > 1 else {})
