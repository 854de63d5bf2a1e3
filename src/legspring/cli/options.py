"""Options that commands share, and what is read from their words."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeVar

import typer

if TYPE_CHECKING:
    from legspring.model import Animal

T = TypeVar("T")


def reading(kind: Callable[[str], T], words: str) -> Callable[[str], T]:
    """Return a parser whose error says what was read, and what must have been."""

    def read(text: str) -> T:
        try:
            return kind(text)
        except ValueError:
            from legspring.checks import shown

            raise typer.BadParameter(f"{shown(text)}: must be {words}") from None

    return read


def plain_number(text: str) -> float:
    """Read a finite number in the usual digits."""
    # Where an option is left out, its default comes by as it is.
    value = float(text if str(text).isascii() and "_" not in str(text) else "")
    if not math.isfinite(value):
        raise ValueError
    return value


def plain_integer(text: str) -> int:
    """Read a whole number in the usual digits."""
    # As of numbers, a default comes by as it is.
    return int(text if str(text).isascii() and "_" not in str(text) else "")


def positive_number(text: str) -> float:
    """Read a positive finite number in the usual digits."""
    value = plain_number(text)
    if value <= 0.0:
        raise ValueError
    return value


number, integer = reading(plain_number, "a finite number"), reading(plain_integer, "a whole number")
positive = reading(positive_number, "a positive finite number")
AnimalName = Annotated[
    str,
    typer.Argument(metavar="ANIMAL", help="A preset's name, such as cockroach, or a TOML file.", show_default=False),
]
Slope = Annotated[
    float | None,
    typer.Option(
        parser=number,
        metavar="DEG",
        help="Slope in degrees, uphill positive; may be left out where an animal is for one slope only, or on "
        "level ground seen from the side.",
        show_default=False,
    ),
]
Heading = Annotated[
    float | None,
    typer.Option(
        parser=number,
        metavar="RAD",
        help="Heading at the start of a step in radians, counter-clockwise from uphill; to be left out where gaits "
        "have headings of their own, unless something else is free.",
        show_default=False,
    ),
]
Family = Annotated[
    str | None,
    typer.Option(
        help="Only this family: which pairs of legs push, by the animal's label; all: whatever legs push and pull, of "
        "the animal's families or not."
    ),
]
OwnFamily = Annotated[
    str | None, typer.Option(help="Only this family: which pairs of legs push, by the animal's label.")
]
Branch = Annotated[
    int | None,
    typer.Option(
        parser=integer,
        metavar="NUMBER",
        help="Number of the gait, as in the list of gaits; by default the first one there is.",
    ),
]
Actuation = Annotated[
    str | None,
    typer.Option(
        metavar="NUMBERS",
        help="Magnitude of the actuation in m, one for each pair of legs, separated by commas; by default the "
        "animal's.",
    ),
]
Speed = Annotated[
    float | None,
    typer.Option(parser=number, metavar="M/S", help="Speed at the start of a step, to be had.", show_default=False),
]
MeanSpeed = Annotated[
    float | None, typer.Option(parser=number, metavar="M/S", help="Mean speed, to be had.", show_default=False)
]
Energy = Annotated[
    float | None,
    typer.Option(
        parser=number,
        metavar="J",
        help="Energy at the start of a step, to be had: of motion, of the springs, and of the height above the ground.",
        show_default=False,
    ),
]
ApexHeight = Annotated[
    float | None,
    typer.Option(
        parser=number,
        metavar="M",
        help="Largest height above the ground in flight, to be had, from the side.",
        show_default=False,
    ),
]
LateralDrift = Annotated[
    float | None,
    typer.Option(parser=number, metavar="M/S", help="Mean speed sideways, to be had.", show_default=False),
]
Free = Annotated[
    str | None,
    typer.Option(
        metavar="NAMES",
        help="Parameters to let go, separated by commas, such as F.phase,step_duration: one for each thing to be had "
        "that is too much.",
        show_default=False,
    ),
]
Asymmetric = Annotated[
    bool,
    typer.Option("--asymmetric", help="Look for gaits, too, whose steps do not mirror one another."),
]
WorkWeights = Annotated[
    str | None,
    typer.Option(
        metavar="B1,B2",
        help="What positive and negative work cost (Eq. 3.5); by default the animal's, 1,1.",
        show_default=False,
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print a list of flat JSON objects; SI units, angles in radians.")]
StoreFolder = Annotated[
    Path | None,
    typer.Option("--store", metavar="FOLDER", help="Zarr: what was stopped goes on where it was.", show_default=False),
]
Cluster = Annotated[
    str | None,
    typer.Option("--cluster", metavar="WHERE", help="Work on Dask: local, or tcp://ADDRESS:PORT.", show_default=False),
]
Workers = Annotated[
    int | None, typer.Option("--workers", parser=integer, metavar="NUMBER", help="Threads; by default one a core.")
]
FigureFile = Annotated[Path | None, typer.Option(metavar="FILE", help="Draw a figure: .png, .pdf or .svg.")]
FootfallFile = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Draw when each leg is down: .png, .pdf or .svg.")
]
MotionFile = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="Draw place, yaw, moment and lengths of legs against time: .png, .pdf or .svg."),
]
EnergiesFile = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Draw energies and works against time: .png, .pdf or .svg.")
]
FilmFile = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Make a moving picture: .gif, .html, .mp4 or .webm.")
]
Slow = Annotated[
    float | None,
    typer.Option(parser=positive, metavar="FACTOR", help="Slow motion, by so much; by default a round number."),
]


def parse_numbers(name: str, text: str | None) -> tuple[float, ...] | None:
    """Read numbers separated by commas."""
    if text is None:
        return None
    try:
        return tuple(plain_number(part) for part in text.split(","))
    except ValueError:
        from legspring.checks import shown

        raise ValueError(f"{name} = {shown(text)}: must be numbers separated by commas") from None


def parse_grid(name: str, text: str) -> tuple[float, ...]:
    """Read START:STOP:STEP, the stop included, or numbers separated by commas."""
    if ":" not in text:
        return parse_numbers(name, text) or ()
    try:
        start, stop, step = (plain_number(part) for part in text.split(":"))
        count = math.floor((stop - start) / step + 1e-9) + 1
        if step > 0.0 and 1 <= count <= 10_000:
            return tuple(round(start + number * step, 12) for number in range(count))
    except (ValueError, ArithmeticError):
        pass
    from legspring.checks import shown

    raise ValueError(f"{name} = {shown(text)}: must be START:STOP:STEP, rising, or numbers separated by commas")


def load_weighing(name: str, weights: str | None) -> "Animal":
    """Read an animal, with what its work costs if that is given."""
    from legspring.model import load_animal

    animal, given = load_animal(name), parse_numbers("--work-weights", weights)
    if given is None:
        return animal
    if len(given) != 2 or min(given) < 0.0:
        raise ValueError(f"--work-weights = {weights!r}: must be two numbers, not negative, separated by a comma")
    return animal.replace(work_weights=given)


def parse_names(text: str | None) -> tuple[str, ...]:
    """Read names separated by commas."""
    return () if text is None else tuple(name.strip() for name in text.split(","))


def parse_over(texts: list[str] | None) -> dict[str, tuple[float, ...]] | None:
    """Read what a map is over: NAME=START:STOP:STEP, or numbers separated by commas, once for each."""
    if not texts:
        return None
    over: dict[str, tuple[float, ...]] = {}
    for text in texts:
        name, equals, values = text.partition("=")
        if not equals or name in over:
            from legspring.checks import shown

            raise ValueError(f"--over = {shown(text)}: must be NAME=START:STOP:STEP, each name once")
        over[name] = parse_grid(f"--over {name}", values)
    return over


def parse_ranges(
    option: str, texts: list[str], *, half_open: bool = False
) -> dict[str, tuple[float | None, float | None]]:
    """Read NAME=LOW:HIGH, each name once; where an end may be open, nothing stands for it."""
    found: dict[str, tuple[float | None, float | None]] = {}
    for text in texts:
        name, equals, values = text.partition("=")
        ends = values.split(":")
        if not equals or name in found or len(ends) != 2 or not (half_open or all(ends)):
            from legspring.checks import shown

            raise ValueError(f"{option} = {shown(text)}: must be NAME=LOW:HIGH, each name once")
        low, high = (number(end) if end else None for end in ends)
        found[name] = low, high
    return found


def parse_samples(texts: list[str]) -> dict[str, tuple[float, ...]]:
    """Read what samples are of: NAME=LOW:HIGH, each name once."""
    return {name: (low, high) for name, (low, high) in parse_ranges("--over", texts).items()}  # type: ignore[misc]


def parse_phase(animal: "Animal", text: str) -> list[float]:
    """Read the phase of each pair of legs, in degrees."""
    degrees = parse_numbers("--phase", text) or ()
    if len(degrees) != len(animal.pairs):
        from legspring.checks import shown

        raise ValueError(
            f"--phase = {shown(text)}: must be one angle for each of {', '.join(animal.pairs)}, in degrees"
        )
    return [math.radians(angle) for angle in degrees]


def check_slope(animal: "Animal", slope: float | None) -> None:
    """Make sure that a slope is given where an animal is for more than one."""
    low, high = animal.speed_law.domain_deg
    if slope is None and low < high and not animal.sagittal:
        raise ValueError(f"--slope is missing: must be an angle from {low:g} to {high:g} degrees")


def check_figure(path: Path | None) -> None:
    """Make sure that a figure can be saved, if one is wanted."""
    if path is not None:
        from legspring.drawing.style import SUFFIXES
        from legspring.files import check_output

        check_output(path, SUFFIXES)


def check_film(path: Path | None) -> None:
    """Make sure that a moving picture can be saved, if one is wanted."""
    if path is not None:
        from legspring.drawing.film import check_film

        check_film(path)
