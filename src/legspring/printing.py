"""What the commands print: tables for people, JSON for programs."""

import json
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from legspring.measures.registry import MEASURES, measured

if TYPE_CHECKING:
    import xarray as xr

    from legspring.continuation import Continuation
    from legspring.fronts import Front
    from legspring.gait import Gait
    from legspring.model import Animal
    from legspring.optimum import Optimum
    from legspring.solve import Search
    from legspring.varied import Parameter


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
    print(f"[{lines}]")


LEAST_MULTIPLIER, MOST_MULTIPLIERS = 5e-4, 3
"""Smallest multiplier, and how many of them, that a table shows."""
WIDEST = 10_000
"""Characters of a table, which is as wide as what is in it."""


def describe_gait(gait: "Gait") -> dict[str, Any]:
    """Return what a gait has to say for itself."""
    return measured(MEASURES, gait)


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
    print(
        f"{best.animal.name}, family {best.family}: slope {best.slope_deg:g} deg, heading {best.heading:g} rad\n"
        f"actuation: {amounts}\n"
        f"speed {best.speed:.4f} m/s, phases {phases} deg\n"
        f"reduced eigenvalue {best.reduced_eigenvalue:.4f}, largest multiplier {abs(best.multipliers[0]):.4f}, "
        f"transport cost {best.transport_cost:.4f}\n"
        f"{best.objective}, {best.map} map, {best.method}: {best.value:.4f}, with penalties {best.penalised:.4f}; "
        f"{best.ending} after {best.evaluations} evaluations\n"
        f"constraints that bind:\n  {binding}"
    )


def describe_animal(animal: "Animal") -> dict[str, Any]:
    """Return what is said about a preset."""
    own = {name: getattr(animal, name) for name in ("name", "summary", "source", "pairs", "tuned", "conservative")}
    return own | {
        "legs": [leg.name for leg in animal.legs],
        "families": list(animal.families),
        "yaw": animal.body.yaw,
        "slope_deg": animal.speed_law.domain_deg,
    }


def print_animals(animals: "Sequence[Animal]") -> None:
    """Print names, pairs of legs, families and what they stand for, a line each."""
    rows = [("animal", "pairs", "families", "summary")]
    rows += [(animal.name, ", ".join(animal.pairs), ", ".join(animal.families), animal.summary) for animal in animals]
    print_rows(rows)


def print_parameters(parameters: "Sequence[Parameter]") -> None:
    """Print names, values, units and words, a line each; a dash for what a gait has, or finds."""
    rows = [("name", "value", "unit", "")]
    rows += [
        (one.name, "-" if math.isnan(one.value) else f"{one.value:.6g}", one.unit, one.words) for one in parameters
    ]
    print_rows(rows)


def print_curves(curves: "Sequence[Continuation]") -> None:
    """Print the special points of curves in their order, a line each, and why they begin and end."""
    for curve in curves:
        if curve is not curves[0]:
            print()
        first, last = curve.values[[0, -1]]
        valid = int(curve.valid.sum())
        print(
            f"{curve.gait.animal.name}, family {curve.gait.family}: {len(curve)} points along {curve.parameter}, from "
            f"{first:.6g} to {last:.6g} {curve.unit}".removesuffix(" 1")
            + f"; {valid} are gaits, {int((curve.valid & curve.stable).sum())} of them stable"
        )
        if curve.beginning is not None:
            print(f"begins: {curve.beginning}")
        rows = [(curve.parameter, "", "leg", "")]
        rows += [(f"{one.value:.10g}", str(one.kind), one.leg or "-", one.words) for one in curve.special]
        if len(rows) > 1:
            print_rows(rows)
        print(f"ends: {curve.ending}")


