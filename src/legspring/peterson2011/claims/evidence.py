"""What the claims are judged by: the results, the parts of a claim, and the few criteria that all claims share."""

import json
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from legspring.model import Animal
from legspring.peterson2011.claims.criteria import ACCURACY, FEWEST, OURS, SAME, Criteria, Word

Floats = NDArray[np.float64]

OUR_SEARCH, THESIS_SEARCH = "least actuation among the best", "Nelder-Mead"
"""The two searches that optimised gaits come from."""

LOW_SLOPE, STEEP_SLOPE = 10.0, 60.0
"""Greatest of the low and least of the steep slopes, deg."""


class Outcome(StrEnum):
    """What became of a claim, or of a part of one."""

    HOLDS = "holds"
    PARTLY = "holds in part"
    FAILS = "does not hold"
    UNDECIDED = "cannot be decided"
    OPEN = "cannot be checked"


@dataclass(frozen=True)
class Part:
    """One thing that a claim says, and what there is instead.

    Attributes
    ----------
    what
        The quantity.
    claimed
        What the thesis says of it.
    wanted
        What that is taken to mean; empty where the thesis's own number decides.
    found
        The number found, and of how many cells.
    outcome
        Whether the one is like the other.
    reason
        Why it is not, where that is known.
    lenient, strict
        What becomes of it if the criterion is eased or tightened.
    evidence
        What was looked at, cell by cell, by search: the quantity, or 1 where it is so and 0 where not; missing where
        the claim does not speak of the cell.
    """

    what: str
    claimed: str
    wanted: str
    found: str
    outcome: Outcome
    reason: str = ""
    lenient: Outcome | None = None
    strict: Outcome | None = None
    evidence: Mapping[str, xr.DataArray] = field(default_factory=dict)

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
    code
        What judges it, as it stands in the package.
    """

    number: int
    chapter: int
    claim: str
    verdict: Outcome
    found: str
    why: str
    parts: tuple[Part, ...]
    code: str = ""

    @property
    def lenient(self) -> Outcome:
        """What would become of it if words meant less."""
        return combine(part.lenient or part.outcome for part in self.parts)

    @property
    def strict(self) -> Outcome:
        """What would become of it if words meant more."""
        return combine(part.strict or part.outcome for part in self.parts)

    @property
    def decisive(self) -> Part:
        """The part to name where there is room for one only: one that does not hold, if there is any."""
        order = (Outcome.FAILS, Outcome.PARTLY, Outcome.UNDECIDED, Outcome.OPEN, Outcome.HOLDS)
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
    single_leg
        Gaits of one leg, of `legspring.peterson2011.single_leg.map_single_legs`; None if there are none.
    starts
        Forces of Tables 6.1-6.3 by the thesis's search from several other starts, of
        `legspring.peterson2011.force_tables.peak_ranges`, over ``start``; None if none were tried.
    criteria
        What the thesis's words are taken to mean.
    """

    atlas: xr.Dataset
    optima: xr.Dataset
    nelder_mead: xr.Dataset
    selected: xr.Dataset
    selected_nelder_mead: xr.Dataset
    measured: xr.Dataset
    back_pulls: xr.Dataset | None = None
    single_leg: xr.Dataset | None = None
    starts: xr.Dataset | None = None
    criteria: Criteria = OURS

    @property
    def published(self) -> xr.Dataset:
        """The gaits of the thesis among those of the atlas."""
        return self.atlas.isel(branch=0)

    @property
    def searches(self) -> tuple["Optima", "Optima"]:
        """Optimised gaits by either search."""
        return (
            Optima(self.optima, self.selected, self.criteria),
            Optima(self.nelder_mead, self.selected_nelder_mead, self.criteria),
        )


@dataclass(frozen=True)
class Optima:
    """Optimised gaits of all families, and those of the best family of each cell, by one search."""

    families: xr.Dataset
    selected: xr.Dataset
    criteria: Criteria

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
    known = [part.outcome for part in (best, thesis) if part.outcome != Outcome.OPEN]
    outcome = combine(known or [Outcome.OPEN])
    found = best.found if best.found == thesis.found else f"{best.found}; by Nelder-Mead {thesis.found}"
    evidence = {
        OUR_SEARCH: best.evidence.get("", xr.DataArray()),
        THESIS_SEARCH: thesis.evidence.get("", xr.DataArray()),
    }
    merged = replace(best, found=found, outcome=outcome, evidence=evidence)
    if best.outcome == thesis.outcome:
        return merged
    one_only = "One of the two searches has no such cells: the other one decides."
    return replace(merged, reason=one_only if len(known) == 1 else "One of the two searches does not bear it out.")


