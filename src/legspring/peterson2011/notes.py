"""What to know before reading a chapter of the report. Every number in it is computed from the data."""

import xarray as xr

from legspring.optima import select
from legspring.peterson2011.claims.evidence import exists
from legspring.peterson2011.force_tables import CLEAR, OBJECTIVES

NOT_UNIQUE = (
    "The best actuation is often not unique: whole ranges of amplitudes reach the same eigenvalue or "
    "cost. Figures 5.2 to 5.7 and 5.12 to 5.17 of the thesis then show where its search happened to stop. "
    "Ours show the least actuation among equals, so that they may differ from the thesis's where both are "
    "right. Claims are therefore judged twice: by these gaits, and by those at which the thesis's own "
    "search (Nelder-Mead) ends when it is run again."
)


def notes(
    optima: xr.Dataset, nelder_mead: xr.Dataset, ranges: xr.Dataset, starts: xr.Dataset | None
) -> dict[int, list[str]]:
    """Write paragraphs, by chapter.

    Parameters
    ----------
    optima, nelder_mead
        Gaits with optimised actuation of all families, by our search and by the thesis's.
    ranges
        Of `legspring.peterson2011.force_tables.force_ranges`.
    starts
        Forces by the thesis's search from several other starts; None if none were tried.
    """
    chapter5 = [NOT_UNIQUE, _selection(optima, nelder_mead)]
    return {5: chapter5, 6: [_agreement(ranges, starts)]}


def _selection(optima: xr.Dataset, nelder_mead: xr.Dataset) -> str:
    """Say where the family would be another one if penalties did not count."""
    parts = []
    for words, gaits in (("our search", optima), ("the thesis's", nelder_mead)):
        by_penalised, by_value = (select(gaits, by=by) for by in ("penalised", "value"))
        other = (by_penalised["family"] != by_value["family"]).sum(["slope_deg", "heading"])
        cells = exists(by_penalised).sum(["slope_deg", "heading"])
        numbers = (
            f"{int(other.sel(objective=goal))} of {int(cells.sel(objective=goal))} for {goal}" for goal in OBJECTIVES
        )
        parts.append(f"by {words} {' and '.join(numbers)}")
    return (
        "In each cell we select the family with the least objective, penalties included, as the searches do; the "
        "thesis selects by the plain eigenvalue or cost. The families of so many cells would be others by that rule: "
        f"{'; '.join(parts)}."
    )


def _agreement(ranges: xr.Dataset, starts: xr.Dataset | None) -> str:
    """Say how many numbers of the optimised columns of Tables 6.1-6.3 come out again."""

    def away(kind: str) -> xr.DataArray:
        both = [abs(ranges[f"{goal}{kind}"] - ranges[f"{goal}_thesis"]) for goal in OBJECTIVES]
        return xr.concat(both, dim="objective")

    ours, again = away(""), away("_nelder_mead")
    total = int(ours.notnull().sum())
    text = (
        f"Of the {total} numbers of Tables 6.1 to 6.3 for optimised gaits, {int((ours <= CLEAR).sum())} are those of "
        f"our best gaits to {CLEAR:g} m g, and {int((again <= CLEAR).sum())} those of the thesis's search, run again. "
        "The others cannot be decided: where that search ends depends on where it starts, and the thesis does not say. "
    )
    if starts is None:
        return text + "What other starts give can be seen by reproduce --starts NUMBER."
    each = xr.concat([abs(starts[goal] - ranges[f"{goal}_thesis"]) for goal in OBJECTIVES], dim="objective")
    counts = sorted(int((each.sel(start=number) <= CLEAR).sum()) for number in each["start"].values)
    some = xr.concat([each, again.expand_dims(start=[0])], dim="start").min("start")
    return text + (
        f"From {len(counts)} other starts, it gives {counts[0]} to {counts[-1]} of these numbers, and "
        f"{int((some <= CLEAR).sum())} of them from at least one start, that of its first run among them."
    )
