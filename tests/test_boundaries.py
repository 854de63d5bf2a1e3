"""Boundaries: curves of what is special, in two parameters."""

import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scipy.interpolate import CubicSpline

import legspring as ls
from legspring import Animal, Gait, charts, load_animal
from legspring.continuation import Special
from legspring.figures import draw_boundaries
from legspring.footing import Reason
from legspring.landmarks import Kind
from legspring.measures.forces import peak_magnitude
from legspring.planes import Boundary
from legspring.stretch import Stretch

LIMITS = ((0.0, 90.0), (0.0, 0.7))


@pytest.fixture(scope="module")
def steep(roach: Animal) -> Gait:
    return ls.find_gaits(roach, slope_deg=40, heading=0.4)[0]


@pytest.fixture(scope="module")
def walker_at() -> Gait:
    return ls.find_gaits(load_animal("walker").replace(stiffness=13740.0), energy=831.0)[0]


@pytest.fixture(scope="module")
def special(steep: Gait) -> dict[Kind, Special]:
    return {one.kind: one for one in ls.follow(steep, "heading", to=0.6).special}


@pytest.fixture(scope="module")
def folds(special: dict[Kind, Special]) -> Boundary:
    return ls.boundary(special[Kind.FOLD], "slope_deg", "heading", within=LIMITS)


def test_the_line_of_folds_turns_back_in_a_cusp(folds: Boundary) -> None:
    """It dips to 0.4375 rad near 38 deg, and ends where the front leg is idle."""
    (cusp,) = (one for one in folds.special if one.kind == "cusp")
    assert cusp.values == pytest.approx((30.914367, 0.453984), abs=1e-6)
    slopes, headings = folds.values.T
    lowest = np.argmin(np.where(slopes > 33.0, headings, 1.0))
    assert headings[lowest] == pytest.approx(0.4375, abs=1e-4) and 37.0 < slopes[lowest] < 39.0
    ends = [end for end in (folds.beginning, folds.ending) if end is not None and end.reason is Reason.WINDOW]
    assert [end.leg for end in ends] == ["FL"]


def test_its_points_are_folds(roach: Animal, folds: Boundary, special: dict[Kind, Special]) -> None:
    for n in range(5, len(folds), 12):
        slope, heading = folds.values[n]
        gait = folds.gaits[n]
        assert (gait.slope_deg, gait.heading) == pytest.approx((slope, heading), abs=1e-9)
        # On one side two gaits, on the other none: a curve through it turns just there.
        below = ls.follow(folds.gaits[n], "heading", within=(heading - 0.05, heading + 0.05))
        turn = min((one.value for one in below.special if one.kind is Kind.FOLD), key=lambda one: abs(one - heading))
        assert turn == pytest.approx(heading, abs=1e-8)
    n = int(np.argmin(np.abs(folds.values[:, 0] - 40.0)))
    assert folds.values[n] == pytest.approx((40.0, 0.4382000525), abs=1e-8)
    assert not ls.find_gaits(roach, slope_deg=40, heading=0.45)


def test_fold_lines_in_other_parameters(special: dict[Kind, Special], steep: Gait) -> None:
    line = ls.boundary(special[Kind.FOLD], "F.stiffness", "heading", within=((1.0, 2.0), (0.0, 0.7)))
    assert (line.values[:, 0].min(), line.values[:, 0].max()) == pytest.approx((1.0, 2.0), abs=1e-9)
    softer = ls.follow(steep, "F.stiffness", to=1.2).gaits[-1]
    (fold,) = (one for one in ls.follow(softer, "heading", to=0.6).special if one.kind is Kind.FOLD)
    there = ls.boundary(special[Kind.FOLD], "heading", "F.stiffness", within=((0.0, 0.7), (1.2, 2.0)))
    ends = {round(float(stiffness), 9): float(heading) for heading, stiffness in there.values[[0, -1]]}
    assert ends[1.2] == pytest.approx(fold.value, abs=1e-9)


