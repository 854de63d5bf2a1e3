"""The four ways in which this package compiles: all release Python's lock and use fused multiply-adds.

Division by zero gives infinity, as in NumPy, so that loops stay free of branches. Numba counts references to arrays
at every call, at the cost of several right-hand sides a call: what does not make arrays goes without.
"""

from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

import numba

P = ParamSpec("P")
R = TypeVar("R")

OPTIONS = {"nogil": True, "error_model": "numpy", "fastmath": {"contract", "nsz", "arcp"}}
njit: Any = numba.njit  # its types leave out some of its options


def driver(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function that makes arrays and hands them down."""
    compiled: Callable[P, R] = njit(cache=True, **OPTIONS)(function)
    return compiled


def jit(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function that only works on arrays that it is given."""
    compiled: Callable[P, R] = njit(cache=True, _nrt=False, **OPTIONS)(function)
    return compiled


def formula(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function that only works on what it is given into its callers, where it costs no call."""
    compiled: Callable[P, R] = njit(forceinline=True, _nrt=False, **OPTIONS)(function)
    return compiled


def part(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a part of one other function, split off for the reader's sake, as if it stood there."""
    compiled: Callable[P, R] = njit(inline="always", _nrt=False, **OPTIONS)(function)
    return compiled
