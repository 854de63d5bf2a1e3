"""What several tests share."""

import csv
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
import xarray as xr

from legspring import Animal, Gait, cockroach, load_animal, mapping, solve
from legspring.mapping import HEADINGS, SLOPES_DEG, find_all
from legspring.peterson2011.surfaces import lines
from tests.oracle.periods import Period, largest_allowed

REFERENCE = Path(__file__).parent / "reference"
Cells = dict[tuple[float, float], tuple[Gait, ...]]


def read_reference(name: str) -> list[dict[str, str]]:
    """Return the rows of one of the reference tables."""
    with open(REFERENCE / name, newline="") as file:
        return list(csv.DictReader(file))


def pytest_addoption(parser: pytest.Parser) -> None:
    """Let more animals be made up than in the usual tests."""
    parser.addoption("--animals", type=int, default=20, help="how many random animals to look at")


RETURNED: list[Gait] = []
"""Gaits that were returned since somebody looked."""


SEEN: set[tuple[object, ...]] = set()
"""Those that have come back."""


@pytest.fixture(scope="session", autouse=True)
def _noted() -> Iterator[None]:
    """Note all gaits that a search, or a map, returns."""
    number = solve.number_branches

    def noting(gaits: Sequence[Gait]) -> tuple[Gait, ...]:
        numbered = number(gaits)
        RETURNED.extend(numbered)
        return numbered

    with pytest.MonkeyPatch.context() as patch:
        for module in (mapping, solve):
            patch.setattr(module, "number_branches", noting)
        yield


@pytest.fixture(autouse=True)
def _come_back() -> Iterator[None]:
    """Make sure that every gait returned in a test comes back in an integration of another make."""
    yield
    gaits, RETURNED[:] = list(RETURNED), []
    for gait in gaits:
        # The same gait to the last bit needs no second look.
        animal = gait.animal.model_dump_json()
        key = animal, gait.point.tobytes(), gait.family, gait.actuation, gait.contacts, gait.symmetric, gait.strides
        if key in SEEN:
            continue
        SEEN.add(key)
        departure = Period(gait).departure()
        assert departure < largest_allowed(gait), f"{gait!r} is off by {departure:g} after a period"


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
def family_lines(roach: Animal) -> xr.Dataset:
    """Lines over slope and heading at which families of gaits end."""
    return lines(roach)


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
