"""Commands that map, optimise and reproduce."""

import sys
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

import legspring
from legspring.cli.options import (
    Actuation,
    AnimalName,
    ApexHeight,
    Asymmetric,
    Cluster,
    Energy,
    FigureFile,
    Free,
    Heading,
    Json,
    LateralDrift,
    MeanSpeed,
    OwnFamily,
    Slope,
    Speed,
    StoreFolder,
    Workers,
    WorkWeights,
    check_figure,
    check_slope,
    integer,
    load_weighing,
    parse_grid,
    parse_names,
    parse_numbers,
    parse_over,
    parse_samples,
)
from legspring.cli.outputs import atlas_figures, draws, save, save_dataset
from legspring.cli.program import NO_GAIT, app, fail, patience
from legspring.cli.subjects import choose_gait, search_at, where
from legspring.printing import describe_optimum, print_json, print_optimum


@app.command()
def atlas(
    animal: AnimalName,
    out: Annotated[
        Path,
        typer.Option(
            metavar="FILE", help="The file to write: .nc (netCDF), .csv or .mat (MATLAB).", show_default=False
        ),
    ],
    slopes: Annotated[
        str | None,
        typer.Option(metavar="START:STOP:STEP", help="Slopes in degrees; by default 0:90:5.", show_default=False),
    ] = None,
    headings: Annotated[
        str | None,
        typer.Option(
            metavar="START:STOP:STEP", help="Headings in radians; by default 0:0.45:0.05.", show_default=False
        ),
    ] = None,
    over: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=START:STOP:STEP",
            help="In place of slopes and headings, whatever varies: slope_deg, a target such as energy, or a parameter "
            "such as F.stiffness; once for each.",
            show_default=False,
        ),
    ] = None,
    slope: Slope = None,
    heading: Heading = None,
    speed: Speed = None,
    mean_speed: MeanSpeed = None,
    energy: Energy = None,
    apex_height: ApexHeight = None,
    lateral_drift: LateralDrift = None,
    free: Free = None,
    asymmetric: Asymmetric = False,
    no_recovery: Annotated[bool, typer.Option("--no-recovery", help="Do not push every gait sideways.")] = False,
    actuation: Actuation = None,
    work_weights: WorkWeights = None,
    method: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help="search: in every cell; follow: a few gaits along all lines of the grid first, which numbers the "
            "sheets that hang together.",
        ),
    ] = "search",
    store: StoreFolder = None,
    cluster: Cluster = None,
    workers: Workers = None,
    figures: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Draw Figures 4.1 to 4.5 of the thesis, or other maps, into this directory."),
    ] = None,
) -> None:
    """Map the gaits over slope and heading, or over any parameters, into a file.

    Example: legspring atlas cockroach --out atlas.nc --figures maps

    Example: legspring atlas cockroach --out coarse.nc --slopes 0:90:15 --headings 0.05,0.15 --no-recovery

    Example: legspring atlas walker --out walks.nc --over energy=805:825:5 --over T.stiffness=13000:15000:500
    """
    from legspring.files import check_output, make_directory

    slopes_deg = None if slopes is None else parse_grid("--slopes", slopes)
    radians = None if headings is None else parse_grid("--headings", headings)
    creature, magnitudes = load_weighing(animal, work_weights), parse_numbers("--actuation", actuation)
    check_output(out, [".nc", ".csv", ".mat"])
    if figures is not None:
        make_directory(figures)
    from legspring.atlases import atlas as map_gaits
    from legspring.mapping import IMPULSES

    maps = map_gaits(
        creature,
        slopes_deg=slopes_deg,
        headings=radians,
        over=parse_over(over),
        slope_deg=slope,
        heading=heading,
        speed=speed,
        mean_speed=mean_speed,
        method=method,
        energy=energy,
        apex_height=apex_height,
        lateral_drift=lateral_drift,
        free=parse_names(free),
        mirrored=False if asymmetric else None,
        actuation=magnitudes,
        impulses=() if no_recovery else IMPULSES,
        store=store,
        cluster=cluster,
        workers=workers,
        progress=sys.stderr.isatty(),
    )
    found = maps["family"].values != ""
    cells = found.any(axis=-1)
    print(f"{out}: {found.sum()} gaits in {cells.sum()} of {cells.size} cells")
    save((out, partial(save_dataset, maps)), *([] if figures is None else atlas_figures(maps, figures)))


