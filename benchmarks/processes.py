"""What a user waits for: compiling once, the first gait, the command's help, an atlas; each in processes of its own.

Nothing here imports the package: these processes inherit our memory's peak.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median
from typing import Any

from benchmarks.figures import Figure

HERE = Path(__file__).resolve().parent
FIRST_GAIT = "import legspring as ls; ls.find_gaits(ls.cockroach(), slope_deg=45, heading=0.15)[0]"
HELP = "import sys; sys.argv = ['legspring', '--help']; from legspring.cli import app; app()"
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


def run(*arguments: str, cache: str | None = None) -> tuple[float, str]:
    """Run Python; return how long that took, s, and what it printed.

    Raises
    ------
    RuntimeError
        If it fails.
    """
    environment = os.environ | ({"NUMBA_CACHE_DIR": cache} if cache else {})
    begin = time.perf_counter()
    done = subprocess.run([sys.executable, *arguments], env=environment, capture_output=True, text=True)
    wall = time.perf_counter() - begin
    if done.returncode:
        raise RuntimeError(f"python {arguments[0]} ... failed: {done.stderr.strip()[-2000:]}")
    return wall, done.stdout


def typical(*arguments: str, rounds: int) -> float:
    """Median time of running Python, s, after a first time that does not count."""
    run(*arguments)
    return median(run(*arguments)[0] for _ in range(rounds))


def cold(quick: bool) -> list[Figure]:
    """Compile everything, once."""
    with tempfile.TemporaryDirectory() as cache:
        wall, printed = run(str(HERE / "compiling.py"), cache=cache)
        detail: dict[str, Any] = json.loads(printed)
        size = sum(path.stat().st_size for path in Path(cache).rglob("*") if path.is_file())
    detail |= {"process_s": wall, "cache_mb": size / 1e6}
    return [
        Figure("compiling, once", detail["compiling_s"], "s", 45.0, 15.0, detail=detail),
        Figure("from the shell to a first gait, nothing cached", detail["first_gait_s"], "s"),
    ]


def cached(quick: bool) -> list[Figure]:
    """Start anew, everything compiled."""
    rounds = 3 if quick else 7
    bare = typical("-c", "pass", rounds=rounds)
    imports = typical("-c", "import numba, scipy.integrate", rounds=rounds)
    detail = {"bare_python_s": bare, "importing_numba_and_scipy_s": imports}
    first = typical("-c", FIRST_GAIT, rounds=rounds)
    figures = [Figure("from the shell to a first gait, cached", first, "s", 2.0, 1.0, detail=detail)]
    command = Path(sys.executable).parent / "legspring"
    arguments = (str(command), "--help") if command.exists() else ("-c", HELP)
    try:
        helping = typical(*arguments, rounds=rounds)
    except RuntimeError as error:
        print(f"No figure for legspring --help: {error}", file=sys.stderr)
        return figures
    return [*figures, Figure("legspring --help", helping, "s", 0.3, 0.15, detail={"bare_python_s": bare})]


def atlas(quick: bool) -> list[Figure]:
    """Make the whole atlas."""
    figures = []
    cases = [("2", "without", 8.0, 2.0), ("1", "without", None, None)]
    cases += [] if quick else [("2", "with", None, None), ("1", "with", None, None)]
    for workers, recovery, must, aim in cases:
        run("-c", ATLAS, workers, recovery)
        results = [json.loads(run("-c", ATLAS, workers, recovery)[1]) for _ in range(1 if quick else 3)]
        middle = sorted(results, key=lambda result: float(result["wall_s"]))[len(results) // 2]
        name = f"whole atlas, {recovery} recovery, on {workers} core{'s' if workers > '1' else ''}"
        peak = middle.pop("peak") / (2**20 if sys.platform == "darwin" else 2**10)
        figures.append(Figure(name, middle["wall_s"], "s", must, aim, detail=middle))
        figures.append(Figure(f"{name}, most memory", peak, "MiB"))
    return figures
