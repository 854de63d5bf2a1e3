"""The command: whatever its arguments, it ends with a status of its own, and says in one line what is wrong."""

import functools
import os
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

import legspring as ls
from legspring import solve
from legspring.cli import app
from tests.fuzz.trying import OUTCOMES, examples, is_one_line, text

NUMBERS = [
    *3 * ["1", "0.5", "2"],
    "0",
    "45",
    "90",
    "0.15",
    "-0.3",
    "1",
    "2",
    "1e-9",
    "nan",
    "inf",
    "1e400",
    "0x10",
    "\uff11",
    "",
    "9" * 400,
    "-1",
]
FILES = [
    *4 * ["x.png"],
    "x.png",
    "x.pdf",
    "x.nc",
    "x.csv",
    "x.mat",
    "x.txt",
    "",
    ".",
    "nowhere/x.png",
    "folder.png",
    "x\0.png",
    "y" * 300 + ".svg",
]
GRIDS = ["45", "45,60", "0:90:45", "::", "0:90:0", "0:1e9:1e-9", "nan:1:1", "a", "", "90:0:10", "0:1:1e-320"]
LISTS = [*4 * ["0.01,0.01,0.01"], "0.01,0.01,0.01", "1,2,3", "1", "", ",", "63,4,-49", "0.1,nan,0", "1,2,3,4"]
VARIED = ("slope_deg", "mass", "energy", "F.stiffness", "speed", "heading")
OVERS = [f"{name}={grid}" for name in VARIED for grid in GRIDS] + ["a", "="]
NAMES = ["F.phase", "step_duration", "F.phase,M.phase", "slope", "", "x.y", "mass,mass", "T.stiffness"]
TARGETS = ["--speed", "--mean-speed", "--energy", "--apex-height", "--lateral-drift", "--free", "--asymmetric"]
WORDS = [
    *3 * ["A", "B", "P", "stability"],
    "A",
    "FB",
    "B",
    "P",
    "stability",
    "efficiency",
    "complete",
    "reduced",
    "nelder-mead",
    "2.1",
    "4.2,6.1",
    "[/x]",
]
VALUES: dict[str, list[str]] = {
    "--slope": NUMBERS, "--heading": NUMBERS, "--branch": NUMBERS, "--speed": NUMBERS, "--strides": NUMBERS,
    "--impulse": NUMBERS, "--workers": ["0", "nan", "-1", "1e9", "x"], "--family": WORDS, "--actuation": LISTS,
    "--phase": ["10,20,30", *LISTS], "--figure": FILES, "--footfalls": FILES, "--out": FILES,
    "--slopes": GRIDS, "--headings": GRIDS, "--over": OVERS, "--free": NAMES, "--asymmetric": [],
    "--mean-speed": NUMBERS, "--energy": NUMBERS, "--apex-height": NUMBERS, "--lateral-drift": NUMBERS,
    "--method": WORDS, "--objective": WORDS, "--map": WORDS, "--only": WORDS, "--json": [], "--no-recovery": [],
    "--help": [], "--version": [], "--memory": [*WORDS, "kept", "rebuilt"], "--refine": NUMBERS,
    "--directions": NUMBERS, "--moments": NUMBERS, "--impulses": GRIDS, "--runs": NUMBERS, "--scales": GRIDS,
    "--distribution": [*WORDS, "normal", "uniform"], "--correlation": NUMBERS, "--seed": NUMBERS,
    "--samples": NUMBERS, "--sampling": [*WORDS, "latin", "list"], "--measures": NAMES, "--cluster": WORDS,
    "--draw": NAMES, "--follow": [], "--minimize": NAMES, "--maximize": [*NAMES, "push"],
    "--bound": [*OVERS, "friction=:2", "speed=nan:1"],
    "--constraints": [*WORDS, "peterson2011"], "--points": NUMBERS, "--evaluations": NUMBERS,
    "--with": [f"{name}={value}" for name in ("slope_deg", "miss", "height", "wind") for value in NUMBERS] + ["a", "="],
}  # fmt: skip
OPTIONS = {
    "presets": ["--json", "--figure"],
    "parameters": ["--family", "--json"],
    "gaits": ["--family", "--actuation", "--json", "--figure", "--footfalls", *TARGETS],
    "simulate": [
        *("--branch", "--family", "--speed", "--phase", "--actuation", "--strides", "--out", "--json"),
        *("--figure", "--footfalls"),
    ],
    "recover": ["--impulse", "--branch", "--family", "--actuation", "--json", "--figure"],
    "atlas": ["--out", "--slopes", "--headings", "--no-recovery", "--actuation", "--over", *TARGETS],
    "basin": ["--over", "--memory", "--refine", "--out", "--figure", "--json"],
    "push": ["--directions", "--moments", "--impulses", "--out", "--figure", "--json"],
    "rough": ["--with", "--runs", "--scales", "--distribution", "--correlation", "--seed", "--out", "--json"],
    "pareto": ["--over", "--minimize", "--maximize", "--bound", "--constraints", "--points", "--evaluations", "--out"],
    "sweep": [
        "--over",
        "--follow",
        "--samples",
        "--sampling",
        "--measures",
        "--out",
        "--cluster",
        "--draw",
        "--branch",
    ],
    "optimize": ["--objective", "--family", "--map", "--method", "--json", "--figure"],
    "reproduce": ["--out", "--only", "--method", "--workers"],
}


