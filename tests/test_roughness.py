"""Rough ground and bad luck."""

import math
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.interpolate import RegularGridInterpolator

import legspring as ls
from legspring import Animal, Gait
from legspring.flow import flow
from legspring.kernel.wander import OF_LEGS, OF_SLOPE, OF_STIFFNESS
from legspring.roughness import Roughness, hazard, run_all, wilson

MASS, STIFFNESS, LENGTH, GRAVITY = 80.0, 20_000.0, 1.0, 9.81


@pytest.fixture(scope="module")
def flat(roach: Animal) -> Gait:
    return ls.find_gaits(roach, slope_deg=15, heading=0.2)[0]


@pytest.fixture(scope="module")
def level(roach: Animal) -> Gait:
    """A gait at whose start no leg of the step before is down."""
    gait = ls.find_gaits(roach, slope_deg=0, heading=0.1)[0]
    assert not np.any(flow(gait.system, gait.point, steps=0).contacts().down[gait.system.offset == 1.0])
    return gait


@pytest.fixture(scope="module")
def runner() -> Gait:
    """The stable gait of the spring-loaded inverted pendulum."""
    return ls.find_gaits(ls.load_animal("spring_loaded_inverted_pendulum"))[1]


def no_changes(gait: Gait, steps: int) -> NDArray[np.float64]:
    return np.zeros((1, steps, OF_LEGS + 3 * len(gait.animal.legs)))


def test_on_even_ground_a_gait_goes_on_as_it_is(flat: Gait) -> None:
    found = ls.rough(flat, {"slope_deg": 0.0, "miss": 0.0, "phase": 0.0}, runs=2, strides=20)
    assert np.all(found["fate"] == 0) and np.all(found["steps"] == 40)
    assert found["mean_speed"].values == pytest.approx(flat.speed, rel=1e-9)
    assert found["mean_heading"].values == pytest.approx(flat.heading, abs=1e-9)
    assert found["speed_spread"].values == pytest.approx(0.0, abs=1e-9)


def test_a_slope_that_changes_once_is_that_slope(flat: Gait) -> None:
    """The same change in each step: the motion on another slope, by a clock that does not know."""
    changes = no_changes(flat, 4)
    changes[:, :, OF_SLOPE] = 0.1
    seen, fates, _ = run_all(flat, changes)
    p = flat.point.copy()
    p[flat.system.place_of("slope")] += 0.1
    run = flow(flat.system, p, steps=4)
    speeds = np.hypot(run.states[1:, 2], run.states[1:, 3]) / flat.system.desired_speed
    assert fates[0] == 0 and seen[0, :, 0] == pytest.approx(speeds, rel=1e-10)


def test_ground_that_changes_once_is_another_leg(level: Gait) -> None:
    """Legs put down in the second step are stiffer, and later in their phase."""
    changes = no_changes(level, 2)
    changes[:, 1, OF_STIFFNESS], changes[:, 1, OF_LEGS::3] = 0.2, 0.1
    seen, _, _ = run_all(level, changes)
    stiffer, system = level.point.copy(), level.system
    for leg, one in enumerate(level.animal.legs):
        if one.offset == 1.0:
            stiffer[system.place(leg, "stiffness")] *= math.exp(0.2)
            stiffer[system.place(leg, "phase")] += 0.1
    run = flow(system, stiffer, steps=2)
    speed = float(np.hypot(*run.states[2, 2:4])) / system.desired_speed
    assert seen[0, 1, 0] == pytest.approx(speed, rel=1e-9)
    assert seen[0, 0, 0] == pytest.approx(level.speed / system.desired_speed, rel=1e-9)


def test_a_leg_that_misses_is_not_there(level: Gait) -> None:
    """A step in which a whole tripod finds no ground is a flight, but for what is still down."""
    changes = no_changes(level, 2)
    later = [leg for leg, one in enumerate(level.animal.legs) if one.offset == 1.0]
    for leg in later:
        changes[0, 1, OF_LEGS + 3 * leg + 2] = 1.0
    missed, _, _ = run_all(level, changes)
    weak = level.point.copy()
    for leg in later:
        weak[level.system.place(leg, "stiffness")] = 1e-9
    run = flow(level.system, weak, steps=2)
    speed = float(np.hypot(*run.states[2, 2:4])) / level.system.desired_speed
    assert missed[0, 1, 0] == pytest.approx(speed, abs=1e-6)


