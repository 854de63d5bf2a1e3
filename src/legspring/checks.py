"""Checks of arguments: what comes from outside is a finite number, or an error of one line says what it must be.

A number is a real one of Python's or NumPy's, or an array without dimensions; no truth value, no text, none that is
masked or too large for a float.
"""

import math
import numbers
import os
import reprlib
from collections.abc import Iterable
from itertools import islice, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

UNFIT = TypeError, ValueError, ArithmeticError, AttributeError, LookupError, RecursionError, NotImplementedError
"""What objects raise that are no numbers, or cannot be shown; an interruption is none of these."""
LONGEST_GRID = 100_000
LARGEST_GROUP = 1000
LARGEST_SEED = 2**63 - 1
MOST_STARTS = 1_000_000


def shown(value: object) -> str:
    """Return a value as an error shows it: short, in one line."""
    try:
        return " ".join(reprlib.repr(value).split())
    except UNFIT:
        return f"<{type(value).__name__}>"


def _number(value: Any) -> float:
    """Return a number as a float; nan if it is none."""
    try:
        if not isinstance(value, numbers.Real):
            # What is no array may be too long to be made one.
            if not hasattr(value, "__array__"):
                return math.nan
            array = np.ma.asanyarray(value)
            if array.ndim or array.dtype.kind not in "fiu" or np.ma.is_masked(array):
                return math.nan
            value = array.item()
        return math.nan if isinstance(value, bool) else float(value)
    except UNFIT:
        return math.nan


def checked_number(name: str, value: Any, valid: str = "a finite number", most: float = math.inf) -> float:
    """Return a number as a float.

    Parameters
    ----------
    name, value
        The argument.
    valid
        What is valid, in words.
    most
        Largest magnitude.

    Raises
    ------
    ValueError
        If it is no finite number, or too large.
    """
    number = _number(value)
    if not (math.isfinite(number) and abs(number) <= most):
        raise ValueError(f"{name} = {shown(value)}: must be {valid}")
    return number


def checked_positive(name: str, value: Any) -> float:
    """Return a positive finite number as a float; raise ValueError if it is none."""
    valid = "a positive finite number"
    number = checked_number(name, value, valid)
    if number <= 0.0:
        raise ValueError(f"{name} = {shown(value)}: must be {valid}")
    return number


def checked_angle(name: str, value: Any, largest: float) -> float:
    """Return an angle of at most the largest magnitude as a float, all in rad; raise ValueError if it is none."""
    limit = f"{largest:.4g} rad ({math.degrees(largest):g} deg)"
    return checked_number(name, value, f"a finite angle within +-{limit}", largest * (1.0 + 1e-12))


def checked_slope(slope: Any, slope_deg: Any) -> float:
    """Return the one slope that is given, in rad.

    Raises
    ------
    ValueError
        If both or none are given, or it is beyond the vertical.
    """
    if (slope is None) == (slope_deg is None):
        raise ValueError("give either slope (rad) or slope_deg (degrees)")
    if slope_deg is not None:
        return math.radians(checked_number("slope_deg", slope_deg, "a finite angle from -90 to 90 degrees", 90.0))
    return checked_angle("slope", slope, math.pi / 2)


def checked_whole(name: str, value: Any, least: int, most: int) -> int:
    """Return a whole number as an int; raise ValueError if it is none, or out of range."""
    if isinstance(value, np.ndarray) and value.ndim == 0 and not np.ma.is_masked(value):
        value = value.item()
    whole = isinstance(value, numbers.Integral) and not isinstance(value, bool)
    if not (whole and least <= value <= most):
        raise ValueError(f"{name} = {shown(value)}: must be a whole number from {least} to {most}")
    return int(value)


def checked_choice(name: str, value: Any, valid: Iterable[str]) -> None:
    """Raise ValueError unless a value is one of some words."""
    words = list(valid)
    if not (isinstance(value, str) and value in words):
        raise ValueError(f"{name} = {shown(value)}: must be {' or '.join(map(repr, words))}")


def checked_names(name: str, value: Any) -> tuple[str, ...]:
    """Return a sequence of distinct names as a tuple.

    Raises
    ------
    ValueError
        If it is something else.
    """
    try:
        names = tuple(islice(iter(value), LARGEST_GROUP)) if not isinstance(value, str | bytes) else ()
    except UNFIT:
        names = ("", "")
    given = isinstance(value, str | bytes) or len(set(map(str, names))) < len(names)
    if given or not all(isinstance(one, str) for one in names):
        raise ValueError(f"{name} = {shown(value)}: must be a sequence of different names")
    return names


def checked_workers(workers: Any) -> int:
    """Return the number of threads or processes: one a core, unless said otherwise."""
    cores = os.cpu_count() or 1
    return cores if workers is None else checked_whole("workers", workers, 1, 4 * cores)


def _numbers(values: Any, most: int) -> list[float]:
    """Return numbers as floats, nan for what is none; a single one for itself; no more than one too many."""
    if isinstance(values, np.ndarray) and values.ndim:
        # A row or a column is a vector, too.
        values = np.ma.asanyarray(values).ravel()
    elif not isinstance(values, Iterable) or not getattr(values, "ndim", 1):
        return [_number(values)]
    if isinstance(values, str | bytes):
        return [math.nan]
    return [_number(value) for value in islice(values, most + 1)]


def checked_vector(name: str, value: Any, size: int) -> Floats:
    """Return an array of finite numbers of the given size, repeating a single number.

    Raises
    ------
    ValueError
        If there are more or fewer numbers, or one is not finite.
    """
    if type(value) is np.ndarray and value.dtype == float and value.shape == (size,) and np.isfinite(value).all():
        # What searches ask for, many times.
        return value.copy()
    vector = _numbers(value, size)
    if len(vector) == 1:
        vector *= size
    if len(vector) != size or not all(map(math.isfinite, vector)):
        raise ValueError(f"{name} = {shown(value)}: must be {size} finite numbers, or one for all")
    return np.array(vector)


def checked_grid(name: str, values: Any, largest: float, *, least: int = 1) -> tuple[float, ...]:
    """Return a grid as floats; raise ValueError unless its numbers rise and are in range, and there are enough."""
    grid = _numbers(values, LONGEST_GRID)
    rising = all(low < high for low, high in pairwise(grid))
    if not (least <= len(grid) <= LONGEST_GRID and rising and all(abs(value) <= largest for value in grid)):
        many = "one or more" if least == 1 else "some"
        raise ValueError(f"{name} = {shown(values)}: must be {many} rising numbers within +-{largest:.5g}")
    return tuple(grid)
