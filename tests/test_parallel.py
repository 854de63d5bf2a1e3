"""Work shared among processes."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from legspring.parallel import processes

HERE = str(Path(__file__).parents[1])


def number() -> int:
    return os.getpid()


def double(x: float) -> float:
    return 2.0 * x


def fail(x: float) -> None:
    raise ValueError(f"x = {x}")


def die() -> None:
    os._exit(3)


@pytest.fixture(autouse=True)
def importable(monkeypatch: pytest.MonkeyPatch) -> None:
    """Processes import what they work on; here, this file, under the name that pytest has given it."""
    monkeypatch.syspath_prepend(HERE)


@pytest.mark.parametrize("count", [1, 2])
def test_results_come_in_order(count: int) -> None:
    with processes(count) as pool:
        assert list(pool.map(pool.call, [(double, float(n)) for n in range(20)])) == [2.0 * n for n in range(20)]


def test_one_process_is_this_one() -> None:
    with processes(1) as pool:
        assert pool.call(number) == os.getpid()


def test_processes_are_used_again_and_end_with_the_block() -> None:
    with processes(2) as pool:
        first = {pool.call(number) for _ in range(3)}
        with processes(2) as inner:
            assert inner is pool
        assert {pool.call(number)} == first and len(first) == 1
        worker = pool._all[0].process
        assert worker.poll() is None
    assert worker.poll() is not None


def test_errors_are_those_of_the_work() -> None:
    with processes(2) as pool:
        with pytest.raises(ValueError, match="x = 3"):
            pool.call(fail, 3.0)
        assert pool.call(double, 1.0) == 2.0
        with pytest.raises(ChildProcessError, match="ended by itself"):
            pool.call(die)


def test_work_that_is_abandoned_ends_at_once() -> None:
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt), processes(2) as pool:
        pool._threads.submit(pool.call, time.sleep, 60.0)
        time.sleep(0.5)
        raise KeyboardInterrupt
    assert time.monotonic() - start < 20.0


CODE = """
import os, time
from legspring.parallel import processes
with processes(2) as pool:
    print(pool.call(os.getpid), flush=True)
    pool.call(time.sleep, 600.0)
"""


@pytest.mark.skipif(os.name == "nt", reason="asks the system in its own way")
def test_processes_end_with_their_program_however_that_ends() -> None:
    with subprocess.Popen([sys.executable, "-c", CODE], stdout=subprocess.PIPE, text=True) as program:
        assert program.stdout is not None
        worker = int(program.stdout.readline())
        os.kill(worker, 0)
        program.kill()
    for _ in range(100):
        try:
            os.kill(worker, 0)
            if Path(f"/proc/{worker}/stat").exists() and " Z " in Path(f"/proc/{worker}/stat").read_text():
                return
        except (ProcessLookupError, FileNotFoundError):
            return
        time.sleep(0.1)
    raise AssertionError("still there")
