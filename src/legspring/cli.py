"""The command `legspring`.

Slow imports stay inside the commands, so that ``legspring --help`` answers at once.
"""

import math
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn, TypeVar

import typer
from typer.core import TyperGroup

import legspring
from legspring.messages import one_line
from legspring.printing import (
    describe_animal,
    describe_gait,
    describe_optimum,
    print_animals,
    print_gaits,
    print_json,
    print_optimum,
    print_run,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from legspring.gait import Gait
    from legspring.model import Animal
    from legspring.solve import Search

T = TypeVar("T")

EXAMPLE_SLOPE, EXAMPLE_HEADING = 45.0, 0.15
"""Of the gaits that are drawn beside presets, deg and rad."""
BAD_INPUT, NO_GAIT, INTERRUPTED = 2, 1, 130
"""Exit statuses other than 0."""


class Commands(TyperGroup):
    """Commands of which every error is one line on the error stream."""

    def main(self, args: Sequence[str] | None = None, *rest: Any, **options: Any) -> NoReturn:
        """Run a command and exit; without any arguments, show the help."""
        given = sys.argv[1:] if args is None else args
        options["standalone_mode"] = False
        try:
            status = super().main(args if given else ["--help"], *rest, **options)
        except (typer.TyperException, OSError, ValueError, ArithmeticError, ExceptionGroup) as error:
            fail(words(error))
        if status == INTERRUPTED:
            fail("interrupted", INTERRUPTED)
        sys.exit(status)


def words(error: Exception) -> str:
    """Say what an error is about."""
    match error:
        case ExceptionGroup():
            return "; ".join(words(part) for part in error.exceptions)
        case typer.TyperException():
            return error.format_message()
        case OSError(filename=str(name), strerror=str(reason)):
            return f"{name}: {reason}"
        case OSError(strerror=str(reason)):
            return reason
        case OSError() | ValueError() | ArithmeticError():
            return str(error)
    return f"{type(error).__name__}: {error}"


def fail(message: str, status: int = BAD_INPUT) -> NoReturn:
    """Exit with one line on the error stream."""
    say(message)
    sys.exit(status)


def say(message: str) -> None:
    """Print a line on the error stream."""
    print(one_line(f"legspring: {message}"), file=sys.stderr)


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
    return int(text if text.isascii() and "_" not in text else "")


number, integer = reading(plain_number, "a finite number"), reading(plain_integer, "a whole number")

app = typer.Typer(
    cls=Commands,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

AnimalName = Annotated[
    str,
    typer.Argument(metavar="ANIMAL", help="A preset's name, such as cockroach, or a TOML file.", show_default=False),
]
Slope = Annotated[
    float | None,
    typer.Option(
        parser=number,
        metavar="DEG",
        help="Slope in degrees, uphill positive; may be left out where an animal is for one slope only.",
        show_default=False,
    ),
]
Heading = Annotated[
    float | None,
    typer.Option(
        parser=number,
        metavar="RAD",
        help="Initial heading in radians, counter-clockwise from uphill; none where gaits have headings of their own.",
        show_default=False,
    ),
]
Family = Annotated[str | None, typer.Option(help="Only this family: which pairs of legs push, by the animal's label.")]
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
        metavar="F,M,B", help="Magnitude of the actuation of each pair of legs in m; the animal's by default."
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print a list of flat JSON objects; SI units, angles in radians.")]
FigureFile = Annotated[Path | None, typer.Option(metavar="FILE", help="Draw a figure: .png, .pdf or .svg.")]
FootfallFile = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Draw when each leg is down: .png, .pdf or .svg.")
]


def show_version(wanted: bool) -> None:
    """Print the version and exit."""
    if wanted:
        print(f"legspring {legspring.__version__}")
        raise typer.Exit


@app.callback()
def describe(
    version: Annotated[
        bool, typer.Option("--version", callback=show_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    """Reduced-order models of legged locomotion: gaits of planar bodies on springy legs.

    Slopes are in degrees and headings in radians, as in the field. The first run compiles for about half a minute.
    """


@app.command()
def presets(
    as_json: Json = False,
    figure: Annotated[Path | None, typer.Option(metavar="FILE", help="Draw all of them: .png, .pdf or .svg.")] = None,
    figures: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Draw each of them with a gait of its own into this directory.")
    ] = None,
) -> None:
    """List the animals that come with Legspring, one a line, with their families.

    Example: legspring presets --figures animals
    """
    from legspring.model import load_animal, presets

    check_figure(figure)
    if figures is not None:
        from legspring.files import make_directory

        make_directory(figures)
    animals = [load_animal(name) for name in presets()]
    if as_json:
        print_json([describe_animal(animal) for animal in animals])
    else:
        print_animals(animals)
    each = [] if figures is None else [(figures / f"{animal.name}.png", draws_preset(animal)) for animal in animals]
    save((figure, draws("draw_animals", animals)), *each)


@app.command()
def gaits(
    animal: AnimalName,
    slope: Slope = None,
    heading: Heading = None,
    family: Family = None,
    actuation: Actuation = None,
    as_json: Json = False,
    figure: FigureFile = None,
    footfalls: FootfallFile = None,
) -> None:
    """Find the gaits at one slope and heading; --figure and --footfalls draw the first one.

    Example: legspring gaits cockroach --slope 45 --heading 0.15

    Example: legspring gaits lateral_leg_spring
    """
    check_figure(figure)
    check_figure(footfalls)
    search = search_at(animal, slope, heading, family, actuation)
    if as_json:
        print_json([describe_gait(gait) for gait in search.gaits])
    elif search.gaits:
        print_gaits(search)
    else:
        print(no_gait(search, slope, heading))
    if search.gaits:
        first = search.gaits[0]
        save((figure, draws("draw_gait", first)), (footfalls, draws("draw_footfalls", first)))
    else:
        for path in filter(None, (figure, footfalls)):
            say(f"there is nothing to draw into {path}")


@app.command()
def simulate(
    animal: AnimalName,
    slope: Slope = None,
    heading: Heading = None,
    branch: Branch = None,
    family: Family = None,
    speed: Annotated[
        float | None,
        typer.Option(parser=number, metavar="M/S", help="Initial speed in m/s, for a start that is no gait."),
    ] = None,
    phase: Annotated[
        str | None,
        typer.Option(
            metavar="F,M,B",
            help="Phase of each pair of legs in degrees, for a start that is no gait; by default the animal's.",
            show_default=False,
        ),
    ] = None,
    actuation: Actuation = None,
    strides: Annotated[
        float, typer.Option(parser=number, metavar="NUMBER", help="How long; half a stride is a step.")
    ] = 2.0,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Save the time series: .nc (netCDF), .mat (MATLAB) or .csv (no events)."),
    ] = None,
    as_json: Json = False,
    figure: FigureFile = None,
    footfalls: FootfallFile = None,
) -> None:
    """Simulate a gait, or any start given by --speed, --heading, --phase and --family.

    Example: legspring simulate cockroach --slope 45 --heading 0.15 --strides 4 --out run.nc --figure run.png

    Example: legspring simulate cockroach --slope 0 --heading 0.15 --speed 0.375 --phase 63,4,-49 --family A

    Example: legspring simulate lateral_leg_spring --speed 0.5 --heading 0.1 --strides 20
    """
    from legspring.model import load_animal

    if out is not None:
        from legspring.files import SAVERS, check_output

        check_output(out, list(SAVERS))
    check_figure(figure)
    check_figure(footfalls)
    check_strides(animal, strides)
    if speed is None and phase is None:
        gait = choose_gait(search_at(animal, slope, heading, family, actuation), slope, heading, branch)
        run, about = gait.simulate(strides), {"family": gait.family, "branch": gait.branch}
    else:
        if branch is not None:
            raise ValueError(f"--branch = {branch}: must be left out for a start that is no gait")
        run = simulate_start(animal, slope, heading, speed, phase, family, actuation, strides)
        # Without a family there is but one.
        about = {"family": family or next(iter(load_animal(animal).families)), "branch": None}
    print_run(run, about, strides, as_json)
    drawn = (figure, draws("draw_simulation", run)), (footfalls, draws("draw_footfalls", run))
    save((out, partial(save_dataset, run)), *drawn)


@app.command()
def recover(
    animal: AnimalName,
    slope: Slope = None,
    heading: Heading = None,
    impulse: Annotated[
        float,
        typer.Option(parser=number, metavar="NUMBER", help="Sideways impulse in units of m v_des, > 0 to the right."),
    ] = 0.5,
    branch: Branch = None,
    family: Family = None,
    actuation: Actuation = None,
    as_json: Json = False,
    figure: FigureFile = None,
) -> None:
    """Push a gait sideways in its first step and count the steps until it is back.

    Example: legspring recover cockroach --slope 45 --heading 0.15 --impulse 0.5
    """
    check_figure(figure)
    gait = choose_gait(search_at(animal, slope, heading, family, actuation), slope, heading, branch)
    recovery = gait.recover(impulse)
    if as_json:
        about = {name: getattr(gait, name) for name in ("family", "branch", "slope_deg", "heading")}
        outcome = {
            name: getattr(recovery, name) for name in ("impulse", "steps", "recovered", "other_gait", "distance")
        }
        print_json([about | outcome])
    else:
        elsewhere = "settled on another gait" if recovery.other_gait else "not back within 100 steps"
        elsewhere = recovery.failure or elsewhere
        steps = elsewhere if recovery.steps is None else f"back after {recovery.steps} steps"
        print(f"family {gait.family}, branch {gait.branch}, impulse {impulse:g} m v_des: {steps}")
    save((figure, draws("draw_recovery", recovery)))


@app.command()
def atlas(
    animal: AnimalName,
    out: Annotated[
        Path, typer.Option(metavar="FILE", help="The file to write: .nc (netCDF) or .mat (MATLAB).", show_default=False)
    ],
    slopes: Annotated[str, typer.Option(metavar="START:STOP:STEP", help="Slopes in degrees.")] = "0:90:5",
    headings: Annotated[str, typer.Option(metavar="START:STOP:STEP", help="Headings in radians.")] = "0:0.45:0.05",
    no_recovery: Annotated[bool, typer.Option("--no-recovery", help="Do not push every gait sideways.")] = False,
    actuation: Actuation = None,
    figures: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Draw Figures 4.1 to 4.5 of the thesis into this directory.")
    ] = None,
) -> None:
    """Map the gaits over slope and heading into a file.

    Example: legspring atlas cockroach --out atlas.nc --figures maps

    Example: legspring atlas cockroach --out coarse.nc --slopes 0:90:15 --headings 0.05,0.15 --no-recovery
    """
    from legspring.files import check_output, make_directory
    from legspring.model import load_animal

    slopes_deg, radians = parse_grid("--slopes", slopes), parse_grid("--headings", headings)
    creature, magnitudes = load_animal(animal), parse_numbers("--actuation", actuation)
    check_output(out, [".nc", ".mat"])
    if figures is not None:
        make_directory(figures)
    from legspring import sweep

    maps = sweep.atlas(
        creature,
        slopes_deg=slopes_deg,
        headings=radians,
        actuation=magnitudes,
        impulses=() if no_recovery else sweep.IMPULSES,
        progress=sys.stderr.isatty(),
    )
    found = maps["family"].values != ""
    cells = found.any(axis=-1)
    print(f"{out}: {found.sum()} gaits in {cells.sum()} of {cells.size} cells")
    save((out, partial(save_dataset, maps)), *([] if figures is None else chapter_4(maps, figures)))


@app.command()
def optimize(
    animal: AnimalName,
    slope: Slope = None,
    heading: Heading = None,
    objective: Annotated[
        str, typer.Option(metavar="GOAL", help="What to reach: stability or efficiency.")
    ] = "stability",
    family: Family = None,
    map: Annotated[
        str, typer.Option(metavar="MAP", help="Whose eigenvalues count: complete, or the thesis's reduced map.")
    ] = "complete",
    method: Annotated[
        str, typer.Option(metavar="METHOD", help="default, or nelder-mead for the thesis's method.")
    ] = "default",
    as_json: Json = False,
    figure: FigureFile = None,
) -> None:
    """Find the actuation that makes a gait most stable or most efficient.

    Example: legspring optimize cockroach --slope 45 --heading 0.15 --objective efficiency
    """
    from legspring.model import load_animal

    check_figure(figure)
    creature = load_animal(animal)
    with patience("loading"):
        from legspring.solve import check_tuned
    check_tuned(creature, "for its actuation to be optimised")
    check_place(creature, slope, heading)
    with patience("searching for the best actuation"):
        best = legspring.optimize(
            creature,
            slope_deg=slope,
            heading=heading,  # type: ignore[arg-type]  # checked above
            family=family,
            objective=objective,  # type: ignore[arg-type]  # checked there
            map=map,  # type: ignore[arg-type]
            method=method,  # type: ignore[arg-type]
        )
    if as_json:
        print_json([] if best is None else [describe_optimum(best)])
    elif best is None:
        fail(f"no gait worth having{where(slope, heading)}", NO_GAIT)
    else:
        print_optimum(best)
    if best is not None:
        save((figure, draws("draw_gait", best)))


@app.command()
def reproduce(
    out: Annotated[Path, typer.Option(metavar="DIR", help="The directory to write to.", show_default=False)],
    only: Annotated[
        str | None,
        typer.Option(metavar="NUMBERS", help="Only these figures and tables, such as 4.2,6.1; no report."),
    ] = None,
    method: Annotated[
        str, typer.Option(metavar="METHOD", help="Of the optimisation: default, or nelder-mead for the thesis's.")
    ] = "default",
    fresh: Annotated[bool, typer.Option("--fresh", help="Compute everything again.")] = False,
    workers: Annotated[
        int | None, typer.Option(parser=integer, metavar="NUMBER", help="Processes; by default one a core.")
    ] = None,
) -> None:
    """Recompute the thesis of D. E. Peterson (2011): all figures and tables, and a report that judges its claims.

    A run that was stopped goes on where it was.

    Example: legspring reproduce --out thesis

    Example: legspring reproduce --out thesis --only 4.2,6.1
    """
    from legspring.peterson2011.reproduce import reproduce as run

    print(
        run(
            out,
            only=tuple(part.strip() for part in only.split(",")) if only is not None else (),
            method=method,  # type: ignore[arg-type]  # checked there
            fresh=fresh,
            workers=workers,
            progress=sys.stderr.isatty(),
        )
    )


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


def check_strides(name: str, strides: float) -> None:
    """Make sure that an animal can be simulated for so many strides."""
    from legspring.model import load_animal

    animal = load_animal(name)
    with patience("loading"):
        from legspring.layout import System
        from legspring.simulation import steps_in

    slope_deg, _ = animal.speed_law.domain_deg
    steps_in(System(animal, math.radians(slope_deg), animal.functions(next(iter(animal.families)))), strides)


def check_figure(path: Path | None) -> None:
    """Make sure that a figure can be saved, if one is wanted."""
    if path is not None:
        from legspring.figures.style import SUFFIXES
        from legspring.files import check_output

        check_output(path, SUFFIXES)


@contextmanager
def patience(words: str) -> Iterator[None]:
    """Tell somebody who looks at a terminal what is going on."""
    if not sys.stderr.isatty():
        yield
        return
    from rich.console import Console

    with Console(stderr=True, markup=False, emoji=False).status(f"{words} ..."):
        yield


def check_place(animal: "Animal", slope: float | None, heading: float | None) -> None:
    """Make sure that a slope and a heading are given where gaits need them, and only there."""
    low, high = animal.speed_law.domain_deg
    if slope is None and low < high:
        raise ValueError(f"--slope is missing: must be an angle from {low:g} to {high:g} degrees")
    if animal.tuned and heading is None:
        raise ValueError("--heading is missing: must be an angle in radians")
    if heading is not None and not animal.tuned:
        raise ValueError(f"--heading = {heading:g}: must be left out; gaits of {animal.name} have their own")


def search_at(
    animal: str, slope: float | None, heading: float | None, family: str | None, actuation: str | None
) -> "Search":
    """Search for the gaits that a command is about."""
    from legspring.model import load_animal

    creature, magnitudes = load_animal(animal), parse_numbers("--actuation", actuation)
    check_place(creature, slope, heading)
    if magnitudes is not None and not creature.tuned:
        raise ValueError(f"--actuation = {actuation!r}: must be left out; gaits of {creature.name} have the animal's")
    with patience("loading"):
        from legspring.solve import search_gaits
    return search_gaits(
        creature,
        slope_deg=slope,
        heading=heading,
        family=family,
        actuation=magnitudes,
        progress=sys.stderr.isatty(),
    )


def choose_gait(search: "Search", slope: float | None, heading: float | None, branch: int | None) -> "Gait":
    """Return the gait of a branch, by default the first; exit if there is none at all."""
    if not search.gaits:
        fail(no_gait(search, slope, heading), NO_GAIT)
    if branch is None:
        return search.gaits[0]
    for gait in search.gaits:
        if gait.branch == branch:
            return gait
    offered = ", ".join(str(gait.branch) for gait in search.gaits)
    raise ValueError(f"--branch = {branch}: must be one of {offered}")


def no_gait(search: "Search", slope: float | None, heading: float | None) -> str:
    """Say that there is no gait, and why."""
    return f"no gait{where(slope, heading)}; {search.summary()}"


def where(slope: float | None, heading: float | None) -> str:
    """Say where gaits were looked for."""
    slopes = [] if slope is None else [f"slope {slope:g} deg"]
    headings = [] if heading is None else [f"heading {heading:g} rad"]
    return f" at {' and '.join(slopes + headings)}" if slopes or headings else ""


def simulate_start(
    animal: str,
    slope: float | None,
    heading: float | None,
    speed: float | None,
    phase: str | None,
    family: str | None,
    actuation: str | None,
    strides: float,
) -> "xr.Dataset":
    """Simulate a start that need not be a gait; phases in degrees."""
    from legspring.model import load_animal

    creature = load_animal(animal)
    if speed is None or heading is None:
        raise ValueError("a start that is no gait must have --speed and --heading")
    if creature.tuned and (phase is None or family is None):
        raise ValueError(
            f"a start of {creature.name} that is no gait must have --speed, --heading, --phase and --family"
        )
    check_place(creature, slope, heading if creature.tuned else None)
    with patience("simulating"):
        return legspring.simulate(
            creature,
            slope_deg=slope,
            heading=heading,
            speed=speed,
            phase=None if phase is None else parse_phase(creature, phase),
            family=family,
            actuation=parse_numbers("--actuation", actuation),
            strides=strides,
        )


def parse_phase(animal: "Animal", text: str) -> list[float]:
    """Read the phase of each pair of legs, in degrees."""
    degrees = parse_numbers("--phase", text) or ()
    if len(degrees) != len(animal.pairs):
        from legspring.checks import shown

        raise ValueError(
            f"--phase = {shown(text)}: must be one angle for each of {', '.join(animal.pairs)}, in degrees"
        )
    return [math.radians(angle) for angle in degrees]


def save(*outputs: tuple[Path | None, Callable[[Path], object]]) -> None:
    """Write files, those that are wanted; one that fails keeps none of the others from being written."""
    # What has been printed is not to wait for them.
    sys.stdout.flush()
    errors = []
    for path, write in outputs:
        try:
            if path is not None:
                write(path)
        except Exception as error:
            errors.append(error)
    if len(errors) == 1:
        raise errors[0]
    if errors:
        raise ExceptionGroup("several outputs", errors)


def draws(name: str, *subjects: Any) -> Callable[[Path], object]:
    """Return what draws subjects into a file, by one of the functions of `legspring.figures`."""

    def write(path: Path) -> None:
        from legspring import figures

        figures.save_figure(getattr(figures, name)(*subjects), path)

    return write


def draws_preset(animal: "Animal") -> Callable[[Path], object]:
    """Return what draws an animal, with the most stable of its gaits there."""

    def write(path: Path) -> None:
        with patience("drawing"):
            from legspring.solve import search_gaits

        low, high = animal.speed_law.domain_deg
        slope_deg = low if low == high else EXAMPLE_SLOPE
        found = search_gaits(animal, slope_deg=slope_deg, heading=EXAMPLE_HEADING if animal.tuned else None).gaits
        stable_first = sorted(found, key=lambda gait: abs(gait.multipliers[0]))
        draws("draw_animal", animal, stable_first[0] if found else None)(path)
        print(path, file=sys.stderr)

    return write


def chapter_4(maps: "xr.Dataset", directory: Path) -> Iterator[tuple[Path, Callable[[Path], object]]]:
    """Yield the figures of chapter 4, and what draws those that an atlas gives, and says which it does not."""
    from legspring.figures import save_figure
    from legspring.figures.peterson2011 import chapter4

    def write(draw: "Callable[[xr.Dataset], Figure]", path: Path) -> None:
        try:
            drawn = draw(maps)
        except ValueError as error:
            print(one_line(f"left out {path.name}: {error}"), file=sys.stderr)
        else:
            save_figure(drawn, path)
            print(path)

    for figure in chapter4.FIGURES:
        yield directory / f"{figure.stem}.png", partial(write, figure.draw)


def save_dataset(dataset: "xr.Dataset", path: Path) -> None:
    """Save a dataset in the form that the file's ending says."""
    from legspring.files import SAVERS

    SAVERS[path.suffix.lower()](dataset, path)
