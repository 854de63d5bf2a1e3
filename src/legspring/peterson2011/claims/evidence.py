"""What the claims are judged by: the results, the parts of a claim, and the few criteria that all claims share."""

import json
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from legspring.model import Animal

Floats = NDArray[np.float64]

MOST = 0.75
"""Share of the cells that "most" or "largely" asks for, and share of the changes that "grows" asks for."""
NEARLY_ALL = 0.9
"""Share that "all" asks for on one side of a border; what the thesis calls universal must be so in every cell."""
FEW = 0.1
"""Share of the cells that "rarely" allows."""
NEAR = 0.25
"""Relative deviation that "near" a number allows."""
SAME = 1e-3
"""Changes below it are none: of eigenvalues, costs, and actuations in units of the leg's length."""
LOW_SLOPE, STEEP_SLOPE = 10.0, 60.0
"""Greatest of the low and least of the steep slopes, deg."""


class Outcome(StrEnum):
    """What became of a claim, or of a part of one."""

    HOLDS = "holds"
    PARTLY = "holds in part"
    FAILS = "does not hold"
    OPEN = "cannot be checked"


@dataclass(frozen=True)
class Part:
    """One thing that a claim says, and what there is instead.

    Attributes
    ----------
    what
        The quantity.
    wanted
        What the claim says of it, as a criterion in numbers.
    found
        The number found.
    outcome
        Whether the one is like the other.
    reason
        Why it is not, where that is known.
    """

    what: str
    wanted: str
    found: str
    outcome: Outcome
    reason: str = ""

    @property
    def sentence(self) -> str:
        """The quantity and the number found."""
        return f"{self.what[0].upper()}{self.what[1:]}: {self.found}."


@dataclass(frozen=True)
class Verdict:
    """What became of a claim.

    Attributes
    ----------
    number, chapter
        Of the claim.
    claim
        The claim, in our words.
    verdict
        It holds if all of its parts hold, and in part if some do.
    found
        The numbers found.
    why
        Which parts do not hold and why; empty if all do.
    parts
        All parts of the claim.
    """

    number: int
    chapter: int
    claim: str
    verdict: Outcome
    found: str
    why: str
    parts: tuple[Part, ...]

    @property
    def decisive(self) -> Part:
        """The part to name where there is room for one only: one that does not hold, if there is any."""
        order = (Outcome.FAILS, Outcome.PARTLY, Outcome.OPEN, Outcome.HOLDS)
        return min(self.parts, key=lambda part: order.index(part.outcome))


@dataclass(frozen=True)
class Results:
    """All that the thesis's claims are about.

    Attributes
    ----------
    atlas
        Gaits with the thesis's actuation, of `legspring.atlas`; branch 0 is the published one.
    optima, nelder_mead
        Gaits with optimised actuation by objective, slope, heading and family: the best there are (with the least
        actuation among equals), and those at which the thesis's own search ends.
    selected, selected_nelder_mead
        Those of the best family of each cell; ``family`` is a variable then.
    measured
        Peak forces of animals, of `legspring.peterson2011.published.published_forces`.
    back_pulls
        An atlas of the families in which the back legs pull; None if nobody has looked for them.
    """

    atlas: xr.Dataset
    optima: xr.Dataset
    nelder_mead: xr.Dataset
    selected: xr.Dataset
    selected_nelder_mead: xr.Dataset
    measured: xr.Dataset
    back_pulls: xr.Dataset | None = None

    @property
    def published(self) -> xr.Dataset:
        """The gaits of the thesis among those of the atlas."""
        return self.atlas.isel(branch=0)

    @property
    def searches(self) -> tuple["Optima", "Optima"]:
        """Optimised gaits by either search."""
        return Optima(self.optima, self.selected), Optima(self.nelder_mead, self.selected_nelder_mead)


@dataclass(frozen=True)
class Optima:
    """Optimised gaits of all families, and those of the best family of each cell, by one search."""

    families: xr.Dataset
    selected: xr.Dataset

    def of(self, objective: str, family: str) -> xr.Dataset:
        """Gaits of one family, optimised for one objective."""
        return self.families.sel(objective=objective, family=family)

    def best(self, objective: str) -> xr.Dataset:
        """Gaits of the best families for one objective."""
        return self.selected.sel(objective=objective)


def combine(outcomes: Iterable[Outcome]) -> Outcome:
    """Judge a whole by its parts: it holds if all do, and in part if some do."""
    found = set(outcomes)
    if len(found) == 1:
        return found.pop()
    return Outcome.PARTLY if found & {Outcome.HOLDS, Outcome.PARTLY} else Outcome.FAILS


def by_both(results: Results, judge: Callable[[Optima], list[Part]]) -> list[Part]:
    """Judge the gaits of both searches: a part that only one of them bears out holds in part."""
    pairs = zip(*(judge(optima) for optima in results.searches), strict=True)
    return [_merge(best, thesis) for best, thesis in pairs]


def _merge(best: Part, thesis: Part) -> Part:
    """Put the findings of the two searches into one part."""
    outcome = combine([best.outcome, thesis.outcome])
    found = best.found if best.found == thesis.found else f"{best.found}; by Nelder-Mead {thesis.found}"
    if best.outcome == thesis.outcome:
        return replace(best, found=found)
    reason = "One of the two searches does not bear it out."
    return replace(best, found=found, outcome=outcome, reason=reason)


