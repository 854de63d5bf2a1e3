import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner, Result

import legspring as ls
from legspring.cli import app, parse_grid
from legspring.files import SAVERS
from legspring.printing import plain

HERE = ["--slope", "45", "--heading", "0.15"]
NO_GAIT = ["--slope", "40", "--heading", "0.45"]
PROGRAM = "from legspring.__main__ import main; main()"


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def records(*arguments: str | Path) -> list[dict[str, Any]]:
    """Return what a command prints with --json, which must be all that it prints."""
    result = run(*arguments, "--json")
    assert (result.exit_code, result.stderr) == (0, "")
    found = json.loads(result.stdout, parse_constant=pytest.fail)
    assert isinstance(found, list)
    return found


def error(*arguments: str | Path, status: int = 2) -> str:
    """Return the one line that a command ends with."""
    result = run(*arguments)
    assert result.exit_code == status
    assert result.stdout == ""
    assert result.stderr.startswith("legspring: ")
    assert result.stderr.count("\n") == 1
    return result.stderr.removeprefix("legspring: ").strip()


@pytest.fixture(scope="session")
def gait() -> ls.Gait:
    return ls.find_gaits(ls.cockroach(), slope_deg=45, heading=0.15)[0]


@pytest.mark.parametrize(
    "command",
    ["gaits", "simulate", "recover", "atlas", "presets", "follow", "basin", "push", "rough", "pareto", "sweep"],
)
def test_every_command_has_help_with_an_example(command: str) -> None:
    result = run(command, "--help")
    assert result.exit_code == 0
    assert f"Example: legspring {command}" in result.stdout


def test_help_and_version() -> None:
    assert run("--version").stdout.strip() == f"legspring {ls.__version__}"
    shown = run("--help").stdout
    assert "degrees" in shown and "radians" in shown
    assert run().stdout == shown


