"""Commands that show animals, their gaits and what becomes of them."""

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from legspring.cli.options import (
    Actuation,
    AnimalName,
    ApexHeight,
    Asymmetric,
    Branch,
    EnergiesFile,
    Energy,
    Family,
    FigureFile,
    FilmFile,
    FootfallFile,
    Free,
    Heading,
    Json,
    LateralDrift,
    MeanSpeed,
    MotionFile,
    OwnFamily,
    Slope,
    Slow,
    Speed,
    WorkWeights,
    check_figure,
    check_film,
    integer,
    number,
)
from legspring.cli.outputs import draws, draws_preset, films, save, save_dataset
from legspring.cli.program import app, say
from legspring.cli.subjects import FindGait, about_gait, check_strides, choose_gait, no_gait, search_at, simulate_start
from legspring.printing import (
    describe_animal,
    describe_gait,
    print_animals,
    print_gaits,
    print_json,
    print_parameters,
    print_run,
)


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
def parameters(animal: AnimalName, slope: Slope = None, family: OwnFamily = None, as_json: Json = False) -> None:
    """List everything of an animal that can vary at a slope, with values, units and words.

    Example: legspring parameters cockroach --slope 45
    """
    from legspring.cli.options import check_slope
    from legspring.model import load_animal
    from legspring.varied import parameters

    creature = load_animal(animal)
    check_slope(creature, slope)
    found = parameters(creature, slope_deg=slope, family=family)
    if as_json:
        print_json([one._asdict() for one in found])
    else:
        print_parameters(found)


@app.command()
def gaits(
    animal: AnimalName,
    slope: Slope = None,
    heading: Heading = None,
    family: Family = None,
    actuation: Actuation = None,
    speed: Speed = None,
    mean_speed: MeanSpeed = None,
    energy: Energy = None,
    apex_height: ApexHeight = None,
    lateral_drift: LateralDrift = None,
    free: Free = None,
    asymmetric: Asymmetric = False,
    work_weights: WorkWeights = None,
    as_json: Json = False,
    figure: FigureFile = None,
    footfalls: FootfallFile = None,
) -> None:
    """Find the gaits at one slope and heading; --figure and --footfalls draw the first one.

    Example: legspring gaits cockroach --slope 45 --heading 0.15

    Example: legspring gaits lateral_leg_spring

    Example: legspring gaits walker --energy 816

    Example: legspring gaits cockroach --slope 0 --heading 0.15 --work-weights 1,0.25
    """
    check_figure(figure)
    check_figure(footfalls)
    search = search_at(
        animal,
        slope,
        heading,
        family,
        actuation,
        free,
        asymmetric,
        work_weights,
        speed=speed,
        mean_speed=mean_speed,
        energy=energy,
        apex_height=apex_height,
        lateral_drift=lateral_drift,
    )
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
            metavar="NUMBERS",
            help="Phase in degrees, one for each pair of legs, separated by commas, for a start that is no gait; by "
            "default the animal's.",
            show_default=False,
        ),
    ] = None,
    actuation: Actuation = None,
    mean_speed: MeanSpeed = None,
    energy: Energy = None,
    apex_height: ApexHeight = None,
    lateral_drift: LateralDrift = None,
    free: Free = None,
    asymmetric: Asymmetric = False,
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
    motion: MotionFile = None,
    energies: EnergiesFile = None,
    animation: FilmFile = None,
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
    for path in (figure, footfalls, motion, energies):
        check_figure(path)
    check_film(animation)
    check_strides(animal, strides)
    if speed is None and phase is None:
        gait = choose_gait(
            search_at(
                animal,
                slope,
                heading,
                family,
                actuation,
                free,
                asymmetric,
                mean_speed=mean_speed,
                energy=energy,
                apex_height=apex_height,
                lateral_drift=lateral_drift,
            ),
            slope,
            heading,
            branch,
        )
        run, about = gait.simulate(strides), {"family": gait.family, "branch": gait.branch}
    else:
        if branch is not None:
            raise ValueError(f"--branch = {branch}: must be left out for a start that is no gait")
        run = simulate_start(
            animal,
            slope=slope,
            heading=heading,
            speed=speed,
            phase=phase,
            family=family,
            actuation=actuation,
            strides=strides,
        )
        # Without a family there is but one.
        about = {"family": family or next(iter(load_animal(animal).families)), "branch": None}
    print_run(run, about, strides, as_json)
    save(
        (out, partial(save_dataset, run)),
        (figure, draws("draw_simulation", run)),
        (footfalls, draws("draw_footfalls", run)),
        (motion, draws("draw_motion", run)),
        (energies, draws("draw_energy", run)),
        (animation, films(run)),
    )


@app.command()
@about_gait
def recover(
    found: FindGait,
    impulse: Annotated[
        float,
        typer.Option(parser=number, metavar="NUMBER", help="Sideways impulse in units of m v_des, > 0 to the right."),
    ] = 0.5,
    as_json: Json = False,
    figure: FigureFile = None,
    animation: FilmFile = None,
) -> None:
    """Push a gait sideways in its first step and count the steps until it is back.

    Example: legspring recover cockroach --slope 45 --heading 0.15 --impulse 0.5
    """
    check_figure(figure)
    check_film(animation)
    gait = found()
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
    save((figure, draws("draw_recovery", recovery)), (animation, films(recovery)))


@app.command()
def animate(
    animal: AnimalName,
    out: Annotated[
        Path,
        typer.Option(
            metavar="FILE",
            help="The moving picture: .gif; .html, a page with a player; .mp4 or .webm, by the extra video.",
        ),
    ],
    slope: Slope = None,
    heading: Heading = None,
    branch: Branch = None,
    beside: Annotated[
        int | None,
        typer.Option(parser=integer, metavar="NUMBER", help="Number of another gait, to be seen beside it."),
    ] = None,
    family: Family = None,
    actuation: Actuation = None,
    speed: Speed = None,
    mean_speed: MeanSpeed = None,
    energy: Energy = None,
    apex_height: ApexHeight = None,
    lateral_drift: LateralDrift = None,
    free: Free = None,
    asymmetric: Asymmetric = False,
    strides: Annotated[float, typer.Option(parser=number, metavar="NUMBER", help="How much of it.")] = 2.0,
    slow: Slow = None,
) -> None:
    """Make a moving picture of a gait; `simulate` and `recover` make others, with --animation.

    Example: legspring animate cockroach --slope 45 --heading 0.15 --out run.gif

    Example: legspring animate cockroach --slope 45 --heading 0.15 --beside 1 --slow 50 --out two.html
    """
    check_film(out)
    check_strides(animal, strides)
    search = search_at(
        animal,
        slope,
        heading,
        family,
        actuation,
        free,
        asymmetric,
        speed=speed,
        mean_speed=mean_speed,
        energy=energy,
        apex_height=apex_height,
        lateral_drift=lateral_drift,
    )
    numbers = [branch] if beside is None else [branch, beside]
    gaits = [choose_gait(search, slope, heading, one) for one in numbers]
    save((out, films(*gaits, strides=strides, slow=slow)))
