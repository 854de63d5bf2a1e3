"""What the properties share: how many examples there are, what may go wrong, and values of all kinds."""

import os
from collections import Counter
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from typing import Any, TypeVar

import numpy as np
import xarray as xr
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

Test = TypeVar("Test", bound=Callable[..., None])

ALL = int(os.environ.get("LEGSPRING_FUZZ", "0"))
"""How many examples all properties have together; 0 in CI, where each has its own number."""
OUTCOMES: Counter[str] = Counter()
"""How examples ended."""


def examples(in_ci: int, share: float) -> Callable[[Test], Test]:
    """Try a number of examples in CI, the same ones each time, or a share of all those that are asked for."""
    return settings(
        max_examples=max(1, round(share * ALL)) if ALL else in_ci,
        derandomize=not ALL,
        database=None,
        deadline=None,
        suppress_health_check=[*HealthCheck],
    )


def is_one_line(message: str) -> bool:
    """Whether a message is what is promised: a line of at most 300 characters."""
    return 0 < len(message) <= 300 and message.isprintable()


def refused(what: str, error: BaseException) -> None:
    """Note an error that is allowed; it must say what is wrong in a line."""
    assert is_one_line(str(error)), repr(error)
    OUTCOMES[f"{what}: {type(error).__name__}"] += 1


def text() -> st.SearchStrategy[str]:
    """Return any text: with brackets, control characters, halves of characters, and very long."""
    odd = [
        "",
        " ",
        "[/old]",
        "[red]",
        ":smile:",
        "\x1b[31m",
        "a\nb",
        "\udcff",
        "\u202e",
        "\0",
        "x" * 5000,
        "{}",
        "%s",
        "../..",
    ]
    return st.one_of(st.sampled_from(odd), st.text(max_size=12))


def deep(levels: int) -> Any:
    """Return a list in a list in a list ..."""
    value: Any = 1.0
    for _ in range(levels):
        value = [value]
    return value


ODD: list[Any] = [
    *(None, True, "45", b"1", "", object(), float, [], {}, (), ..., np.True_),
    *(float("nan"), float("inf"), -float("inf"), 10**400, -(10**5000), 1e308, -1e308, 5e-324, -0.0, 1e-12),
    *(1j, np.complex128(1), np.longdouble("1e400"), Decimal("0.1"), Fraction(1, 3), np.float16(0.1), np.uint8(255)),
    *(
        np.ma.masked,
        np.ma.masked_array(0.1, mask=True),
        np.array("1"),
        np.array([]),
        np.zeros((3, 3)),
        np.array([np.nan] * 3),
    ),
    *(np.datetime64("2011-01-01"), np.array(0.1, dtype=object), xr.DataArray([0.1, 0.2, 0.3]), deep(50), deep(3000)),
    *([0.1, 0.2, 0.3], [None], [[0.1]], {0.1: 1}, {0.1}, iter([0.1]), range(10**9), "A", "nan"),
]
"""Values of which hardly any is a valid argument."""


def odd() -> st.SearchStrategy[Any]:
    """Return values that are no valid argument, or only by chance."""
    return st.one_of(st.sampled_from(ODD), st.floats(), st.integers(), text(), st.binary(max_size=4))