def yes(what: str, wanted: str, found: str, holds: bool, reason: str = "") -> Part:
    """Return a part that holds or does not."""
    return Part(what, wanted, found, Outcome.HOLDS if holds else Outcome.FAILS, reason)


def unknown(what: str, wanted: str, reason: str) -> Part:
    """Return a part about which there are no data."""
    return Part(what, wanted, "no data", Outcome.OPEN, reason)


def share(
    what: str,
    true: xr.DataArray,
    among: xr.DataArray,
    least: float = 0.0,
    most: float = 1.0,
    reason: str = "",
) -> Part:
    """Judge in how large a share of some cells something is so."""
    wanted = f"at least {least:.0%}" if least else f"at most {most:.0%}"
    wanted = {(1.0, 1.0): "all", (0.0, 0.0): "none"}.get((least, most), wanted)
    total, count = int(among.sum()), int((true & among).sum())
    if not total:
        return unknown(what, wanted, "There are no such cells.")
    part = count / total
    return yes(what, wanted, f"{count} of {total} ({100 * part:.3g}%)", least <= part <= most, reason)


def within(what: str, value: float, low: float, high: float, unit: str = "", reason: str = "") -> Part:
    """Judge whether a number lies in a range, which may be open upwards."""
    numbers = f"{low:.3g}" if low == high else f"{low:.3g} to {high:.3g}"
    wanted = f"{numbers} {unit}".strip() if math.isfinite(high) else f"at least {low:.3g} {unit}".strip()
    if math.isnan(value):
        return unknown(what, wanted, "There are no such cells.")
    found = f"{value:.3g} {unit}".strip() if math.isfinite(value) else "nowhere"
    return yes(what, wanted, found, low <= value <= high, reason)


def ratio(value: float, unit: float) -> float:
    """Return a value in units of another one; nan if that is not positive."""
    return value / unit if unit > 0.0 else math.nan


def near(what: str, value: float, number: float) -> Part:
    """Judge whether a number is near another one."""
    return within(what, value, (1.0 - NEAR) * number, (1.0 + NEAR) * number)


def grows(what: str, values: xr.DataArray, along: str, falls: bool = False, least: float = MOST) -> Part:
    """Judge whether values grow along a dimension: in how many pairs of cells the farther one has more."""
    rows = values.transpose(..., along).values
    first, second = np.triu_indices(rows.shape[-1], 1)
    change = rows[..., second] - rows[..., first]
    change = (-change if falls else change)[np.isfinite(change)]
    word = "falls" if falls else "grows"
    wanted = f"{word} in at least {least:.0%} of the pairs"
    if not change.size:
        return unknown(what, wanted, "There are no such cells.")
    part = float(np.mean(change > SAME))
    return yes(what, wanted, f"{word} in {part:.0%}", part >= least)


def turns(before: xr.DataArray, known: xr.DataArray, along: str) -> xr.DataArray:
    """Find where something that is so at the start of each row ends, midway between two cells; missing if nowhere."""
    places = before[along].values

    def turn(so: NDArray[np.bool_], there: NDArray[np.bool_]) -> float:
        index = np.flatnonzero(there)
        ends = np.flatnonzero(~so[index])
        if not ends.size or ends[0] == 0:
            return math.nan
        return float(0.5 * (places[index[ends[0] - 1]] + places[index[ends[0]]]))

    dims = [[along], [along]]
    return xr.apply_ufunc(turn, before, known, input_core_dims=dims, vectorize=True, output_dtypes=[float])


def exists(gaits: xr.Dataset) -> xr.DataArray:
    """Cells in which there is a gait."""
    return gaits["speed"].notnull()


def pushes(gaits: xr.Dataset, leg: str) -> xr.DataArray:
    """Cells in which a pair of legs pushes: the back legs forwards, the others backwards."""
    force = gaits["peak_force"].sel(leg=leg, axis="fore_aft", drop=True)
    return force > 0.0 if leg == "B" else force < 0.0


def at(gaits: xr.Dataset, **ranges: tuple[float, float]) -> xr.DataArray:
    """Cells with a gait whose slope_deg and heading lie within ranges, the ends included."""
    cells = exists(gaits)
    for name, (low, high) in ranges.items():
        cells = cells & (gaits[name] >= low - 1e-9) & (gaits[name] <= high + 1e-9)
    return cells


def degrees(gaits: xr.Dataset, leg: str) -> xr.DataArray:
    """Phase of a pair of legs, deg."""
    return gaits["phase"].sel(leg=leg, drop=True) * (180.0 / math.pi)


def animal_of(dataset: xr.Dataset) -> Animal:
    """Return the animal that a dataset is about."""
    parameters: dict[str, Any] = json.loads(dataset.attrs["parameters"])
    return Animal.model_validate(parameters)


def actuation(gaits: xr.Dataset, leg: str) -> xr.DataArray:
    """Actuation of a pair of legs in units of their length."""
    length = next(other.length for other in animal_of(gaits).legs if other.pair == leg)
    return gaits["actuation"].sel(leg=leg, drop=True) / length


def mean(values: xr.DataArray, cells: xr.DataArray | None = None) -> float:
    """Mean over cells; nan if there are none."""
    chosen = values.values if cells is None else values.where(cells).values
    known = chosen[np.isfinite(chosen)]
    return float(known.mean()) if known.size else math.nan
