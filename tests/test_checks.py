"""Arguments are finite numbers, or refused in one line that names them."""

import os
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import xarray as xr

import legspring as ls
from legspring.checks import (
    checked_choice,
    checked_grid,
    checked_number,
    checked_vector,
    checked_whole,
    checked_workers,
    shown,
)

NUMBERS: list[Any] = [
    45,
    45.0,
    np.float32(45),
    np.int8(45),
    np.longdouble(45),
    np.array(45.0),
    np.array(45),
    np.ma.masked_array(45.0, mask=False),
    Fraction(45),
    xr.DataArray(45.0),
]
NONE: list[Any] = [
    "45",
    b"45",
    True,
    np.True_,
    np.array(True),
    10**400,
    10**5000,
    Decimal(45),
    45 + 0j,
    np.complex128(45),
    np.ma.masked,
    np.ma.masked_array(45.0, mask=True),
    np.array([45.0]),
    np.array("45"),
    [45.0],
    range(10**12),
    float("nan"),
    np.inf,
    -np.inf,
    np.longdouble("1e400"),
    None,
    object,
    np.datetime64("2011-01-01"),
]
NOT_WHOLE: list[Any] = [*NONE, 2.5, 2.0, np.float64(2.0), Fraction(2), 0, -1, 10**9]


def refused(call: Callable[[], Any], name: str) -> None:
    """Make sure that a call ends with one line that begins with an argument's name."""
    with pytest.raises(ValueError) as caught:
        call()
    message = str(caught.value)
    assert message.startswith(f"{name} = ") and ": must be " in message
    assert "\n" not in message and len(message) <= 300


@pytest.mark.parametrize("value", NUMBERS, ids=repr)
def test_what_is_a_number(value: Any) -> None:
    assert type(checked_number("x", value)) is float and checked_number("x", value) == 45.0
    np.testing.assert_array_equal(checked_vector("x", value, 2), [45.0, 45.0])
    np.testing.assert_array_equal(checked_vector("x", [value, value], 2), [45.0, 45.0])
    assert checked_grid("x", [value], 90.0) == (45.0,)


@pytest.mark.parametrize("value", NONE, ids=lambda value: shown(value)[:30])
def test_what_is_none(value: Any) -> None:
    refused(lambda: checked_number("x", value), "x")
    refused(lambda: checked_vector("x", [value, 1.0], 2), "x")
    refused(lambda: checked_grid("x", [value], 90.0), "x")
    refused(lambda: checked_whole("x", value, 0, 100), "x")


def test_arrays_and_grids() -> None:
    np.testing.assert_array_equal(checked_vector("x", np.array([[1, 2]]), 2), [1.0, 2.0])
    assert checked_grid("x", range(3), 90.0) == (0.0, 1.0, 2.0)
    assert checked_grid("x", (), 1.0, least=0) == ()
    for values in ("12", b"12", [2, 1], [], [0, 91], iter(int, 1), np.ma.masked_array([0, 1], mask=[False, True])):
        refused(lambda values=values: checked_grid("x", values, 90.0), "x")  # type: ignore[misc]
    refused(lambda: checked_vector("x", iter(int, 1), 3), "x")


def test_whole_numbers() -> None:
    for value in (5, np.int64(5), np.array(5)):
        assert type(checked_whole("x", value, 1, 9)) is int
    assert checked_workers(None) == (os.cpu_count() or 1)
    for value in [*NOT_WHOLE, 4 * (os.cpu_count() or 1) + 1]:
        if value is not None:
            refused(lambda value=value: checked_workers(value), "workers")  # type: ignore[misc]


def test_words() -> None:
    checked_choice("x", "a", ("a", "b"))
    for value in [*NONE, "c", "", np.zeros(3), [], "y" * 1000]:
        refused(lambda value=value: checked_choice("x", value, ("a", "b")), "x")  # type: ignore[misc]
    for name in ("objective", "map", "method"):
        refused(lambda name=name: ls.optimize(ls.cockroach(), **HERE | {name: np.zeros(3)}), name)  # type: ignore[misc]


