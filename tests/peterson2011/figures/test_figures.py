import math
from functools import partial
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from numpy.typing import NDArray

import legspring as ls
from legspring.gait import Gait
from legspring.layout import System
from legspring.peterson2011.figures import FIGURES, GAIT, SIMULATION, chapter3, chapter4
from legspring.peterson2011.published import published_forces
from tests.made_up import FAMILIES, best_of, made_up_optima

NUMBERS = [
    *["2.1", "2.2", "3.1", "3.2"],
    *[f"4.{number}" for number in range(1, 6)],
    *[f"5.{number}" for number in range(1, 22)],
    *[f"6.{number}" for number in range(1, 9)],
]


@pytest.fixture(scope="module")
def sources() -> dict[str, Any]:
    """What the figures are drawn from, by the names in the registry."""
    roach = ls.cockroach()
    optima = made_up_optima((0.0, 15.0, 30.0), (0.05, 0.15))
    return {
        "gait": ls.find_gaits(roach, **GAIT)[0],
        "simulation": ls.simulate(roach, **SIMULATION),
        "system": System(roach, 0.0, "A"),
        "atlas": ls.atlas(roach, slopes_deg=(0, 30), headings=(0.15, 0.3), impulses=(-0.5, 0.5)),
        "optima": optima,
        "selected": best_of(optima),
        "measured": published_forces(),
    }


def draw(number: str, sources: dict[str, Any]) -> Figure:
    return FIGURES[number].draw(sources[FIGURES[number].source])


def meshes(figure: Figure) -> list[QuadMesh]:
    """Return the maps of a figure, without the colours of its bars."""
    found = [child for axes in figure.axes for child in axes.get_children() if isinstance(child, QuadMesh)]
    return [mesh for mesh in found if mesh.axes is not None and mesh.axes.get_label() != "<colorbar>"]


def shown(mesh: QuadMesh) -> NDArray[np.float64]:
    return np.ma.filled(np.ma.asarray(mesh.get_array(), dtype=float), np.nan)


def test_all_figures_are_there_in_order() -> None:
    assert list(FIGURES) == NUMBERS
    assert [figure.number for figure in FIGURES.values()] == NUMBERS
    assert FIGURES["4.1"].stem == "figure_4_1"


@pytest.mark.parametrize("number", NUMBERS)
def test_every_figure_draws_and_has_a_caption(number: str, sources: dict[str, Any]) -> None:
    assert draw(number, sources).axes
    caption = FIGURES[number].caption
    assert caption.endswith(".") and "  " not in caption


@pytest.mark.parametrize(
    ("number", "limits"),
    [
        ("4.1", (0.0, 0.4)),
        ("4.2", (0.0, 0.7)),
        ("4.3", (0.0, 50.0)),
        ("4.4", (0.0, 50.0)),
        ("4.5", (0.0, 2.0)),
        ("5.2", (0.2, 0.9)),
        ("5.7", (-75.0, 75.0)),
        ("5.8", (0.0, 0.7)),
        ("5.11", (0.0, 2.0)),
        ("5.19", (0.0, 2.0)),
        ("5.21", (0.0, 0.7)),
        ("6.3", (-1.0, 1.0)),
    ],
)
def test_the_thesis_colour_ranges(number: str, limits: tuple[float, float], sources: dict[str, Any]) -> None:
    assert meshes(draw(number, sources))[0].get_clim() == limits


def test_figure_4_1_has_speed_and_the_phases_of_all_pairs(sources: dict[str, Any]) -> None:
    figure, here = draw("4.1", sources), sources["atlas"].isel(branch=0)
    speed, *phases = map(shown, meshes(figure))
    np.testing.assert_array_equal(speed, here["speed"].values.T)
    for leg, phase in zip("FMB", phases, strict=True):
        np.testing.assert_allclose(phase, np.degrees(here["phase"].sel(leg=leg).values.T))
    titles = [axes.get_title() for axes in figure.axes[:4]]
    assert titles == ["a) speed", "b) phase, legs F", "c) phase, legs M", "d) phase, legs B"]


def test_figure_4_4_is_over_slope_and_impulse(sources: dict[str, Any]) -> None:
    figure = draw("4.4", sources)
    expected = sources["atlas"]["recovery_steps"].sel(heading=0.15, branch=0).values.T
    np.testing.assert_array_equal(shown(meshes(figure)[0]), expected)
    assert figure.axes[0].get_ylabel() == r"sideways impulse ($m\,v_\mathrm{des}$)"
    assert figure.axes[0].get_title() == "heading 0.15 rad"


