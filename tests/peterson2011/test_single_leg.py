"""The model with one leg that the thesis starts from."""

import numpy as np
import pytest
import xarray as xr

import legspring as ls
from legspring.peterson2011.claims.chapter2 import SWITCH_DEG, steepest
from legspring.peterson2011.single_leg import VARIANTS, map_single_legs, section

SLOPES = (0.0, 10.0, 20.0, 30.0, 40.0, 50.0)


@pytest.fixture(scope="module")
def legs() -> xr.Dataset:
    return map_single_legs(SLOPES)


def test_gaits_are_those_of_find_gaits(legs: xr.Dataset) -> None:
    leg = ls.load_animal("effective_leg")
    gaits = ls.find_gaits(leg, slope_deg=20, heading=0.15, free=("T.angle",))
    for function in ("push", "pull"):
        gait = min((one for one in gaits if one.family == function), key=lambda one: abs(one.multipliers[0]))
        here = legs.sel(variant=VARIANTS[0].words, function=function, slope_deg=20, heading=0.15)
        assert float(here["max_multiplier"]) == pytest.approx(abs(gait.multipliers[0]), abs=1e-7)
        assert float(here["T.angle"]) == pytest.approx(gait.animal.legs[0].angle, abs=1e-8)
        assert gait.mean_speed == pytest.approx(leg.desired_speed(np.radians(20.0)), rel=1e-9)
        steps = [gait.recover(impulse).steps for impulse in (-0.5, 0.5)]
        assert (float(here["recovered"]) == 1.0) == (None not in steps)


def test_pushing_ends_where_the_thesis_has_the_switch(legs: xr.Dataset) -> None:
    push, pull = (legs["max_multiplier"].sel(function=name) for name in ("push", "pull"))
    assert bool(push.isel(slope_deg=0).notnull().all()), "it pushes on the level"
    assert bool((push.sel(slope_deg=50) > 1.0).all()) and bool((pull.sel(slope_deg=50) < 1.0).all())
    ends = steepest(push < 1.0)
    assert float(((ends >= SWITCH_DEG[0]) & (ends <= SWITCH_DEG[1])).mean()) >= 0.7
    text = " ".join(section(legs).paragraphs)
    assert f"up to slopes of {float(ends.min()):g} to {float(ends.max()):g} deg" in text


def test_steepest_slope_at_which_something_is_so() -> None:
    true = xr.DataArray([[1, 1, 0], [0, 1, 0], [0, 0, 0], [1, 1, 1]], dims=("x", "slope_deg")) > 0
    ends = steepest(true.assign_coords(slope_deg=[0.0, 10.0, 20.0]))
    assert ends.values[:2].tolist() == [15.0, 15.0] and bool(np.isnan(ends.values[2:]).all())
