"""Commands that follow gaits while something varies."""

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from legspring.cli.options import (
    FigureFile,
    Json,
    check_figure,
    check_slope,
    integer,
    number,
    parse_names,
    parse_numbers,
)
from legspring.cli.outputs import draws, save, save_dataset
from legspring.cli.program import app, patience
from legspring.cli.subjects import FindGait, about_gait
from legspring.printing import print_curves, print_json


@app.command()
@about_gait
def follow(
    found: FindGait,
    along: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help="What varies: slope_deg, heading, a parameter (see legspring parameters), what gaits are asked for, "
            "as energy; or several names, separated by commas, which grow by a common factor.",
        ),
    ],
    to: Annotated[
        float | None,
        typer.Option(parser=number, metavar="NUMBER", help="Value at which to stop; by default both ways."),
    ] = None,
    within: Annotated[
        str | None,
        typer.Option(metavar="LOW,HIGH", help="Range that is not left.", show_default=False),
    ] = None,
    connected: Annotated[
        bool, typer.Option("--connected", help="Follow what branches off, too, and other families.")
    ] = False,
    most_points: Annotated[
        int, typer.Option(parser=integer, metavar="NUMBER", help="Points after which to stop, each way.")
    ] = 2000,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Save the curve: .nc (netCDF), .mat (MATLAB) or .csv (points only)."),
    ] = None,
    store: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Keep the curve there (.nc) while it is followed; go on from what is there."),
    ] = None,
    as_json: Json = False,
    figure: FigureFile = None,
    quantity: Annotated[
        str, typer.Option(metavar="NAME", help="What the figure shows: speed, heading, max_multiplier, phase_F, ...")
    ] = "speed",
) -> None:
    """Follow a gait while something varies, and list where it bends, branches, and ends.

    Example: legspring follow cockroach --slope 40 --heading 0.4 --along heading --to 0.6 --figure bifurcation.png

    Example: legspring follow cockroach --slope 15 --heading 0.2 --along heading --within 0,0.7 --connected

    Example: legspring follow walker --energy 816 --along energy --within 790,840 --out walker.nc
    """
    if out is not None:
        from legspring.files import SAVERS, check_output

        check_output(out, list(SAVERS))
    check_figure(figure)
    if store is not None:
        from legspring.files import check_output

        check_output(store, [".nc"])
    names: Any = parse_names(along)
    check_along(found.keywords["animal"], found.keywords["slope"], names)
    limits = parse_numbers("--within", within)
    if limits is not None and len(limits) != 2:
        raise ValueError(f"--within = {within!r}: must be two numbers, separated by a comma")
    gait = found()
    with patience("following"):
        from legspring.following import follow, follow_connected

        wanted: Any = {"to": to, "within": limits, "most_points": most_points}
        first = follow(gait, names if len(names) > 1 else along, store=store, **wanted)
        curves = [first, *follow_connected(first, progress=sys.stderr.isatty())] if connected else [first]
    print_json([describe for curve in curves for describe in describe_all(curve)]) if as_json else print_curves(curves)
    save(
        (out, lambda path: save_points(first.to_dataset(), path)),
        (figure, draws("draw_bifurcations", [curve.to_dataset() for curve in curves], quantity)),
    )


def check_along(name: str, slope: float | None, names: tuple[str, ...]) -> None:
    """Make sure that there is what is to vary, before gaits are searched for."""
    from legspring.model import load_animal
    from legspring.problem import TARGETS

    animal = load_animal(name)
    check_slope(animal, slope)
    with patience("loading"):
        from legspring.layout import System, slope_for

    system = System(animal, slope_for(animal, None, slope), next(iter(animal.families)))
    for one in names:
        if one not in TARGETS:
            system.direction(one)


def save_points(dataset: Any, path: Path) -> None:
    """Save a curve, as a table with a row for each point where the file's ending says so."""
    if path.suffix.lower() == ".csv":
        from legspring.files import save_csv

        save_csv(dataset.assign({name: dataset[name].astype(int) for name in ("valid", "stable")}), path, ("point",))
    else:
        save_dataset(dataset, path)


def describe_all(curve: Any) -> list[dict[str, Any]]:
    """Return the special points of a curve, and its end, as flat objects."""
    about = {"parameter": curve.parameter, "family": curve.gait.family}
    found = [
        about | {"kind": one.kind, "value": one.value, "leg": one.leg, "words": one.words} for one in curve.special
    ]
    ends = [curve.ending] if curve.beginning is None else [curve.beginning, curve.ending]
    return found + [
        about | {"kind": "end", "value": one.value, "leg": one.leg, "words": str(one.reason)} for one in ends
    ]
