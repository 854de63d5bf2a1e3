"""What a user waits for: compiling once, the first gait, the command's help, an atlas; each in processes of its own.

Nothing here imports the package: these processes inherit our memory's peak.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.figures import Figure

HERE = Path(__file__).resolve().parent
FIRST_GAIT = "import legspring as ls; ls.find_gaits(ls.cockroach(), slope_deg=45, heading=0.15)[0]"
COMMAND = "from legspring.__main__ import main; main()"
ATLAS = """
import json, resource, sys, time
import legspring as ls
animal = ls.cockroach()
workers, recovery = int(sys.argv[1]), {"impulses": ()} if sys.argv[2] == "without" else {}
ls.atlas(animal, slopes_deg=[45], headings=[0.15], workers=1, **recovery)
begin, cpu = time.perf_counter(), time.process_time()
dataset = ls.atlas(animal, workers=workers, **recovery)
result = {
    "wall_s": time.perf_counter() - begin,
    "cpu_s": time.process_time() - cpu,
    "gaits": int(dataset["speed"].count()),
    "peak": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss,
}
print(json.dumps(result))
"""


STRIDE = """
import statistics, time
from benchmarks.numpy_walker import simulate
from benchmarks.subjects import point_masses
problems = [subject.problem() for subject in point_masses()]
times = []
for _ in range(3):
    begin = time.perf_counter()
    for problem in problems:
        simulate(problem, rtol=1e-10, atol=1e-12)
    times.append((time.perf_counter() - begin) / len(problems))
print(statistics.median(times))
"""


@dataclass(frozen=True)
class Done:
    """A process that has ended: time from its start to its end, time of the processor, s, and what it printed."""

    wall: float
    cpu: float
    printed: str


def run(*arguments: str | Path, cache: str | None = None) -> Done:
    """Run a program.

    Raises
    ------
    RuntimeError
        If it fails.
    """
    environment = os.environ | ({"NUMBA_CACHE_DIR": cache} if cache else {})
    begin, used = time.perf_counter(), os.times()
    done = subprocess.run(arguments, env=environment, capture_output=True, text=True)
    wall, after = time.perf_counter() - begin, os.times()
    if done.returncode:
        raise RuntimeError(f"{arguments} failed: {done.stderr.strip()[-2000:]}")
    cpu = after.children_user + after.children_system - used.children_user - used.children_system
    return Done(wall, cpu, done.stdout)


def typical(*arguments: str | Path, rounds: int) -> Done:
    """Return the run whose time is the median, after a first one that does not count."""
    run(*arguments)
    return sorted((run(*arguments) for _ in range(rounds)), key=lambda done: done.wall)[rounds // 2]


def cold(_: bool) -> list[Figure]:
    """Compile everything, once."""
    with tempfile.TemporaryDirectory() as cache:
        done = run(sys.executable, str(HERE / "compiling.py"), cache=cache)
        size = sum(path.stat().st_size for path in Path(cache).rglob("*") if path.is_file())
    detail: dict[str, Any] = json.loads(done.printed) | {"process_cpu_s": done.cpu, "cache_mb": size / 1e6}
    return [
        Figure("compiling, once", detail["compiling_s"], "s", 45.0, 15.0, detail=detail),
        Figure("from the shell to a first gait, nothing cached", detail["first_gait_s"], "s"),
    ]


def cached(quick: bool) -> list[Figure]:
    """Start anew, everything compiled."""
    rounds = 3 if quick else 9
    bare = typical(sys.executable, "-c", "pass", rounds=rounds)
    imports = typical(sys.executable, "-c", "import numba, scipy.integrate", rounds=rounds)
    first = typical(sys.executable, "-c", FIRST_GAIT, rounds=rounds)
    command = Path(sys.executable).parent / "legspring"
    shown = typical(*([command] if command.exists() else [sys.executable, "-c", COMMAND]), "--help", rounds=rounds)
    detail = {"cpu_s": first.cpu, "bare_python_s": bare.wall, "importing_numba_and_scipy_s": imports.wall}
    return [
        Figure("from the shell to a first gait, cached", first.wall, "s", 2.0, 1.0, detail=detail),
        Figure("legspring --help", shown.wall, "s", 0.3, 0.15, detail={"cpu_s": shown.cpu}),
    ]


def thesis(quick: bool) -> list[Figure]:
    """Reproduce the thesis, with one stride by SciPy as a first-time user writes it for a unit."""
    if quick:
        return []
    command = "from legspring.peterson2011.reproduce import reproduce; import sys; reproduce(sys.argv[1])"
    with tempfile.TemporaryDirectory() as folder:
        # What is compiled is compiled before; half of the strides are timed before, half after.
        run(sys.executable, "-c", command.replace("argv[1])", "argv[1], only=['3.2'])"), folder)
        before = float(run(sys.executable, "-c", STRIDE).printed)
        done = run(sys.executable, "-c", command, folder)
        after = float(run(sys.executable, "-c", STRIDE).printed)
    stride = 0.5 * (before + after)
    detail = {"wall_s": done.wall, "cpu_s": done.cpu, "scipy_stride_ms": [1e3 * before, 1e3 * after]}
    return [
        Figure("reproduce, in strides by SciPy", done.wall / stride, "", 12_000.0, 7_500.0, detail=detail),
        Figure("reproduce", done.wall, "s"),
    ]


def atlas(quick: bool) -> list[Figure]:
    """Make the whole atlas."""
    figures = []
    cases = [("2", "without", 8.0, 2.0), ("1", "without", None, None)]
    cases += [] if quick else [("2", "with", None, None), ("1", "with", None, None)]
    for workers, recovery, must, aim in cases:
        command = (sys.executable, "-c", ATLAS, workers, recovery)
        run(*command)
        results = [json.loads(run(*command).printed) for _ in range(1 if quick else 3)]
        middle = sorted(results, key=lambda result: float(result["wall_s"]))[len(results) // 2]
        middle["every_wall_s"] = [result["wall_s"] for result in results]
        name = f"whole atlas, {recovery} recovery, on {workers} core{'s' if workers > '1' else ''}"
        peak = middle.pop("peak") / (2**20 if sys.platform == "darwin" else 2**10)
        figures.append(Figure(name, middle["wall_s"], "s", must, aim, detail=middle))
        figures.append(Figure(f"{name}, most memory", peak, "MiB"))
    return figures
