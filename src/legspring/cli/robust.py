"""Commands that say what a gait survives, and what that costs."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from legspring.cli.options import (
    FigureFile,
    Json,
    check_figure,
    integer,
    number,
    parse_grid,
    parse_names,
    parse_numbers,
    parse_over,
    parse_ranges,
)
from legspring.cli.outputs import draws, save, save_dataset
from legspring.cli.program import app, patience
from legspring.cli.subjects import FindGait, about_gait
from legspring.printing import (
    describe_basin,
    describe_front,
    describe_pushes,
    describe_rough,
    print_basin,
    print_front,
    print_json,
    print_pushes,
    print_rough,
)

Dataset = Annotated[
    Path | None, typer.Option("--out", metavar="FILE", help="Save the dataset: .nc (netCDF) or .mat (MATLAB).")
]
Store = Annotated[
    Path | None,
    typer.Option(metavar="DIRECTORY", help="Keeps what was computed: what was stopped goes on where it was."),
]
OverStarts = Annotated[
    list[str],
    typer.Option(
        "--over",
        metavar="NAME=START:STOP:STEP",
        help="What varies, once or twice: speed, heading, Dx, ..., or a parameter; or numbers separated by commas. "
        "SI units.",
    ),
]


@app.command()
@about_gait
def basin(
    found: FindGait,
    over: OverStarts,
    memory: Annotated[
        str,
        typer.Option(metavar="WORD", help="Old feet: kept, where the gait has them, or rebuilt, as by the thesis."),
    ] = "kept",
    most_strides: Annotated[
        int, typer.Option(parser=integer, metavar="NUMBER", help="Strides after which a start counts as neither.")
    ] = 400,
    refine: Annotated[
        int, typer.Option(parser=integer, metavar="NUMBER", help="How often to halve the grid along the basin's edge.")
    ] = 0,
    store: Store = None,
    out: Dataset = None,
    as_json: Json = False,
    figure: FigureFile = None,
) -> None:
    """Find out which starts lead to a gait, and where the others go.

    Example: legspring basin cockroach --slope 15 --heading 0.2 --over speed=0.1:1.5:0.05 --over heading=-1.5:1.5:0.1
    """
    check_outputs(out, figure)
    axes = parse_over(over) or {}
    gait = found()
    with patience("loading"):
        from legspring.basins import basin
    dataset = basin(
        gait,
        axes,
        memory=memory,
        most_strides=most_strides,
        refine=refine,
        store=store,
        progress=sys.stderr.isatty(),
    )
    print_json(describe_basin(dataset)) if as_json else print_basin(gait, dataset)
    save((out, lambda path: save_dataset(dataset, path)), (figure, draws("draw_basin", dataset)))


@app.command()
@about_gait
def push(
    found: FindGait,
    directions: Annotated[
        int, typer.Option(parser=integer, metavar="NUMBER", help="How many directions, all around.")
    ] = 24,
    moments: Annotated[int, typer.Option(parser=integer, metavar="NUMBER", help="How many moments of a stride.")] = 16,
    impulses: Annotated[
        str, typer.Option(metavar="START:STOP:STEP", help="Sizes that are tried, m v_des; or separated by commas.")
    ] = "0.25:5:0.25",
    store: Store = None,
    out: Dataset = None,
    as_json: Json = False,
    figure: FigureFile = None,
) -> None:
    """Find the largest push that a gait survives, in every direction and at every moment of a stride.

    Example: legspring push cockroach --slope 15 --heading 0.2 --figure pushes.png
    """
    check_outputs(out, figure)
    sizes = parse_grid("--impulses", impulses)
    gait = found()
    with patience("loading"):
        from legspring.pushing import pushes
    dataset = pushes(
        gait,
        directions=directions,
        moments=moments,
        impulses=sizes,
        store=store,
        progress=sys.stderr.isatty(),
    )
    print_json(describe_pushes(dataset)) if as_json else print_pushes(gait, dataset)
    save((out, lambda path: save_dataset(dataset, path)), (figure, draws("draw_pushes", dataset)))


@app.command()
@about_gait
def rough(
    found: FindGait,
    roughness: Annotated[
        list[str],
        typer.Option(
            "--with",
            metavar="NAME=AMOUNT",
            help="What changes from step to step, once or more: slope_deg, height (m), stiffness (of its logarithm), "
            "phase (rad), late (step durations): standard deviations; miss: a probability.",
        ),
    ],
    runs: Annotated[int, typer.Option(parser=integer, metavar="NUMBER", help="How many runs.")] = 1000,
    strides: Annotated[int, typer.Option(parser=integer, metavar="NUMBER", help="How many strides each.")] = 100,
    scales: Annotated[
        str, typer.Option(metavar="START:STOP:STEP", help="Multiples of the roughness; or separated by commas.")
    ] = "1",
    distribution: Annotated[str, typer.Option(metavar="WORD", help="normal or uniform.")] = "normal",
    correlation: Annotated[
        float, typer.Option(parser=number, metavar="NUMBER", help="From one step to the next, from 0 to below 1.")
    ] = 0.0,
    seed: Annotated[int, typer.Option(parser=integer, metavar="NUMBER", help="Of the luck.")] = 0,
    store: Store = None,
    out: Dataset = None,
    as_json: Json = False,
    figure: FigureFile = None,
) -> None:
    """Let a gait run over rough ground, or with bad luck, many times, and see how long it goes on.

    Example: legspring rough cockroach --slope 15 --heading 0.2 --with slope_deg=10 --with miss=0.02 --scales 1,2,3
    """
    check_outputs(out, figure)
    kinds = parse_amounts(roughness)
    sizes = parse_grid("--scales", scales)
    gait = found()
    with patience("loading"):
        from legspring.roughness import rough
    dataset = rough(
        gait,
        kinds,
        runs=runs,
        strides=strides,
        scales=sizes,
        distribution=distribution,
        correlation=correlation,
        seed=seed,
        store=store,
        progress=sys.stderr.isatty(),
    )
    print_json(describe_rough(dataset)) if as_json else print_rough(gait, dataset)
    save((out, lambda path: save_dataset(dataset, path)), (figure, draws("draw_rough", dataset)))


@app.command()
@about_gait
def pareto(
    found: FindGait,
    over: Annotated[
        list[str],
        typer.Option("--over", metavar="NAME=LOW:HIGH", help="A parameter and its range, once or more; SI units."),
    ],
    minimize: Annotated[
        str | None,
        typer.Option(
            metavar="NAMES",
            help="What is to be small, separated by commas: measures, or stability, recovery, push, basin, roughness.",
        ),
    ] = None,
    maximize: Annotated[str | None, typer.Option(metavar="NAMES", help="What is to be large.")] = None,
    bound: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=LOW:HIGH",
            help="What a gait must keep to, as in friction=:0.8 or mean_speed=0.3:, any number.",
        ),
    ] = None,
    constraints: Annotated[
        str | None, typer.Option(metavar="NAME", help="Constraints at a price, as in optimize: peterson2011.")
    ] = None,
    evaluations: Annotated[
        int, typer.Option(parser=integer, metavar="NUMBER", help="Gaits that the global search tries; 0 for none.")
    ] = 1000,
    points: Annotated[
        int, typer.Option(parser=integer, metavar="NUMBER", help="Largest number of gaits of the front.")
    ] = 15,
    seed: Annotated[int, typer.Option(parser=integer, metavar="NUMBER", help="Of the global search.")] = 0,
    store: Store = None,
    out: Dataset = None,
    as_json: Json = False,
    figure: FigureFile = None,
) -> None:
    """Find the gaits that are worth having where several things are to be small, or large.

    Example: legspring pareto cockroach --slope 10 --heading 0.15 --family A --over F.stiffness=0.5:2.5 --over
    B.stiffness=0.5:2.5 --minimize stability,transport_cost --figure front.png
    """
    check_outputs(out, figure)
    ranges = parse_ranges("--over", over)
    limits = parse_ranges("--bound", bound or [], half_open=True)
    least, most = parse_names(minimize), parse_names(maximize)
    gait = found()
    with patience("loading"):
        from legspring.fronts import pareto
    try:
        front = pareto(
            gait,
            ranges,  # type: ignore[arg-type]  # none of which is half open
            minimize=least,
            maximize=most,
            bounds=limits,  # type: ignore[arg-type]
            constraints=constraints,
            evaluations=evaluations,
            points=points,
            seed=seed,
            store=store,
            progress=sys.stderr.isatty(),
        )
    except ImportError as error:
        raise ValueError(str(error)) from None
    print_json(describe_front(front)) if as_json else print_front(gait, front)
    save((out, lambda path: save_dataset(front.to_dataset(), path)), (figure, draws("draw_front", front)))


def parse_amounts(texts: list[str]) -> dict[str, float]:
    """Read NAME=AMOUNT, each name once."""
    found: dict[str, float] = {}
    for text in texts:
        name, equals, amount = text.partition("=")
        values = parse_numbers(f"--with {name}", amount) if equals and name not in found else None
        if values is None or len(values) != 1:
            raise ValueError(f"--with = {text!r}: must be NAME=AMOUNT, each name once")
        found[name] = values[0]
    return found


def check_outputs(out: Path | None, figure: Path | None) -> None:
    """Make sure that what is wanted can be saved."""
    check_figure(figure)
    if out is not None:
        from legspring.files import check_output

        check_output(out, [".nc", ".mat"])
