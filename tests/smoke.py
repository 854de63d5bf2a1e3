"""Install the package with each Python that there is, and take the first steps with it; ``python3 dev.py smoke``.

Each gets an environment of its own in a temporary folder, with the versions of constraints.txt.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PYTHONS = ["3.12", "3.13"]
STEPS = """
import sys, pathlib, legspring as ls
from legspring.figures import draw_gait, save_figure
from legspring.files import save_netcdf

gait = ls.find_gaits(ls.cockroach(), slope_deg=45, heading=0.15)[0]
assert abs(gait.speed - 0.2731) < 1e-4, gait.speed
save_figure(draw_gait(gait), "gait.png")
save_netcdf(gait.simulate(), "run.nc")
assert all(pathlib.Path(name).stat().st_size > 1000 for name in ("gait.png", "run.nc"))
print(f"Python {sys.version.split()[0]}: a gait of {gait.speed:.4f} m/s, a figure and a netCDF file")
"""


def main() -> int:
    """Take the steps with every Python; return how many did not get there."""
    failed = 0
    for version in sys.argv[1:] or PYTHONS:
        found = interpreter(version)
        if found is None:
            print(f"Python {version}: there is none")
        else:
            with tempfile.TemporaryDirectory() as folder:
                failed += not works(found, Path(folder))
    return failed


def interpreter(version: str) -> str | None:
    """Return a Python of this version, on the path or beside those of pyenv."""
    home = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"))
    beside = sorted(home.glob(f"versions/{version}.*/bin/python{version}"))
    candidates = [shutil.which(f"python{version}"), *map(str, beside)]
    # What is on the path may stand for one that has not been chosen.
    return next((name for name in candidates if name and runs(name)), None)


def runs(python: str) -> bool:
    """Whether it is a Python indeed."""
    return subprocess.run([python, "--version"], capture_output=True).returncode == 0


def works(python: str, folder: Path) -> bool:
    """Install the package into a folder and take the first steps there; tell whether all went well."""
    call([python, "-m", "venv", folder / "venv"])
    own = folder / "venv" / ("Scripts" if os.name == "nt" else "bin") / "python"
    install = [
        own,
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
        "-c",
        ROOT / "constraints.txt",
        ROOT,
    ]
    program = [own, "-m", "legspring", "gaits", "cockroach", "--slope", "45", "--heading", "0.15"]
    steps = (install, [own, "-W", "error::SyntaxWarning", "-c", STEPS], program)
    for step in steps:
        if status := call(step, folder):
            print(f"{python}: status {status} of {' '.join(map(str, step[1:4]))} ...")
            return False
    return True


def call(command: Sequence[object], folder: Path | None = None) -> int:
    """Run a program, and nothing of what is installed here; return its exit status."""
    return subprocess.run([*map(str, command)], cwd=folder, env=os.environ | {"PYTHONPATH": ""}).returncode


if __name__ == "__main__":
    sys.exit(main())
