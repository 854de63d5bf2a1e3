"""What the commands print: tables for people, JSON for programs."""

import json
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    import xarray as xr

    from legspring.gait import Gait
    from legspring.optimisation import Optimum
    from legspring.solve import Search


def plain(value: Any) -> Any:
    """Return a value as JSON can hold it: arrays as lists, complex numbers as [re, im], what is missing as null."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    match value:
        case list() | tuple():
            return [plain(part) for part in value]
        case complex():
            return [value.real, value.imag]
        case float() if not math.isfinite(value):
            return None
    return value


def print_json(records: Sequence[Mapping[str, Any]]) -> None:
    """Print a list of flat objects, one a line."""
    objects = [{name: plain(value) for name, value in record.items()} for record in records]
    lines = ",\n ".join(json.dumps(record, allow_nan=False) for record in objects)
    typer.echo(f"[{lines}]")


ATTRIBUTES = (
    *("family", "branch", "slope_deg", "heading", "speed", "phase", "actuation", "yaw", "yaw_rate", "liftoff"),
    *(
        "events",
        "residual",
        "drift",
        "grazing",
        "reduced_eigenvalue",
        "multipliers",
        "transport_cost",
        "work",
        "peak_force",
        "yaw_amplitude",
        "peak_moment",
    ),
)
"""What is said about a gait in JSON; the net force is added in two parts."""


def describe_gait(gait: "Gait") -> dict[str, Any]:
    """Return what a gait has to say for itself, by the names of its attributes."""
    high, low = gait.net_force
    return {name: getattr(gait, name) for name in ATTRIBUTES} | {"net_force_max": high, "net_force_min": low}


def describe_optimum(best: "Optimum") -> dict[str, Any]:
    """Return what an optimised gait has to say for itself."""
    own = ("objective", "map", "method", "value", "penalised", "ending", "active", "evaluations")
    return describe_gait(best) | {name: getattr(best, name) for name in own}


def print_optimum(best: "Optimum") -> None:
    """Print an optimised gait, what was reached, and why not more."""
    lengths = {leg.pair: leg.length for leg in best.animal.legs}
    shares = zip(best.animal.pairs, best.actuation, strict=True)
    amounts = ", ".join(f"{pair} {1e3 * amount:.2f} mm ({amount / lengths[pair]:.3f} l0)" for pair, amount in shares)
    phases = ", ".join(f"{math.degrees(angle):.1f}" for angle in best.phase)
    binding = "\n  ".join(best.active) or "none"
    typer.echo(
        f"{best.animal.name}, family {best.family}: slope {best.slope_deg:g} deg, heading {best.heading:g} rad\n"
        f"actuation: {amounts}\n"
        f"speed {best.speed:.4f} m/s, phases {phases} deg\n"
        f"reduced eigenvalue {best.reduced_eigenvalue:.4f}, largest multiplier {abs(best.multipliers[0]):.4f}, "
        f"transport cost {best.transport_cost:.4f}\n"
        f"{best.objective}, {best.map} map, {best.method}: {best.value:.4f}, with penalties {best.penalised:.4f}; "
        f"{best.ending} after {best.evaluations} evaluations\n"
        f"constraints that bind:\n  {binding}"
    )


def print_gaits(search: "Search") -> None:
    """Print a table of gaits, and what else was met."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    first = search.gaits[0]
    pairs, yaws = ", ".join(first.animal.pairs), first.animal.body.yaw == "free"
    # One more column fits into 80 characters where columns are closer.
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 0 if yaws else 1, 0, 0), title_justify="left")
    table.title = f"{first.animal.name}: slope {first.slope_deg:g} deg, heading {first.heading:g} rad"
    for name in ("branch", "family"):
        table.add_column(name)
    for name in (
        "speed\n(m/s)",
        f"phase {pairs}\n(deg)",
        *(["yaw\n(rad)"] if yaws else []),
        "reduced\neigenvalue",
        "largest\nmultiplier",
        "transport\ncost",
    ):
        table.add_column(name, justify="right", no_wrap=True)
    for gait in search.gaits:
        phases = ", ".join(f"{math.degrees(angle):.1f}" for angle in gait.phase)
        measures = (gait.reduced_eigenvalue, abs(gait.multipliers[0]), gait.transport_cost)
        yaw = [f"{gait.yaw_amplitude:.3f}"] if yaws else []
        row = (str(gait.branch), gait.family, f"{gait.speed:.4f}", phases, *yaw)
        table.add_row(*row, *(f"{measure:.4f}" for measure in measures))
    Console(highlight=False).print(table)
    for gait in search.gaits:
        if gait.grazes:
            typer.echo(
                f"branch {gait.branch}: a leg lifts off at {gait.grazing:.2g} m/s only; its stability is doubtful"
            )
    typer.echo(search.summary())


def print_run(run: "xr.Dataset", about: Mapping[str, Any], strides: float, as_json: bool) -> None:
    """Print where a simulation started and ended."""
    end = run.isel(time=-1)
    last = {"strides": strides, "displacement": end["position"].values, "velocity": end["velocity"].values}
    record = {**run.attrs, **about, **last}
    if as_json:
        print_json([record])
        return
    phases = ", ".join(f"{math.degrees(angle):.1f}" for angle in record["phase"])
    (dx, dy), (vx, vy) = record["displacement"], record["velocity"]
    typer.echo(
        f"{record['animal']}, family {record['family']}, slope {record['slope_deg']:g} deg, phases {phases} deg\n"
        f"start: heading {record['heading']:g} rad, speed {record['speed']:.4f} m/s\n"
        f"after {strides:g} strides, {end['time'].item():.4f} s: {1e3 * dy:.2f} mm uphill, {1e3 * dx:+.2f} mm to the "
        f"right, heading {math.atan2(-vx, vy) - end['yaw'].item():.4f} rad, speed {math.hypot(vx, vy):.4f} m/s"
    )
