"""The figure of footfalls."""

import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

import legspring as ls
from legspring.drawing.style import COLOURS
from legspring.figures import draw_footfalls
from legspring.figures.footfalls import footfalls
from legspring.files import save_netcdf
from legspring.gait import Gait

PUSH, PULL = COLOURS[:2]


@pytest.fixture(scope="module")
def gait() -> Gait:
    return ls.find_gaits(ls.cockroach(), slope_deg=45, heading=0.15)[0]


def drawn(figure: Figure) -> dict[str, list[tuple[float, float, str]]]:
    """Return start, end and colour of each bar, by the leg."""
    (axes,) = figure.axes
    legs = [label.get_text() for label in axes.get_yticklabels()]
    bars: dict[str, list[tuple[float, float, str]]] = {leg: [] for leg in legs}
    for bar in axes.patches:
        assert isinstance(bar, Rectangle)
        leg = legs[round(bar.get_y() + 0.5 * bar.get_height())]
        bars[leg].append((bar.get_x(), bar.get_x() + bar.get_width(), to_hex(bar.get_facecolor()).upper()))
    return bars


def test_a_bar_is_as_long_as_the_leg_is_down(gait: Gait) -> None:
    bars = drawn(draw_footfalls(gait))
    assert list(bars) == [leg.name for leg in gait.animal.legs]
    rows = zip(gait.animal.legs, gait.duty_factor, gait.phase_lag, gait.system.side, strict=True)
    for leg, share, lag, side in rows:
        assert sum(end - start for start, end, _ in bars[leg.name]) == pytest.approx(2.0 * share)
        assert {colour for *_, colour in bars[leg.name]} == {PUSH if side < 0.0 else PULL}
        starts = [start for start, *_ in bars[leg.name]]
        # The back leg of the step before is still down at the start.
        assert starts == pytest.approx([0.0, 0.5, 1.5] if leg.name == "BR" else [lag, 1.0 + lag])


def test_touch_downs_are_marked_with_their_times(gait: Gait) -> None:
    run = gait.simulate(strides=2)
    for leg, lag in zip(gait.animal.legs, gait.phase_lag, strict=True):
        assert footfalls(run, leg.name)[1] == pytest.approx([lag, 1.0 + lag])
    (axes,) = draw_footfalls(run).axes
    assert [text.get_text() for text in axes.texts] == ["0.00", "0.00", "0.00", "0.50", "0.50", "0.50"]


def test_one_leg_from_the_side() -> None:
    gait = ls.find_gaits(ls.load_animal("spring_loaded_inverted_pendulum"))[0]
    share = gait.duty_factor[0]
    figure = draw_footfalls(gait)
    (bars,) = drawn(figure).values()
    np.testing.assert_allclose([bar[:2] for bar in bars], [(0.0, share), (1.0, 1.0 + share)], atol=1e-9)
    assert [text.get_text() for box in figure.legends for text in box.get_texts()] == ["pushes"]


def test_a_leg_put_down_anew_has_one_bar_after_the_other() -> None:
    animal = ls.load_animal("climbing_template").replace(stance=3.0)
    run = ls.simulate(animal, speed=0.2, heading=0.0, slope_deg=90, strides=2)
    bars, touchdowns = footfalls(run, "L")
    np.testing.assert_allclose(bars, [(0.0, 1.0), (1.0, 2.0)])
    assert touchdowns == pytest.approx([0.0, 1.0])
    bars, touchdowns = footfalls(run, "R")
    assert [start for start, _ in bars] == pytest.approx([0.0, 0.5, 1.5]) and touchdowns == pytest.approx([0.5, 1.5])


def test_a_simulation_from_its_file(gait: Gait, tmp_path: Path) -> None:
    run = gait.simulate(strides=5)
    save_netcdf(run, tmp_path / "run.nc")
    with xr.open_dataset(tmp_path / "run.nc") as stored:
        assert drawn(draw_footfalls(stored)) == drawn(draw_footfalls(run))
    assert run.attrs["stride_duration"] == pytest.approx(2.0 * gait.step_duration)
    assert math.isclose(run["time"].values[-1], 5.0 * run.attrs["stride_duration"])