def test_help_imports_nothing_heavy() -> None:
    heavy = {"numba", "numpy", "scipy", "xarray", "pandas", "matplotlib", "netCDF4", "pydantic"}
    code = f"import atexit, sys; atexit.register(lambda: print(sorted({heavy} & set(sys.modules)))); {PROGRAM}"
    done = subprocess.run([sys.executable, "-c", code, "--help"], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_gaits_as_json_have_the_attributes_of_a_gait(gait: ls.Gait) -> None:
    first, second = records("gaits", "cockroach", *HERE)
    assert [first["branch"], second["branch"]] == [0, 1]
    for name in ("family", "slope_deg", "heading", "speed", "residual", "drift", "grazing", "transport_cost"):
        assert first[name] == pytest.approx(getattr(gait, name))
    for name in ("phase", "actuation", "liftoff", "peak_force"):
        np.testing.assert_allclose(first[name], getattr(gait, name))
    np.testing.assert_allclose(first["net_force_max"], gait.net_force[0])
    np.testing.assert_allclose(first["net_force_min"], gait.net_force[1])
    np.testing.assert_allclose([complex(*pair) for pair in first["multipliers"]], gait.multipliers, atol=1e-12)
    assert first["reduced_eigenvalue"] == pytest.approx(gait.reduced_eigenvalue)


def test_gaits_as_a_table(gait: ls.Gait) -> None:
    shown = run("gaits", "cockroach", *HERE).stdout
    assert "slope 45 deg, heading 0.15 rad" in shown
    assert f"{gait.speed:.4f}" in shown
    assert "-2.8, 31.6, -38.3" in shown
    assert ls.search_gaits(ls.cockroach(), slope_deg=45, heading=0.15).summary() in shown
    assert max(map(len, shown.splitlines()[:8])) <= 80


def test_gaits_of_a_body_that_yaws() -> None:
    steep = ("gaits", "cockroach_rigid", "--slope", "90", "--heading", "0.4")
    (first, *_) = records(*steep)
    assert 0.0 < abs(first["yaw"]) <= first["yaw_amplitude"] < 0.2
    assert first["yaw_rate"] != 0.0 and first["peak_moment"] > 0.0
    shown = run(*steep).stdout.splitlines()
    assert f" {first['yaw_amplitude']:.3f} " in shown[5]
    assert "branch family" in shown[3] and max(map(len, shown[:8])) <= 80, "columns are neither cut nor too wide"


def test_where_there_is_no_gait_the_list_is_empty_and_the_reason_is_said() -> None:
    assert records("gaits", "cockroach", *NO_GAIT) == []
    assert records("gaits", "cockroach", *HERE, "--family", "A") == []
    result = run("gaits", "cockroach", *NO_GAIT)
    assert result.exit_code == 0
    assert result.stdout.startswith("no gait at slope 40 deg and heading 0.45 rad; ")
    assert len(result.stdout) > 60


def test_family_and_actuation_narrow_the_gaits() -> None:
    assert [gait["family"] for gait in records("gaits", "cockroach", *HERE, "--family", "B")] == ["B", "B"]
    stronger = records("gaits", "cockroach", *HERE, "--actuation", "0.017,0.013,0.0095")
    assert stronger[0]["actuation"] == [0.017, 0.013, 0.0095]


def test_an_animal_from_a_file(tmp_path: Path, gait: ls.Gait) -> None:
    (tmp_path / "heavy.toml").write_text('like = "cockroach"\nmass = 3e-3\nstiffness = [1.5, 1.5, 2.0]\n')
    heavy = ls.cockroach().replace(mass=3e-3, stiffness=[1.5, 1.5, 2.0])
    expected = ls.find_gaits(heavy, slope_deg=45, heading=0.15)[0]
    found = records("gaits", tmp_path / "heavy.toml", *HERE)[0]
    assert found["speed"] == pytest.approx(expected.speed, rel=1e-9)
    assert found["speed"] != pytest.approx(gait.speed, rel=1e-3)


def test_simulate_a_gait(tmp_path: Path, gait: ls.Gait) -> None:
    (found,) = records("simulate", "cockroach", *HERE, "--strides", "3", "--out", tmp_path / "run.nc")
    assert (found["family"], found["branch"], found["strides"]) == ("B", 0, 3.0)
    assert found["speed"] == pytest.approx(gait.speed)
    assert found["displacement"] == pytest.approx([0.0, 6 * gait.system.step_length], abs=1e-9)
    with xr.open_dataset(tmp_path / "run.nc") as stored:
        np.testing.assert_allclose(stored["position"], gait.simulate(3)["position"], atol=1e-9)
        assert stored["event_leg"].values[0] == "BR"


def test_simulate_any_start_into_a_table(tmp_path: Path) -> None:
    start = ["--slope", "0", "--heading", "0.15", "--speed", "0.375", "--phase", "63,4,-49", "--family", "A"]
    (found,) = records("simulate", "cockroach", *start, "--out", tmp_path / "run.csv")
    assert found["branch"] is None
    expected = ls.simulate(
        ls.cockroach(), slope_deg=0, heading=0.15, speed=0.375, phase=[*np.radians([63, 4, -49])], family="A"
    )
    header = (tmp_path / "run.csv").read_text().splitlines()[0].split(",")
    table = dict(zip(header, np.loadtxt(tmp_path / "run.csv", delimiter=",", skiprows=1).T, strict=True))
    np.testing.assert_allclose(table["time (s)"], expected["time"])
    np.testing.assert_allclose(table["position_fore_aft (m)"], expected["position"].sel(axis="fore_aft"), atol=1e-12)
    np.testing.assert_allclose(
        table["force_ML_lateral (m g)"], expected["force"].sel(leg="ML", axis="lateral"), atol=1e-12
    )
    np.testing.assert_array_equal(table["stance_FL"], expected["stance"].sel(leg="FL"))
    np.testing.assert_allclose(table["leg_length_BR (m)"], expected["leg_length"].sel(leg="BR"), atol=1e-12)


def test_simulate_says_where_it_ended() -> None:
    shown = run("simulate", "cockroach", *HERE).stdout
    assert "family B, slope 45 deg" in shown
    assert "after 2 strides" in shown and "heading 0.1500 rad" in shown


def test_follow(tmp_path: Path) -> None:
    steep = ["follow", "cockroach", "--slope", "40", "--heading", "0.4", "--along", "heading", "--to", "0.6"]
    files = [tmp_path / f"curve.{suffix}" for suffix in ("nc", "csv", "png")]
    result = run(*steep, "--out", files[0], "--figure", files[2], "--quantity", "phase_B")
    assert (result.exit_code, result.stderr) == (0, "")
    assert "0.4382000525  fold" in result.stdout and result.stdout.splitlines()[-1].startswith(
        "ends: the stance of a leg"
    )
    with xr.open_dataset(files[0]) as data:
        assert data.attrs["followed"] == "heading" and float(data["heading"].max()) > 0.437
    assert files[2].stat().st_size > 10_000
    found = records(*steep, "--out", files[1])
    (fold,) = (one for one in found if one["kind"] == "fold")
    assert fold["value"] == pytest.approx(0.4382000525, abs=1e-9) and found[-1]["kind"] == "end"
    rows = files[1].read_text().splitlines()
    assert "heading (rad)" in rows[0] and len(rows) > 20
    several = run("follow", "cockroach", *HERE, "--along", "F.stiffness,M.stiffness", "--to", "1.1")
    assert several.stdout.splitlines()[-1] == "ends: the value asked for is reached, at 1.1"
    for options, words in (
        (["--along", "wings"], "parameter = 'wings': must be one of"),
        (["--along", "heading", "--within", "0,1,2"], "--within = '0,1,2': must be two numbers"),
        (["--along", "heading", "--to", "0.15"], "to = 0.15: must be another value than 0.15"),
        (["--along", "heading", "--out", "curve.txt"], "curve.txt: must end in"),
    ):
        assert words in error("follow", "cockroach", *HERE, *options)


def test_basin(tmp_path: Path) -> None:
    over = ["--over", "speed=0.1:1.5:0.2", "--over", "heading=-1.5,0,1.5"]
    here = ["basin", "cockroach", "--slope", "15", "--heading", "0.2", *over]
    found = records(*here)
    assert found[0]["outcome"] == "the gait" and sum(one["share"] for one in found) == pytest.approx(1.0)
    assert found[1]["periods"] > 1.0
    files = [tmp_path / name for name in ("basin.nc", "basin.png")]
    shown = run(*here, "--out", files[0], "--figure", files[1]).stdout
    assert "speed (8) and heading (3), old feet kept" in shown and "the gait" in shown
    with xr.open_dataset(files[0]) as data:
        assert data["settles_on"].shape == (8, 3)
    assert files[1].stat().st_size > 1000
    for options, words in (
        (["--over", "wings=1:2:1"], "must be one of"),
        (["--over", "speed"], "must be NAME=START:STOP:STEP"),
        (["--over", "speed=0.2", "--memory", "lost"], "must be 'kept' or 'rebuilt'"),
        (["--over", "speed=0.2", "--out", "basin.txt"], "must end in .nc, .mat"),
    ):
        assert words in error("basin", "cockroach", *HERE, *options)


def test_push(tmp_path: Path) -> None:
    here = ["push", "cockroach", "--slope", "15", "--heading", "0.2", "--directions", "4", "--moments", "2"]
    found = records(*here, "--impulses", "1,5")
    assert len(found) == 8 and all(one["survived"] > 0.0 for one in found)
    files = [tmp_path / name for name in ("pushes.nc", "pushes.png")]
    shown = run(*here, "--impulses", "1,5", "--out", files[0], "--figure", files[1]).stdout
    assert "pushes up to 5 m v_des at 2 moments of a stride" in shown and "270" in shown
    assert files[1].stat().st_size > 1000
    with xr.open_dataset(files[0]) as data:
        assert data["survived"].shape == (4, 2)
    assert "must be above 0" in error("push", "cockroach", *HERE, "--impulses", "0,1")
    assert "keeps what it is given" in error("push", "spring_loaded_inverted_pendulum")


def test_rough(tmp_path: Path) -> None:
    here = ["rough", "cockroach", "--slope", "15", "--heading", "0.2", "--with", "slope_deg=20", "--runs", "20"]
    found = records(*here, "--scales", "0.1,2", "--strides", "20")
    assert found[0]["survival"] == 1.0 and found[0]["expected_steps"] is None
    assert found[1]["survival"] < 0.5 and found[1]["expected_steps"] < 60.0
    files = [tmp_path / name for name in ("rough.nc", "rough.png")]
    shown = run(*here, "--out", files[0], "--figure", files[1]).stdout
    assert "20 runs of 200 steps with slope_deg 20 deg" in shown
    assert all(file.stat().st_size > 1000 for file in files)
    for options, words in (
        (["--with", "wind=1"], "must be"),
        (["--with", "slope_deg"], "must be NAME=AMOUNT"),
        (["--with", "slope_deg=1", "--correlation", "1"], "must be from 0 to below 1"),
    ):
        assert words in error("rough", "cockroach", *HERE, *options)


def test_pareto(tmp_path: Path) -> None:
    here = ["pareto", "cockroach", "--slope", "10", "--heading", "0.15", "--over", "B.stiffness=1.2:1.8"]
    wanted = ["--minimize", "stability,transport_cost", "--evaluations", "24", "--points", "4"]
    found = records(*here, *wanted, "--bound", "friction=:2", "--store", tmp_path / "kept")
    assert all(1.2 <= one["B.stiffness"] <= 1.8 for one in found)
    assert [one["stability"] for one in found] == sorted(one["stability"] for one in found)
    files = [tmp_path / name for name in ("front.nc", "front.png")]
    shown = run(*here, *wanted, "--out", files[0], "--figure", files[1]).stdout
    assert "least stability, least transport_cost; 24 gaits tried" in shown
    assert "from the best stability to the best transport_cost: B.stiffness" in shown
    assert all(file.stat().st_size > 1000 for file in files)
    for options, words in (
        (["--over", "F.stiffness", *wanted], "must be NAME=LOW:HIGH"),
        (["--over", "F.stiffness=1:x", *wanted], "must be"),
        (["--over", "F.stiffness=1:2"], "must be two criteria or more"),
        (["--over", "F.stiffness=1:2", *wanted, "--bound", "wings=1:"], "must be one of"),
    ):
        assert words in error("pareto", "cockroach", *HERE, *options)


def test_sweep(tmp_path: Path) -> None:
    here = ["sweep", "cockroach", "--slope", "45", "--heading", "0.15", "--follow"]
    grid = ["--over", "slope_deg=42:48:2", "--over", "F.stiffness=1.4,1.5,1.6"]
    files = {kind: tmp_path / f"sweep{kind}" for kind in (".nc", ".csv", ".mat", ".png")}
    for kind in (".nc", ".csv", ".mat"):
        shown = run(*here, *grid, "--store", tmp_path / "runs.zarr", "--out", files[kind]).stdout
        assert shown.startswith("20 gaits at 12 of 12 points\n4: not reached: no solution can be followed there")
    with xr.open_dataset(files[".nc"]) as data:
        assert data["speed"].shape == (4, 3, 2) and float(data["speed"].min()) > 0.2
    rows = files[".csv"].read_text().splitlines()
    assert len(rows) == 25 and rows[0].startswith("slope_deg (degrees),F.stiffness (N/m),branch,")
    assert sum("no solution can be followed there" in row for row in rows) == 4
    run(*here, *grid, "--branch", "1", "--figure", files[".png"], "--draw", "transport_cost")
    assert files[".png"].stat().st_size > 1000
    samples = ["--samples", "8", "--over", "slope_deg=42:48", "--over", "M.stiffness=1.4:1.6"]
    shown = run(*here, *samples, "--figure", tmp_path / "samples.png").stdout
    assert "gaits at 8 of 8 points" in shown
    few: list[str | Path] = ["--heading", "0.7", "--over", "slope_deg=40", "--starts", "2", "--out", files[".nc"]]
    assert run("sweep", "cockroach", *few).stdout.startswith("0 gaits at 0 of 1 points")
    for options, words in (
        ([*grid], "--store, --out or --figure must be given"),
        (["--over", "slope_deg", "--out", files[".nc"]], "must be NAME=START:STOP:STEP"),
        ([*samples[:2], "--over", "slope_deg=1", "--out", files[".nc"]], "must be NAME=LOW:HIGH"),
        ([*grid, "--out", "sweep.txt"], "must end in .nc, .csv, .mat"),
        ([*grid, "--out", files[".nc"], "--measures", "luck"], "must be one of"),
        ([*grid, "--out", files[".nc"], "--cluster", "nowhere"], "must be local, an address"),
    ):
        assert words in error(*here, *options)
    assert "without --follow" in error("sweep", "cockroach", *grid, "--branch", "1", "--out", files[".nc"])


def test_what_branches_off_is_followed_too() -> None:
    result = run("follow", "cockroach", "--slope", "15", "--heading", "0.2", "--along", "heading", "--connected")
    families = [line.split(",")[1].split(":")[0] for line in result.stdout.splitlines() if line.startswith("cockroach")]
    assert {"family A", "family FB", "family MB", "family B"} <= {family.strip() for family in families}


def test_recover(gait: ls.Gait) -> None:
    (found,) = records("recover", "cockroach", *HERE, "--impulse", "-0.3")
    expected = gait.recover(-0.3)
    assert (found["steps"], found["recovered"], found["impulse"]) == (expected.steps, True, -0.3)
    np.testing.assert_allclose(found["distance"], expected.distance, atol=1e-9)
    assert "impulse 0.5 m v_des: back after 9 steps" in run("recover", "cockroach", *HERE).stdout
    assert "branch 1" in run("recover", "cockroach", *HERE, "--branch", "1").stdout


@pytest.mark.parametrize(
    ("command", "option"),
    [
        ("gaits", "--figure"),
        ("gaits", "--footfalls"),
        ("simulate", "--figure"),
        ("simulate", "--footfalls"),
        ("simulate", "--motion"),
        ("simulate", "--energies"),
        ("recover", "--figure"),
    ],
)
def test_figures(tmp_path: Path, command: str, option: str) -> None:
    assert run(command, "cockroach", *HERE, option, tmp_path / "x.png").exit_code == 0
    assert (tmp_path / "x.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("suffix", ["gif", "html", "mp4", "webm"])
def test_a_gait_is_filmed(tmp_path: Path, suffix: str) -> None:
    out = tmp_path / f"run.{suffix}"
    result = run("animate", "cockroach", *HERE, "--strides", "1", "--slow", "10", "--beside", "1", "--out", out)
    assert (result.exit_code, result.stdout) == (0, "")
    assert result.stderr.endswith(f"{out}: 0.92 s, 10 times slower\n")
    assert list(tmp_path.iterdir()) == [out]


@pytest.mark.parametrize("command", ["simulate", "recover"])
def test_what_becomes_of_a_start_is_filmed(tmp_path: Path, command: str) -> None:
    assert run(command, "cockroach", *HERE, "--animation", tmp_path / "x.gif").exit_code == 0
    assert (tmp_path / "x.gif").read_bytes().startswith(b"GIF89a")


def test_what_cannot_be_drawn_is_said(tmp_path: Path) -> None:
    result = run("gaits", "cockroach", *NO_GAIT, "--figure", tmp_path / "x.png", "--footfalls", tmp_path / "y.png")
    said = [f"legspring: there is nothing to draw into {tmp_path / name}" for name in ("x.png", "y.png")]
    assert result.stderr.splitlines() == said and not list(tmp_path.iterdir())


def test_atlas_with_its_figures(tmp_path: Path) -> None:
    grid = ["--slopes", "0:40:20", "--headings", "0.05,0.15"]
    result = run("atlas", "cockroach", "--out", tmp_path / "a.nc", *grid, "--figures", tmp_path / "maps")
    assert result.exit_code == 0, result.stderr
    with xr.open_dataset(tmp_path / "a.nc") as stored:
        np.testing.assert_array_equal(stored["slope_deg"], [0, 20, 40])
        np.testing.assert_array_equal(stored["heading"], [0.05, 0.15])
        count = int((stored["family"] != "").sum())
        assert stored.sizes["impulse"] == 17
    assert result.stdout.splitlines()[0] == f"{tmp_path / 'a.nc'}: {count} gaits in 6 of 6 cells"
    drawn = sorted(file.name for file in (tmp_path / "maps").iterdir())
    assert drawn == [f"figure_4_{number}.png" for number in range(1, 6)]


def test_an_atlas_without_recovery_leaves_figures_out_and_says_so(tmp_path: Path) -> None:
    grid = ["--slopes", "45", "--headings", "0.1", "--no-recovery"]
    result = run("atlas", "cockroach", "--out", tmp_path / "a.nc", *grid, "--figures", tmp_path)
    assert result.exit_code == 0
    left_out = [line.split(":")[0] for line in result.stderr.splitlines()]
    assert left_out == ["left out figure_4_3.png", "left out figure_4_4.png"]
    with xr.open_dataset(tmp_path / "a.nc") as stored:
        assert stored.sizes["impulse"] == 0


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("0:90:45", (0, 45, 90)),
        ("-30:0:20", (-30, -10)),
        ("0:0.45:0.15", (0, 0.15, 0.3, 0.45)),
        ("7,8.5", (7, 8.5)),
        ("3", (3,)),
    ],
)
def test_grids(text: str, expected: tuple[float, ...]) -> None:
    assert parse_grid("--slopes", text) == expected


