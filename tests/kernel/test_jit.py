"""Machine code on disk is never older than the source."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import legspring

CODE = """
import numpy as np
from legspring.kernel import launch, run, walker
legs = np.zeros((1, walker.N_LEG, 1))
legs[0, :7, 0] = 0, 0, 1, 0.03, 0.01, 1.0, 0
start = np.full((launch.N_START, 1), 0.1)
w = run.run(np.zeros((2, 1)), legs, -np.ones(1), np.zeros(1), np.zeros((0, 3)), start, 4, 0.0, 1.0, 0, 0)[1]
print(w.stance[0, walker.FOOT_Y, 0])
"""


def test_an_edit_of_one_file_reaches_the_others(tmp_path: Path) -> None:
    shutil.copytree(
        Path(legspring.__file__).parent, tmp_path / "legspring", ignore=shutil.ignore_patterns("__pycache__")
    )

    def foot() -> float:
        environment = os.environ | {"PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
        run = subprocess.run(
            [sys.executable, "-P", "-c", CODE], env=environment, capture_output=True, text=True, check=True
        )
        return float(run.stdout)

    before = foot()
    assert foot() == before
    law = tmp_path / "legspring" / "kernel" / "length.py"
    law.write_text(law.read_text().replace("a - b * sine", "2.0 * a - b * sine"))
    # The leg is put down as much further ahead as its nominal length, 3 cm, says.
    assert abs(foot() - before - 0.03) < 1e-12
