"""Set up Legspring in .venv and run it, with nothing but Python 3.11 or newer to start from.

python3 dev.py test [PYTEST ARGUMENTS]    all checks: ruff, mypy, pytest
python3 dev.py run ARGUMENTS              the command legspring
python3 dev.py docs [--quick]             the documentation, in docs/_build/html; --quick leaves out what takes long
python3 dev.py bench [ARGUMENTS]          the benchmarks
python3 dev.py fuzz [--examples N] [--animals N]   random input, 10000 examples by default; 300 random animals; signals
python3 dev.py smoke                      installation and first steps with all Pythons there are
"""

# No syntax here that older Pythons lack: they are to say what is wrong, not to stumble over it.
from __future__ import annotations

import argparse
import hashlib
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent
VENV = ROOT / ".venv"
BIN = VENV / ("Scripts" if os.name == "nt" else "bin")
STAMP = VENV / "legspring-installed"
OLDEST = (3, 11)
# Of all tests a file runs in one process, so that what its tests share is computed once.
IN_PARALLEL = ["--numprocesses", "auto", "--maxprocesses", "4", "--dist", "loadfile"]


def main(arguments: list[str]) -> int:
    """Carry out one of the commands; return its exit status."""
    if sys.version_info < OLDEST:
        return fail(f"Legspring needs Python 3.11 or newer; {sys.executable} is {sys.version.split()[0]}.")
    command, *rest = arguments or ["help"]
    try:
        if command == "test":
            set_up("test")
            return test(rest)
        if command == "run":
            set_up()
            return run("legspring", *rest)
        if command == "docs":
            set_up("docs")
            return docs(rest)
        if command == "bench":
            set_up("bench")
            return run("python", str(ROOT / "benchmarks" / "run.py"), *rest)
        if command == "fuzz":
            set_up("test")
            return fuzz(rest)
        if command == "smoke":
            return subprocess.run([sys.executable, str(ROOT / "tests" / "smoke.py"), *rest]).returncode
    except subprocess.CalledProcessError as error:
        return fail(f"The set-up failed: {' '.join(map(str, error.cmd))}")
    return fail(str(__doc__).strip())


def set_up(*extras: str) -> None:
    """Install the package and its extras into .venv, unless that has been done."""
    inputs = [(ROOT / name).read_bytes() for name in ("pyproject.toml", "constraints.txt")]
    # An environment works for one interpreter and in one place.
    inputs += [sys.version.encode(), str(ROOT).encode()]
    wanted = hashlib.sha256(b"\0".join(inputs)).hexdigest()
    found, *installed = (STAMP.read_text() if STAMP.exists() else "").split() or [""]
    if found == wanted and set(extras) <= set(installed):
        return
    print("Setting up .venv ...", file=sys.stderr, flush=True)
    STAMP.unlink(missing_ok=True)
    subprocess.run([sys.executable, "-m", "venv", VENV], check=True)
    pip: list[str | Path] = [BIN / "python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    target = f".[{','.join(extras)}]" if extras else "."
    subprocess.run([*pip, "-c", "constraints.txt", "-e", target], check=True, cwd=ROOT)
    kept = installed if found == wanted else []
    STAMP.write_text("\n".join([wanted, *sorted({*extras, *kept})]))


def test(arguments: list[str]) -> int:
    """Run every check, even after one has failed, and name those that did."""
    checks = {
        "ruff check": ["ruff", "check"],
        "ruff format": ["ruff", "format", "--check"],
        "mypy": ["mypy"],
        "pytest": ["pytest", *(arguments or IN_PARALLEL)],
    }
    failed = []
    for name, command in checks.items():
        print(f"== {name}", flush=True)
        if run(*command, cwd=ROOT):
            failed.append(name)
    return fail(f"Failed: {', '.join(failed)}") if failed else 0


def docs(arguments: list[str]) -> int:
    """Build the documentation, in which every example is run, and check its links; warnings are errors."""
    parser = argparse.ArgumentParser(prog="dev.py docs")
    parser.add_argument("--quick", action="store_true", help="show the long notebooks without running them")
    quick = parser.parse_args(arguments).quick
    os.environ["LEGSPRING_DOCS"] = "quick" if quick else "whole"
    source, build = ROOT / "docs", ROOT / "docs" / "_build"
    pages = build / "html"
    if not quick:
        # Two pages show the thesis: what both need is computed before.
        (build / "pages").mkdir(parents=True, exist_ok=True)
        run("legspring", "reproduce", "--out", str(build / "pages" / "thesis"))
    # One page after another: kernels that start at once may be given the same port.
    options = ["-W", "--keep-going", "-q", "-d", str(build / "doctrees")]
    failed = run("sphinx-build", *options, str(source), str(pages), cwd=ROOT)
    failed = failed or run("python", str(source / "links.py"), str(pages))
    print(f"The documentation is in {pages / 'index.html'}." if not failed else "", file=sys.stderr)
    return failed


def fuzz(arguments: list[str]) -> int:
    """Try random input, as much as is asked for, and then how commands end that are not left to finish."""
    parser = argparse.ArgumentParser(prog="dev.py fuzz")
    parser.add_argument("--examples", type=int, default=10_000)
    parser.add_argument("--animals", type=int, default=300)
    numbers = parser.parse_args(arguments)
    os.environ["LEGSPRING_FUZZ"] = str(numbers.examples)
    tried = run("pytest", str(ROOT / "tests" / "fuzz"), cwd=ROOT)
    tried |= run("pytest", str(ROOT / "tests" / "test_random_animals.py"), "--animals", str(numbers.animals), cwd=ROOT)
    return run("python", str(ROOT / "tests" / "fuzz" / "kills.py"), cwd=ROOT) or tried


def run(program: str, *arguments: str, cwd: Path | None = None) -> int:
    """Run one of .venv's programs; return its exit status."""
    return subprocess.run([BIN / program, *arguments], cwd=cwd).returncode


def fail(message: str) -> int:
    """Say what is wrong; return the exit status for it."""
    print(message, file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