def test_a_leg_is_idle_all_along(special: dict[Kind, Special]) -> None:
    line = ls.boundary(special[Kind.IDLE], "slope_deg", "heading", within=((30.0, 50.0), (0.0, 0.7)))
    assert (line.kind, line.leg) == ("idle leg", "BL")
    for gait in line.gaits[::6]:
        assert peak_magnitude(gait.stride, gait.first_legs[2]) == pytest.approx(1e-3, abs=1e-8)


def test_beside_the_ignored_window(special: dict[Kind, Special]) -> None:
    line = ls.boundary(special[Kind.WINDOW], "slope_deg", "heading", within=((35.0, 45.0), (0.0, 0.7)))
    assert len(line) > 5
    for gait in line.gaits[::6]:
        assert 0.02 < gait.liftoff[2] < 0.02 + 2e-8


def test_the_cost_of_a_family_is_the_sine_of_the_slope(steep: Gait) -> None:
    """Where no leg does negative work, so that its level lines are those of slope."""
    line = ls.boundary(steep, "slope_deg", "heading", level="transport_cost", within=((30, 50), (0.38, 0.42)))
    assert line.values[:, 0] == pytest.approx([40.0] * len(line), abs=1e-7)
    assert (line.values[:, 1].min(), line.values[:, 1].max()) == pytest.approx((0.38, 0.42), abs=1e-9)


