"""Every family for itself: gaits by family, words and numbers, and the fronts between optima."""

import numpy as np
import pytest
import xarray as xr

import legspring as ls
from legspring.peterson2011.families import section
from legspring.peterson2011.figures.families import of_families
from legspring.peterson2011.fronts import undominated
from tests.made_up import FAMILIES, made_up_optima

SLOPES, HEADINGS = (0.0, 45.0), (0.15, 0.3)


@pytest.fixture(scope="module")
def atlas(roach: ls.Animal) -> xr.Dataset:
    return ls.atlas(roach, slopes_deg=SLOPES, headings=HEADINGS, impulses=(-0.5, 0.5))


def test_of_each_family_the_first_gait_is_kept(atlas: xr.Dataset) -> None:
    gaits = of_families(atlas)
    assert gaits["family"].values.tolist() == FAMILIES
    for slope in SLOPES:
        for heading in HEADINGS:
            cell = atlas.sel(slope_deg=slope, heading=heading)
            for family in FAMILIES:
                speeds = cell["speed"].values[cell["family"].values == family]
                kept = float(gaits["speed"].sel(slope_deg=slope, heading=heading, family=family))
                assert kept == speeds[0] if len(speeds) else np.isnan(kept)


def test_families_are_counted(atlas: xr.Dataset) -> None:
    fixed, optima = of_families(atlas), made_up_optima(SLOPES, HEADINGS)
    (table,) = section(fixed, optima).tables
    rows = {(str(row[0]), str(row[1])): row[2:] for row in table.cells}
    assert len(rows) == 3 * len(FAMILIES)
    here = fixed.sel(family="FB")
    assert rows["fixed", "FB"][0] == float(here["speed"].notnull().sum())
    assert rows["fixed", "FB"][2] == float(np.nanmedian(here["reduced_eigenvalue"]))
    there = optima.sel(objective="efficiency", family="B")
    assert rows["for efficiency", "B"][0] == float(there["speed"].notnull().sum())
    assert rows["for efficiency", "B"][4] == pytest.approx(float(np.nanmean(there["recovered"])))


def test_dominated_points_and_doubles_leave_the_front() -> None:
    points = np.array([[0.3, 1.0], [0.3, 1.0], [0.4, 0.9], [0.5, 0.95], [0.6, 0.9 + 1e-4], [0.7, 0.5]])
    assert undominated(points).tolist() == [True, False, True, False, False, True]
    assert undominated(np.empty((0, 2))).tolist() == []
    assert undominated(np.array([[0.2, 0.8]])).tolist() == [True]
