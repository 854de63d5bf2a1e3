"""The total energy, against the one that a simulation's time series give."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
import xarray as xr

import legspring as ls
from legspring import Animal, Gait, load_animal
from legspring.flow import SEEN, flow
from legspring.kernel.walker import Floats
from tests.places import place_of


def energies(animal: Animal, run: xr.Dataset) -> Floats:
    """Total energy at the samples of a simulation, J; from above without that of the height."""
    mass, inertia = animal.body.mass, animal.body.inertia or 0.0
    stiffness = np.array([leg.stiffness for leg in animal.legs])
    stretch = (run["leg_length"] - run["free_length"]).fillna(0.0).values
    energy = 0.5 * mass * np.sum(run["velocity"].values ** 2, axis=1) + 0.5 * np.sum(stiffness * stretch**2, axis=1)
    energy += 0.5 * inertia * run["yaw_rate"].values ** 2
    if animal.sagittal:
        ground = run["foot"].values[0, 0, 1]
        energy += mass * animal.gravity * (run["position"].values[:, 1] - ground)
    return np.asarray(energy)


def gaits_of(animal: Animal) -> Sequence[Gait]:
    return ls.find_gaits(animal, **place_of(animal))


@pytest.mark.parametrize("name", ls.presets())
def test_it_is_that_of_the_time_series(name: str) -> None:
    for gait in gaits_of(load_animal(name)):
        series = energies(gait.animal, gait.simulate(strides=1))
        assert gait.energy == pytest.approx(series[0], rel=1e-12)
        assert gait.energy == pytest.approx(series[-1], rel=1e-6)
        if "energy" in gait.conserved:
            np.testing.assert_allclose(series, gait.energy, rtol=1e-6)


def test_the_runner_has_the_energy_of_its_apex() -> None:
    """At its highest point a runner has but speed and height: numbers of another origin are in `test_periodic`."""
    gait = ls.find_gaits(load_animal("spring_loaded_inverted_pendulum"))[0]
    leg, mass, g = gait.animal.legs[0], gait.animal.body.mass, gait.animal.gravity
    height = leg.length * math.sin(math.radians(68.0))
    assert gait.energy == pytest.approx(0.5 * mass * gait.speed**2 + mass * g * height)


def test_legs_that_are_still_down_count() -> None:
    gait = ls.find_gaits(load_animal("cockroach_rigid"), slope_deg=45, heading=0.15)[0]
    turning = 0.5 * gait.animal.body.inertia * gait.yaw_rate**2  # type: ignore[operator]
    assert gait.duty_factor.max() > 0.5
    assert gait.energy > 0.5 * gait.animal.body.mass * gait.speed**2 + turning + 1e-9


@pytest.mark.parametrize(
    ("name", "slope_deg"), [("walker", 0.0), ("driven", 2.0), ("quadruped", 0.0), ("centipede", 0.0)]
)
def test_what_is_asked_for_is_what_is_measured(name: str, slope_deg: float) -> None:
    """The solver observes energy and its derivatives by itself: at the end of a period they are those of the start."""
    if name == "driven":
        animal = load_animal("spring_loaded_inverted_pendulum").replace(actuation=0.05, phase=-0.5, damping=60.0)
    else:
        animal = load_animal(name)
    gait = ls.find_gaits(animal, slope_deg=slope_deg)[0]
    names = ["mass", "gravity", "step_duration", "speed", "slope"]
    steps = gait.system.period
    seen = flow(gait.system, gait.point, steps=steps, along=names, everything=True, accuracy=1e-13).seen
    row = SEEN.index("energy")
    assert seen[row, 0] == pytest.approx(gait.energy, rel=1e-9)
    for column, parameter in enumerate(names, start=1):
        way, size = gait.system.direction(parameter), max(abs(gait.point[gait.system.place_of(parameter)]), 0.1)
        h = 1e-5 * size
        ends = [
            flow(gait.system, gait.point + sign * h * way, steps=steps, everything=True, accuracy=1e-13).seen[row, 0]
            for sign in (1.0, -1.0)
        ]
        difference = (ends[0] - ends[1]) / (2.0 * h)
        assert seen[row, column] * size == pytest.approx(difference * size, rel=1e-5, abs=1e-6 * gait.energy)


def sums(run: xr.Dataset) -> tuple[float, float]:
    """Return the greatest energy of a run, and its largest error of balance."""
    held = run["kinetic_energy"] + abs(run["potential_energy"]) + run["spring_energy"].sum("leg")
    return float(held.max()), float(abs(run["energy_balance"]).max())


@pytest.mark.parametrize("name", ls.presets())
def test_every_joule_is_accounted_for(name: str) -> None:
    for gait in gaits_of(load_animal(name))[:2]:
        run = gait.simulate(strides=2)
        greatest, error = sums(run)
        assert error < 2e-9 * greatest
        # In a gait the body has at the end what it had at the start, but for its height.
        climbed = float(run["potential_energy"][-1])
        made = float(run["actuation_work"][-1].sum() - run["lost_energy"][-1])
        assert made == pytest.approx(climbed, abs=2e-9 * greatest)
        whole = energies(gait.animal, run) + (0.0 if gait.animal.sagittal else run["potential_energy"].values)
        parts = run["kinetic_energy"] + run["potential_energy"] + run["spring_energy"].sum("leg")
        np.testing.assert_allclose(parts - parts[0], whole - whole[0], atol=1e-12 * greatest)


@pytest.mark.parametrize("name", ["cockroach", "cockroach_rigid", "climbing_template", "single_leg"])
def test_a_push_does_work_and_that_is_all(name: str) -> None:
    run = gaits_of(load_animal(name))[0].recover(0.4).simulate()
    greatest, error = sums(run)
    assert error < 1e-9 * greatest and abs(float(run["push_work"][-1])) > 1e-4 * greatest


def test_what_dampers_and_loaded_legs_take(roach: Animal) -> None:
    gait = ls.find_gaits(roach, slope_deg=45, heading=0.15)[0]
    start: dict[str, Any] = {
        "slope_deg": 45,
        "heading": 0.15,
        "speed": gait.speed,
        "phase": gait.phase,
        "family": gait.family,
    }
    whole = ls.simulate(roach, **start)
    assert float(abs(whole["lost_energy"]).max()) < 1e-12
    for other in (roach.replace(damping=0.005), roach.replace(stance=(0.4, 0.4, 0.4))):
        run = ls.simulate(other, **start)
        lost, (greatest, error) = run["lost_energy"].values, sums(run)
        assert lost[-1] > 1e-3 * greatest and np.min(np.diff(lost)) > -1e-12 * greatest
        assert error < 1e-9 * greatest


def test_work_of_the_actuation_by_other_means(roach: Animal) -> None:
    """By the trapezoidal rule, from forces and lengths of the time series."""
    run = ls.find_gaits(roach, slope_deg=45, heading=0.15)[0].simulate(strides=1)
    weight = roach.body.mass * roach.gravity
    for leg in ("FL", "MR", "BL"):
        one = run.sel(leg=leg)
        along = one["force"].values / np.hypot(*one["force"].values.T).clip(1e-300)[:, None]
        direction = (one["foot"] - one["hip"]).values
        pull = np.sign(np.nansum(along * direction, axis=1)) * np.hypot(*one["force"].values.T)
        length = np.nan_to_num(one["free_length"].values)
        down = one["stance"].values[1:] & one["stance"].values[:-1]
        work = -weight * 0.5 * (pull[1:] + pull[:-1]) * np.diff(length) * down
        assert np.sum(work) == pytest.approx(float(one["actuation_work"][-1]), rel=2e-3)


@pytest.mark.parametrize("slope_deg", [-10.0, 10.0])
def test_on_slopes_seen_from_the_side(slope_deg: float) -> None:
    runner = load_animal("spring_loaded_inverted_pendulum")
    run = ls.simulate(runner, slope_deg=slope_deg, heading=-1.7, speed=5.0, strides=1)
    greatest, error = sums(run)
    assert error < 1e-9 * greatest
    # Up is where gravity does not pull: in flight, energy is that of the height.
    slope, place = math.radians(slope_deg), run["position"].values - run["position"].values[0]
    height = place @ np.array([math.sin(slope), math.cos(slope)])
    weight = runner.body.mass * runner.gravity
    np.testing.assert_allclose(run["potential_energy"], weight * height, atol=1e-12 * greatest)


def test_a_leg_without_work_does_none_to_the_last_digit() -> None:
    for speed in np.linspace(0.3, 0.6, 16):
        for gait in ls.find_gaits(load_animal("lateral_leg_spring"), speed=float(speed)):
            done, taken = gait.work.sum(axis=0)
            assert done + taken == pytest.approx(0.0, abs=1e-9 * done)