def test_figures_of_an_atlas_show_any_branch(sources: dict[str, Any]) -> None:
    assert sources["atlas"].sizes["branch"] == 2
    for figure in chapter4.FIGURES:
        assert "branch 1" in figure.draw(sources["atlas"], branch=1).axes[0].get_title() or figure.number == "4.1"


@pytest.mark.parametrize(
    ("number", "name", "objective", "leg"),
    [
        ("5.2", "actuation", "stability", "F"),
        ("5.4", "actuation", "stability", "B"),
        ("5.6", "phase", "stability", "M"),
        ("5.8", "reduced_eigenvalue", "stability", None),
        ("5.10", "transport_cost", "stability", None),
        ("5.13", "actuation", "efficiency", "M"),
        ("5.17", "phase", "efficiency", "B"),
        ("5.18", "transport_cost", "efficiency", None),
        ("5.20", "reduced_eigenvalue", "efficiency", None),
    ],
)
def test_a_map_for_each_family(
    number: str, name: str, objective: str, leg: str | None, sources: dict[str, Any]
) -> None:
    at = {"objective": objective} | ({"leg": leg} if leg else {})
    expected = sources["optima"][name].sel(at)
    scale = {"phase": 180.0 / math.pi, "actuation": 1.0 / {"F": 0.032, "M": 0.026, "B": 0.019}.get(leg or "", 1.0)}
    figure = draw(number, sources)
    for family, mesh in zip(FAMILIES, meshes(figure), strict=True):
        np.testing.assert_allclose(shown(mesh), scale.get(name, 1.0) * expected.sel(family=family).values.T)
    assert len(figure.axes) == 5, "four maps and one colour bar"
    assert figure.axes[4].get_ylabel().endswith({"actuation": "($l_0$)", "phase": "(deg)"}.get(name, ""))


@pytest.mark.parametrize(
    ("number", "name", "objective"),
    [
        ("5.9", "reduced_eigenvalue", "stability"),
        ("5.11", "transport_cost", "stability"),
        ("5.19", "transport_cost", "efficiency"),
        ("5.21", "reduced_eigenvalue", "efficiency"),
    ],
)
def test_a_map_of_the_best_family(number: str, name: str, objective: str, sources: dict[str, Any]) -> None:
    figure, best = draw(number, sources), sources["selected"].sel(objective=objective)
    np.testing.assert_array_equal(shown(meshes(figure)[0]), best[name].values.T)
    assert places(figure.axes[0]) == {
        family: {(float(cell["slope_deg"]), float(cell["heading"])) for cell in cells_of(best["family"] == family)}
        for family in np.unique(best["family"].values.astype(str))
        if family
    }


def cells_of(where: xr.DataArray) -> list[xr.DataArray]:
    return [cell for cell in where.stack(cell=where.dims).T if bool(cell)]


def places(axes: Axes) -> dict[str, set[tuple[float, float]]]:
    """Return the places of each kind of marker, by its meaning."""
    found = {}
    for line in axes.get_lines():
        x, y = (np.asarray(values, dtype=float) for values in line.get_data())
        found[str(line.get_label())] = set(zip(x.tolist(), y.tolist(), strict=True))
    return found


def test_existence_shows_every_family_in_a_corner_of_its_own(sources: dict[str, Any]) -> None:
    figure, optima = draw("5.1", sources), sources["optima"]
    for axes, objective in zip(figure.axes, ("stability", "efficiency"), strict=True):
        drawn = places(axes)
        unstable = {family: drawn.pop(f"_{family}, unstable") for family in FAMILIES}
        assert list(drawn) == FAMILIES and not any(unstable.values())
        assert len(set.union(*drawn.values())) == sum(map(len, drawn.values())), "no marker hides another"
        for family, points in drawn.items():
            there = cells_of(optima["speed"].sel(objective=objective, family=family).notnull())
            cells = {(float(cell["slope_deg"]), float(cell["heading"])) for cell in there}
            nearest = {(15.0 * round(x / 15.0), round(0.1 * round((y - 0.05) / 0.1) + 0.05, 2)) for x, y in points}
            assert nearest == cells


def test_existence_tells_gaits_that_are_unstable(sources: dict[str, Any]) -> None:
    optima = sources["optima"]
    worse = optima.assign(max_multiplier=optima["max_multiplier"] + 1.0)
    for axes, objective in zip(FIGURES["5.1"].draw(worse).axes, ("stability", "efficiency"), strict=True):
        drawn, gaits = places(axes), optima["speed"].sel(objective=objective)
        for family in FAMILIES:
            assert len(drawn[f"_{family}, unstable"]) == int(gaits.sel(family=family).count())
            assert not drawn[family]