def yes(
    what: str, claimed: str, found: str, holds: bool, reason: str = "", wanted: str = "", of: xr.DataArray | None = None
) -> Part:
    """Return a part that holds or does not."""
    evidence = {} if of is None else {"": of.astype(float)}
    return Part(what, claimed, wanted, found, Outcome.HOLDS if holds else Outcome.FAILS, reason, evidence=evidence)


def unknown(what: str, claimed: str, reason: str, found: str = "no data") -> Part:
    """Return a part that nothing can be compared with."""
    return Part(what, claimed, "", found, Outcome.OPEN, reason)


def share(
    what: str, true: xr.DataArray, among: xr.DataArray, word: Word, reason: str = "", fewest: int = FEWEST
) -> Part:
    """Judge in how large a share of some cells something is so.

    What is said of all cells is disproved by one; of few cells, nothing else is decided.
    """
    total, count = int(among.sum()), int((true & among).sum())
    if not total:
        return replace(unknown(what, word.words, "There are no such cells."), wanted=word.wanted)
    found = f"{count} of {total} ({100 * count / total:.3g}%)"
    part = yes(what, word.words, found, word.keeps(count / total), reason, word.wanted, true.where(among))
    universal = word.least == word.most
    if total >= fewest or (universal and part.outcome == Outcome.FAILS):
        return part
    return replace(part, outcome=Outcome.UNDECIDED, reason=f"So few cells (less than {fewest}) decide nothing.")


def both_ways(
    true: tuple[str, xr.DataArray], place: tuple[str, xr.DataArray], among: xr.DataArray, only: Word, there: Word
) -> list[Part]:
    """Judge whether something is so in a place only, and whether it is so there: of what is so, and of the place."""
    (what, so), (where, inside) = true, place
    return [
        share(f"{what} that lie {where}", inside, so & among, only),
        share(f"of cells {where}: {what}", so, inside & among, there),
    ]


def within(
    what: str,
    value: float,
    low: float,
    high: float,
    unit: str = "",
    reason: str = "",
    *,
    claimed: str = "",
    of: xr.DataArray | None = None,
) -> Part:
    """Judge whether a number lies in a range, which may be open upwards, as exactly as it is known.

    Parameters
    ----------
    what, value, low, high, unit, reason
        The quantity, its value and the range.
    claimed
        What the thesis says, where the range is not its own.
    of
        What the number is made of, cell by cell.
    """
    numbers = f"{low:.3g}" if low == high else f"{low:.3g} to {high:.3g}"
    if not math.isfinite(low + high):
        numbers = f"at least {low:.3g}" if math.isfinite(low) else f"at most {high:.3g}"
    wanted = f"{numbers} {unit}".strip()
    words = (claimed, wanted) if claimed else (wanted, "")
    if math.isnan(value):
        return replace(unknown(what, words[0], "There are no such cells."), wanted=words[1])
    found = f"{value:.3g} {unit}".strip() if math.isfinite(value) else "nowhere"
    slack = ACCURACY.get(unit, SAME)
    return yes(what, words[0], found, low - slack <= value <= high + slack, reason, words[1], of)


def ratio(value: float, unit: float) -> float:
    """Return a value in units of another one; nan if that is not positive."""
    return value / unit if unit > 0.0 else math.nan


def near(what: str, value: float, number: float, criteria: Criteria, of: xr.DataArray | None = None) -> Part:
    """Judge whether a number is near another one."""
    low, high = ((1.0 + sign * criteria.near) * number for sign in (-1, 1))
    return within(what, value, low, high, claimed=f"about {number:g}", of=of)


def grows(what: str, values: xr.DataArray, along: str, word: Word, falls: bool = False) -> Part:
    """Judge whether values grow along a dimension: in how many pairs of cells the farther one has more."""
    rows = values.transpose(..., along).values
    first, second = np.triu_indices(rows.shape[-1], 1)
    change = rows[..., second] - rows[..., first]
    change = (-change if falls else change)[np.isfinite(change)]
    verb = "falls" if falls else "grows"
    wanted = f"in {word.wanted or 'all'} of the pairs"
    if not change.size:
        return replace(unknown(what, verb, "There are no such cells."), wanted=wanted)
    part = float(np.mean(change > SAME))
    found = f"{verb} in {part:.0%} of {change.size} pairs"
    return yes(what, verb, found, word.keeps(part), wanted=wanted, of=values)


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


def median(values: xr.DataArray) -> float:
    """Median of all known values; nan if there are none."""
    known = values.values[np.isfinite(values.values)]
    return float(np.median(known)) if known.size else math.nan
