"""Machine code on disk is never older than the source."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import legspring

# The force-free length of a leg on a tape that was written by hand.
CODE = """
import numpy as np
from legspring.kernel import measure, walker
none = np.zeros(1)
w = walker.new_walker(-np.ones(1), none, none, none, np.zeros((0, 3)), 4, 0)
tape = walker.new_tape(1, 0, w)
for one in tape:
    one[...] = 1
tape.stance[0, 0, walker.LAW, 0] = 0.03
legs = np.zeros((1, 1, 4))
measure.write_series(tape, np.zeros(1, dtype=np.int64), none, np.zeros((1, *tape.y.shape[1:])), legs)
print(legs[0, 0, 0])
"""


@pytest.mark.long
def test_an_edit_of_one_file_reaches_the_others(tmp_path: Path) -> None:
    shutil.copytree(
        Path(legspring.__file__).parent, tmp_path / "legspring", ignore=shutil.ignore_patterns("__pycache__")
    )

    def length() -> float:
        environment = os.environ | {"PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
        run = subprocess.run(
            [sys.executable, "-P", "-c", CODE], env=environment, capture_output=True, text=True, check=True
        )
        return float(run.stdout)

    before = length()
    assert length() == before
    law = tmp_path / "legspring" / "kernel" / "length.py"
    law.write_text(law.read_text().replace("a - b * sine", "2.0 * a - b * sine"))
    assert abs(length() - before - 0.03) < 1e-12
