"""The thesis's tables from our own data, and where our forces differ from those it printed."""

import csv
import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from legspring.constraints import Constraint
from legspring.files import whole_file
from legspring.model import Animal
from legspring.peterson2011.constraints import TABLE_3_1
from legspring.peterson2011.published import published_forces

OBJECTIVES = ("stability", "efficiency")
LEG_WORDS = {"F": "front", "M": "middle", "B": "back"}
HEADINGS = (0.05, 0.40)
"""Range of headings over which Tables 6.1-6.3 take the smallest and the largest force, rad."""
CLEAR = 0.05
"""Difference of forces that asks for an explanation, in units of m g."""
SAME = 1e-3
"""Difference of objectives that makes no difference."""


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
        return tuple(column.replace("_", " ") for column in self.columns)

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


def force_ranges(atlas: xr.Dataset, selected: xr.Dataset, nelder_mead: xr.Dataset | None = None) -> xr.Dataset:
    """Return the numbers of Tables 6.1-6.3, ours beside the thesis's.

    Parameters
    ----------
    atlas
        Gaits with fixed actuation; branch 0 counts.
    selected
        Gaits of the best family of each cell, for each objective.
    nelder_mead
        The same, by the thesis's method.

    Returns
    -------
    xarray.Dataset
        Over leg, axis, slope_deg and extreme (see `legspring.peterson2011.published`): ``experiment``, ``model``,
        ``model_thesis``, and for each objective such as stability ``stability``, ``stability_nelder_mead`` and
        ``stability_thesis``; missing where there is no gait.
    """
    published = published_forces()
    columns = {
        "experiment": published["experiment"],
        "model": peak_range(atlas.sel(branch=0)),
        "model_thesis": published["model"],
    }
    for objective in OBJECTIVES:
        columns[objective] = peak_range(selected.sel(objective=objective))
        if nelder_mead is not None:
            columns[f"{objective}_nelder_mead"] = peak_range(nelder_mead.sel(objective=objective))
        columns[f"{objective}_thesis"] = published[objective]
    return xr.Dataset(columns)


def peak_range(gaits: xr.Dataset) -> xr.DataArray:
    """Return the smallest and the largest peak force over the headings of the tables, at their slopes."""
    peaks = table_cells(gaits)["peak_force"]
    both = xr.concat([peaks.min("heading"), peaks.max("heading")], dim="extreme").assign_coords(extreme=["min", "max"])
    return both.transpose("leg", "axis", "slope_deg", ..., "extreme").reset_coords(drop=True)


def table_cells(gaits: xr.Dataset) -> xr.Dataset:
    """Return the gaits at the slopes and headings of Tables 6.1-6.3; missing where the grid does not have them."""
    heading = gaits["heading"]
    inside = gaits.isel(heading=np.flatnonzero((heading > HEADINGS[0] - 1e-9) & (heading < HEADINGS[1] + 1e-9)))
    return inside.reindex(slope_deg=published_forces()["slope_deg"].values, method="nearest", tolerance=1e-9)


def force_tables(ranges: xr.Dataset) -> tuple[Table, ...]:
    """Return Tables 6.1-6.3, one for each pair of legs, of what `force_ranges` has found."""
    names = [str(name) for name in ranges.data_vars]
    tables = []
    for number, leg in enumerate(ranges["leg"].values, start=1):
        rows: list[tuple[Cell, ...]] = []
        for axis in ranges["axis"].values:
            for slope in ranges["slope_deg"].values:
                here = ranges.sel(leg=leg, axis=axis, slope_deg=slope)
                cells = (Range(*map(float, here[name].sel(extreme=["min", "max"]))) for name in names)
                rows.append((str(axis).replace("_", "-"), float(slope), *cells))
        caption = (
            f"Peak forces of {LEG_WORDS[str(leg)]} legs in units of m g: smallest to largest over headings of "
            f"{HEADINGS[0]:.2f} to {HEADINGS[1]:.2f} rad."
        )
        tables.append(Table(f"6.{number}", caption, ("direction", "slope_deg", *names), tuple(rows)))
    return tuple(tables)


class Alternative(NamedTuple):
    """A gait that was not selected: its family, heading and penalised objective, and the selected one's."""

    family: str
    heading: float
    objective: float
    best: float


