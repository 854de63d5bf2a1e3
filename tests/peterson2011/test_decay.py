"""Decay of small disturbances."""

import json
from pathlib import Path

import pytest
import xarray as xr

import legspring as ls
from legspring.peterson2011.decay import decays

HARD_CELLS = [(75.0, 0.15, 0.127, 0.203), (60.0, 0.40, 0.054, 0.084)]


@pytest.fixture(scope="module")
def simulated(roach: ls.Animal) -> xr.Dataset:
    return decays(roach, [cell[:2] for cell in HARD_CELLS] + [(30.0, 0.15)])


@pytest.mark.parametrize(("slope", "heading", "reduced", "true"), HARD_CELLS)
def test_disturbances_decay_as_the_complete_map_says(
    slope: float, heading: float, reduced: float, true: float, simulated: xr.Dataset
) -> None:
    gait = simulated.sel(gait=f"{slope:g} deg, {heading:g} rad")
    assert [float(gait["slope_deg"]), float(gait["heading"])] == pytest.approx([slope, heading])
    assert float(gait["reduced_eigenvalue"]) == pytest.approx(reduced, abs=5e-4)
    assert float(gait["max_multiplier"]) == pytest.approx(true, abs=5e-4)
    assert float(gait["decay"]) == pytest.approx(float(gait["max_multiplier"]), rel=0.02)
    assert float(gait["decay"]) > 1.3 * float(gait["reduced_eigenvalue"])


def test_both_maps_predict_the_decay_where_no_old_leg_matters(simulated: xr.Dataset) -> None:
    gait = simulated.isel(gait=2)
    for name in ("reduced_eigenvalue", "max_multiplier"):
        assert float(gait["decay"]) == pytest.approx(float(gait[name]), rel=0.02)


def test_disturbances_start_small_and_end_in_the_noise(simulated: xr.Dataset) -> None:
    distance = simulated["distance"]
    assert float(distance.isel(stride=0).max()) < 2e-4
    assert float(distance.isel(stride=slice(-10, None)).max()) < simulated.attrs["fit_from"]


def test_decays_can_be_stored(simulated: xr.Dataset, tmp_path: Path) -> None:
    simulated.to_netcdf(tmp_path / "decays.nc")
    with xr.open_dataset(tmp_path / "decays.nc") as stored:
        xr.testing.assert_identical(stored.load(), simulated)
    assert json.loads(simulated.attrs["parameters"])["name"] == "cockroach"


def test_decays_of_no_gait(roach: ls.Animal) -> None:
    with pytest.raises(ValueError, match=r"there is no gait at 40 deg, 0\.45 rad"):
        decays(roach, [(40.0, 0.45)])
