"""The four ways in which this package compiles: all release Python's lock and use fused multiply-adds.

Division by zero gives infinity, as in NumPy, so that loops stay free of branches. Numba counts references to arrays
at every call, at the cost of several right-hand sides a call: what does not make arrays goes without.
"""

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numba

P = ParamSpec("P")
R = TypeVar("R")

OPTIONS = {"nogil": True, "error_model": "numpy", "fastmath": {"contract", "nsz", "arcp"}}
njit: Any = numba.njit  # its types leave out some of its options


SOURCES = sorted(Path(__file__).parent.glob("*.py"))
FINGERPRINT = hashlib.sha256(b"\0".join(path.read_bytes() for path in SOURCES)).hexdigest()


def kept(compiled: Any) -> Any:
    """Keep machine code on disk for as long as no file of the kernel changes.

    Numba looks at a function's own file only, and would go on using old code of the functions that it calls; this puts
    all files in the place of that one.
    """
    compiled.enable_caching()
    compiled._cache._cache_file._source_stamp = FINGERPRINT
    return compiled


def driver(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function that makes arrays and hands them down."""
    compiled: Callable[P, R] = kept(njit(**OPTIONS)(function))
    return compiled


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
