"""Long work that is killed at random moments: what was done stays, and the end is that of an undisturbed run."""

import os
import random
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import legspring as ls
from legspring.stores import finished, open_sweep

BEGIN = """
import sys
from pathlib import Path
import numpy as np
import legspring as ls
from legspring import plans
place, roach = Path(sys.argv[1]), ls.cockroach()
"""
SWEEP = """
plans.FOLLOWED, plans.FEWEST = 2, 1
gaits = ls.find_gaits(roach, slope_deg=45, heading=0.15)
print("begins", flush=True)
ls.sweep(roach, {"slope_deg": np.linspace(40, 50, 40)}, gaits=gaits, store=place / "runs.zarr", workers=2)
"""
ATLAS = """
print("begins", flush=True)
ls.atlas(roach, slopes_deg=range(20, 60, 5), headings=[0.1, 0.2, 0.3, 0.4], store=place / "runs.zarr", workers=2)
"""
OPTIMA = """
print("begins", flush=True)
ls.optimal_atlas(roach, slopes_deg=(60,), headings=(0.15, 0.2), map="reduced", store=place / "runs.zarr", workers=2)
"""
REPRODUCE = """
from legspring.optima import optimal_atlas
from legspring.atlases import atlas
from legspring.peterson2011 import store
place_of = {"slopes_deg": (60,), "headings": (0.15,)}
store.optimal_atlas = lambda *given, **asked: optimal_atlas(*given, **place_of, **asked)
store.ls.atlas = lambda *given, **asked: atlas(*given, **place_of, **asked)
results = store.Store(place, workers=2)
print("begins", flush=True)
results.atlas, results.nelder_mead, results.optima
"""
WORK = {"sweep": (SWEEP, 0.5), "atlas": (ATLAS, 2.5), "optima": (OPTIMA, 8.0), "reproduce": (REPRODUCE, 4.0)}
"""What is killed, and the latest moment to do so, s."""


def run(script: str, place: Path) -> "subprocess.Popen[str]":
    """Begin some work in a process of its own; return when it is about to begin."""
    text = BEGIN + script + '\nprint("done", flush=True)\n'
    process = subprocess.Popen([sys.executable, "-c", text, place], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "begins\n"
    return process


def ends(process: "subprocess.Popen[str]") -> bool:
    """Wait for a process; return whether it has done its work."""
    said, _ = process.communicate()
    return "done" in said


def kept(place: Path) -> dict[str, tuple[int, float]]:
    """Return the results that are finished, with what tells whether they were written again."""
    data = [*place.glob("*.nc"), *place.glob(".unfinished/*.json"), *place.glob(".runs.zarr.search/*.json")]
    return {file.name: (file.stat().st_ino, file.stat().st_mtime) for file in data}


def results(place: Path) -> dict[str, xr.Dataset]:
    """Return all results of some work."""
    found = {file.name: xr.load_dataset(file, engine="netcdf4") for file in sorted(place.glob("*.nc"))}
    return found | ({"runs": open_sweep(place / "runs.zarr").load()} if (place / "runs.zarr").exists() else {})


@pytest.mark.skipif(sys.platform == "win32", reason="there is no such signal")
@pytest.mark.parametrize(
    ("name", "count"),
    [
        ("sweep", 5),
        ("atlas", 5),
        ("reproduce", 5),
        *(pytest.param(name, 50, marks=pytest.mark.long) for name in WORK),
    ],
)
def test_killed_at_random_moments(tmp_path: Path, name: str, count: int) -> None:
    script, latest = WORK[name]
    place, other = tmp_path / "killed", tmp_path / "undisturbed"
    place.mkdir()
    other.mkdir()
    chance, hit, done = random.Random(count), 0, 0
    for _ in range(count):
        before = kept(place)
        process = run(script, place)
        time.sleep(chance.uniform(0.0, latest))
        os.kill(process.pid, signal.SIGKILL)
        hit += not ends(process)
        if (place / "runs.zarr").exists():
            so_far, total = finished(place / "runs.zarr")
            assert done <= so_far <= total
            done = so_far
            open_sweep(place / "runs.zarr").load()
        # What was finished was not done again; the pieces of a search go when it is.
        after = kept(place)
        assert all(after.get(one, when) == when for one, when in before.items())
    assert hit > 0
    assert ends(run(script, place)) and ends(run(script, other))
    ours, undisturbed = results(place), results(other)
    assert ours.keys() == undisturbed.keys() and ours
    for key, one in undisturbed.items():
        for variable in one.variables:
            values, wanted = ours[key][variable].values, one[variable].values
            assert np.array_equal(values, wanted, equal_nan=wanted.dtype.kind == "f"), variable
    assert not list(tmp_path.rglob("*.part")) and not list(tmp_path.rglob("*.before"))


@pytest.mark.long
def test_workers_are_killed(tmp_path: Path) -> None:
    """Another worker takes over what one that is killed has begun."""
    distributed = pytest.importorskip("distributed")
    roach = ls.cockroach()
    gaits = ls.find_gaits(roach, slope_deg=45, heading=0.15)
    over = {"slope_deg": np.linspace(30.0, 60.0, 400), "mass": [2.2e-3, 2.5e-3, 2.8e-3]}
    whole = ls.sweep(roach, over, gaits=gaits)
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        victims = list[int]()

        def kill_one() -> None:
            info = client.run(os.getpid)
            victims.append(next(iter(info.values())))
            os.kill(victims[-1], signal.SIGKILL)

        timers = [threading.Timer(delay, kill_one) for delay in (2.0, 6.0)]
        for timer in timers:
            timer.start()
        same = ls.sweep(roach, over, gaits=gaits, cluster=client, store=tmp_path / "runs.zarr")
        for timer in timers:
            timer.join()
    assert len(victims) == 2
    for name in whole.data_vars:
        assert np.array_equal(same[name].values, whole[name].values, equal_nan=whole[name].dtype.kind == "f"), name
