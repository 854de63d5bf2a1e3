from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import QuadMesh
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

import legspring as ls
from legspring.drawing.style import MARKERS
from legspring.figures import draw_animal, draw_atlas, draw_gait, draw_recovery, draw_simulation, save_figure
from legspring.figures.maps import draw_panels, edges
from legspring.gait import Gait

SLOPES_DEG, HEADINGS, IMPULSES = (0.0, 20.0, 40.0), (0.0, 0.15, 0.45), (-0.5, 0.5)


@pytest.fixture(scope="session")
def maps() -> xr.Dataset:
    """All four families, and no gait at (0 deg, 0) and (40 deg, 0.45)."""
    return ls.atlas(ls.cockroach(), slopes_deg=SLOPES_DEG, headings=HEADINGS, impulses=IMPULSES)


@pytest.fixture(scope="session")
def gait() -> Gait:
    return ls.find_gaits(ls.cockroach(), slope_deg=45, heading=0.15)[0]


def cells(figure: Figure, panel: int = 0) -> Any:
    """Return what a map shows, as an array with nan where there is no cell."""
    (mesh,) = (child for child in figure.axes[panel].get_children() if isinstance(child, QuadMesh))
    return np.ma.filled(np.ma.asarray(mesh.get_array(), dtype=float), np.nan)


def markers(figure: Figure) -> dict[str, set[tuple[float, float]]]:
    """Return the places of each kind of marker in a map, by its meaning."""
    lines = [line for line in figure.axes[0].get_lines() if line.get_linestyle() == "None"]
    places = ((np.asarray(line.get_xdata()), np.asarray(line.get_ydata())) for line in lines)
    return {str(line.get_label()): set(zip(*xy, strict=True)) for line, xy in zip(lines, places, strict=True)}


@pytest.mark.parametrize("branch", [0, 1])
@pytest.mark.parametrize("name", ["speed", "reduced_eigenvalue", "max_multiplier", "transport_cost", "residual"])
def test_a_map_shows_the_data_and_nothing_else(maps: xr.Dataset, name: str, branch: int) -> None:
    figure = draw_atlas(maps, name, branch=branch)
    np.testing.assert_array_equal(cells(figure), maps[name].isel(branch=branch).values.T)
    axes, bar = figure.axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("slope (deg)", "initial heading (rad)")
    assert bar.get_ylabel().replace("\n", " ").startswith(maps[name].long_name)
    assert axes.get_title() == ("branch 1" if branch else "")


def test_angles_are_shown_in_degrees_and_signed_numbers_around_zero(maps: xr.Dataset) -> None:
    figure = draw_atlas(maps, "phase", leg="B")
    np.testing.assert_allclose(cells(figure), np.degrees(maps["phase"].sel(leg="B", branch=0).values.T))
    assert figure.axes[1].get_ylabel() == "phase of the actuation (deg)"
    assert figure.axes[0].get_title() == "leg B"
    low, high = figure.axes[1].get_ylim()
    assert low == -high < 0


def test_a_map_over_nothing_is_refused(maps: xr.Dataset) -> None:
    with pytest.raises(ValueError, match="recovery_steps: the atlas has no impulse"):
        draw_atlas(maps.isel(impulse=slice(0)), "recovery_steps", y="impulse", heading=float(maps.heading[0]))


def test_a_leg_that_points_straight_ahead_is_drawn() -> None:
    draw_animal(ls.cockroach().replace(angle_deg=0.0))


def test_cells_are_centred_on_their_points() -> None:
    np.testing.assert_allclose(edges(np.array([0.0, 5.0, 10.0])), [-2.5, 2.5, 7.5, 12.5])
    np.testing.assert_allclose(edges(np.array([0.0, 1.0, 4.0])), [-0.5, 0.5, 2.5, 5.5])
    np.testing.assert_allclose(edges(np.array([15.0])), [14.25, 15.75])


def test_every_gait_has_the_marker_of_its_family(maps: xr.Dataset) -> None:
    figure = draw_atlas(maps, "speed")
    family = maps["family"].isel(branch=0)
    expected: dict[str, set[tuple[float, float]]] = {}
    for row, slope in enumerate(SLOPES_DEG):
        for column, heading in enumerate(HEADINGS):
            if label := str(family.values[row, column]):
                expected.setdefault(label, set()).add((slope, heading))
    assert markers(figure) == expected
    assert set(expected) == {"A", "FB", "MB", "B"}
    shapes = {str(line.get_label()): line.get_marker() for line in figure.axes[0].get_lines()}
    assert shapes == {"A": "s", "FB": "v", "MB": "^", "B": "o"}
    assert not markers(draw_atlas(maps, "speed", families=False))


