"""Output files."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import scipy.io
import xarray as xr

import legspring as ls
from legspring.files import SAVERS, check_output, make_directory, save_mat, save_netcdf, whole_file


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


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    """Of an animal with one pair of legs."""
    start = {"heading": 0.1, "speed": 0.5, "strides": 1}
    return ls.simulate(ls.load_animal("lateral_leg_spring"), **start)  # type: ignore[arg-type]


def test_what_there_is_one_of_comes_back_as_it_was(run: xr.Dataset, tmp_path: Path) -> None:
    save_netcdf(run, tmp_path / "run.nc")
    with xr.open_dataset(tmp_path / "run.nc") as stored:
        assert list(stored["pairs"].values) == ["T"] and stored["phase"].shape == (1,)
        assert list(stored["leg_function"].values) == ["push"]
        assert stored.identical(run)
    # An attribute that is a list of one would come back as what is in it.
    assert not [name for name, value in run.attrs.items() if np.ndim(value)]


def test_simulations_for_matlab(run: xr.Dataset, tmp_path: Path) -> None:
    save_mat(run, tmp_path / "run.mat")
    found = scipy.io.loadmat(tmp_path / "run.mat", simplify_cells=True)
    for name in ("time", "position", "force", "event_time"):
        np.testing.assert_array_equal(found[name], run[name].values)
    assert found["event_kind"].tolist() == run["event_kind"].values.tolist()
    assert (found["units"]["force"], found["long_name"]["yaw_rate"]) == ("m g", "yaw rate")
    assert found["attributes"]["animal"] == "lateral_leg_spring"
    # Words of MATLAB's own are no names.
    assert not {"function", "end", "for", "if"} & set(found)


@pytest.mark.parametrize("suffix", SAVERS)
def test_a_link_stays_one(suffix: str, run: xr.Dataset, tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    real, link = tmp_path / "data" / f"real{suffix}", tmp_path / f"link{suffix}"
    real.write_text("before")
    try:
        link.symlink_to(real)
    except OSError:
        pytest.skip("no links here")
    SAVERS[suffix](run, link)
    assert link.is_symlink() and real.read_bytes() != b"before"
    assert [path.name for path in (tmp_path / "data").iterdir()] == [real.name]


FULL = """
import resource, signal, sys
import legspring as ls
from legspring.figures import draw_simulation, save_figure
from legspring.files import SAVERS
run = ls.simulate(ls.load_animal("lateral_leg_spring"), heading=0.1, speed=0.5, strides=1)
figure = draw_simulation(run)
work = [(save, run, suffix) for suffix, save in SAVERS.items()]
work += [(save_figure, figure, suffix) for suffix in (".png", ".pdf", ".svg")]
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))
for save, what, suffix in work:
    try:
        save(what, sys.argv[1] + "/x" + suffix)
    except OSError as error:
        print(suffix, error.filename is not None, len(str(error).splitlines()))
"""


def test_a_full_disk_is_an_error_of_one_line(tmp_path: Path) -> None:
    pytest.importorskip("resource")
    done = subprocess.run([sys.executable, "-c", FULL, tmp_path], capture_output=True, text=True, check=True)
    endings = [*SAVERS, ".png", ".pdf", ".svg"]
    assert done.stdout.splitlines() == [f"{suffix} True 1" for suffix in endings], done.stderr
    assert list(tmp_path.iterdir()) == []


def test_unfinished_files_of_others_stay(tmp_path: Path) -> None:
    theirs = [tmp_path / name for name in (".backup.2019.part", ".film.99999.part", ".x.legspring-0123-99999.part")]
    for path in theirs:
        path.touch()
    with whole_file(tmp_path / "mine.txt") as part:
        part.write_text("mine")
    assert all(path.exists() for path in theirs)