def test_the_grid_of_an_atlas_is_the_thesis_grid_unless_told_otherwise() -> None:
    from legspring.mapping import HEADINGS, SLOPES_DEG

    assert (parse_grid("--slopes", "0:90:5"), parse_grid("--headings", "0:0.45:0.05")) == (SLOPES_DEG, HEADINGS)
    shown = run("atlas", "--help").stdout
    assert "0:90:5" in shown and "0:0.45:0.05" in shown


@pytest.mark.parametrize("text", ["", "a", "0:1", "0:1:0", "1:0:1", "0:1:-1", "0:1:nan", "0:inf:1", "0:1:1e-9", "1,,2"])
def test_what_is_no_grid(text: str) -> None:
    with pytest.raises(ValueError, match=f"^--slopes = '{text}': must be "):
        parse_grid("--slopes", text)


def test_what_json_cannot_hold() -> None:
    value = [np.array([1.0, np.nan]), 1 + 2j, np.float64(np.inf), None, "x", np.True_]
    assert plain(value) == [[1.0, None], [1.0, 2.0], None, None, "x", True]


BAD = {
    "gaits roach --slope 45 --heading 0.1": "no animal 'roach': must be a preset (centipede, climbing_template, ",
    "gaits nowhere.toml --slope 45 --heading 0.1": "nowhere.toml: No such file or directory",
    "gaits cockroach --slope steep --heading 0.1": "'--slope': 'steep': must be a finite number",
    "gaits cockroach --slope 100 --heading 0.1": "slope_deg = 100.0: must be a finite angle from -90 to 90",
    "gaits cockroach --slope nan --heading 0.1": "'--slope': 'nan': must be a finite number",
    "gaits cockroach --slope 45 --heading 2": "heading = 2.0: must be a finite angle within +-1.571 rad",
    "gaits cockroach --slope 45 --heading 0.1 --family C": "family = 'C': must be one of A, FB, MB, B, or all",
    "gaits cockroach --slope 45 --heading 0.1 --actuation 1,x": "--actuation = '1,x': must be numbers",
    "gaits cockroach --slope 45 --heading 0.1 --actuation 0.1,0.1,0.1": "below the leg's length, 0.032 m",
    "gaits cockroach --slope 45": "heading is missing: must be an angle in rad, within +-pi/2",
    "gaits": "Missing argument 'ANIMAL'.",
    "gates": "No such command 'gates'.",
    "gaits cockroach --slop 45": "No such option",
    "simulate cockroach --slope 45 --heading 0.15 --strides 0.3": "strides = 0.3: must be a multiple of 1/2",
    "simulate cockroach --slope 45 --heading 0.15 --branch 7": "--branch = 7: must be one of 0, 1",
    "simulate cockroach --slope 45 --heading 0.15 --branch x": "'--branch': 'x': must be a whole number",
    "simulate cockroach --slope 45 --heading 0.15 --speed 0.3": "must have --speed, --heading, --phase and --family",
    "simulate cockroach --slope 0 --heading 0 --speed 0.3 --phase 1,2 --family A": "one angle for each of F, M, B",
    "simulate cockroach --slope 0 --heading 0 --speed 0 --phase 1,2,3 --family A": "speed = 0.0: must be a positive",
    "recover cockroach --slope 45 --heading 0.15 --impulse nan": "'--impulse': 'nan': must be a finite number",
    "animate cockroach --slope 45 --heading 0.15": "Missing option '--out'",
    "animate cockroach --slope 45 --heading 0.15 --out a.gif --slow 0": "'0': must be a positive finite number",
    "animate cockroach --slope 45 --heading 0.15 --out a.gif --slow 1e9": "the film has from 2 to 5000 frames",
    "animate cockroach --slope 45 --heading 0.15 --out a.gif --strides 0.3": "strides = 0.3: must be a multiple",
    "animate cockroach --slope 45 --heading 0.15 --out a.gif --beside 7": "--branch = 7: must be one of 0, 1",
    "atlas cockroach --out a.nc --slopes 0:90": "--slopes = '0:90': must be START:STOP:STEP",
    "atlas cockroach --out a.nc --slopes 5,0": "slopes_deg = (5.0, 0.0): must be one or more rising numbers",
    "atlas cockroach --out a.nc --headings x": "--headings = 'x': must be numbers separated by commas",
}


