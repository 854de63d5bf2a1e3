"""Commands that say what a gait survives."""

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
    parse_numbers,
    parse_over,
)
from legspring.cli.outputs import draws, save, save_dataset
from legspring.cli.program import app, patience
from legspring.cli.subjects import FindGait, about_gait
from legspring.printing import (
    describe_basin,
    describe_pushes,
    describe_rough,
    print_basin,
    print_json,
    print_pushes,
    print_rough,
)

Dataset = Annotated[
    Path | None, typer.Option("--out", metavar="FILE", help="Save the dataset: .nc (netCDF) or .mat (MATLAB).")
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
    dataset = basin(gait, axes, memory=memory, most_strides=most_strides, refine=refine, progress=sys.stderr.isatty())
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
    dataset = pushes(gait, directions=directions, moments=moments, impulses=sizes, progress=sys.stderr.isatty())
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
        progress=sys.stderr.isatty(),
    )
    print_json(describe_rough(dataset)) if as_json else print_rough(gait, dataset)
    save((out, lambda path: save_dataset(dataset, path)), (figure, draws("draw_rough", dataset)))


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
