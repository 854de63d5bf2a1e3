"""What every description shares: it is immutable, checked when made, and its errors are one line."""

import math
from collections.abc import Mapping
from numbers import Real
from typing import Annotated, Any, Self

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, ValidationError
from pydantic_core import ErrorDetails

from legspring.checks import shown
from legspring.messages import one_line


class ModelError(ValueError):
    """A description that cannot be right; the message is one line that says what would be."""

    def __init__(self, message: object = "") -> None:
        super().__init__(one_line(message))


SMALLEST, LARGEST = 1e-60, 1e60
"""Magnitudes whose products and squares are still numbers of the machine's."""


def require_number(value: object) -> Real:
    """Refuse what pydantic would turn into a number: True into 1.0, "3" into 3.0."""
    if not isinstance(value, Real) or isinstance(value, bool):
        raise ValueError("must be a number")
    try:
        finite = math.isfinite(value)
    except OverflowError:
        finite = False
    if not finite:
        raise ValueError("must be a finite number")
    if abs(float(value)) > LARGEST:
        raise ValueError(f"must be a number of at most {LARGEST:g}")
    return value


def require_size(value: float) -> float:
    """Refuse quantities so small that what is divided by them is no number of the machine's."""
    if value < SMALLEST:
        raise ValueError(f"must be at least {SMALLEST:g}")
    return value


Number = Annotated[float, BeforeValidator(require_number)]
Positive = Annotated[Number, Field(gt=0), AfterValidator(require_size)]
NotNegative = Annotated[Number, Field(ge=0)]


def require_printable(text: str) -> str:
    """Refuse names that tables and messages of one line cannot show."""
    if not text.isprintable():
        raise ValueError("must be printable text in one line")
    return text


LONGEST_LABEL = 60
Label = Annotated[str, Field(min_length=1, max_length=LONGEST_LABEL), AfterValidator(require_printable)]


class Frozen(BaseModel):
    """Base of all descriptions: frozen, without unknown fields, all numbers finite.

    Raises
    ------
    ModelError
        If a field is missing, unknown or not valid.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    def __init__(self, **fields: Any) -> None:
        try:
            super().__init__(**fields)
        except ValidationError as error:
            name = f" {shown(fields['name'])}" if "name" in fields else ""
            problems = "; ".join(self._describe(problem) for problem in error.errors(include_url=False))
            raise ModelError(f"{type(self).__name__}{name}: {problems}") from None

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a copy with some fields changed, checked as if it were made anew."""
        return type(self)(**dict(self) | dict(update or {}))

    @classmethod
    def _describe(cls, problem: ErrorDetails) -> str:
        where = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in problem["loc"])[1:]
        message = problem["msg"].removeprefix("Value error, ").removeprefix("Input ")
        message = message.replace("should have", "must have").replace("should be", "must be")
        match problem["type"]:
            case "missing":
                return f"{where} is missing"
            case "extra_forbidden":
                return f"{where} is unknown: must be among {', '.join(cls.model_fields)}"
            case "value_error" if not where:
                return message
            case "value_error" if isinstance(problem["ctx"]["error"], ModelError):
                return f"{where}: {message}"
        return f"{where} = {shown(problem['input'])}: {message[0].lower()}{message[1:]}"
