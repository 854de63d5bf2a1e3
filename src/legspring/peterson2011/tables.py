"""Tables in words and numbers, and those of the thesis that are about the model: 3.1 and 4.1."""

import csv
import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from legspring.constraints import Constraint
from legspring.files import whole_file
from legspring.model import Animal
from legspring.peterson2011.constraints import TABLE_3_1

LEG_WORDS = {"F": "front", "M": "middle", "B": "back"}


class Range(NamedTuple):
    """The smallest and the largest of some numbers; nan where there are none."""

    min: float
    max: float


Cell = str | float | Range


@dataclass(frozen=True)
class Table:
    """A table: `save_table` writes its numbers; `header` and `rows` are the words for a page.

    Attributes
    ----------
    number
        As in the thesis.
    caption
        What it shows.
    columns
        Names of the columns.
    cells
        Those of each row.
    """

    number: str
    caption: str
    columns: tuple[str, ...]
    cells: tuple[tuple[Cell, ...], ...]

    @property
    def stem(self) -> str:
        """Name of its file, without the ending."""
        return f"table_{self.number.replace('.', '_')}"

    @property
    def header(self) -> tuple[str, ...]:
        """Names of the columns in words."""
        return tuple(column.replace("_nelder_mead", ", Nelder-Mead").replace("_", " ") for column in self.columns)

    @property
    def rows(self) -> tuple[tuple[str, ...], ...]:
        """Cells of each row in words; empty where a number is missing."""
        return tuple(tuple(map(_text, row)) for row in self.cells)


def _text(cell: Cell) -> str:
    if isinstance(cell, Range):
        return "" if math.isnan(cell.min) else f"{cell.min:.2f} to {cell.max:.2f}"
    if isinstance(cell, str):
        return cell
    return "" if math.isnan(cell) else f"{cell:.3g}"


def save_table(table: Table, path: str | os.PathLike[str]) -> None:
    """Save a table as CSV; a range becomes two columns, such as model_min and model_max.

    Parameters
    ----------
    table
        The table.
    path
        The file; it appears whole, or not at all.
    """
    ranges = [any(isinstance(row[place], Range) for row in table.cells) for place in range(len(table.columns))]
    head: list[str] = []
    for column, two in zip(table.columns, ranges, strict=True):
        head += [f"{column}_min", f"{column}_max"] if two else [column]
    with whole_file(path) as file, open(file, "w", newline="", encoding="utf-8") as out:
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(head)
        for row in table.cells:
            parts = [part for cell in row for part in (cell if isinstance(cell, Range) else (cell,))]
            writer.writerow([part if isinstance(part, str) else _number(part) for part in parts])


def _number(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.6g}"


def constraint_table() -> Table:
    """Return Table 3.1: what an optimised gait must keep to, what for, and what it costs not to."""
    missing = "max(10 + log10 e, 0), e the sum of squared residuals"
    angle = "0.05 (10 - a), a the angle between their curves against time in deg, rates in m/s; where a < 10"
    share, least = TABLE_3_1.beside
    further = f"There are gaits around it, too: it is not the last one of its kind. Below {least / share:g} rad, at "
    rows = {
        Constraint.FIXED_POINT: ("hard", f"2 + 2 {missing}", "There is something to be optimised."),
        Constraint.FIXED_POINT_BESIDE: ("hard", f"0.5 + 0.5 {missing}", f"{further}{least:g} rad more."),
        Constraint.PHASE_LATEST: (
            "soft",
            "0.5 (phi - pi/3) / (pi/6)",
            "Stances are long enough: those of late phases are short and weak.",
        ),
        Constraint.PHASE_EARLIEST: (
            "hard",
            "0.5 + 0.5 (-pi/2 - phi) / (pi/6)",
            "At touch-down, the force-free length changes as the leg's function has it.",
        ),
        Constraint.ANGLE_TOUCHDOWN: ("soft", angle, "The force begins clearly, whatever disturbs the leg."),
        Constraint.ANGLE_LIFTOFF: ("soft", angle, "The force ends clearly: the time of lift-off is well defined."),
        Constraint.ACTUATION_LEAST: ("hard", "30 + (0.2 l0 - ldev) / (0.2 l0)", "Every leg does something."),
        Constraint.ACTUATION_MOST: ("hard", "30 + (ldev - 0.9 l0) / (0.1 l0)", "Legs keep a length."),
    }
    return Table(
        "3.1",
        "Constraints of the optimisation. Where one is not kept, its penalty is added to the objective. The purposes "
        "are in our words.",
        ("constraint", "type", "penalty", "purpose"),
        tuple((TABLE_3_1.words(constraint), *rows[constraint]) for constraint in Constraint),
    )


def parameter_table(animal: Animal, slopes_deg: Sequence[float], headings: Sequence[float]) -> Table:
    """Return Table 4.1: an animal with fixed actuation, and the grid on which its gaits are looked for."""
    legs = [animal.legs[first] for first in animal.first_legs]
    ends = [math.radians(slope) for slope in (min(slopes_deg), max(slopes_deg))]
    speeds, durations = [list(map(law, ends)) for law in (animal.desired_speed, animal.step_duration)]
    none: tuple[Cell, ...] = ("",) * len(legs)
    rows: list[tuple[Cell, ...]] = [
        ("nominal length l0", "mm", *(1e3 * leg.length for leg in legs), ""),
        ("angle at touch-down beta", "deg", *(math.degrees(leg.angle) for leg in legs), ""),
        ("actuation ldev", "mm", *(1e3 * leg.actuation for leg in legs), ""),
        ("stiffness k", "N/m", *(float(leg.stiffness) for leg in legs), ""),
        ("mass m", "g", *none, 1e3 * animal.body.mass),
        ("slope sigma", "deg", *none, _grid(slopes_deg)),
        ("initial heading delta0", "rad", *none, _grid(headings)),
        ("desired speed v_des", "m/s", *none, "{:.3g} to {:.3g}, linear in the slope".format(*speeds)),
        ("step duration t_des", "ms", *none, "{:.3g} to {:.3g}, by the speed".format(*(1e3 * t for t in durations))),
    ]
    names = ", ".join(leg.name for leg in legs)
    return Table(
        "4.1",
        f"Parameters with fixed actuation. Angles are those of the legs that touch down first ({names}), positive "
        "counter-clockwise from straight ahead. Speeds and durations from the least slope to the greatest.",
        ("quantity", "unit", *animal.pairs, "all"),
        tuple(rows),
    )


def _grid(values: Sequence[float]) -> str:
    """Say which values a grid has."""
    steps = np.diff(values)
    if len(steps) and np.allclose(steps, steps[0]):
        return f"{values[0]:g} to {values[-1]:g} in steps of {steps[0]:g}"
    return ", ".join(f"{value:g}" for value in values)