@dataclass(frozen=True)
class Difference:
    """A force of Tables 6.1-6.3 that is clearly another for us than in the thesis, and what may explain it.

    Attributes
    ----------
    objective, leg, axis, slope_deg, extreme
        Which number.
    ours, thesis, nelder_mead
        The force: of our best gaits, as printed, and of gaits by the thesis's method (nan if there are none).
    heading, family, active
        Where our number occurs, whose it is, and which constraints hold that gait back.
    decisive_heading
        The cell in which the two methods part: where the more extreme of their numbers occurs.
    decisive_families
        Best families in that cell by our method and by the thesis's, empty where there is none.
    decisive_objectives
        The penalised objectives in that cell by our method and by the thesis's, nan where there is none.
    alternative
        A gait of a family that was not selected which has the thesis's number; None if there is none.
    """

    objective: str
    leg: str
    axis: str
    slope_deg: float
    extreme: str
    ours: float
    thesis: float
    nelder_mead: float
    heading: float
    family: str
    active: str
    decisive_heading: float
    decisive_families: tuple[str, str]
    decisive_objectives: tuple[float, float]
    alternative: Alternative | None

    @property
    def nelder_mead_is_closer(self) -> bool:
        """Whether the thesis's method comes closer to the thesis's number than our best gaits do."""
        return abs(self.nelder_mead - self.thesis) < abs(self.ours - self.thesis)

    @property
    def same_objective(self) -> bool:
        """Whether both methods end at the same objective with different forces: the minimum is not unique."""
        ours, other = self.decisive_objectives
        return abs(ours - other) <= SAME

    @property
    def ours_is_better(self) -> bool:
        """Whether our objective is clearly lower, so that the thesis's method has missed the minimum."""
        ours, other = self.decisive_objectives
        return ours < other - SAME

    @property
    def explanation(self) -> str:
        """What the facts say, in a sentence or two."""
        held = f", held by {self.active}" if self.active else ""
        where = f"Ours: heading {self.heading:g} rad, family {self.family}{held}."
        return " ".join(filter(None, [where, self._by_method(), self._elsewhere()]))

    def _by_method(self) -> str:
        """Say what the thesis's method finds now, and why it is not what we find."""
        if math.isnan(self.nelder_mead):
            return ""
        again = "The thesis's method, run again,"
        if abs(self.ours - self.nelder_mead) <= CLEAR:
            return f"{again} gives the same as ours: the search is not the reason."
        agrees = abs(self.nelder_mead - self.thesis) <= CLEAR
        closer = "closer" if self.nelder_mead_is_closer else "no closer"
        return f"{again} {'gives its number' if agrees else f'comes {closer}'}. {self._reason()}"

    def _reason(self) -> str:
        ours, other = self.decisive_objectives
        where = f"At heading {self.decisive_heading:g} rad"
        if math.isnan(ours) or math.isnan(other):
            return f"{where}, only {'that' if math.isnan(ours) else 'our'} method finds a gait."
        families = (
            "" if len(set(self.decisive_families)) == 1 else f", family {' against '.join(self.decisive_families)}"
        )
        if self.same_objective:
            return f"{where}, both end at the same objective, {ours:.3f}{families}: the minimum is not unique."
        verdict = "it stops short of the minimum" if self.ours_is_better else "it finds a better one"
        return f"{where}, our objective is {ours:.3f} against {other:.3f}{families}: {verdict}."

    def _elsewhere(self) -> str:
        if self.alternative is None:
            return ""
        family, heading, objective, best = self.alternative
        return (
            f"Family {family} at heading {heading:g} rad has the thesis's number; its objective is {objective:.3f}, "
            f"that of the best family {best:.3f}."
        )


def differences(
    optima: xr.Dataset, selected: xr.Dataset, nelder_mead: xr.Dataset | None = None
) -> tuple[Difference, ...]:
    """List all forces of Tables 6.1-6.3, for optimised gaits, that differ clearly from the thesis's.

    Parameters
    ----------
    optima
        Gaits with optimised actuation of all families.
    selected, nelder_mead
        As for `force_ranges`.
    """
    published, families = published_forces(), table_cells(optima)
    methods = [table_cells(gaits) for gaits in (selected, nelder_mead) if gaits is not None]
    found = []
    for objective in OBJECTIVES:
        for place in np.ndindex(published[objective].shape):
            printed = published[objective][place]
            at = {name: printed[name].item() for name in ("leg", "axis", "slope_deg", "extreme")}
            extremes = [_extreme(gaits.sel(objective=objective), **at) for gaits in methods]
            if extremes[0] is not None and abs(extremes[0].force - float(printed)) > CLEAR:
                found.append(_difference(families.sel(objective=objective), at, float(printed), extremes))
    return tuple(found)


