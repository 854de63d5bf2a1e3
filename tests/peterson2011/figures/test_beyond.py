"""Figures of what is beyond the thesis, against the data that they show."""

from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import LineCollection, QuadMesh
from matplotlib.figure import Figure

import legspring as ls
from legspring.peterson2011.figures import FIGURES
from legspring.peterson2011.figures.beyond import BEYOND, most_stable, second_minus_first
from legspring.peterson2011.figures.families import of_families
from legspring.peterson2011.single_leg import map_single_legs
from legspring.peterson2011.yawing import force_ranges
from tests.made_up import best_of, made_up_limits, made_up_optima

MULTIPLIER, EIGENVALUE = 0.5, 0.25


@pytest.fixture(scope="module")
def sources(roach: ls.Animal, family_lines: xr.Dataset) -> dict[str, Any]:
    """What the figures are drawn from, by the names in the registry."""
    strides = 0.5 * np.arange(81)
    decays = xr.Dataset(
        {
            "distance": (("gait", "stride"), [1e-4 * MULTIPLIER**strides, 1e-5 * 0.01**strides]),
            "max_multiplier": ("gait", [MULTIPLIER, 0.01]),
            "reduced_eigenvalue": ("gait", [EIGENVALUE, 0.01]),
        },
        coords={"gait": ["one", "two"], "stride": strides},
        attrs={"fit_from": 1e-12, "fit_to": 1e-7},
    )
    families = {"F": ("F",), "none": ()}
    grid: dict[str, Any] = {"slopes_deg": (0, 20), "headings": (0.15, 0.3), "impulses": ()}
    front = ("slope_deg", "family", "point")
    nothing = [np.nan, np.nan]
    yawing = ls.atlas(ls.load_animal("cockroach_rigid"), **grid | {"slopes_deg": (0, 30)})
    survivals = xr.Dataset(
        {
            "max_multiplier": ("gait", [0.2, 0.5, 0.8]),
            "recovery_steps": ("gait", [4.0, 9.0, np.nan]),
            "least_push": ("gait", [np.nan, 3.0, 1.0]),
            "roughest": ("gait", [30.0, 20.0, 8.0]),
            "family": ("gait", np.array(["A", "B", "B"], dtype=object)),
        }
    )
    atlas, optima = ls.atlas(roach, **grid), made_up_optima((0.0, 20.0), (0.15, 0.3))
    return {
        "atlas": atlas,
        "families": of_families(ls.atlas(roach, **grid | {"impulses": (0.5,)})),
        "optima": optima,
        "selected": best_of(optima),
        "back_pulls": ls.atlas(roach.replace(families=families), **grid),
        "decays": decays,
        "fronts": xr.Dataset(
            {
                "reduced_eigenvalue": (front, [[[0.3, 0.6], nothing], [nothing, [0.2, np.nan]]]),
                "transport_cost": (front, [[[1.2, 0.6], nothing], [nothing, [0.4, np.nan]]]),
            },
            coords={"slope_deg": [0.0, 20.0], "family": ["A", "B"]},
            attrs={"heading": 0.15},
        ),
        "single_leg": map_single_legs((0.0, 45.0)),
        "surfaces": family_lines,
        "limits": made_up_limits(),
        "survivals": survivals,
        "yawing": yawing,
        "yaw_forces": force_ranges({"one body": yawing, "another body": yawing.isel(branch=[0])}),
    }


def test_limits_are_lines_with_names_where_gaits_are(sources: dict[str, Any]) -> None:
    (axes,) = draw("beyond_limits", sources).axes
    pieces = [len(one.get_segments()) for one in axes.collections if isinstance(one, LineCollection)]
    assert pieces == [2, 0]
    (name,) = (text for text in axes.texts if text.get_text())
    slope, heading = name.get_position()
    assert name.get_text() == "A" and heading < np.interp(slope, [0.0, 10.0, 20.0], [0.15, 0.16, 0.18])


def draw(name: str, sources: dict[str, Any]) -> Figure:
    return BEYOND[name].draw(sources[BEYOND[name].source])


def maps(figure: Figure) -> list[np.ndarray]:
    """Return the numbers of each map, without the colours of the bars."""
    meshes = [child for axes in figure.axes[:2] for child in axes.get_children() if isinstance(child, QuadMesh)]
    return [np.ma.filled(np.ma.asarray(mesh.get_array(), dtype=float), np.nan) for mesh in meshes]


@pytest.mark.parametrize("name", BEYOND)
def test_every_figure_draws_and_has_a_caption_and_a_file(name: str, sources: dict[str, Any]) -> None:
    assert draw(name, sources).axes
    assert BEYOND[name].caption.endswith(".") and "  " not in BEYOND[name].caption
    assert BEYOND[name].stem == BEYOND[name].number == name
    assert name.startswith(("beyond_", "families_")) and name not in FIGURES


