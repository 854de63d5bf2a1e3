"""The program: a signal ends it at once, with one line, whatever it does, and nothing is left."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(os.name == "nt", reason="needs signals")
ENDS = {signal.SIGINT: (130, "legspring: interrupted\n"), signal.SIGTERM: (143, "legspring: terminated\n")}
HERE = ["--slope", "45", "--heading", "0.15"]

# A command that has everything: processes at work, a file half written, an output that nobody reads.
BUSY = """
import os, sys, time, types
from legspring.files import whole_file
from legspring.parallel import processes
from legspring.__main__ import main

def app(**_):
    with processes(2) as pool, whole_file(sys.argv[1]) as part:
        part.write_text("half of")
        print(pool.call(os.getpid), flush=True)
        {}

sys.modules["legspring.cli"] = types.SimpleNamespace(app=app)
main()
"""
WAYS = {
    "in a process": "pool.call(time.sleep, 600.0)",
    "in Python": "while True: pass",
    "in an endless output": "while True: print(100 * 'x')",
    "in compiled code": "import hashlib; hashlib.pbkdf2_hmac('sha256', b'x', b'x', 10**9)",
}


def start(*command: str, **more: str) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, *command],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | more,
        # A terminal's Ctrl-C goes to the whole group.
        start_new_session=True,
        # What a shell runs in the background ignores interruptions, and so would its children.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )


def ended(program: "subprocess.Popen[str]", number: signal.Signals, times: int = 1) -> str:
    """Send a signal; make sure that the program ends as it should; return what it said before."""
    before = time.monotonic()
    for _ in range(times):
        os.killpg(program.pid, number)
    try:
        code = program.wait(10.0)
        took = time.monotonic() - before
        _, errors = program.communicate(timeout=10.0)
    finally:
        program.kill()
    status, words = ENDS[number]
    assert code == status and errors.endswith(words), errors
    assert took < 1.0
    return errors.removesuffix(words)


def is_gone(number: int) -> bool:
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return True
    status = Path(f"/proc/{number}/stat")
    return status.exists() and " Z " in status.read_text()


@pytest.mark.parametrize("number", ENDS)
@pytest.mark.parametrize("way", WAYS)
def test_a_signal_ends_everything(number: signal.Signals, way: str, tmp_path: Path) -> None:
    program = start("-c", BUSY.format(WAYS[way]), str(tmp_path / "a.nc"))
    assert program.stdout is not None
    worker = int(program.stdout.readline())
    time.sleep(0.2)
    assert ended(program, number, times=2) == ""
    assert is_gone(worker)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("seconds", [0.3, 0.6, 1.2, 2.0])
def test_also_while_it_is_loading(seconds: float) -> None:
    program = start("-m", "legspring", "gaits", "cockroach", *HERE)
    time.sleep(seconds)
    assert ended(program, signal.SIGTERM) in ("", "legspring: compiling (about half a minute, once) ...\n")


@pytest.mark.parametrize("number", ENDS)
def test_also_while_it_is_compiling(number: signal.Signals, tmp_path: Path) -> None:
    program = start("-m", "legspring", "gaits", "lateral_leg_spring", NUMBA_CACHE_DIR=str(tmp_path))
    assert program.stderr is not None
    notice = program.stderr.readline()
    time.sleep(2.5)
    assert ended(program, number) == ""
    assert notice == "legspring: compiling (about half a minute, once) ...\n"


def test_also_in_a_map(tmp_path: Path) -> None:
    program = start("-m", "legspring", "atlas", "cockroach", "--out", str(tmp_path / "a.nc"), "--slopes", "0:90:0.1")
    time.sleep(4.0)
    ended(program, signal.SIGINT)
    assert not list(tmp_path.iterdir())


def test_what_a_shell_has_in_the_background_ignores_interruptions() -> None:
    program = subprocess.Popen(
        [sys.executable, "-m", "legspring", "presets"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN),
    )
    time.sleep(0.3)
    program.send_signal(signal.SIGINT)
    out, errors = program.communicate(timeout=60)
    assert program.returncode == 0 and "cockroach" in out and errors == ""


def test_a_mistake_in_the_program_is_not_hidden() -> None:
    code = "import sys; sys.modules['legspring.cli'] = None; from legspring.__main__ import main; main()"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 1 and "ModuleNotFoundError" in done.stderr
