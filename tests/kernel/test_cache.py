"""Machine code on disk is a convenience: whatever happens to it, the kernel works."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

# What takes little time to compile, with two signatures.
TWICE = """
from legspring.kernel.jit import driver

@driver
def twice(x):
    return 2.0 * x[0]
"""
CODE = """
import logging, sys
import numpy as np
logging.basicConfig(level=logging.INFO, format="%(message)s", stream=sys.stderr)
from twice import twice
for kind in "f4", "f8":
    print(twice(np.ones(1, kind)))
"""
RIGHT = "2.0\n2.0\n"
pytestmark = pytest.mark.skipif(os.name == "nt", reason="needs limits of files")


def start(
    folder: Path, cache: Path | None = None, before: Callable[[], Any] | None = None, **more: str
) -> "subprocess.Popen[str]":
    """Start a process that calls a compiled function, whose source is in a folder."""
    (folder / "source").mkdir(exist_ok=True)
    (folder / "source" / "twice.py").write_text(TWICE)
    places = os.pathsep.join([str(folder / "source"), os.environ.get("PYTHONPATH", "")])
    environment = os.environ | {"PYTHONPATH": places, "NUMBA_CACHE_DIR": str(cache or folder / "cache")} | more
    return subprocess.Popen(
        [sys.executable, "-P", "-c", CODE],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=before,
    )


def compiles(*arguments: Any, **more: Any) -> str:
    """Return what a process says while it does its work, rightly."""
    out, said = (run := start(*arguments, **more)).communicate()
    assert (run.returncode, out) == (0, RIGHT), said
    assert "Error" not in said
    return said


def test_it_says_when_it_compiles_and_only_then(tmp_path: Path) -> None:
    assert "compiling (about half a minute, once) ..." in compiles(tmp_path)
    assert compiles(tmp_path) == ""


@pytest.mark.parametrize("damage", [b"", b"half", None])
def test_damaged_files_are_made_anew(tmp_path: Path, damage: bytes | None) -> None:
    compiles(tmp_path)
    files = list(tmp_path.rglob("*.nbc"))
    assert files
    for file in files:
        data = file.read_bytes()
        # One bit of machine code, or everything but the beginning.
        file.write_bytes(data[:-9] + bytes([data[-9] ^ 1]) + data[-8:] if damage is None else damage)
    assert "compiling" in compiles(tmp_path)
    assert compiles(tmp_path) == ""


def test_files_of_other_versions_and_unfinished_ones_go(tmp_path: Path) -> None:
    compiles(tmp_path)
    (first, _) = tmp_path.rglob("*.nbc")
    name = first.name.split(".py3")[0] + ".py3" + first.name.split(".py3")[1].split(".")[0]
    first.unlink()
    old, unfinished, growing = (first.with_name(f"{name}.{end}") for end in ("1.nbc", "a.nbc.1.tmp", "b.nbc.2.tmp"))
    for path in (old, unfinished, growing):
        path.touch()
    os.utime(unfinished, (0, 0))
    compiles(tmp_path)
    assert not old.exists() and not unfinished.exists() and growing.exists()


def test_a_full_disk_is_no_hindrance(tmp_path: Path) -> None:
    import resource

    assert "compiling" in compiles(tmp_path, before=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000)))
    assert not [path for path in (tmp_path / "cache").rglob("*") if path.is_file()]


def test_no_place_for_files_is_no_hindrance(tmp_path: Path) -> None:
    (tmp_path / "source").mkdir()
    (tmp_path / "source" / "__pycache__").touch()
    nowhere = {"HOME": os.devnull, "XDG_CACHE_HOME": os.devnull}
    assert "NUMBA_CACHE_DIR" in compiles(tmp_path, Path(os.devnull) / "x", **nowhere)


def test_processes_that_compile_at_once_share_the_files(tmp_path: Path) -> None:
    together = [start(tmp_path) for _ in range(3)]
    for run in together:
        out, said = run.communicate()
        assert (run.returncode, out) == (0, RIGHT), said
    assert compiles(tmp_path) == ""
    assert {path.suffix for path in (tmp_path / "cache").rglob("*") if path.is_file()} == {".nbc"}


def test_without_a_compiler_it_says_so(tmp_path: Path) -> None:
    out, said = (run := start(tmp_path, NUMBA_DISABLE_JIT="1")).communicate()
    assert run.returncode == 1 and out == ""
    assert said.splitlines()[-1].startswith("ValueError: NUMBA_DISABLE_JIT = '1': must be 0, or left out")