def test_second_branch_is_compared_with_the_first(sources: dict[str, Any]) -> None:
    atlas = sources["atlas"]
    for values, name in zip(
        maps(draw("beyond_second_branch", sources)), ("reduced_eigenvalue", "transport_cost"), strict=True
    ):
        np.testing.assert_array_equal(values, (atlas[name].sel(branch=1) - atlas[name].sel(branch=0)).values.T)
        assert np.isfinite(values).any()


def test_without_a_second_branch_there_is_nothing_to_compare(sources: dict[str, Any]) -> None:
    change = second_minus_first(sources["atlas"].isel(branch=[0]))
    assert change["transport_cost"].isnull().all()
    assert not change["family"].values.astype(bool).any()
    assert BEYOND["beyond_second_branch"].draw(sources["atlas"].isel(branch=[0])).axes


def test_true_stability_is_set_beside_the_thesis_s(sources: dict[str, Any]) -> None:
    first = sources["atlas"].sel(branch=0)
    multiplier, excess = maps(draw("beyond_true_stability", sources))
    np.testing.assert_array_equal(multiplier, first["max_multiplier"].values.T)
    np.testing.assert_array_equal(excess, (first["max_multiplier"] - first["reduced_eigenvalue"]).values.T)


def test_predicted_decays_are_straight_lines_from_the_fit_on(sources: dict[str, Any]) -> None:
    figure = draw("beyond_decays", sources)
    assert [axes.get_title() for axes in figure.axes] == ["one", "two"]
    _, complete, reduced = figure.axes[0].get_lines()
    for line, rate in ((complete, MULTIPLIER), (reduced, EIGENVALUE)):
        strides, distance = (np.asarray(values, dtype=float) for values in line.get_data())
        assert 0.9 * MULTIPLIER * 1e-7 < distance[0] < 1e-7
        np.testing.assert_allclose(distance, distance[0] * rate ** (strides - strides[0]))


def test_fronts_lead_from_the_most_stable_to_the_cheapest_gait(sources: dict[str, Any]) -> None:
    level, steep = draw("beyond_trade_off", sources).axes
    line, stable, cheap = level.get_lines()
    np.testing.assert_array_equal(line.get_xydata(), [[1.2, 0.3], [0.6, 0.6]])
    np.testing.assert_array_equal(stable.get_xydata(), [[1.2, 0.3]])
    np.testing.assert_array_equal(cheap.get_xydata(), [[0.6, 0.6]])
    assert cheap.get_markerfacecolor() == "white" != stable.get_markerfacecolor()
    assert all(np.array_equal(np.asarray(line.get_xydata()), [[0.4, 0.2]]) for line in steep.get_lines())
    assert np.ptp(steep.get_xlim()) == pytest.approx(0.1), "a single point is not blown up"


def test_of_a_body_that_yaws_the_most_stable_gaits_are_shown(sources: dict[str, Any]) -> None:
    yawing = sources["yawing"]
    excess, amplitude = maps(draw("beyond_yaw", sources))
    np.testing.assert_allclose(excess, yawing["max_multiplier"].min("branch").values.T - 1.0)
    best = most_stable(yawing)
    np.testing.assert_allclose(amplitude, np.degrees(best["yaw_amplitude"].values.T))
    for slope, heading in ((0, 0.15), (30, 0.3)):
        cell, one = yawing.sel(slope_deg=slope, heading=heading), best.sel(slope_deg=slope, heading=heading)
        (same,) = np.flatnonzero(cell["max_multiplier"].values == float(one["max_multiplier"]))
        assert one["family"].item() == cell["family"].values[same]


def test_forces_stand_beside_the_measured_ones(sources: dict[str, Any]) -> None:
    panels = draw("beyond_yaw_forces", sources).axes
    assert [axes.get_title()[3:] for axes in panels] == [
        "front legs, lateral",
        "front legs, fore-aft",
        "back legs, lateral",
        "back legs, fore-aft",
    ]
    measured, one, _ = panels[2].containers
    lows = [bar.get_y() for bar in measured]
    assert lows == pytest.approx([-0.20, -0.18, -0.12, -0.12, -0.18, -0.14, -0.02])
    force = sources["yawing"]["peak_force"].sel(leg="B", axis="lateral", slope_deg=30)
    assert one[2].get_y() == pytest.approx(float(force.min()))
    assert one[2].get_y() + one[2].get_height() == pytest.approx(float(force.max()), abs=0.02)