def test_one_seed_is_one_result_whatever_the_number_of_workers(flat: Gait) -> None:
    options = {"runs": 30, "strides": 20, "seed": 5}
    kinds = {"slope_deg": 10.0, "miss": 0.05, "late": 0.1, "phase": 0.1, "stiffness": 0.1}
    one, three, other = (
        ls.rough(flat, kinds, **options | more)  # type: ignore[arg-type]
        for more in ({"workers": 1}, {"workers": 3}, {"seed": 6})
    )
    for name in one.data_vars:
        assert np.array_equal(one[name], three[name], equal_nan=True)
    assert not np.array_equal(one["mean_speed"], other["mean_speed"])


def test_what_is_drawn_is_what_was_asked_for() -> None:
    amounts = {"slope_deg": 2.0, "phase": 0.3, "miss": 0.25, "late": 0.05}
    for distribution, kurtosis in (("normal", 3.0), ("uniform", 1.8)):
        kind = Roughness(amounts, distribution, 0.6)
        drawn = kind.drawn(np.random.default_rng(1), 20_000, 2, 1.0)
        slopes = np.degrees(drawn[:, OF_SLOPE])
        assert slopes.std() == pytest.approx(2.0, rel=0.03) and slopes.mean() == pytest.approx(0.0, abs=0.1)
        assert ((slopes / slopes.std()) ** 4).mean() == pytest.approx(kurtosis, rel=0.08)
        assert np.corrcoef(slopes[1:], slopes[:-1])[0, 1] == pytest.approx(0.6, abs=0.04)
        assert drawn[:, OF_LEGS + 2].mean() == pytest.approx(0.25, abs=0.02)
        assert np.all(drawn[:, OF_LEGS + 1] >= 0.0)


# Against an exact answer --------------------------------------------------------------------------------------


def apex_after(height: float, energy: float, angle: float) -> float:
    """Return the height of the next apex above the same ground, by SciPy; nan if there is none."""
    level = LENGTH * math.cos(angle)
    if height < level:
        return math.nan
    speed_x = math.sqrt(max(2.0 * (energy / MASS - GRAVITY * height), 0.0))
    start = [-LENGTH * math.sin(angle), level, speed_x, -math.sqrt(2.0 * GRAVITY * (height - level))]

    def rates(_: float, y: NDArray[np.float64]) -> list[float]:
        x, h, vx, vy = y
        length = math.hypot(x, h)
        pull = STIFFNESS / MASS * (LENGTH / length - 1.0)
        return [vx, vy, pull * x, pull * h - GRAVITY]

    def lifts(_: float, y: NDArray[np.float64]) -> float:
        return math.hypot(y[0], y[1]) - LENGTH

    def falls(_: float, y: NDArray[np.float64]) -> float:
        return float(y[1]) - 1e-3

    lifts.terminal, lifts.direction, falls.terminal = True, 1.0, True  # type: ignore[attr-defined]
    run = solve_ivp(rates, (0.0, 3.0), start, events=[lifts, falls], method="DOP853", rtol=1e-10, atol=1e-12)
    if not len(run.t_events[0]):
        return math.nan
    _, h, vx, vy = run.y[:, -1]
    return float(h + vy**2 / (2.0 * GRAVITY)) if vy > 0.0 and vx > 0.0 else math.nan


def expected_steps(height: float, energy: float, angle: float, spread: float) -> float:
    """Return how many steps a runner takes on ground of uniformly random height until it falls: a matrix's answer."""
    level, nodes = LENGTH * math.cos(angle), np.polynomial.legendre.leggauss(24)
    largest = math.sqrt(3.0) * spread
    grounds, weights = largest * nodes[0], 0.5 * nodes[1]
    heights = np.linspace(level, level + 0.12, 121)
    energies = np.linspace(energy - MASS * GRAVITY * largest, energy + MASS * GRAVITY * largest, 9)
    table = np.array(
        [[apex_after(float(h), float(e), angle) for e in energies] for h in np.linspace(level, level + 0.14, 57)]
    )
    after = RegularGridInterpolator((np.linspace(level, level + 0.14, 57), energies), table, bounds_error=False)
    matrix = np.zeros((len(heights), len(heights)))
    for ground, weight in zip(grounds, weights, strict=True):
        above = heights - ground
        there = above >= level
        new = ground + after(np.column_stack([above, np.full(len(above), energy - MASS * GRAVITY * ground)]))
        for row in np.flatnonzero(there & np.isfinite(new)):
            place = (new[row] - heights[0]) / (heights[1] - heights[0])
            if 0.0 <= place < len(heights) - 1:
                low = int(place)
                matrix[row, low] += weight * (1.0 - place + low)
                matrix[row, low + 1] += weight * (place - low)
    steps = np.linalg.solve(np.eye(len(heights)) - matrix, np.ones(len(heights)))
    return float(np.interp(height, heights, steps))


