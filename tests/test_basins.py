"""Which starts lead to a gait."""

import math

import numpy as np
import pytest
import xarray as xr

import legspring as ls
from legspring import Animal, Gait
from legspring.figures import draw_basin
from legspring.layout import System
from legspring.settling import Settling, attractor

SPEEDS, HEADINGS = np.linspace(0.02, 1.5, 100), np.linspace(-1.55, 1.55, 100)
LONG_ENOUGH = 36
"""Strides after which all motions of these starts have settled."""


@pytest.fixture(scope="module")
def flat(roach: Animal) -> Gait:
    """A gait beside which the clock lets the animal run backwards as well."""
    return ls.find_gaits(roach, slope_deg=15, heading=0.2)[0]


@pytest.fixture(scope="module")
def found(flat: Gait) -> xr.Dataset:
    return ls.basin(flat, {"speed": SPEEDS, "heading": HEADINGS})


def leads_to(gait: Gait, speed: float, heading: float) -> bool:
    """Say whether a start leads to a gait, in a simulation of its own."""
    run = ls.simulate(
        gait.animal,
        slope_deg=gait.slope_deg,
        family=gait.family,
        phase=gait.phase,
        speed=speed,
        heading=heading,
        strides=LONG_ENOUGH,
    )
    end = run["velocity"].values[-1]
    wanted = gait.speed * np.array([-math.sin(gait.heading), math.cos(gait.heading)])
    return bool(np.max(np.abs(end - wanted)) < 1e-3 * gait.speed)


def differing(gait: Gait, found: xr.Dataset, places: np.ndarray) -> int:
    """Return how many cells differ from simulations of their own."""
    ours = found["settles_on"].values == 0
    return sum(
        bool(ours[row, column]) != leads_to(gait, float(SPEEDS[row]), float(HEADINGS[column])) for row, column in places
    )


def test_a_basin_is_what_separate_simulations_say(flat: Gait, found: xr.Dataset) -> None:
    """Forty cells anywhere, and twenty of those whose neighbours go elsewhere."""
    rng, fates = np.random.default_rng(1), found["settles_on"].values
    anywhere = rng.integers(0, 100, (40, 2))
    edge = np.argwhere(fates[1:, :] != fates[:-1, :])
    assert differing(flat, found, np.vstack([anywhere, rng.permutation(edge)[:20]])) == 0


@pytest.mark.long
def test_ten_thousand_separate_simulations_say_the_same(flat: Gait, found: xr.Dataset) -> None:
    assert differing(flat, found, np.argwhere(np.ones((100, 100)))) == 0


def test_what_else_is_met_repeats_itself(flat: Gait, found: xr.Dataset) -> None:
    """A motion down the slope that comes back, in mirror image, after five steps."""
    periods = found["attractor_periods"].values.tolist()
    assert periods[0] == 1 and 5 in periods
    assert np.all(found["attractor_multiplier"] < 1.0)
    assert np.all(found["settles_on"] >= 0)
    five = periods.index(5)
    row, column = np.argwhere(found["settles_on"].values == five)[0]
    run = ls.simulate(
        flat.animal,
        slope_deg=15,
        family=flat.family,
        phase=flat.phase,
        speed=float(SPEEDS[row]),
        heading=float(HEADINGS[column]),
        strides=LONG_ENOUGH,
    )
    stride = float(run.attrs["stride_duration"])
    ends = [run["velocity"].interp(time=(LONG_ENOUGH - n) * stride).values for n in (0, 5, 2)]
    assert ends[0] == pytest.approx(ends[1], abs=1e-4)
    assert ends[0] != pytest.approx(ends[2], abs=1e-2)


def test_the_result_does_not_depend_on_workers(flat: Gait, found: xr.Dataset) -> None:
    some = {"speed": SPEEDS[::7], "heading": HEADINGS[::7]}
    one, three = (ls.basin(flat, some, workers=workers) for workers in (1, 3))
    for name in ("settles_on", "steps", "attractor_multiplier", "area"):
        assert np.array_equal(one[name], three[name])
    assert np.array_equal(one["settles_on"] == 0, found["settles_on"].values[::7, ::7] == 0)


@pytest.mark.long
def test_refined_edges_are_those_of_the_fine_grid(flat: Gait) -> None:
    speeds, headings = np.linspace(0.1, 1.4, 27), np.linspace(1.6, 2.8, 25)
    fine = ls.basin(flat, {"speed": np.linspace(0.1, 1.4, 105), "heading": np.linspace(1.6, 2.8, 97)})
    refined = ls.basin(flat, {"speed": speeds, "heading": headings}, refine=2)
    assert refined["settles_on"].shape == fine["settles_on"].shape
    there = refined["simulated"].values
    assert 0.1 < there.mean() < 0.6
    assert np.array_equal((refined["settles_on"] == 0).values[there], (fine["settles_on"] == 0).values[there])
    # What was filled in may hide what is smaller than the coarse grid.
    assert ((refined["settles_on"] == 0) != (fine["settles_on"] == 0)).mean() < 0.01
    assert float(refined["area"][0]) == pytest.approx(float(fine["area"][0]), rel=0.02)


def test_areas_fill_what_was_asked_for(found: xr.Dataset) -> None:
    assert float(found["area"].sum()) == pytest.approx(np.ptp(SPEEDS) * np.ptp(HEADINGS))


