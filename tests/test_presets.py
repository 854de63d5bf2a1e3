"""Every preset: its gaits against the oracle, and what the commands make of it."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import legspring as ls
from legspring import Gait, load_animal
from tests.oracle import heyoka_rules
from tests.oracle.animals import START, before_of, states_of, walker_of
from tests.places import place_of
from tests.test_cli import error, records, run

each = pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.long] * (name == "centipede")) for name in ls.presets()]
)
UPRIGHT = [name for name in ls.presets() if name not in ("walker", "quadruped")]
"""Those that do not fall from any start."""


def place(name: str) -> dict[str, float]:
    """Where to look for gaits: nothing that the animal does without."""
    animal = load_animal(name)
    low, high = animal.speed_law.domain_deg
    somewhere = place_of(animal)
    slope = somewhere.pop("slope_deg")
    return ({} if low == high or animal.sagittal else {"slope": slope}) | somewhere


def options(name: str) -> list[str]:
    """The same on the command line."""
    return [word for option, value in place(name).items() for word in (f"--{option}", str(value))]


@pytest.fixture(scope="module")
def gaits() -> dict[str, Gait]:
    """The first gait of each preset."""
    found = {}
    for name in ls.presets():
        where = place(name)
        found[name] = ls.find_gaits(load_animal(name), slope_deg=where.get("slope"), heading=where.get("heading"))[0]
    return found


@each
def test_a_preset_says_what_it_is(name: str) -> None:
    animal = load_animal(name)
    assert 20 < len(animal.summary) <= 100
    assert animal.summary.endswith(")"), "ends with its source, in brackets"
    assert animal.source


@each
def test_first_gait_against_the_oracle(name: str, gaits: dict[str, Gait]) -> None:
    gait = gaits[name]
    system = gait.system
    phases = {leg.name: gait.phase[pair] for leg, pair in zip(gait.animal.legs, gait.animal.pair_of, strict=True)}
    start = dict(zip(START, gait.point.tolist(), strict=False))
    given = gait.animal, gait.slope, gait.family, start, phases
    before = before_of(gait)
    expected = heyoka_rules.simulate(walker_of(*given, before), system.steps_per_stride)
    states = states_of(*given, system.steps_per_stride, before)[:, :6]
    speed = system.desired_speed
    scale = np.array([system.step_length, system.step_length, speed, speed, 1.0, 1.0 / system.step_duration])
    ours = gait.stride.states / scale[: system.rows]
    np.testing.assert_allclose(ours, (states / scale)[:, : system.rows], rtol=0, atol=1e-10)
    kinds = {"touchdown": "touch-down", "liftoff": "lift-off"}
    words = [f"{gait.animal.legs[leg].name} {kinds[kind]}" for leg, kind in expected.sequence]
    assert sorted(gait.events) == sorted(words)
    # By the oracle alone it is a gait.
    ends = (states / scale)[[0, -1], 2:]
    np.testing.assert_allclose(ends[1], ends[0], rtol=0, atol=1e-9)


@each
def test_gaits(name: str, gaits: dict[str, Gait]) -> None:
    animal, gait = load_animal(name), gaits[name]
    first = records("gaits", name, *options(name))[0]
    assert (first["speed"], first["heading"]) == pytest.approx((gait.speed, gait.heading))
    assert first["mean_speed"] == pytest.approx(gait.mean_speed)
    assert (first["reduced_eigenvalue"] is None) == (not (animal.tuned and gait.straight))
    shown = run("gaits", name, *options(name)).stdout.splitlines()
    assert shown[0].startswith(f"{name}: slope {gait.slope_deg:g} deg")
    assert max(map(len, shown[:7])) <= 80
    assert f" {gait.speed:.4f} " in shown[5]
    assert "heading" in place(name) or f" {gait.heading:.4f} " in shown[5]
    assert "nan" not in "".join(shown)


@each
def test_simulate(name: str, gaits: dict[str, Gait], tmp_path: Path) -> None:
    gait = gaits[name]
    (found,) = records("simulate", name, *options(name), "--strides", "2", "--figure", tmp_path / "run.png")
    assert found["speed"] == pytest.approx(gait.speed)
    assert np.hypot(*found["velocity"]) == pytest.approx(gait.speed, rel=1e-9)
    assert np.hypot(*found["displacement"]) == pytest.approx(2 * gait.system.steps_per_stride * gait.distance, rel=1e-6)
    assert (tmp_path / "run.png").exists()


@pytest.mark.parametrize("name", [name for name in UPRIGHT if not load_animal(name).tuned])
def test_simulate_a_start_with_the_phases_that_are_given(name: str) -> None:
    slope = [] if "slope" not in place(name) else ["--slope", "45"]
    heading = "-1.65" if load_animal(name).sagittal else "0.05"
    speed = load_animal(name).speed_law.level
    slope += ["--family", "B"] if len(load_animal(name).families) > 1 else []
    (found,) = records("simulate", name, *slope, "--speed", str(speed), "--heading", heading, "--strides", "1")
    assert (found["branch"], found["speed"]) == (None, speed)
    assert found["phase"] == list(load_animal(name).phase)


@each
def test_recover(name: str, tmp_path: Path) -> None:
    arguments = ["recover", name, *options(name), "--impulse", "0.01"]
    if load_animal(name).conservative:
        assert error(*arguments) == (
            f"animal = '{name}': must have legs that do work, or lose some, to come back from a push; this one "
            "conserves energy and keeps what it is given"
        )
    else:
        (found,) = records(*arguments, "--figure", tmp_path / "recovery.png")
        assert found["recovered"] == (found["steps"] is not None)
        assert len(found["distance"]) == 101


@each
def test_atlas(name: str, tmp_path: Path) -> None:
    animal, out = load_animal(name), tmp_path / "a.nc"
    arguments = ["atlas", name, "--out", str(out), "--slopes", "90", "--headings", "0.4", "--no-recovery"]
    if animal.tuned:
        # One phase goes with the desired speed; a heading takes something else.
        free = ["--free", "T.angle"] if name == "effective_leg" else []
        assert run(*arguments, *free).stdout.endswith(" gaits in 1 of 1 cells\n")
        return
    assert error(*arguments).startswith(
        f"animal = '{name}': must have actuated legs whose phases are not given for a map over slope and heading; "
        "other maps take over="
    )
    slope = place(name).get("slope")
    where = ["--slope", str(slope)] if slope is not None else []
    mass = animal.body.mass
    words = run("atlas", name, "--out", str(out), *where, "--over", f"mass={0.99 * mass},{mass}").stdout
    assert words.endswith("of 2 cells\n")
    with xr.open_dataset(out) as maps:
        assert maps["mean_speed"].dims == ("mass", "branch")
        assert ("missing" in maps["recovery_steps"].attrs) == animal.conservative


DRIVEN = ("single_leg", "climbing_template", "cockroach_rigid")
"""Those whose actuation is worth optimising with the thesis's constraints; the cockroach is optimised elsewhere."""


