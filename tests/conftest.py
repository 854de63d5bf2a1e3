"""What several tests share."""

import csv
from pathlib import Path

import pytest

from legspring import Animal, Gait, cockroach, load_animal
from legspring.sweep import HEADINGS, SLOPES_DEG, find_all

REFERENCE = Path(__file__).parent / "reference"
Cells = dict[tuple[float, float], tuple[Gait, ...]]


def read_reference(name: str) -> list[dict[str, str]]:
    """Return the rows of one of the reference tables."""
    with open(REFERENCE / name, newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="session")
def roach() -> Animal:
    """The thesis's animal."""
    return cockroach()


@pytest.fixture(scope="session")
def thesis_map(roach: Animal) -> Cells:
    """All gaits over the thesis's grid, by slope (deg) and heading."""
    found, _ = find_all(roach, SLOPES_DEG, HEADINGS)
    return {(SLOPES_DEG[row], HEADINGS[column]): gaits for (row, column), gaits in found.items()}


@pytest.fixture(scope="session")
def rigid() -> Animal:
    """The cockroach that yaws."""
    return load_animal("cockroach_rigid")


@pytest.fixture(scope="session")
def rigid_map(rigid: Animal) -> Cells:
    """Its gaits over a coarse grid, by slope (deg) and heading."""
    slopes_deg, headings = (0.0, 30.0, 60.0, 90.0), (0.05, 0.15, 0.3, 0.45)
    found, _ = find_all(rigid, slopes_deg, headings, starts=16)
    return {(slopes_deg[row], headings[column]): gaits for (row, column), gaits in found.items()}