def test_the_band_of_heights_from_which_a_runner_comes_back() -> None:
    """From below the apex of its unstable gait, down to where it can only just touch the ground."""
    runner = ls.load_animal("spring_loaded_inverted_pendulum")
    unstable, stable = ls.find_gaits(runner)
    assert abs(stable.multipliers).min() < 1.0 < abs(unstable.multipliers).max()
    headings = np.linspace(-math.pi / 2 - 0.8, -math.pi / 2 - 1e-3, 81)
    found = ls.basin(stable, {"heading": headings}, refine=5)
    back = found["heading"].values[found["settles_on"].values == 0]
    step = float(found["heading"][1] - found["heading"][0])
    assert unstable.heading < back.min() < unstable.heading + step
    assert back.max() == headings[-1] and len(back) == np.ceil((back.max() - back.min()) / step - 0.5) + 1
    # The height of the apex follows from the speed at which it comes down.
    highest = runner.legs[0].length * math.cos(runner.legs[0].angle + math.pi)
    apexes = [
        abs(highest) + (stable.speed * math.cos(heading)) ** 2 / (2.0 * 9.81) for heading in (back.min(), -1.6634)
    ]
    assert apexes[0] == pytest.approx(unstable.apex_height, abs=2e-3)
    with pytest.raises(ValueError, match="gait: must be stable"):
        ls.basin(unstable, {"heading": headings})


def test_another_energy_is_kept() -> None:
    stable = ls.find_gaits(ls.load_animal("spring_loaded_inverted_pendulum"))[1]
    found = ls.basin(stable, {"speed": [5.15, 5.2, 5.25]})
    assert found["settles_on"].values.tolist() == [-7, 0, -7]


def test_along_a_parameter_the_gait_keeps_its_number(flat: Gait) -> None:
    stiffness = np.linspace(0.5, 2.5, 9)
    found = ls.basin(flat, {"F.stiffness": stiffness, "speed": [0.25, 0.35]})
    assert np.all(found["settles_on"] == 0)
    here = float(found["attractor_speed"].sel({"F.stiffness": 1.5}, method="nearest")[0])
    assert here == pytest.approx(flat.speed, rel=1e-6)
    # What else is met is the same at neighbouring values, wherever in its five steps it was met.
    fast = ls.basin(flat, {"F.stiffness": [0.5, 0.94, 1.375, 2.25, 2.7], "speed": [1.4]})
    assert fast["settles_on"].values.ravel().tolist() == [1] * 5
    assert fast["attractor_periods"].values[1].tolist() == [5.0] * 5
    assert np.all(np.abs(np.diff(fast["attractor_speed"].values[1])) < 0.1)
    # At another stiffness, with the same phases, it is what an animal of that stiffness settles on.
    stiffer = flat.animal.replace(**{"F.stiffness": float(stiffness[-1])})
    run = ls.simulate(
        stiffer, slope_deg=15, family=flat.family, phase=flat.phase, speed=0.3, heading=0.2, strides=LONG_ENOUGH
    )
    speed = float(np.hypot(*run["velocity"].values[-1]))
    assert speed == pytest.approx(float(found["attractor_speed"][0, -1]), rel=1e-6)


def test_neighbourhoods_contract(flat: Gait) -> None:
    """Whoever comes near settles: from all around, at its border."""
    one = attractor(flat.system, flat.point)
    assert 1e-4 < one.within <= 1e-2
    around = np.repeat(flat.point[None], 64, axis=0)
    angles = np.linspace(0.0, 2.0 * np.pi, 64)
    around[:, 0] *= 1.0 + 0.9 * one.within * np.cos(angles)
    around[:, 1] += 0.9 * one.within * np.sin(angles)
    fates, _ = Settling(System(flat.animal, flat.slope, flat.family), [one], 200)(around)
    assert np.all(fates == 0)


def test_figures_show_what_was_found(found: xr.Dataset, tmp_path: object) -> None:
    figure = draw_basin(found)
    assert [text.get_text() for text in figure.legends[0].get_texts()][-2:] == ["the gait", "gait"]
    mesh = figure.axes[0].collections[0]
    assert np.array_equal(np.asarray(mesh.get_array()), found["settles_on"].values.T)
    line = draw_basin(found.isel(heading=50))
    assert line.axes[0].get_xlabel() == "speed (m/s)"
    with pytest.raises(ValueError, match=r"must be one of legspring\.basin"):
        draw_basin(xr.Dataset())


def test_errors_say_what_would_be_valid(flat: Gait) -> None:
    for over, words in (
        ({}, "must be one or two coordinates"),
        ({"speed": [0.3, 0.2]}, "must be rising numbers"),
        ({"speed": [-1.0, 0.2]}, "speeds above 0"),
        ({"speed": "fast"}, "must be rising numbers"),
        ({"yaw": [0.0, 0.1]}, "'yaw' must be one of speed, heading, Dx, Dy"),
        ({"wings": [1.0]}, "must be one of"),
        ({"mass": [2e-3, 3e-3], "F.stiffness": [1.0, 2.0]}, "must be a coordinate of the start"),
        ({"slope_deg": [10, 200], "speed": [0.2]}, "slope"),
        ({"mass": [-1.0, 1.0], "speed": [0.2]}, "mass"),
        ({"F.stiffness": [-1.0, 1.0]}, "stiffness"),
        ({"speed": [0.2, math.nan]}, "must be rising numbers"),
        ({"heading": [0.0, math.inf]}, "must be finite numbers"),
        ({"heading": [[0.0, 0.1], [0.2]]}, "must be rising numbers"),
        ({7: [1.0]}, "must be one of speed"),
    ):
        with pytest.raises(ValueError, match=words):
            ls.basin(flat, over)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="memory = 'lost': must be 'kept' or 'rebuilt'"):
        ls.basin(flat, {"speed": [0.2]}, memory="lost")
