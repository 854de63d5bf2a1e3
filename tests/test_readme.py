"""The README: what it shows is run, and what it names is there."""

import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

from legspring.cli import app

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
LINES = [line.partition("#")[0].strip() for line in README.splitlines() if line.startswith("    legspring ")]
COMMANDS = [line for line in LINES if "COMMAND" not in line]


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "heavy.toml").write_text(blocks("toml")[0])
    return tmp_path


# What reproduces the thesis has tests of its own.
LATER = (" reproduce ", " presets --figures ")
LONG = [
    pytest.param(line, marks=pytest.mark.long) if any(words in line for words in LATER) else line for line in COMMANDS
]


@pytest.mark.parametrize("line", LONG)
def test_commands_do_what_they_say(folder: Path, line: str) -> None:
    _, *arguments = shlex.split(line)
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    for option in ("--out", "--figure", "--figures"):
        if option in arguments:
            assert (folder / arguments[arguments.index(option) + 1]).exists()


def test_the_first_example_runs(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (example,) = blocks("python")
    exec(example, {})
    family, speed, *_ = capsys.readouterr().out.split()
    assert (family, round(float(speed), 4)) == ("B", 0.2731)
    assert (folder / "run.gif").read_bytes().startswith(b"GIF89a")


def test_what_it_links_to_is_there() -> None:
    links = re.findall(r"\]\(([^)#]+)\)", README)
    assert len(links) > 12
    for link in links:
        assert (ROOT / link).is_file(), link