def describe_basin(dataset: "xr.Dataset") -> list[dict[str, Any]]:
    """Return what becomes of starts, and of how many: an object for each outcome."""
    from legspring.settling import words_of

    fates, found = dataset["settles_on"].values, []
    for n in sorted(set(fates.ravel().tolist()), key=lambda n: (n < 0, abs(n))):
        steps = dataset["steps"].values[fates == n]
        one = {"number": n, "outcome": words_of(dataset, n), "share": float((fates == n).mean())}
        one |= {
            "area": float(dataset["area"][n]) if n >= 0 else None,
            "median_steps": float(sorted(steps)[len(steps) // 2]),
        }
        for name in ("speed", "heading", "periods", "multiplier"):
            values = dataset[f"attractor_{name}"].values
            one[name] = float(values[n]) if n >= 0 and values.ndim == 1 else None
        found.append(one)
    return found


def print_basin(gait: "Gait", dataset: "xr.Dataset") -> None:
    """Print what becomes of starts, a line for each outcome."""
    names = " and ".join(f"{name} ({axis.size})" for name, axis in dataset["settles_on"].coords.items())
    print(f"{gait!r}: starts over {names}, old feet {dataset.attrs['memory']}")
    rows = [("outcome", "share", "steps", "multiplier")]
    for one in describe_basin(dataset):
        size = "-" if one["multiplier"] is None else number(one["multiplier"])
        rows.append((one["outcome"], f"{100.0 * one['share']:.1f} %", f"{one['median_steps']:.0f}", size))
    print_rows(rows)


def describe_pushes(dataset: "xr.Dataset") -> list[dict[str, Any]]:
    """Return the largest impulse that is survived, for each direction and moment."""
    steps = dataset["recovery_steps"].isel(impulse=0).values
    return [
        {
            "direction": float(dataset["direction"][row]),
            "moment": float(dataset["moment"][column]),
            "survived": float(dataset["survived"][row, column]),
            "lost": float(dataset["lost"][row, column]),
            "recovery_steps": float(steps[row, column]),
        }
        for row in range(dataset.sizes["direction"])
        for column in range(dataset.sizes["moment"])
    ]


def print_pushes(gait: "Gait", dataset: "xr.Dataset") -> None:
    """Print the largest impulses that are survived: in each direction, the least over the moments of a stride."""
    least, most = float(dataset["impulse"][0]), float(dataset["impulse"][-1])
    print(f"{gait!r}: pushes up to {most:g} m v_des at {dataset.sizes['moment']} moments of a stride")
    rows = [("direction (deg)", "survives at any moment", "at the moment", f"steps back from {least:g}")]
    for n, direction in enumerate(dataset["direction"].values):
        survived, steps = dataset["survived"].values[n], dataset["recovery_steps"].values[n, :, 0]
        worst, back = int(survived.argmin()), [step for step in steps if math.isfinite(step)]
        bound = "" if math.isfinite(dataset["lost"].values[n, worst]) else " or more"
        back_words = f"{min(back):.0f} to {max(back):.0f}" if back else "-"
        moment = f"{float(dataset['moment'][worst]):.3f}" if not bound else "-"
        rows.append((f"{math.degrees(direction):.0f}", f"{survived[worst]:.3f}{bound}", moment, back_words))
    print_rows(rows)


def describe_rough(dataset: "xr.Dataset") -> list[dict[str, Any]]:
    """Return how long runs go on, an object for each multiple of the roughness."""
    names = [f"{name}{end}" for name in ("survival", "expected_steps") for end in ("", "_low", "_high")]
    names += ["mean_speed", "speed_spread", "mean_heading", "heading_spread"]
    last = dataset.isel(step=-1)
    return [
        {"scale": float(dataset["scale"][n])} | {name: float(last[name][n]) for name in names}
        for n in range(dataset.sizes["scale"])
    ]


def print_rough(gait: "Gait", dataset: "xr.Dataset") -> None:
    """Print how many runs go on to the end, and the steps to failure, with their 95 % confidence intervals."""
    print(f"{gait!r}: {dataset.sizes['run']} runs of {dataset.sizes['step']} steps with {dataset.attrs['roughness']}")
    rows: list[tuple[str, ...]] = [("multiple", "go on to the end", "steps to failure", "speed (m/s)", "heading (rad)")]
    for one in describe_rough(dataset):
        share, low, high = (100.0 * one[f"survival{end}"] for end in ("", "_low", "_high"))
        least, most = (number(one[f"expected_steps{end}"], 0) for end in ("_low", "_high"))
        failing = f"{number(one['expected_steps'], 0)} ({least} to {most})" if most != "-" else f"more than {least}"
        means = [f"{number(one[f'mean_{name}'])} +- {number(one[f'{name}_spread'])}" for name in ("speed", "heading")]
        rows.append((f"{one['scale']:g}", f"{share:.1f} % ({low:.1f} to {high:.1f})", failing, *means))
    print_rows(rows)


def describe_front(front: "Front") -> list[dict[str, Any]]:
    """Return the gaits of a front, an object each: what was traded, what varies, and the family."""
    return [
        {one.name: float(value) for one, value in zip(front.criteria, values, strict=True)}
        | {"penalty": float(penalty), "family": gait.family}
        | dict(zip(front.box.names, front.box.values(place).tolist(), strict=True))
        for gait, values, penalty, place in zip(front.gaits, front.values, front.penalties, front.places, strict=True)
    ]


def print_front(gait: "Gait", front: "Front") -> None:
    """Print the gaits of a front, a line each, and what separates its ends."""
    words = [
        f"{'least' if sign > 0.0 else 'most'} {one.name}" for one, sign in zip(front.criteria, front.signs, strict=True)
    ]
    print(f"{gait!r}: {', '.join(words)}; {front.evaluations} gaits tried, {len(front.gaits)} worth having")
    found = describe_front(front)
    if not found:
        print("no gait keeps all bounds")
        return
    charged = ["penalty"] if any(front.penalties) else []
    names = [*(one.name for one in front.criteria), *charged, *front.box.names]
    rows = [("family", *names)]
    rows += [(one["family"], *(f"{one[name]:.5g}" for name in names)) for one in found]
    print_rows(rows)
    print(*front.separation(), sep="\n")
    if limits := front.at_limits():
        print(f"most of them have {', '.join(limits)}: a wider range may give more")


def print_rows(rows: Sequence[tuple[str, ...]]) -> None:
    """Print rows in columns that line up."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        print("  ".join(f"{cell:{width}}" for cell, width in zip(row, widths, strict=True)).rstrip())


def number(value: float, digits: int = 4) -> str:
    """Return a number as tables show it, and what is missing as a dash."""
    return f"{value:.{digits}f}" if math.isfinite(value) else "-"


def tuned_columns(gait: "Gait") -> dict[str, str]:
    """Return the columns of a gait at a heading that somebody has chosen, with phases to go with it."""
    yaws = {"yaw\n(rad)": number(gait.yaw_amplitude, 3)} if gait.animal.body.yaw == "free" else {}
    return {
        "speed\n(m/s)": number(gait.speed),
        f"phase {', '.join(gait.animal.pairs)}\n(deg)": ", ".join(f"{math.degrees(a):.1f}" for a in gait.phase),
        **yaws,
        "reduced\neigenvalue": number(gait.reduced_eigenvalue),
        "largest\nmultiplier": number(abs(gait.multipliers[0])),
        "transport\ncost": number(gait.transport_cost),
    }


def own_columns(gait: "Gait") -> dict[str, str]:
    """Return the columns of a gait that has a heading of its own."""
    yaws = {"yaw\n(rad)": number(gait.yaw_amplitude, 3)} if gait.animal.body.yaw == "free" else {}
    largest = [f"{abs(value):.3f}" for value in gait.multipliers if abs(value) > LEAST_MULTIPLIER][:MOST_MULTIPLIERS]
    return {
        "heading\n(rad)": number(gait.heading),
        "speed\n(m/s)": number(gait.speed),
        "mean\n(m/s)": number(gait.mean_speed),
        **yaws,
        "multipliers,\nlargest first": ", ".join(largest),
        "transport\ncost": number(gait.transport_cost),
    }


def print_gaits(search: "Search") -> None:
    """Print a table of gaits, and what else was met."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    first = search.gaits[0]
    at_heading = first.animal.tuned and first.origin is not None and "heading" in first.origin.given
    columns = tuned_columns if at_heading else own_columns
    # One more column fits into 80 characters where columns are closer.
    close = first.animal.body.yaw == "free"
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 0 if close else 1, 0, 0), title_justify="left")
    heading = f", heading {first.heading:g} rad" if at_heading else ""
    table.title = f"{first.animal.name}: slope {first.slope_deg:g} deg{heading}"
    for name in ("branch", "family"):
        table.add_column(name)
    for name in columns(first):
        table.add_column(name, justify="right", no_wrap=True)
    for gait in search.gaits:
        table.add_row(str(gait.branch), gait.family, *columns(gait).values())
    # What does not fit into a terminal is wider than it, and keeps its digits; names are no markup.
    Console(highlight=False, markup=False, emoji=False, width=WIDEST).print(table)
    if first.conserved:
        print(f"conserved, with a multiplier of 1 each: {', '.join(first.conserved)}")
    for gait in search.gaits:
        if gait.grazes:
            print(f"branch {gait.branch}: a leg lifts off at {gait.grazing:.2g} m/s only; its stability is doubtful")
        if gait.freed:
            print(f"branch {gait.branch}: {', '.join(map(parameter_words, gait.freed, gait.freed.values()))}")
        if "transport_cost" in gait.missing:
            print(f"branch {gait.branch}: no transport cost; {gait.missing['transport_cost']}")
    print(search.summary())