def test_markers_follow_the_order_of_the_animals_families(maps: xr.Dataset) -> None:
    renamed = maps.copy(deep=True)
    renamed["family"].values[np.isin(renamed["family"].values, ["A", "FB", "MB"])] = "two"
    renamed.attrs["parameters"] = '{"families": {"two": [], "B": []}}'
    shapes = {str(line.get_label()): line.get_marker() for line in draw_atlas(renamed, "speed").axes[0].get_lines()}
    assert shapes == {"two": MARKERS[0], "B": MARKERS[1]}


def test_cells_without_a_gait_are_hatched(maps: xr.Dataset) -> None:
    figure = draw_atlas(maps, "speed")
    assert np.isnan(cells(figure)).sum() == 2
    assert figure.axes[0].patch.get_hatch()
    assert "no gait" in legend(figure)
    full = draw_atlas(maps.isel(slope_deg=[1]), "speed")
    assert not full.axes[0].patch.get_hatch() and "no gait" not in legend(full)


def legend(figure: Figure) -> list[str]:
    return [text.get_text() for box in figure.legends for text in box.get_texts()]


def test_a_gait_that_does_not_recover_is_crossed_and_beyond_the_range(maps: xr.Dataset) -> None:
    lost = maps.copy(deep=True)
    lost["recovered"].loc[{"slope_deg": 20.0, "heading": 0.15, "impulse": 0.5}] = 0.0
    lost["recovery_steps"].loc[{"slope_deg": 20.0, "heading": 0.15, "impulse": 0.5}] = np.nan
    over_headings: dict[str, Any] = {"impulse": 0.5, "limits": (0.0, 50.0)}
    over_impulses: dict[str, Any] = {"y": "impulse", "heading": 0.15, "limits": (0.0, 50.0), "families": False}
    for options, row, place in ((over_headings, HEADINGS.index(0.15), 0.15), (over_impulses, IMPULSES.index(0.5), 0.5)):
        figure = draw_atlas(lost, "recovery_steps", **options)
        assert cells(figure)[row, 1] == 100.0
        assert markers(figure)["not recovered"] == {(20.0, place)}
        assert "not recovered" in legend(figure)
        assert "not recovered" not in legend(draw_atlas(maps, "recovery_steps", **options))
        (mesh,) = (child for child in figure.axes[0].get_children() if isinstance(child, QuadMesh))
        assert tuple(mesh.to_rgba(np.array([100.0]))[0]) == to_rgba("#D55E00")


def test_maps_side_by_side_share_a_bar(maps: xr.Dataset) -> None:
    figure = draw_panels(maps, "phase", [{"leg": leg, "branch": 0} for leg in "FMB"], limits=(-30.0, 60.0))
    for panel, leg in enumerate("FMB"):
        np.testing.assert_allclose(cells(figure, panel), np.degrees(maps["phase"].sel(leg=leg, branch=0).values.T))
    *panels, bar = figure.axes
    assert [axes.get_title() for axes in panels] == ["a) leg F", "b) leg M", "c) leg B"]
    assert bar.get_ylim() == (-30.0, 60.0)
    assert bar.get_ylabel() == "phase of the actuation (deg)"


@pytest.mark.parametrize("limits", [(-1.0, 1.0), (-0.5, 2.0), (-3.0, 1.0)])
def test_zero_is_pale_and_signs_are_told_apart(maps: xr.Dataset, limits: tuple[float, float]) -> None:
    figure = draw_atlas(maps, "phase", leg="F", limits=limits)
    (mesh,) = (child for child in figure.axes[0].get_children() if isinstance(child, QuadMesh))
    red, green, blue, _ = mesh.to_rgba(np.array([0.02, 0.0, -0.02]) * (limits[1] - limits[0])).T
    assert min(red[1], green[1], blue[1]) > 0.9
    assert red[0] > blue[0] and blue[2] > red[2]


@pytest.mark.parametrize(
    ("name", "at", "message"),
    [
        ("velocity", {}, "name = 'velocity': must be one of speed, mean_speed"),
        ("family", {}, "name = 'family': must be one of speed"),
        ("phase", {}, "leg = None: must be one of F, M, B"),
        ("phase", {"leg": "X"}, "leg = 'X': must be one of F, M, B"),
        ("speed", {"branch": 9}, "branch = 9: must be one of 0, 1"),
        ("speed", {"leg": "F"}, "speed has no dimension 'leg': must be one of slope_deg, heading, branch"),
        ("recovery_steps", {"impulse": 0.3}, "impulse = 0.3: must be one of -0.5, 0.5"),
    ],
)
def test_a_map_that_the_atlas_does_not_have(maps: xr.Dataset, name: str, at: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError) as caught:
        draw_atlas(maps, name, **at)
    assert str(caught.value).startswith(message)


def lines(figure: Figure, panel: str) -> dict[str, Line2D]:
    """Return the labelled lines of the panel whose vertical axis begins with these words."""
    (axes,) = (axes for axes in figure.axes if axes.get_ylabel().startswith(panel))
    return {str(line.get_label()): line for line in axes.get_lines() if not str(line.get_label()).startswith("_")}


