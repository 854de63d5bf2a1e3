"""The command `legspring`.

Slow imports stay inside the commands, so that ``legspring --help`` answers at once.
"""

import math
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn, TypeVar

import typer
from typer.core import TyperGroup

import legspring
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
        except typer.TyperException as error:
            fail(error.format_message())
        except OSError as error:
            fail(f"{error.filename}: {error.strerror}" if error.filename else str(error))
        except (ValueError, ArithmeticError) as error:
            fail(str(error))
        if status == INTERRUPTED:
            fail("interrupted", INTERRUPTED)
        sys.exit(status)


def fail(message: str, status: int = BAD_INPUT) -> NoReturn:
    """Exit with one line on the error stream."""
    typer.echo(f"legspring: {' '.join(message.split())}", err=True)
    sys.exit(status)


def reading(kind: Callable[[str], T], words: str) -> Callable[[str], T]:
    """Return a parser whose error says what was read, and what must have been."""

    def read(text: str) -> T:
        try:
            return kind(text)
        except ValueError:
            raise typer.BadParameter(f"{text!r}: must be {words}") from None

    return read


number, integer = reading(float, "a number"), reading(int, "a whole number")

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


def show_version(wanted: bool) -> None:
    """Print the version and exit."""
    if wanted:
        typer.echo(f"legspring {legspring.__version__}")
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
    """List the animals that come with Legspring, one a line.

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
    if figure is not None:
        from legspring.figures import draw_animals, save_figure

        save_figure(draw_animals(animals), figure)
    if figures is not None:
        draw_presets(animals, figures)


@app.command()
def gaits(
    animal: AnimalName,
    slope: Slope = None,
    heading: Heading = None,
    family: Family = None,
    actuation: Actuation = None,
    as_json: Json = False,
    figure: FigureFile = None,
) -> None:
    """Find all gaits at one slope and heading; --figure draws the first one.

    Example: legspring gaits cockroach --slope 45 --heading 0.15

    Example: legspring gaits lateral_leg_spring
    """
    check_figure(figure)
    search = search_at(animal, slope, heading, family, actuation)
    if figure is not None and search.gaits:
        from legspring.figures import draw_gait, save_figure

        save_figure(draw_gait(search.gaits[0]), figure)
    if as_json:
        print_json([describe_gait(gait) for gait in search.gaits])
    elif search.gaits:
        print_gaits(search)
    else:
        typer.echo(no_gait(search, slope, heading))
    if figure is not None and not search.gaits:
        typer.echo(f"legspring: there is nothing to draw into {figure}", err=True)


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
) -> None:
    """Simulate a gait, or any start given by --speed, --heading, --phase and --family.

    Example: legspring simulate cockroach --slope 45 --heading 0.15 --strides 4 --out run.nc --figure run.png

    Example: legspring simulate cockroach --slope 0 --heading 0.15 --speed 0.375 --phase 63,4,-49 --family A

    Example: legspring simulate lateral_leg_spring --speed 0.5 --heading 0.1 --strides 20
    """
    if out is not None:
        from legspring.files import SAVERS, check_output

        check_output(out, list(SAVERS))
    check_figure(figure)
    if speed is None and phase is None:
        gait = choose_gait(search_at(animal, slope, heading, family, actuation), slope, heading, branch)
        run, about = gait.simulate(strides), {"family": gait.family, "branch": gait.branch}
    else:
        if branch is not None:
            raise ValueError(f"--branch = {branch}: must be left out for a start that is no gait")
        run = simulate_start(animal, slope, heading, speed, phase, family, actuation, strides)
        about = {"family": family, "branch": None}
    save_run(run, out, figure)
    print_run(run, about, strides, as_json)


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
    if figure is not None:
        from legspring.figures import draw_recovery, save_figure

        save_figure(draw_recovery(recovery), figure)
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
        typer.echo(f"family {gait.family}, branch {gait.branch}, impulse {impulse:g} m v_des: {steps}")


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
    """Map all gaits over slope and heading into a file.

    Example: legspring atlas cockroach --out atlas.nc --figures maps

    Example: legspring atlas cockroach --out coarse.nc --slopes 0:90:15 --headings 0.05,0.15 --no-recovery
    """
    from legspring.files import SAVERS, check_output, make_directory
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
    SAVERS[out.suffix.lower()](maps, out)
    found = maps["family"].values != ""
    cells = found.any(axis=-1)
    typer.echo(f"{out}: {found.sum()} gaits in {cells.sum()} of {cells.size} cells")
    if figures is not None:
        draw_chapter_4(maps, figures)


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
    if best is not None and figure is not None:
        from legspring.figures import draw_gait, save_figure

        save_figure(draw_gait(best), figure)
    if as_json:
        print_json([] if best is None else [describe_optimum(best)])
    elif best is None:
        fail(f"no gait worth having{where(slope, heading)}", NO_GAIT)
    else:
        print_optimum(best)


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

    typer.echo(
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
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise ValueError(f"{name} = {text!r}: must be numbers separated by commas") from None


def parse_grid(name: str, text: str) -> tuple[float, ...]:
    """Read START:STOP:STEP, the stop included, or numbers separated by commas."""
    if ":" not in text:
        return parse_numbers(name, text) or ()
    try:
        start, stop, step = (float(part) for part in text.split(":"))
        count = math.floor((stop - start) / step + 1e-9) + 1
        if step > 0.0 and 1 <= count <= 10_000:
            return tuple(round(start + number * step, 12) for number in range(count))
    except (ValueError, ArithmeticError):
        pass
    raise ValueError(f"{name} = {text!r}: must be START:STOP:STEP, rising, or numbers separated by commas")


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

    with Console(stderr=True).status(f"{words} ..."):
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
    if len(degrees) != len(animal.pairs) or not all(map(math.isfinite, degrees)):
        raise ValueError(f"--phase = {text!r}: must be one angle for each of {', '.join(animal.pairs)}, in degrees")
    return [math.radians(angle) for angle in degrees]


def draw_presets(animals: "Sequence[Animal]", directory: Path) -> None:
    """Draw each animal, with the most stable of its gaits there, into a file of its name."""
    with patience("drawing"):
        from legspring.figures import draw_animal, save_figure
        from legspring.solve import search_gaits

    for animal in animals:
        path = directory / f"{animal.name}.png"
        low, high = animal.speed_law.domain_deg
        slope_deg = low if low == high else EXAMPLE_SLOPE
        found = search_gaits(animal, slope_deg=slope_deg, heading=EXAMPLE_HEADING if animal.tuned else None).gaits
        stable_first = sorted(found, key=lambda gait: abs(gait.multipliers[0]))
        save_figure(draw_animal(animal, stable_first[0] if found else None), path)
        typer.echo(path, err=True)


def save_run(run: "xr.Dataset", out: Path | None, figure: Path | None) -> None:
    """Save a simulation's time series and figure, where they are wanted."""
    if out is not None:
        from legspring.files import SAVERS

        SAVERS[out.suffix.lower()](run, out)
    if figure is not None:
        from legspring.figures import draw_simulation, save_figure

        save_figure(draw_simulation(run), figure)


def draw_chapter_4(maps: "xr.Dataset", directory: Path) -> None:
    """Draw the figures of chapter 4 that an atlas gives, and say which it does not."""
    from legspring.figures import save_figure
    from legspring.figures.peterson2011 import chapter4

    for figure in chapter4.FIGURES:
        path = directory / f"{figure.stem}.png"
        try:
            save_figure(figure.draw(maps), path)
        except ValueError as error:
            typer.echo(f"left out {path.name}: {error}", err=True)
        else:
            typer.echo(path)