@pytest.mark.parametrize("arguments", BAD)
def test_bad_input_ends_with_one_line(arguments: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert BAD[arguments] in error(*arguments.split())
    assert not list(tmp_path.iterdir())


OUTPUTS = {
    ("gaits", "--figure"): ("x.jpg", "must end in .png, .pdf, .svg"),
    ("simulate", "--out"): ("x.txt", "must end in .nc, .csv, .mat"),
    ("gaits", "--footfalls"): ("x.jpg", "must end in .png, .pdf, .svg"),
    ("simulate", "--motion"): ("x.jpg", "must end in .png, .pdf, .svg"),
    ("simulate", "--energies"): ("nowhere/x.png", "the directory {0}/nowhere must exist"),
    ("simulate", "--footfalls"): ("folder.png", "is a directory; must be a file"),
    ("simulate", "--figure"): ("nowhere/x.png", "the directory {0}/nowhere must exist"),
    ("animate", "--out"): ("x.avi", "must end in .gif, .html, .mp4, .webm"),
    ("simulate", "--animation"): ("x.png", "must end in .gif, .html, .mp4, .webm"),
    ("recover", "--animation"): ("nowhere/x.gif", "the directory {0}/nowhere must exist"),
    ("recover", "--figure"): ("folder.png", "is a directory; must be a file"),
}


@pytest.mark.parametrize("where", OUTPUTS)
def test_outputs_are_checked_before_the_work(
    where: tuple[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "folder.png").mkdir()
    monkeypatch.setattr("legspring.solve.search_gaits", lambda *_, **__: pytest.fail("searched"))
    (command, option), (name, message) = where, OUTPUTS[where]
    shown = error(command, "cockroach", *HERE, option, tmp_path / name)
    assert shown == f"{tmp_path / name}: {message.format(tmp_path)}"


def test_outputs_of_an_atlas_are_checked_before_the_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setattr("legspring.atlases.atlas", lambda *_, **__: pytest.fail("searched"))
    assert "must end in .nc" in error("atlas", "cockroach", "--out", tmp_path / "a.txt")
    assert "must exist" in error("atlas", "cockroach", "--out", tmp_path / "nowhere" / "a.nc")
    out = ["--out", str(tmp_path / "a.nc"), "--figures"]
    assert "is a file; must be a directory" in error("atlas", "cockroach", *out, tmp_path / "file")
    assert "must exist" in error("atlas", "cockroach", *out, tmp_path / "a" / "b")


NUMBERS = ["nan", "inf", "1e400", "0x10", "\uff11\uff12", "", "1_0", "9" * 400, "x" * 10_000]
BEFORE = [
    ("gaits", "--slope"),
    ("gaits", "--heading"),
    ("gaits", "--actuation"),
    ("simulate", "--strides"),
    ("simulate", "--branch"),
    ("simulate", "--speed"),
    ("simulate", "--phase"),
    ("recover", "--impulse"),
    ("animate", "--slow"),
    ("animate", "--strides"),
    ("animate", "--beside"),
    ("optimize", "--slope"),
    ("atlas", "--slopes"),
    ("atlas", "--headings"),
    ("reproduce", "--workers"),
]


@pytest.mark.parametrize(("command", "option"), BEFORE)
def test_numbers_are_checked_before_the_work(
    command: str, option: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for name in ("solve.search_gaits", "atlases.atlas", "simulation.flow", "peterson2011.reproduce.reproduce"):
        monkeypatch.setattr(f"legspring.{name}", lambda *_, **__: pytest.fail("worked"))
    here = [*HERE, *(["--speed", "0.3", "--family", "B"] if option == "--phase" else [])]
    if command == "animate":
        here += ["--out", str(tmp_path / "a.gif")]
    if command in ("atlas", "reproduce"):
        here = ["--out", str(tmp_path / "a.nc")]
    for text in NUMBERS:
        if (option, text) not in [("--branch", "9" * 400), ("--beside", "9" * 400), ("--workers", "9" * 400)]:
            shown = error(command, *(["cockroach"] if command != "reproduce" else []), *here, option, text)
            assert option in shown and "must be" in shown and len(shown) < 300


@pytest.mark.parametrize("text", ["0", "-1", "0.3", "1e9", "1e-300"])
def test_strides_are_checked_before_the_work(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("legspring.solve.search_gaits", lambda *_, **__: pytest.fail("searched"))
    assert "strides = " in error("simulate", "cockroach", *HERE, "--strides", text)


@pytest.mark.parametrize(
    "text", ["0:90:0", "0:1e9:1e-9", "::", "nan:1:1", "0:1:1e-320", "0:inf:1", "\uff11:2:1", ":" * 9999]
)
def test_grids_are_checked_before_the_work(text: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("legspring.atlases.atlas", lambda *_, **__: pytest.fail("searched"))
    assert "must be START:STOP:STEP" in error("atlas", "cockroach", "--out", tmp_path / "a.nc", "--slopes", text)


def test_errors_are_no_longer_than_a_line_and_show_what_cannot_be_printed() -> None:
    assert len(error("gaits", "x" * 10_000)) < 300
    assert error("gates\x1b[31m\n\udcff") == "No such command 'gates\\x1b[31m\\n\\udcff'."


def test_names_are_no_markup_and_no_emoji(tmp_path: Path) -> None:
    file = tmp_path / "odd.toml"
    file.write_text('like = "cockroach"\nname = "roach [/old] [v2] :smile:"\n[families]\n"[red]:b:" = ["B"]\n')
    result = run("gaits", file, *HERE)
    assert result.exit_code == 0, result.stderr
    assert "roach [/old] [v2] :smile:: slope 45 deg" in result.stdout
    assert " [red]:b: " in result.stdout


@pytest.mark.parametrize("columns", ["1", "40", "80"])
def test_narrow_terminals_lose_no_columns_and_no_digits(
    columns: str, monkeypatch: pytest.MonkeyPatch, gait: ls.Gait
) -> None:
    monkeypatch.setenv("COLUMNS", columns)
    shown = run("gaits", "cockroach", *HERE).stdout
    assert f" {gait.speed:.4f}   -2.8, 31.6, -38.3 " in shown and f" {gait.transport_cost:.4f}" in shown
    assert "multiplier" in shown and "\u2026" not in shown


@pytest.mark.parametrize("command", ["gaits", "simulate", "recover"])
def test_a_figure_that_fails_leaves_the_result(command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device", str(tmp_path / "x.png"))

    expected = run(command, "cockroach", *HERE).stdout
    monkeypatch.setattr("legspring.figures.save_figure", full)
    result = run(command, "cockroach", *HERE, "--figure", tmp_path / "x.png")
    assert (result.exit_code, result.stdout) == (2, expected)
    assert result.stderr == f"legspring: {tmp_path / 'x.png'}: No space left on device\n"


def test_one_output_that_fails_leaves_the_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device", "run.csv")

    monkeypatch.setitem(SAVERS, ".csv", full)
    outputs = ["--out", str(tmp_path / "run.csv"), "--figure", str(tmp_path / "run.png")]
    result = run("simulate", "cockroach", *HERE, *outputs)
    assert (result.exit_code, result.stderr) == (2, "legspring: run.csv: No space left on device\n")
    assert [file.name for file in tmp_path.iterdir()] == ["run.png"]
    monkeypatch.setattr("legspring.figures.save_figure", full)
    result = run("simulate", "cockroach", *HERE, *outputs)
    assert result.stderr == "legspring: run.csv: No space left on device; run.csv: No space left on device\n"


@pytest.mark.parametrize("command", ["simulate", "recover"])
def test_what_needs_a_gait_fails_without_one(command: str) -> None:
    assert error(command, "cockroach", *NO_GAIT, status=1).startswith("no gait at slope 40 deg")


def test_a_mistake_in_a_file_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "bad.toml").write_text('like = "cockroach"\nstiffness = -1\n')
    assert "stiffness = -1: must be greater than 0" in error("gaits", tmp_path / "bad.toml", *HERE)


def test_the_program_reports_errors_by_its_exit_status() -> None:
    done = subprocess.run([sys.executable, "-c", PROGRAM, "gaits", "roach", *HERE], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("legspring: no animal 'roach': must be a preset (centipede, climbing_template, ")
    assert done.stderr.endswith(" or a TOML file\n") and done.stderr.count("\n") == 1


def test_what_is_missing_is_said(tmp_path: Path) -> None:
    (tmp_path / "hopper.toml").write_text('like = "spring_loaded_inverted_pendulum"\nangle_deg = 180')
    shown = run("gaits", str(tmp_path / "hopper.toml")).stdout
    reason = "the gait stays where it is: there is no distance to go by"
    assert f"branch 0: no transport cost; {reason}" in shown
    (found,) = records("gaits", str(tmp_path / "hopper.toml"))
    assert found["transport_cost"] is None and found["missing"]["transport_cost"] == reason