def test_a_gait_is_drawn_over_one_stride(gait: Gait) -> None:
    figure = draw_gait(gait)
    run = gait.simulate(strides=1)
    path = lines(figure, "fore-aft, uphill (mm)")["centre of mass"]
    np.testing.assert_allclose(np.array(path.get_data()).T, 1e3 * run["position"].values)
    for axis in ("lateral", "fore_aft"):
        drawn = lines(figure, axis.replace("_", "-") + "\n")
        assert list(drawn) == ["sum", *run["leg"].values]
        force = run["force"].sel(axis=axis)
        np.testing.assert_allclose(np.asarray(drawn["sum"].get_ydata(), dtype=float), force.sum("leg").values)
        expected = force.sel(leg="BL").where(run["stance"].sel(leg="BL")).values
        np.testing.assert_array_equal(np.asarray(drawn["BL"].get_ydata(), dtype=float), expected)
    title = figure.get_suptitle()
    assert title.startswith("cockroach: family B, slope 45 deg, heading 0.15 rad")


def test_a_simulation_can_be_drawn_from_its_file(gait: Gait, tmp_path: Path) -> None:
    from legspring.files import save_netcdf

    run = gait.simulate(strides=3)
    save_netcdf(run, tmp_path / "run.nc")
    with xr.open_dataset(tmp_path / "run.nc") as stored:
        figure = draw_simulation(stored)
    velocity = lines(figure, "velocity (m/s)")
    np.testing.assert_allclose(
        np.asarray(velocity["fore-aft"].get_ydata(), dtype=float), run["velocity"].sel(axis="fore_aft").values
    )


def test_a_recovery_is_drawn_with_its_thresholds(gait: Gait) -> None:
    recovery = gait.recover(0.5)
    axes = draw_recovery(recovery).axes[0]
    drawn, one_percent, tenth_percent, back = axes.get_lines()
    np.testing.assert_array_equal(np.asarray(drawn.get_ydata()), recovery.distance[1:])
    assert [line.get_ydata()[0] for line in (one_percent, tenth_percent)] == [1e-2, 1e-3]  # type: ignore[index]
    assert list(np.asarray(back.get_xdata())) == [recovery.steps]
    assert axes.get_yscale() == "log"
    assert axes.get_title().endswith(f"back after {recovery.steps} steps")


@pytest.mark.parametrize(("elsewhere", "outcome"), [(True, "settled on another gait"), (False, "not back")])
def test_a_recovery_that_fails_says_how(gait: Gait, elsewhere: bool, outcome: str) -> None:
    recovery = replace(gait.recover(0.8), steps=None, distance=np.full(101, 2.0), other_gait=elsewhere)
    axes = draw_recovery(recovery).axes[0]
    assert axes.get_title().endswith(outcome)


@pytest.mark.parametrize(
    ("suffix", "magic"), [("png", b"\x89PNG"), ("pdf", b"%PDF"), ("svg", b"<?xml"), ("PNG", b"\x89")]
)
def test_the_suffix_says_the_format(maps: xr.Dataset, tmp_path: Path, suffix: str, magic: bytes) -> None:
    figure = draw_atlas(maps, "speed")
    save_figure(figure, tmp_path / f"map.{suffix}")
    assert (tmp_path / f"map.{suffix}").read_bytes().startswith(magic)
    assert [file.name for file in tmp_path.iterdir()] == [f"map.{suffix}"]


def test_a_png_has_300_dots_per_inch(maps: xr.Dataset, tmp_path: Path) -> None:
    figure = draw_atlas(maps, "speed")
    save_figure(figure, tmp_path / "map.png")
    header = (tmp_path / "map.png").read_bytes()
    assert int.from_bytes(header[16:20]) == int(300 * figure.get_figwidth())


@pytest.mark.parametrize("name", ["map.jpg", "map", "nowhere/map.png"])
def test_a_figure_that_cannot_be_saved(tmp_path: Path, name: str) -> None:
    message = "the directory .* must exist" if "/" in name else r"must end in .png, .pdf, .svg"
    with pytest.raises((ValueError, OSError), match=message):
        save_figure(Figure(), tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_a_figure_that_fails_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "map.png"
    target.write_text("old")

    def half(self: Figure, file: BytesIO, **options: Any) -> None:
        file.write(b"half")
        raise OSError("disk full")

    monkeypatch.setattr(Figure, "savefig", half)
    with pytest.raises(OSError, match="disk full"):
        save_figure(Figure(), target)
    assert [file.name for file in tmp_path.iterdir()] == ["map.png"]
    assert target.read_text() == "old"


def test_the_style_stays_with_our_figures(maps: xr.Dataset) -> None:
    before = dict(mpl.rcParams)
    draw_atlas(maps, "speed")
    assert dict(mpl.rcParams) == before