def test_steps_to_failure_are_those_of_a_map_with_noise(runner: Gait) -> None:
    """The apex map of the runner, on ground whose height changes from step to step: a transition matrix is exact."""
    spread = 0.004
    found = ls.rough(runner, {"height": spread}, runs=4000, strides=400, distribution="uniform", seed=3)
    assert np.all(found["fate"] != 0)
    angle = math.pi + runner.animal.legs[0].angle
    exact = expected_steps(runner.apex_height, runner.energy, angle, spread)
    steps = found["steps"].values[0].astype(float)
    standard_error = steps.std() / math.sqrt(len(steps))
    assert abs(steps.mean() - exact) < 3.5 * standard_error + 0.02 * exact
    assert float(found["expected_steps"][0]) == pytest.approx(steps.mean())


# Statistics ---------------------------------------------------------------------------------------------------


def test_intervals_hold_what_is_true_as_often_as_they_say() -> None:
    rng, true = np.random.default_rng(2), 40.0
    lives = rng.exponential(true, (2000, 30))
    exposure, failed = np.minimum(lives, 60.0).sum(axis=1), (lives < 60.0).sum(axis=1)
    expected, low, high = hazard(exposure, failed)
    assert expected.mean() == pytest.approx(true, rel=0.05)
    assert ((low < true) & (true < high)).mean() == pytest.approx(0.95, abs=0.02)
    low, high = wilson(rng.binomial(50, 0.2, 4000), 50)
    assert ((low < 0.2) & (high > 0.2)).mean() == pytest.approx(0.95, abs=0.02)
    nothing = hazard(np.array([100.0]), np.array([0]))
    assert math.isnan(nothing[0][0]) and nothing[1][0] > 20.0 and math.isnan(nothing[2][0])


def test_more_roughness_is_survived_less(flat: Gait) -> None:
    found = ls.rough(flat, {"slope_deg": 10.0}, runs=100, strides=30, scales=(0.5, 1.0, 2.0, 4.0))
    last = found["survival"].values[:, -1]
    assert all(one >= other for one, other in pairwise(last)) and last[0] == 1.0 and last[-1] < 0.5
    assert found.attrs["largest_scale"] in (1.0, 2.0)
    assert np.all(found["survival_low"] <= found["survival"]) and np.all(found["survival"] <= found["survival_high"])


def test_errors_say_what_would_be_valid(flat: Gait, runner: Gait) -> None:
    for gait, kinds, options, words in (
        (flat, {}, {}, "roughness = {}: must name one or more of slope_deg"),
        (flat, {"wind": 1.0}, {}, "roughness = 'wind': must be"),
        (flat, {"height": 0.01}, {}, "'height' must be left out"),
        (runner, {"miss": 0.1}, {}, "'miss' must be left out where no leg goes by the clock"),
        (flat, {"miss": 1.5}, {}, "must be from 0 to 1"),
        (flat, {"slope_deg": -1.0}, {}, "must be from 0 to 90"),
        (flat, {"slope_deg": 1.0}, {"correlation": 1.0}, "correlation = 1: must be from 0 to below 1"),
        (flat, {"slope_deg": 1.0}, {"distribution": "cauchy"}, "distribution = 'cauchy': must be"),
        (flat, {"slope_deg": 1.0}, {"scales": [2.0, 1.0]}, "scales = "),
        (flat, {"slope_deg": 1.0}, {"runs": 1_000_000}, "runs = 1000000, strides = 100: must be of 100,000,000 steps"),
    ):
        with pytest.raises(ValueError, match=words):
            ls.rough(gait, kinds, **options)