def parameter_words(name: str, value: float) -> str:
    """Return a parameter's name, value and unit; angles in degrees."""
    from legspring.layout import unit_and_words

    unit = unit_and_words(name)[0]
    value, unit = (math.degrees(value), "deg") if unit == "rad" else (value, unit)
    return f"{name} {value:.5g} {unit}".removesuffix(" 1")


def print_run(run: "xr.Dataset", about: Mapping[str, Any], strides: float, as_json: bool) -> None:
    """Print where a simulation started and ended."""
    end = run.isel(time=-1)
    last = {"strides": strides, "displacement": end["position"].values, "velocity": end["velocity"].values}
    legs = {name: run[name].values for name in ("pairs", "phase", "actuation")} | {
        "functions": run["leg_function"].values
    }
    record = {**run.attrs, **legs, **about, **last}
    if as_json:
        print_json([record])
        return
    degrees = ", ".join(f"{math.degrees(angle):.1f}" for angle in record["phase"])
    phases = f", phases {degrees} deg" if any(record["actuation"]) else ""
    (dx, dy), (vx, vy) = record["displacement"], record["velocity"]
    heading = math.remainder(math.atan2(-vx, vy) - end["yaw"].item(), 2.0 * math.pi)
    up, aside = ("up", "forward") if record["view"] == "side" else ("uphill", "to the right")
    print(
        f"{record['animal']}, family {record['family']}, slope {record['slope_deg']:g} deg{phases}\n"
        f"start: heading {record['heading']:.4g} rad, speed {record['speed']:.4f} m/s\n"
        f"after {strides:g} strides, {end['time'].item():.4f} s: {length(dy)} {up}, {length(dx, '+')} {aside}, "
        f"heading {heading:.4f} rad, speed {math.hypot(vx, vy):.4f} m/s"
    )


def length(metres: float, sign: str = "") -> str:
    """Return a length in mm, or in m where that is long."""
    metres = round(metres, 5) + 0.0  # no -0.0
    return f"{1e3 * metres:{sign}.2f} mm" if abs(metres) < 1.0 else f"{metres:{sign}.4f} m"
