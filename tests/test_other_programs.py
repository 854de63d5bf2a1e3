"""What the page on data says to MATLAB and R, run by Octave and R where they are."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest
from typer.testing import CliRunner

from legspring.cli import app

PAGE = (Path(__file__).parents[1] / "docs" / "howto" / "data.md").read_text(encoding="utf-8")
HERE = ["cockroach", "--slope", "45", "--heading", "0.15", "--strides", "4"]
ATLAS = ["--slopes", "0:90:30", "--headings", "0.05,0.15", "--no-recovery"]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    lines = [["simulate", *HERE, "--out", f"run.{suffix}"] for suffix in ("mat", "csv")]
    for arguments in (*lines, ["atlas", "cockroach", "--out", "atlas.mat", *ATLAS]):
        assert CliRunner().invoke(app, arguments).exit_code == 0
    return tmp_path


def program(language: str) -> str:
    (text,) = re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)
    return str(text)


@pytest.mark.skipif(not (shutil.which("octave-cli") and shutil.which("gnuplot")), reason="needs Octave and gnuplot")
def test_matlab(folder: Path) -> None:
    before = "graphics_toolkit('gnuplot'); set(0, 'defaultfigurevisible', 'off');"
    after = "assert(size(maps.transport_cost)(1:2), [4 2]); assert(size(run.force), [801 6 2]); disp('done')"
    (folder / "page.m").write_text(f"{before}\n{program('matlab')}\n{after}\n")
    done = subprocess.run(["octave-cli", "page.m"], capture_output=True, text=True, cwd=folder, timeout=120)
    assert done.stdout.splitlines()[-1:] == ["done"], done.stderr


@pytest.mark.skipif(shutil.which("Rscript") is None, reason="needs R")
def test_r(folder: Path) -> None:
    (folder / "page.R").write_text(f"{program('r')}\ncat(nrow(run), 'rows')\n")
    done = subprocess.run(["Rscript", "page.R"], capture_output=True, text=True, cwd=folder, timeout=120)
    assert (done.returncode, done.stdout) == (0, "801 rows"), done.stderr