@pytest.mark.parametrize("name", [name for name in ls.presets() if not any(load_animal(name).actuation)])
def test_nothing_to_optimize(name: str) -> None:
    reason = "must have legs with an actuation for it to be optimised"
    assert error("optimize", name, *options(name)) == f"animal = '{name}': {reason}"


@pytest.mark.parametrize("name", DRIVEN)
def test_optimize(name: str, gaits: dict[str, Gait]) -> None:
    (best,) = records("optimize", name, *options(name), *(["--family", "B"] if name == "cockroach_rigid" else []))
    assert best["penalised"] < abs(gaits[name].multipliers[0])
    assert best["value"] == pytest.approx(best["max_multiplier"])


def test_presets_are_listed_one_a_line() -> None:
    head, *lines = run("presets").stdout.splitlines()
    assert head.split() == ["animal", "pairs", "families", "summary"]
    assert [line.split()[0] for line in lines] == list(ls.presets())
    for line in lines:
        animal = load_animal(line.split()[0])
        assert line.endswith(animal.summary)
        assert f"  {', '.join(animal.pairs)}  " in line and f"  {', '.join(animal.families)}  " in line
    listed = records("presets")
    assert [animal["name"] for animal in listed] == list(ls.presets())
    assert all(animal["source"] == load_animal(animal["name"]).source for animal in listed)


@pytest.mark.long
def test_presets_are_drawn(tmp_path: Path) -> None:
    result = run("presets", "--figure", tmp_path / "all.png", "--figures", tmp_path / "each")
    assert result.exit_code == 0
    assert (tmp_path / "all.png").read_bytes().startswith(b"\x89PNG")
    assert sorted(file.stem for file in (tmp_path / "each").iterdir()) == list(ls.presets())


BAD = {
    "gaits cockroach --heading 0.1": "--slope is missing: must be an angle from -90 to 90 degrees",
    "gaits cockroach --slope 45": "heading is missing: must be an angle in rad, within +-pi/2",
    "recover cockroach --slope 45": "heading is missing: must be an angle in rad, within +-pi/2",
    "optimize cockroach --slope 45": "heading is missing: must be an angle in rad, within +-pi/2",
    "simulate cockroach": "--slope is missing: must be an angle from -90 to 90 degrees",
    "gaits single_leg --slope 45 --heading 0.1": "animal = 'single_leg': has 3 unknowns (speed, Dx, Dy) for 4 ",
    "gaits lateral_leg_spring --energy -1": "energy = -1.0: must be a positive number (J, at the start of a step)",
    "gaits lateral_leg_spring --apex-height 1": "apex_height = 1.0: must be left out for an animal that is seen from ",
    "gaits lateral_leg_spring --free colour": "free = 'colour': must be one of",
    "gaits lateral_leg_spring --slope 10": "slope = 10 deg: must be 0 deg",
    "gaits lateral_leg_spring --family A": "family = 'A': must be one of P",
    "gaits climbing_template --actuation 0.01": (
        "--actuation = '0.01': must be left out; gaits of climbing_template have the animal's"
    ),
    "simulate lateral_leg_spring --branch 3": "--branch = 3: must be one of 0",
    "simulate lateral_leg_spring --speed 0.5": "a start that is no gait must have --speed and --heading",
    "simulate lateral_leg_spring --phase 10": "a start that is no gait must have --speed and --heading",
    "simulate lateral_leg_spring --speed 0.5 --heading 0.1 --branch 0": (
        "--branch = 0: must be left out for a start that is no gait"
    ),
    "simulate lateral_leg_spring --speed 0.5 --heading 0.1 --phase 1,2": (
        "--phase = '1,2': must be one angle for each of T, in degrees"
    ),
    "simulate lateral_leg_spring --speed 0.5 --heading 4": (
        "heading = 4.0: must be a finite angle within +-3.142 rad (180 deg)"
    ),
    "simulate spring_loaded_inverted_pendulum --strides 0.5": "strides = 0.5: must be a whole number, up to 2000",
}


@pytest.mark.parametrize("arguments", BAD)
def test_arguments_that_an_animal_does_not_take(arguments: str) -> None:
    assert error(*arguments.split()).startswith(BAD[arguments])