FIRST = {
    "basin": ["--over", "speed=0.2,0.3"],
    "rough": ["--with", "slope_deg=3"],
    "sweep": ["--over", "slope_deg=44,45", "--out", "a.nc"],
    "pareto": ["--over", "F.stiffness=1:2", "--minimize", "stability,transport_cost"],
}
"""What commands cannot do without."""


@st.composite
def arguments(draw: st.DrawFn) -> list[str]:
    """Return arguments of a command, many of them its own and valid, some not."""
    command = draw(st.sampled_from([*OPTIONS]))
    given = [command]
    if command not in ("presets", "reproduce"):
        given.append(
            draw(
                st.sampled_from(
                    [*2 * ls.presets(), *8 * ["cockroach"], "animal.toml", "broken.toml", "roach", "", "[/x]"]
                )
            )
        )
        if draw(st.integers(0, 3)):
            given += ["--slope", "45", "--heading", "0.15"] if command != "atlas" else ["--out", "a.nc"]
        if command in FIRST and draw(st.integers(0, 3)):
            given += FIRST[command]
    for option in draw(st.lists(st.sampled_from(OPTIONS[command]), max_size=2)):
        given.append(option)
        given += [draw(st.one_of(*[st.sampled_from(VALUES[option])] * 9, text()))] if VALUES[option] else []
    if draw(st.integers(0, 9)) == 0:
        given.insert(draw(st.integers(0, len(given))), draw(st.one_of(st.sampled_from([*VALUES, *WORDS]), text())))
    return given


def worked(*_: Any, **__: Any) -> None:
    """Stand for work that takes too long; everything before it has been right."""
    raise ValueError("work")


@pytest.fixture(scope="module")
def runner(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Return a runner in a folder of its own, where searches are short and long work is not done."""
    folder = tmp_path_factory.mktemp("commands")
    (folder / "folder.png").mkdir()
    (folder / "animal.toml").write_text('like = "cockroach"\nname = "[/red] :smile:"\n')
    (folder / "broken.toml").write_text("mass = [/]")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        short = functools.partial(solve.search_gaits, starts=4)
        patch.setattr("legspring.solve.search_gaits", short)
        long: tuple[str, ...] = ("optimisation.search", "optimisation.tried", "peterson2011.reproduce.Store")
        for name in (
            *long,
            "basins.refined",
            "pushing.Trial",
            "roughness.run_all",
            "fronts.Archive",
            "sweeping.block_of",
        ):
            patch.setattr(f"legspring.{name}", worked, raising=False)
        patch.setattr("legspring.mapping.find_on", worked)
        yield CliRunner()


@examples(in_ci=300, share=0.14)
@given(given=arguments())
def test_a_command_ends_with_a_status_and_a_line(runner: CliRunner, given: list[str]) -> None:
    result = runner.invoke(app, given)
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    assert result.exit_code in (0, 1, 2)
    assert "Traceback" not in result.output
    if result.exit_code:
        assert result.stderr.endswith("\n") and is_one_line(result.stderr[:-1]), result.stderr
    else:
        assert result.stdout or "nothing to draw" in result.stderr
    assert not [name for name in os.listdir() if name.endswith(".part")]
    OUTCOMES[f"{given[0] if given[0] in OPTIONS else 'no command'}: status {result.exit_code}"] += 1
