"""Output files."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from legspring.files import check_output, make_directory, whole_file


def test_a_file_appears_whole(tmp_path: Path) -> None:
    target = tmp_path / "out.txt"
    with whole_file(target) as part:
        part.write_text("all of it")
        assert not target.exists()
    assert target.read_text() == "all of it"
    assert list(tmp_path.iterdir()) == [target]


def test_or_not_at_all(tmp_path: Path) -> None:
    target = tmp_path / "out.txt"
    target.write_text("before")

    def interrupted() -> None:
        with whole_file(target) as part:
            part.write_text("half of")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert target.read_text() == "before"
    assert list(tmp_path.iterdir()) == [target]


def test_errors_name_the_file_that_was_asked_for(tmp_path: Path) -> None:
    target = tmp_path / "missing" / "out.txt"
    with pytest.raises(FileNotFoundError) as caught, whole_file(target) as part:
        part.write_text("nowhere")
    assert (caught.value.errno, caught.value.filename) == (errno.ENOENT, str(target))


def test_paths_are_checked_beforehand(tmp_path: Path) -> None:
    check_output(tmp_path / "a.nc", [".nc"])
    with pytest.raises(ValueError, match=r"must end in \.nc"):
        check_output(tmp_path / "a.txt", [".nc"])
    with pytest.raises(FileNotFoundError, match="directory"):
        check_output(tmp_path / "b" / "a.nc", [".nc"])
    with pytest.raises(IsADirectoryError):
        (tmp_path / "c.nc").mkdir()
        check_output(tmp_path / "c.nc", [".nc"])


def test_directories_are_made(tmp_path: Path) -> None:
    make_directory(tmp_path / "new")
    assert (tmp_path / "new").is_dir()
    (tmp_path / "file").write_text("")
    with pytest.raises(NotADirectoryError):
        make_directory(tmp_path / "file")


KILLED = """
import os, sys
from pathlib import Path
from legspring.files import whole_file
with whole_file(sys.argv[1]) as part:
    part.write_text("half of")
    os._exit(9)
"""


def test_what_a_killed_process_leaves_is_removed_by_the_next_one(tmp_path: Path) -> None:
    for name in ("a.nc", "b.nc"):
        subprocess.run([sys.executable, "-c", KILLED, tmp_path / name])
        (left,) = tmp_path.iterdir()
        assert left.name.startswith(f".{name}.") and left.suffix == ".part"
    mine, other = tmp_path / f".c.nc.{os.getpid()}.part", tmp_path / ".hidden.part"
    mine.touch()
    other.touch()
    with whole_file(tmp_path / "a.nc") as part:
        part.write_text("all of it")
    assert {path.name for path in tmp_path.iterdir()} == {"a.nc", mine.name, other.name}
