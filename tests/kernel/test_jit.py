"""Machine code on disk is never older than the source."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import legspring

CODE = """
import numpy as np
from legspring.kernel import many, walker
none = np.zeros(1)
w = walker.new_walker(-np.ones(1), none, none, none, np.zeros((0, 3)), 4, 0)
p = np.array([*[0.1] * 7, 0, 9.81, 1, 1, 0.1, 1, 0, 0, 1, 0.03, 0.01, 1.0, 0, 0, 0, 0])
tape, ends = walker.new_tape(0, 0, w), many.new_ends(1, 0, 0, w)
many.many(w, tape, p[None], np.zeros((0, len(p))), np.zeros((0, 0, 3)), 0.0, 0, 1.0, False, ends)
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
