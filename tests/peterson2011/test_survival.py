"""Whether stability and robustness rank gaits alike."""

import math

import numpy as np
import pytest
import xarray as xr

import legspring as ls
from legspring.peterson2011.survival import MEASURES, correlations, measured, section


def made_up(order: tuple[float, ...]) -> xr.Dataset:
    """Gaits of growing multipliers, whose measures of robustness are in another order."""
    stable = np.linspace(0.1, 0.9, len(order))
    values = {name: ("gait", sign * np.array(order)) for name, (_, sign) in MEASURES.items()}
    return xr.Dataset({"max_multiplier": ("gait", stable), "reduced_eigenvalue": ("gait", stable[::-1])} | values)


def test_ranks_that_are_alike_and_that_are_not() -> None:
    for order, expected, words in (
        ((5.0, 4.0, 3.0, 2.0, 1.0), 1.0, "alike (rank"),
        ((1.0, 2.0, 3.0, 4.0, 5.0), -1.0, "not alike"),
        ((5.0, 3.0, 1.0, 4.0, 2.0), 0.5, "alike in part"),
    ):
        found = made_up(order)
        for first, second in correlations(found).values():
            assert first == pytest.approx(expected) and second == pytest.approx(-expected)
        assert words in " ".join(section(found).paragraphs)


def test_what_survives_all_is_the_most_robust() -> None:
    found = made_up((5.0, 4.0, 3.0, 2.0, 1.0))
    found["least_push"].values[0] = math.nan
    assert correlations(found)["least_push"][0] == pytest.approx(1.0)
    # Of steps, missing means that it does not come back.
    found["recovery_steps"].values[-1] = math.nan
    assert correlations(found)["recovery_steps"][0] == pytest.approx(1.0)


def test_a_gait_is_measured_as_it_measures_itself(roach: ls.Animal) -> None:
    gait = ls.find_gaits(roach, slope_deg=15, heading=0.25)[0]
    row = measured(gait)
    assert row["recovery_steps"] == np.mean(gait.recovery_steps([0.5, -0.5]))
    assert 1.0 < row["least_push"] < row["sideways_push"] < 10.0
    assert row["max_multiplier"] == pytest.approx(abs(gait.multipliers[0]))