class _Extreme(NamedTuple):
    """A table's number: the force, the heading at which it occurs, and all best gaits at its slope."""

    force: float
    heading: float
    gaits: xr.Dataset

    def at(self, heading: float) -> tuple[str, str, float]:
        """Family, active constraints and penalised objective at a heading."""
        gait = self.gaits.sel(heading=heading, method="nearest", tolerance=1e-9)
        return str(gait["family"].item()), str(gait["active"].item()), float(gait["penalised"])


def _extreme(gaits: xr.Dataset, leg: str, axis: str, slope_deg: float, extreme: str) -> _Extreme | None:
    """Find where the smallest or largest force occurs; None if there is no gait at the slope."""
    here = gaits.sel(slope_deg=slope_deg)
    forces = here["peak_force"].sel(leg=leg, axis=axis)
    if not forces.notnull().any():
        return None
    place = int(np.nanargmin(forces) if extreme == "min" else np.nanargmax(forces))
    return _Extreme(float(forces[place]), float(forces["heading"][place]), here)


def _difference(
    families: xr.Dataset, at: dict[str, Any], printed: float, extremes: list[_Extreme | None]
) -> Difference:
    """Collect the facts about one number, of ours and, where there is one, of the thesis's method."""
    ours, other = extremes[0], extremes[1] if len(extremes) > 1 else None
    assert ours is not None
    family, active, _ = ours.at(ours.heading)
    decisive = ours
    if other is not None and (other.force < ours.force) == (at["extreme"] == "min"):
        decisive = other
    family_there, _, objective_there = ours.at(decisive.heading)
    other_family, _, other_objective = ("", "", math.nan) if other is None else other.at(decisive.heading)
    return Difference(
        objective=str(families["objective"].item()),
        **at,
        ours=ours.force,
        thesis=printed,
        nelder_mead=math.nan if other is None else other.force,
        heading=ours.heading,
        family=family,
        active=active,
        decisive_heading=decisive.heading,
        decisive_families=(family_there, other_family),
        decisive_objectives=(objective_there, other_objective),
        alternative=_alternative(families, ours, at, printed),
    )


def _alternative(families: xr.Dataset, ours: _Extreme, at: dict[str, Any], printed: float) -> Alternative | None:
    """Find the gait of a family that was not selected whose force is the printed one, as nearly as can be."""
    here = families.sel(slope_deg=at["slope_deg"])
    forces = here["peak_force"].sel(leg=at["leg"], axis=at["axis"]).transpose("heading", "family")
    chosen = forces["family"] == ours.gaits["family"]
    away = abs(forces - printed).where(~chosen.transpose("heading", "family")).fillna(math.inf).values
    row, column = np.unravel_index(np.argmin(away), away.shape)
    if away[row, column] > CLEAR:
        return None
    gait = here.isel(heading=int(row), family=int(column))
    heading = float(gait["heading"])
    return Alternative(str(gait["family"].item()), heading, float(gait["penalised"]), ours.at(heading)[2])


def difference_table(found: Sequence[Difference]) -> Table:
    """Return the list of differences as a table, with an explanation of each."""
    columns = ("objective", "leg", "direction", "slope_deg", "extreme", "ours", "nelder_mead", "thesis", "explanation")
    cells = tuple(
        (
            one.objective,
            LEG_WORDS[one.leg],
            one.axis.replace("_", "-"),
            one.slope_deg,
            one.extreme,
            f"{one.ours:.2f}",
            "" if math.isnan(one.nelder_mead) else f"{one.nelder_mead:.2f}",
            f"{one.thesis:.2f}",
            one.explanation,
        )
        for one in found
    )
    caption = f"Forces that differ by more than {CLEAR:g} m g from those of the thesis, with what may explain it."
    return Table("6.1-6.3", caption, columns, cells)