def test_where_the_inverted_pendulum_loses_its_stability() -> None:
    """In energy and angle: both lines, each point checked by a curve in the angle alone."""
    runner = load_animal("spring_loaded_inverted_pendulum").replace(angle_deg=-158.0)
    curve = ls.follow(ls.find_gaits(runner, energy=1784.8)[0], "angle", within=(-2.79, -2.7))
    for kind in (Kind.FOLD, Kind.PERIOD_DOUBLING):
        (one,) = (special for special in curve.special if special.kind is kind)
        line = ls.boundary(one, "energy", "angle", within=((1600.0, 2000.0), (-2.9, -2.6)))
        assert sorted(line.values[[0, -1], 0]) == pytest.approx([1600.0, 2000.0], rel=1e-9)
        energy, angle = line.values[len(line) // 3]
        gait = line.gaits[len(line) // 3]
        assert gait.energy == pytest.approx(energy, rel=1e-9)
        beside = ls.follow(gait, "angle", within=(angle - 0.03, angle + 0.03))
        found = [special.value for special in beside.special if special.kind is kind]
        assert min(abs(value - angle) for value in found) < 1e-8


def test_a_boundary_comes_back_from_its_file(folds: Boundary, tmp_path: Path) -> None:
    path = tmp_path / "line.nc"
    folds.save(path)
    again = ls.load_boundary(path)
    assert np.array_equal(again.values, folds.values) and again.special == folds.special
    assert (again.ending, again.beginning, again.parameters) == (folds.ending, folds.beginning, folds.parameters)
    with xr.open_dataset(path) as data:
        assert len(draw_boundaries([data.load(), folds]).axes) == 1


def test_a_boundary_that_is_stopped_goes_on(
    special: dict[Kind, Special], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, limits = tmp_path / "line.nc", ((36.0, 44.0), (0.0, 0.7))
    whole = ls.boundary(special[Kind.FOLD], "slope_deg", "heading", within=limits)
    monkeypatch.setattr(charts, "SECONDS", 0.0)
    keep, count = charts.Shelf.note, 0

    def noting(shelf: charts.Shelf, stretches: list[Stretch]) -> None:
        nonlocal count
        keep(shelf, stretches)
        count += 1
        if count == 4:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(charts.Shelf, "note", noting)
        with pytest.raises(KeyboardInterrupt):
            ls.boundary(special[Kind.FOLD], "slope_deg", "heading", within=limits, store=path)
    with pytest.raises(ValueError, match="must hold a boundary that was followed to its end"):
        ls.load_boundary(path)
    resumed = ls.boundary(special[Kind.FOLD], "slope_deg", "heading", within=limits, store=path)
    assert resumed.values == pytest.approx(whole.values, abs=1e-9)
    assert np.array_equal(ls.load_boundary(path).values, resumed.values)


def test_a_level_that_a_curve_meets(roach: Animal) -> None:
    curve = ls.follow(ls.find_gaits(roach, slope_deg=15, heading=0.2)[0], "heading", within=(0.0, 0.7))
    half = curve.where("max_multiplier", 0.5)
    assert half and all(abs(gait.multipliers[0]) == pytest.approx(0.5, abs=1e-9) for gait in half)
    line = ls.boundary(half[0], "slope_deg", "heading", level="max_multiplier", within=((12, 18), (0.2, 0.5)))
    for gait in line.gaits[::4]:
        assert abs(gait.multipliers[0]) == pytest.approx(0.5, abs=1e-7)
    with pytest.raises(ValueError, match="measure = 'wings': must be a measure that is one number"):
        curve.where("wings", 1.0)


def ends_on(line: Boundary, stiffness: float, branch: int, to: float) -> tuple[float, float]:
    """Return the energy at which gaits of another stiffness end, and that of the line."""
    softer = load_animal("walker").replace(stiffness=stiffness)
    curve = ls.follow(ls.find_gaits(softer, energy=831.0)[branch], "energy", to=to)
    order = np.argsort(line.values[:, 0])
    between = CubicSpline(line.values[order, 0], line.values[order, 1])
    return curve.ending.value, float(between(stiffness))


def test_a_force_that_dips_to_zero(walker_at: Gait) -> None:
    """The walker's leg between its two humps, where it would leave the ground early."""
    end = ls.follow(walker_at, "energy", to=900.0).special[-1]
    assert (end.kind, end.leg) == (Kind.GRAZING_LIFTOFF, "L")
    line = ls.boundary(end, "stiffness", "energy", within=((13000.0, 15000.0), (750.0, 900.0)))
    found, expected = ends_on(line, 13900.0, 0, 900.0)
    assert found == pytest.approx(expected, abs=2e-4)


def test_a_foot_that_comes_down_at_a_rate_of_zero(walker_at: Gait) -> None:
    """Where the walker's body goes level as its foot comes down."""
    end = ls.follow(walker_at, "energy", to=800.0).special[-1]
    assert end.kind is Kind.GRAZING_TOUCHDOWN
    line = ls.boundary(end, "stiffness", "energy", within=((13000.0, 15000.0), (750.0, 900.0)))
    found, expected = ends_on(line, 13600.0, 0, 800.0)
    assert found == pytest.approx(expected, abs=2e-4)
    headings = [gait.heading for gait in line.gaits]
    assert headings == pytest.approx([-math.pi / 2] * len(headings), abs=1e-8)


def test_errors_say_what_would_be_valid(steep: Gait, special: dict[Kind, Special]) -> None:
    fold = special[Kind.FOLD]
    for arguments, options, words in (
        (("slope_deg", "slope_deg"), {}, "must be two parameters"),
        (("slope_deg", "desired_speed"), {}, "must be two parameters"),
        (("slope_deg", "wings"), {}, "must be one of"),
        (("slope_deg", "heading"), {"within": (0, 90)}, r"must be two ranges, \(\(low, high\), \(low, high\)\)"),
        (("slope_deg", "heading"), {"within": ((50, 90), (0, 1))}, "must hold the value of slope_deg, 40"),
        (("slope_deg", "heading"), {"level": "speed"}, "must be left out for a special point"),
    ):
        with pytest.raises(ValueError, match=words):
            ls.boundary(fold, *arguments, **options)
    with pytest.raises(ValueError, match="level = 'family': must be a measure that is one number"):
        ls.boundary(steep, "slope_deg", "heading", level="family")
    assert math.isfinite(fold.value)
