"""Real commands that are stopped at random moments: how they end, and what they leave; for ``python3 dev.py fuzz``."""

import argparse
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

HERE = ["--slope", "45", "--heading", "0.15"]
COMMANDS = {
    "presets": ["presets", "--figure", "all.png", "--figures", "each"],
    "gaits": ["gaits", "cockroach", *HERE, "--figure", "gait.png", "--json"],
    "passive gaits": ["gaits", "lateral_leg_spring"],
    "simulate": ["simulate", "cockroach", *HERE, "--strides", "200", "--out", "run.nc", "--figure", "run.pdf"],
    "recover": ["recover", "cockroach", *HERE, "--figure", "recovery.svg"],
    "atlas": [
        "atlas",
        "cockroach",
        "--out",
        "atlas.nc",
        "--slopes",
        "0:90:15",
        "--headings",
        "0.1,0.2",
        "--figures",
        "maps",
    ],
    "optimize": ["optimize", "cockroach", *HERE],
    "sweep": [
        *(
            "sweep",
            "cockroach",
            *HERE,
            "--follow",
            "--over",
            "slope_deg=40:50:0.1",
            "--over",
            "mass=0.002:0.003:0.0001",
        ),
        *("--store", "runs.zarr", "--out", "sweep.nc"),
    ],
    "reproduce": ["reproduce", "--out", "thesis", "--only", "2.2,4.1", "--workers", "2"],
}
LONGEST = {"presets": 6.0, "atlas": 9.0, "optimize": 6.0, "reproduce": 12.0}
"""Latest moment to stop a command, s; 4 s for the others."""
SIGNALS = {signal.SIGINT: (130, "interrupted"), signal.SIGTERM: (143, "terminated"), signal.SIGKILL: (-9, "")}
START = 0.5
"""How long Python may take before the program is there to answer, s."""
SAID = ("legspring: compiling", "each/", "left out")
"""How lines on the error stream may begin that are about the work."""


def main() -> int:
    """Stop commands; count how that went."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    chance = random.Random(options.seed)
    outcomes: Counter[str] = Counter()
    folder = Path(tempfile.mkdtemp(prefix="legspring-kills-"))
    names = [*COMMANDS]
    for number in range(options.count):
        name, how = names[number % len(names)], list(SIGNALS)[number // len(names) % len(SIGNALS)]
        seconds = chance.uniform(0.05, LONGEST.get(name, 4.0))
        faults = [*stopped(COMMANDS[name], how, seconds, folder, outcomes)]
        for fault in faults:
            print(f"{name}, {how.name} after {seconds:.2f} s: {fault}", flush=True)
        outcomes["faults"] += len(faults)
    for fault in finishing(folder):
        print(f"afterwards: {fault}", flush=True)
        outcomes["faults"] += 1
    shutil.rmtree(folder)
    print("\n".join(f"{count:7d}  {what}" for what, count in sorted(outcomes.items())))
    return int(outcomes["faults"] > 0)


def stopped(
    command: list[str], how: signal.Signals, seconds: float, folder: Path, outcomes: Counter[str]
) -> Iterator[str]:
    """Stop a command after a time; yield what is wrong with how it ended and what it left."""
    program = started(command, folder)
    time.sleep(seconds)
    group = family(program.pid)
    over = program.poll() is not None
    began = time.monotonic()
    if not over:
        program.send_signal(how)
    try:
        _, errors = program.communicate(timeout=30.0)
    except subprocess.TimeoutExpired:
        program.kill()
        yield "it does not end"
        return
    took = time.monotonic() - began
    status, words = SIGNALS[how]
    outcomes[f"{how.name}: {'it was over' if program.returncode == 0 else f'status {program.returncode}'}"] += 1
    lines = [line for line in errors.splitlines() if not line.startswith(SAID)]
    if program.returncode == 0:
        status, words = 0, ""
    elif seconds < START and how == signal.SIGTERM and program.returncode == -how:
        # Python itself was still starting.
        status, words = -how, ""
    if program.returncode != status:
        yield f"status {program.returncode}: {errors[-300:]}"
    if lines != ([f"legspring: {words}"] if words else []):
        yield f"it said {lines}"
    if took > 1.5 and not over and program.returncode != 0:
        yield f"it took {took:.2f} s to end"
    time.sleep(0.6)
    for number in group:
        if is_alive(number):
            yield f"process {number} is left"
    if how != signal.SIGKILL and (parts := list(folder.rglob("*.part"))):
        yield f"left {parts}"
    yield from damaged(folder)


def started(command: list[str], folder: Path) -> "subprocess.Popen[str]":
    """Start a command in a folder."""
    return subprocess.Popen(
        [sys.executable, "-m", "legspring", *command],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        # What a shell runs in the background ignores interruptions, and so would its children.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )


def family(parent: int) -> list[int]:
    """Return the processes that a process has started, and itself, where the system says so."""
    found = [parent]
    for task in Path(f"/proc/{parent}/task").glob("*/children"):
        # Threads come and go.
        with suppress(OSError):
            found += map(int, task.read_text().split())
    return found


def is_alive(number: int) -> bool:
    """Whether a process runs, and is not only waiting for somebody to ask how it ended."""
    status = Path(f"/proc/{number}/stat")
    return status.exists() and status.read_text().rsplit(")", 1)[1].split()[0] != "Z"


def damaged(folder: Path) -> Iterator[str]:
    """Yield the files that are not whole, and remove the others."""
    for file in folder.rglob("*"):
        if not file.is_file() or file.suffix == ".part" or "thesis" in file.parts:
            continue
        content = file.read_bytes()
        begins, ends = {
            ".png": (b"\x89PNG", b"IEND\xaeB`\x82"),
            ".pdf": (b"%PDF", b"%%EOF\n"),
            ".svg": (b"<?xml", b"</svg>\n"),
            ".nc": (b"\x89HDF", b""),
        }[file.suffix]
        if not (content.startswith(begins) and content.endswith(ends)):
            yield f"{file.name} is not whole"
        if file.suffix == ".nc":
            import xarray as xr

            with xr.open_dataset(file) as dataset:
                dataset.load()
        file.unlink()


def finishing(folder: Path) -> Iterator[str]:
    """Let every command finish where others were stopped; yield what is wrong then."""
    for name, command in COMMANDS.items():
        program = started(command, folder)
        out, errors = program.communicate(timeout=600.0)
        if program.returncode != 0 or not all(line.startswith(SAID) for line in errors.splitlines()):
            yield f"{name}: status {program.returncode}: {errors[-300:]}"
        if "--json" in command:
            json.loads(out)
    if parts := list(folder.rglob("*.part")):
        yield f"left {parts}"
    yield from damaged(folder)


if __name__ == "__main__":
    if os.name == "nt":
        sys.exit("needs signals")
    sys.exit(main())
