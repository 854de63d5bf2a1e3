"""Where optimised gaits cease to exist."""

import math

import numpy as np
import pytest
import xarray as xr

import legspring as ls
from legspring.objective import Objective
from legspring.optimisation import search
from legspring.peterson2011.limits import HALVINGS, limits, outline
from tests.made_up import made_up_optima


@pytest.mark.long
def test_beyond_a_limit_a_search_finds_nothing(roach: ls.Animal) -> None:
    slope_deg, low, high, family = 60.0, 0.25, 0.4, "MB"
    optima = ls.optimal_atlas(roach, slopes_deg=(slope_deg,), headings=(low, high), map="reduced", workers=2)
    found = limits(roach, optima, 2)["limit"].sel(family=family, slope_deg=slope_deg, heading=low, axis="heading")
    step = (high - low) / 2**HALVINGS
    limit = float(found.sel(objective="stability"))
    assert low < limit < high

    def at(heading: float) -> object:
        return search(Objective(roach, math.radians(slope_deg), heading, family, "stability", "reduced"), 0)

    assert at(limit - step) is not None
    assert at(limit + 2.0 * step) is None


def test_lines_go_around_the_cells_that_have_gaits() -> None:
    """Of nine cells the middle one has a gait: four pieces around it, a quarter of a cell away."""
    nothing = np.full((3, 3, 2), np.nan)
    nothing[0, 1, 0], nothing[1, 1, 0], nothing[1, 0, 1], nothing[1, 1, 1] = 7.5, 12.5, 0.15, 0.25
    found = xr.Dataset(
        {"limit": (("slope_deg", "heading", "axis"), nothing)},
        coords={"slope_deg": [0.0, 10.0, 20.0], "heading": [0.1, 0.2, 0.3], "axis": ["slope_deg", "heading"]},
    )
    pieces = [frozenset(piece) for piece in outline(found)]
    corners = [(7.5, 0.2), (12.5, 0.2), (10.0, 0.15), (10.0, 0.25)]
    assert sorted(map(sorted, pieces)) == sorted(sorted((a, b)) for a in corners[:2] for b in corners[2:])


def test_no_limits_where_all_cells_have_gaits(roach: ls.Animal) -> None:
    optima = made_up_optima((0.0, 20.0), (0.15, 0.3))
    there = optima.assign(speed=xr.ones_like(optima["speed"]))
    assert limits(roach, there, 1)["limit"].isnull().all()


@pytest.mark.parametrize("name", ["objective", "family", "slope_deg", "heading"])
def test_coordinates_are_those_of_the_map(roach: ls.Animal, name: str) -> None:
    optima = made_up_optima((0.0, 20.0), (0.15, 0.3))
    there = optima.assign(speed=xr.ones_like(optima["speed"]))
    assert np.array_equal(limits(roach, there, 1)[name], optima[name])
