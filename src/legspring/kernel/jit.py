"""The one way in which this package compiles."""

from collections.abc import Callable
from typing import ParamSpec, TypeVar

import numba

P = ParamSpec("P")
R = TypeVar("R")

OPTIONS = {"nogil": True, "error_model": "numpy", "fastmath": {"contract", "nsz", "arcp"}}


def jit(function: Callable[P, R]) -> Callable[P, R]:
    """Compile to machine code, kept on disk, without Python's lock, with fused multiply-adds.

    Division by zero gives infinity, as in NumPy, so that loops stay free of branches.
    """
    compiled: Callable[P, R] = numba.njit(cache=True, **OPTIONS)(function)
    return compiled


def formula(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a short function into its callers: there it costs no call, and no counting of references."""
    compiled: Callable[P, R] = numba.njit(forceinline=True, **OPTIONS)(function)
    return compiled
