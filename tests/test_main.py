"""The program: a signal ends it at once, with one line, whatever it does, and nothing is left."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

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
def test_also_while_it_is_loading(seconds: float, tmp_path: Path) -> None:
    """And just after that: of a command that takes long, however fast the machine is."""
    program = start("-m", "legspring", "atlas", "cockroach", "--out", str(tmp_path / "a.nc"), "--slopes", "0:90:0.1")
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


def finished(*command: str | bytes, **options: Any) -> tuple[int, str, str]:
    """Run the program; return its exit status and what it printed."""
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | options
    options["env"] = os.environ | options.pop("more", {})
    done: subprocess.CompletedProcess[Any] = subprocess.run([sys.executable, *command], **options)
    return done.returncode, (done.stdout or b"").decode(), (done.stderr or b"").decode()


def test_a_mistake_in_the_program_is_one_line_and_not_hidden() -> None:
    mistake = "import sys; sys.modules['legspring.cli'] = None; from legspring.__main__ import main; main()"
    status, _, errors = finished("-c", mistake)
    line = "legspring: a mistake in Legspring itself (LEGSPRING_DEBUG=1 shows where): ModuleNotFoundError: "
    assert status == 70 and errors.startswith(line) and errors.count("\n") == 1 and len(errors) <= 301
    status, _, errors = finished("-c", mistake, more={"LEGSPRING_DEBUG": "1"})
    assert status == 70 and errors.startswith("Traceback") and line in errors


def test_where_nobody_reads_on_it_ends_quietly() -> None:
    for arguments in (["presets"], ["--help"], ["presets", "--json"], ["gaits", "roach"]):
        for unbuffered in ("", "1"):
            reader, writer = os.pipe()
            os.close(reader)
            status, _, errors = finished(
                "-m", "legspring", *arguments, stdout=writer, more={"PYTHONUNBUFFERED": unbuffered}
            )
            os.close(writer)
            assert status == (2 if arguments[0] == "gaits" else 1)
            assert errors.count("\n") == (arguments[0] == "gaits") and "Traceback" not in errors


def test_where_nobody_hears_of_errors_it_ends_quietly() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    assert finished("-m", "legspring", "gaits", "roach", stderr=writer)[:2] == (1, "")
    os.close(writer)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a disk that is full")
def test_what_cannot_be_printed_is_an_error_of_one_line() -> None:
    with open("/dev/full", "w") as full:
        status, _, errors = finished("-m", "legspring", "presets", stdout=full)
    assert status != 0 and "No space left on device" in errors and errors.count("\n") == 1


ENCODINGS = [
    {"PYTHONIOENCODING": "ascii"},
    {"LANG": "C", "LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
]


@pytest.mark.parametrize("more", ENCODINGS, ids=lambda more: next(iter(more.values())))
def test_what_an_output_cannot_show_is_escaped(more: dict[str, str], tmp_path: Path) -> None:
    (tmp_path / "odd.toml").write_text('like = "cockroach"\nname = "r\u0434\u00e9"\n', encoding="utf-8")
    status, out, errors = finished("-m", "legspring", "gaits", str(tmp_path / "odd.toml"), *HERE, more=more)
    assert (status, errors) == (0, "") and "\\u0434" in out and "0.2731" in out
    status, out, errors = finished("-m", "legspring", "gaits", "r\u0434".encode(), *HERE, more=more)
    assert status == 2 and errors.count("\n") == 1 and "Traceback" not in errors


@pytest.mark.skipif(sys.platform != "linux", reason="needs names that are no text")
def test_files_whose_names_are_no_text(tmp_path: Path) -> None:
    name = os.fsencode(tmp_path) + b"/caf\xe9\xff"
    status, _, errors = finished("-m", "legspring", "gaits", name + b".toml", *HERE)
    assert status == 2 and errors.endswith("caf\\udce9\\udcff.toml: No such file or directory\n")
    with open(name + b".toml", "w") as file:
        file.write('like = "cockroach"')
    output = [b"--out", name + b".nc", b"--figure", name + b".png"]
    status, out, errors = finished("-m", "legspring", "simulate", name + b".toml", *HERE, *output)
    assert (status, errors) == (0, "") and out.startswith("caf\\udce9\\udcff, family B")
    assert os.path.getsize(name + b".nc") > 1000 and os.path.getsize(name + b".png") > 1000