def test_measured_ranges_are_bars_and_missing_ones_are_named() -> None:
    for number, axis in (("6.1", "lateral"), ("6.2", "fore_aft")):
        front, middle, back = FIGURES[number].draw(published_forces()).axes
        for axes, leg in ((front, "F"), (back, "B")):
            bars = [(bar.get_y(), bar.get_y() + bar.get_height()) for bar in axes.patches]  # type: ignore[attr-defined]
            expected = published_forces()["experiment"].sel(leg=leg, axis=axis, extreme=["min", "max"])
            np.testing.assert_allclose(bars, expected.values)
        assert not front.texts and [text.get_text() for text in middle.texts] == ["no numbers in\nTables 6.1 to 6.3"]


@pytest.mark.parametrize(
    ("number", "source", "axis", "at"),
    [
        ("6.3", "atlas", "lateral", {"branch": 0}),
        ("6.4", "atlas", "fore_aft", {"branch": 0}),
        ("6.6", "selected", "fore_aft", {"objective": "stability"}),
        ("6.7", "selected", "lateral", {"objective": "efficiency"}),
    ],
)
def test_forces_of_legs_and_of_all(
    number: str, source: str, axis: str, at: dict[str, Any], sources: dict[str, Any]
) -> None:
    here, figure = sources[source].sel(at).sel(axis=axis), draw(number, sources)
    *legs, together = meshes(figure)
    for leg, mesh in zip("FMB", legs, strict=True):
        np.testing.assert_array_equal(shown(mesh), here["peak_force"].sel(leg=leg).values.T)
    np.testing.assert_array_equal(shown(together), here["net_force_max"].values.T)
    assert together.get_clim() == (-0.5, 2.0)


def test_figure_2_2_shows_lengths_in_stance_and_zero_in_swing(sources: dict[str, Any]) -> None:
    run, figure = sources["simulation"], draw("2.2", sources)
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["FL", "FR", "ML", "MR", "BL", "BR"]
    for axes in figure.axes:
        leg = axes.get_title(loc="left")
        drawn = {str(line.get_label()): np.asarray(line.get_ydata(), dtype=float) for line in axes.get_lines()}
        down = run["stance"].sel(leg=leg).values
        for words, name in (("actual", "leg_length"), ("force-free", "free_length")):
            np.testing.assert_allclose(drawn[words][down], 1e3 * run[name].sel(leg=leg).values[down])
            assert not drawn[words][~down].any()
    assert "our choice" in figure.get_suptitle()


def test_figure_3_2_shows_a_push_of_the_given_impulse(sources: dict[str, Any]) -> None:
    system = sources["system"]
    axes = partial(chapter3.push, impulse=0.3)(system).axes[0]
    time, force = (np.asarray(values, dtype=float) for values in axes.get_lines()[0].get_data())
    impulse = np.trapezoid(force, 1e-3 * time) * system.animal.gravity  # per mass
    assert impulse == pytest.approx(0.3 * system.desired_speed)
    assert (time[0], time[-1]) == (0.0, pytest.approx(1e3 * system.step_duration))


def test_the_sketch_of_the_model_is_to_scale(sources: dict[str, Any]) -> None:
    gait: Gait = sources["gait"]
    figure = draw("2.1", sources)
    above, _, length = figure.axes
    start = gait.simulate(strides=1).isel(time=0)
    dots = [np.ravel(line.get_xydata()) for line in above.get_lines() if line.get_marker() == "o"]
    for foot in 1e3 * start["foot"].values[start["stance"].values]:
        assert min(math.dist(foot, dot) for dot in dots) < 1e-9
    free, actual = (np.asarray(line.get_ydata(), dtype=float) for line in length.get_lines()[:2])
    down = np.isfinite(actual)
    assert free[0] == pytest.approx(actual[0]), "a leg touches down without force"
    assert np.all(free[down] > actual[down] - 1e-9), "the front leg of this gait pushes"


def test_the_sketch_of_the_path_shows_a_gait(sources: dict[str, Any]) -> None:
    gait: Gait = sources["gait"]
    (axes,) = draw("3.1", sources).axes
    along, left = (np.asarray(values, dtype=float) for values in axes.get_lines()[0].get_data())
    assert along[[0, -1]] == pytest.approx([0.0, 2e3 * gait.system.step_length], abs=1e-6)
    assert left[[0, len(left) // 2, -1]] == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)
    assert left[1] > 0.0, "a positive heading is to the left"
    words = [text.get_text() for text in axes.texts]
    assert words.count(r"$\delta_0$") == 2 and words.count(r"$-\delta_0$") == 1
    assert sum("(3.1)" in text for text in words) == 2
