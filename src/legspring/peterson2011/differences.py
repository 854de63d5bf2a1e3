"""Where forces of optimised gaits differ from those that the thesis printed, and what may explain it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from legspring.peterson2011.force_tables import CLEAR, OBJECTIVES, table_cells
from legspring.peterson2011.published import published_forces
from legspring.peterson2011.tables import LEG_WORDS, Range, Table

SAME = 1e-3
"""Difference of objectives that makes no difference."""
UNTRIED = Range(math.nan, math.nan)


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
    starts
        What the thesis's method gives from several other starts; nan if that was not tried.
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
    starts: Range = UNTRIED

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
        held = f"; what binds there: {self.active}" if self.active else ""
        where = f"Ours: heading {self.heading:g} rad, family {self.family}{held}."
        return " ".join(filter(None, [where, self._by_method(), self._elsewhere()]))

    def _by_method(self) -> str:
        """Say what the thesis's method finds now, and why it is not what we find."""
        if math.isnan(self.nelder_mead):
            return ""
        again = "The thesis's method, run again,"
        if abs(self.ours - self.nelder_mead) <= CLEAR:
            return f"{again} gives the same as ours.{self._by_starts()}"
        agrees = abs(self.nelder_mead - self.thesis) <= CLEAR
        closer = "closer" if self.nelder_mead_is_closer else "no closer"
        return f"{again} {'gives its number' if agrees else f'comes {closer}'}. {self._reason()}{self._by_starts()}"

    def _by_starts(self) -> str:
        """Say what the thesis's method finds from other starts."""
        low, high = self.starts
        if math.isnan(low):
            return ""
        ends = dict.fromkeys((f"{low:.2f}", f"{high:.2f}"))
        return f" From other starts it gives {' to '.join(ends)}."

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
        method = "the thesis's method"
        verdict = f"{method} stops short of the minimum" if self.ours_is_better else f"{method} finds a better one"
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
    optima: xr.Dataset,
    selected: xr.Dataset,
    nelder_mead: xr.Dataset | None = None,
    starts: xr.Dataset | None = None,
) -> tuple[Difference, ...]:
    """List all forces of Tables 6.1-6.3, for optimised gaits, that differ clearly from the thesis's.

    Parameters
    ----------
    optima
        Gaits with optimised actuation of all families.
    selected, nelder_mead
        As for `force_ranges`.
    starts
        Of `peak_ranges`, over ``start`` as well: what the thesis's method gives from several other starts.
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
                one = _difference(families.sel(objective=objective), at, float(printed), extremes)
                tried: list[float] = []
                if starts is not None:
                    tried = starts[objective].sel(at).dropna("start").values.tolist()
                found.append(replace(one, starts=Range(min(tried), max(tried))) if len(tried) else one)
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
    caption = (
        f"Numbers of Tables 6.1 to 6.3 for optimised gaits that differ by more than {CLEAR:g} m g from the thesis's, "
        "with what may explain it."
    )
    return Table("6.differences", caption, columns, cells)
