"""The five ways in which this package compiles: all release Python's lock and use fused multiply-adds.

Division by zero gives infinity, as in NumPy, so that loops stay free of branches. Numba counts references to arrays
at every call, at the cost of several right-hand sides a call: what does not make arrays goes without.

What Python calls must return numbers, arrays and plain tuples of them only. A named tuple is made by running Python,
in which a signal (Ctrl-C) may raise; compiled code does not look, and crashes.
"""

import hashlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numba
import numba.extending
from numba.core import serialize

from legspring.kernel.cache import check_compiler, keep

P = ParamSpec("P")
R = TypeVar("R")

OPTIONS = {"nogil": True, "error_model": "numpy", "fastmath": {"contract", "nsz", "arcp"}}
check_compiler()
njit: Any = numba.njit  # its types leave out some of its options
# Where compiled code hands an array to Python, Numba looks up what it knows by this function, in Python: the one place
# left for a signal to raise where nobody looks, so that it comes out as a SystemError. A cache written in C is none.
if hasattr(serialize, "_numba_unpickle"):
    serialize._numba_unpickle = cache(serialize._numba_unpickle)


SOURCES = sorted(Path(__file__).parent.glob("*.py"))
FINGERPRINT = hashlib.sha256(b"\0".join(path.read_bytes() for path in SOURCES)).hexdigest()


def kept(compiled: Any) -> Any:
    """Keep machine code on disk for as long as no file of the kernel changes.

    Numba looks at a function's own file only, and would go on using old code of the functions that it calls; this puts
    all files in the place of that one.
    """
    keep(compiled, FINGERPRINT)
    return compiled


def driver(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function that makes arrays and hands them down."""
    compiled: Callable[P, R] = kept(njit(**OPTIONS)(function))
    return compiled


def maker(function: Callable[P, R]) -> Callable[P, R]:
    """Leave a function that makes a named tuple of arrays to Python, and compile it into those that call it."""
    made: Callable[P, R] = numba.extending.register_jitable(**OPTIONS)(function)
    return made


def jit(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function that only works on arrays that it is given."""
    compiled: Callable[P, R] = kept(njit(_nrt=False, **OPTIONS)(function))
    return compiled


def formula(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function that only works on what it is given into its callers, where it costs no call."""
    compiled: Callable[P, R] = njit(
        forceinline=True, no_cpython_wrapper=True, no_cfunc_wrapper=True, _nrt=False, **OPTIONS
    )(function)
    return compiled


def part(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a part of one other function, split off for the reader's sake, as if it stood there."""
    compiled: Callable[P, R] = njit(inline="always", _nrt=False, **OPTIONS)(function)
    return compiled