@app.command()
def sweep(
    animal: AnimalName,
    over: Annotated[
        list[str],
        typer.Option(
            "--over",
            metavar="NAME=START:STOP:STEP",
            help="What varies, once for each; numbers separated by commas; or, for samples, NAME=LOW:HIGH. SI units.",
        ),
    ],
    follow: Annotated[
        bool,
        typer.Option(
            "--follow", help="Follow the gaits found at --slope and --heading to all points, which is much faster."
        ),
    ] = False,
    branch: Annotated[
        int | None, typer.Option(parser=integer, metavar="NUMBER", help="Only this one of them.", show_default=False)
    ] = None,
    samples: Annotated[
        int | None, typer.Option(parser=integer, metavar="NUMBER", help="How many samples.", show_default=False)
    ] = None,
    sampling: Annotated[
        str | None, typer.Option(metavar="NAME", help="sobol (by default), latin, random, saltelli; or list.")
    ] = None,
    seed: Annotated[int, typer.Option(parser=integer, metavar="NUMBER", help="Of samples.")] = 0,
    slope: Slope = None,
    heading: Heading = None,
    speed: Speed = None,
    mean_speed: MeanSpeed = None,
    energy: Energy = None,
    apex_height: ApexHeight = None,
    lateral_drift: LateralDrift = None,
    free: Free = None,
    asymmetric: Asymmetric = False,
    measures: Annotated[
        str | None, typer.Option(metavar="NAMES", help="What to say of gaits, separated by commas.", show_default=False)
    ] = None,
    starts: Annotated[
        int | None,
        typer.Option(
            parser=integer,
            metavar="NUMBER",
            help="Starts of a search at each point, for each family; by default 8 or 16 on a grid, else 24.",
            show_default=False,
        ),
    ] = None,
    store: StoreFolder = None,
    cluster: Cluster = None,
    workers: Workers = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Save all of it: .nc (netCDF), .csv or .mat (MATLAB).", show_default=False),
    ] = None,
    figure: FigureFile = None,
    draw: Annotated[str, typer.Option(metavar="NAME", help="The measure that is drawn.")] = "max_multiplier",
) -> None:
    """Find and measure gaits over any parameters: on a grid, at listed points, or at samples.

    Example: legspring sweep cockroach --slope 45 --heading 0.15 --follow --over slope_deg=35:55:1
    --over F.stiffness=1.2:1.8:0.1 --store runs.zarr --figure sweep.png

    Example: legspring sweep cockroach --heading 0.15 --slope 45 --follow --samples 1000 --over mass=0.002:0.003
    --over M.stiffness=1.2:1.8 --out samples.csv
    """
    from legspring.files import check_output

    check_figure(figure)
    if out is not None:
        check_output(out, [".nc", ".csv", ".mat"])
    with patience("loading"):
        from legspring import sweeping
        from legspring.checks import checked_choice
        from legspring.measures.registry import BY_NAME
        from legspring.plans import QUICK, SAMPLINGS
    if store is None and out is None and figure is None:
        raise ValueError("--store, --out or --figure must be given, for the result to be kept")
    names = parse_names(measures)
    drawable = [one.name for one in BY_NAME.values() if one.unit and not one.dimensions]
    if figure is not None and (draw not in (names or QUICK) or draw not in drawable):
        valid = ", ".join(name for name in (names or QUICK) if name in drawable)
        raise ValueError(f"--draw = {draw!r}: must be one of {valid}")
    how = sampling or ("grid" if samples is None else "sobol")
    checked_choice("--sampling", how, SAMPLINGS)
    points = (parse_over(over) or {}) if how in ("grid", "list") else parse_samples(over)
    targets: Any = {"speed": speed, "mean_speed": mean_speed, "energy": energy}
    targets |= {"apex_height": apex_height, "lateral_drift": lateral_drift}
    creature = load_weighing(animal, None)
    asked: dict[str, Any] = {"slope_deg": slope, "free": parse_names(free), "mirrored": False if asymmetric else None}
    if branch is not None and not follow:
        raise ValueError(f"--branch = {branch}: must be left out without --follow")
    if follow:
        search = search_at(animal, slope, heading, None, None, free, asymmetric, **targets)
        one = choose_gait(search, slope, heading, branch)
        asked = {"gaits": search.gaits if branch is None else one}
    else:
        asked |= targets | {"heading": heading}
    try:
        found = sweeping.sweep(
            creature,
            points,
            samples=samples,
            sampling=how,
            seed=seed,
            measures=names or None,
            starts=starts,
            store=store,
            cluster=cluster,
            workers=workers,
            progress=sys.stderr.isatty(),
            **asked,
        )
    except ImportError as error:
        raise ValueError(str(error)) from None
    outcome = found["outcome"].values
    print(f"{(outcome == 0).sum()} gaits at {(outcome == 0).any(axis=-1).sum()} of {outcome[..., 0].size} points")
    print(*sweeping.fates_of(found), sep="\n", end="\n" if len(sweeping.fates_of(found)) else "")
    save((out, partial(save_dataset, found)), (figure, draws("draw_sweep", found, draw)))


@app.command()
def optimize(
    animal: AnimalName,
    slope: Slope = None,
    heading: Heading = None,
    objective: Annotated[
        str, typer.Option(metavar="GOAL", help="What to reach: stability or efficiency.")
    ] = "stability",
    family: OwnFamily = None,
    map: Annotated[
        str, typer.Option(metavar="MAP", help="Whose eigenvalues count: complete, or the thesis's reduced map.")
    ] = "complete",
    method: Annotated[
        str, typer.Option(metavar="METHOD", help="default, or nelder-mead for the thesis's method.")
    ] = "default",
    work_weights: WorkWeights = None,
    as_json: Json = False,
    figure: FigureFile = None,
) -> None:
    """Find the actuation that makes a gait most stable or most efficient.

    Example: legspring optimize cockroach --slope 45 --heading 0.15 --objective efficiency
    """
    check_figure(figure)
    creature = load_weighing(animal, work_weights)
    check_slope(creature, slope)
    with patience("searching for the best actuation"):
        best = legspring.optimize(
            creature,
            slope_deg=slope,
            heading=heading,
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
    starts: Annotated[
        int,
        typer.Option(
            parser=integer,
            metavar="NUMBER",
            help="Further starts of the thesis's own search, to see what depends on them; each takes a while.",
        ),
    ] = 0,
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
            starts=starts,
            workers=workers,
            progress=sys.stderr.isatty(),
        )
    )