def test_values_are_shown_in_short() -> None:
    assert shown(45.0) == "45.0"
    assert len(shown(np.zeros((50, 50)))) < 80 and "\n" not in shown(np.zeros((50, 50)))
    assert shown(10**5000) == "<int>"


HERE: dict[str, Any] = {"slope_deg": 45, "heading": 0.15}
START: dict[str, Any] = {**HERE, "speed": 0.3, "phase": [0.1, 0.2, 0.3], "family": "B"}
ARGUMENTS: dict[str, tuple[dict[str, Any], list[str]]] = {
    "find_gaits": (HERE, ["slope_deg", "heading", "actuation"]),
    "search_gaits": (HERE, ["slope_deg", "heading", "actuation"]),
    "simulate": (
        START,
        [
            "slope_deg",
            "heading",
            "speed",
            "phase",
            "actuation",
            "displacement",
            "yaw",
            "yaw_rate",
            "strides",
            "accuracy",
        ],
    ),
    "optimize": (HERE, ["slope_deg", "heading"]),
    "trade_off": ({**HERE, "family": "B"}, ["slope_deg", "heading"]),
    "atlas": ({}, ["slopes_deg", "headings", "impulses", "actuation"]),
    "optimal_atlas": ({}, ["slopes_deg", "headings"]),
}
COUNTS: dict[str, list[str]] = {
    "find_gaits": ["starts"],
    "search_gaits": ["starts"],
    "optimize": ["seed"],
    "trade_off": ["seed", "points"],
    "atlas": ["starts", "workers"],
    "optimal_atlas": ["seed", "workers"],
}
MISSING = ("slope_deg", "heading", "actuation", "phase", "displacement", "workers")
"""None stands for an argument that is left out, or one that is then said to be missing."""
LEFT_OUT = {("atlas", "slopes_deg"), ("atlas", "headings"), ("atlas", "starts")}
"""Those of which that is so in one function only."""


@pytest.mark.parametrize(("function", "name"), [(f, name) for f, (_, names) in ARGUMENTS.items() for name in names])
def test_every_number_of_the_interface(roach: ls.Animal, function: str, name: str) -> None:
    given, _ = ARGUMENTS[function]
    for value in NONE:
        several = isinstance(value, list | np.ndarray) and name in ("slopes_deg", "headings", "impulses")
        vector = (
            isinstance(value, list | np.ndarray)
            and np.size(value) == 1
            and name in ("actuation", "phase", "displacement")
        )
        if not (value is None and (name in MISSING or (function, name) in LEFT_OUT)) and not several and not vector:
            refused(lambda value=value: getattr(ls, function)(roach, **given | {name: value}), name)  # type: ignore[misc]


@pytest.mark.parametrize(("function", "name"), [(f, name) for f, names in COUNTS.items() for name in names])
def test_every_count_of_the_interface(roach: ls.Animal, function: str, name: str) -> None:
    given, _ = ARGUMENTS[function]
    for value in NOT_WHOLE:
        big_seed = name == "seed" and isinstance(value, int) and 0 <= value <= 10**9
        if not (value is None and (name in MISSING or (function, name) in LEFT_OUT)) and not (
            big_seed and not isinstance(value, bool)
        ):
            refused(lambda value=value: getattr(ls, function)(roach, **given | {name: value}), name)  # type: ignore[misc]


def test_impulses_of_any_kind(roach: ls.Animal) -> None:
    gait = ls.find_gaits(roach, **HERE)[0]
    expected = gait.recover(0.5)
    for value in (np.float32(0.5), np.longdouble(0.5), np.array(0.5), Fraction(1, 2)):
        recovery = gait.recover(value)  # type: ignore[arg-type]
        assert type(recovery.impulse) is float and recovery.steps == expected.steps
    for bad in NONE:
        refused(lambda bad=bad: gait.recover(bad), "impulse")  # type: ignore[misc]
