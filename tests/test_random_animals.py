"""Gaits of animals that nobody has seen, by an integrator of another make: they come back; multipliers are exact."""

from collections import Counter
from collections.abc import Iterator

import numpy as np
import pytest

from legspring import Animal
from legspring.solve import search_gaits
from tests.oracle.periods import Period, largest_allowed
from tests.oracle.random_animals import random_animal

STATE, MULTIPLIERS = 1e-9, 1e-6
SMALL = 1e-2
"""Magnitude of multipliers below which only their number is looked at: several close to 0 are ill-conditioned."""
MET: Counter[str] = Counter()


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    if "seed" in metafunc.fixturenames:
        metafunc.parametrize("seed", range(metafunc.config.getoption("--animals")))


def made_up(seed: int) -> tuple[Animal, float]:
    """Return an animal and a slope, deg, on which it may have gaits."""
    rng = np.random.default_rng(seed)
    animal = random_animal(rng)
    if animal.conservative or (animal.sagittal and rng.random() < 0.5):
        return animal, 0.0
    return animal, float(rng.uniform(-5.0, 5.0) if animal.sagittal else rng.uniform(0.0, 90.0))


def test_gaits_of_an_animal(seed: int) -> None:
    animal, slope_deg = made_up(seed)
    gaits = search_gaits(animal, slope_deg=slope_deg, starts=24).gaits
    MET["from the side" if animal.sagittal else "from above"] += len(gaits)
    for gait in gaits[:4]:
        period = Period(gait)
        assert period.departure() < largest_allowed(gait)
        states = period.walk().states[:, 2:4] / gait.system.step_duration
        ours = gait.stride.states[: len(states), 2:4]
        np.testing.assert_allclose(ours, states, rtol=0, atol=STATE * gait.speed)
        expected, found = np.linalg.eigvals(period.jacobian()), gait.half_multipliers
        assert len(found) == len(expected)
        for one, others in ((found, expected), (expected, found)):
            for value in one[np.abs(one) > SMALL]:
                assert np.min(np.abs(others - value)) < MULTIPLIERS * max(1.0, abs(value))


@pytest.fixture(scope="module", autouse=True)
def _there_were_gaits(request: pytest.FixtureRequest) -> Iterator[None]:
    """Make sure that, where all were tried, something was."""
    yield
    if request.session.testscollected >= 20:
        assert min(MET["from the side"], MET["from above"]) >= 2
