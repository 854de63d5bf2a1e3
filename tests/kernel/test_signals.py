"""A signal that raises while the kernel runs comes out as what it raises, wherever it hits."""

import importlib
import os
import pkgutil
import subprocess
import sys
import typing

import pytest

import legspring.kernel

CODE = """
import random, signal, sys, time
import legspring as ls
from legspring.flow import flow
from legspring.asking import tuned
from legspring.solve import solve
from legspring.starts import starts_for

class Alarm(Exception):
    pass

def ring(*_):
    raise Alarm

def work():
    flow(gait.system, gait.point, steps=2, record=True)
    problem = tuned(gait.animal, gait.slope, gait.heading, gait.family)
    solve(problem, starts_for(problem, 1), 1e-8, 1e-7)

gait = ls.find_gaits(ls.cockroach(), slope_deg=45, heading=0.15)[0]
work()
start = time.perf_counter()
work()
span = time.perf_counter() - start
signal.signal(signal.SIGALRM, ring)
for _ in range(int(sys.argv[1])):
    try:
        signal.setitimer(signal.ITIMER_REAL, 1e-6 + random.random() * span)
        work()
        time.sleep(10.0)
    except Alarm:
        continue
    raise AssertionError("no alarm")
print("all well")
"""


@pytest.mark.skipif(os.name == "nt", reason="needs timers")
@pytest.mark.parametrize("count", [200, pytest.param(1000, marks=pytest.mark.long)])
def test_a_signal_comes_out_as_what_it_raises(count: int) -> None:
    done = subprocess.run([sys.executable, "-c", CODE, str(count)], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, "all well\n", "")


def test_nothing_compiled_makes_a_named_tuple_for_python() -> None:
    """Boxing one runs Python, where a signal may raise, unseen by the compiled code."""
    for module in pkgutil.iter_modules(legspring.kernel.__path__):
        for name, found in vars(importlib.import_module(f"legspring.kernel.{module.name}")).items():
            if hasattr(found, "py_func") and not found.targetoptions.get("no_cpython_wrapper"):
                result = typing.get_type_hints(found.py_func)["return"]
                inside = {result, *typing.get_args(result)}
                assert not any(hasattr(kind, "_fields") for kind in inside), f"{module.name}.{name}"
