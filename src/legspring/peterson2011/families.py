"""Every family for itself: a section of the report. Every number in it is computed from the data."""

import numpy as np
import xarray as xr

from legspring.figures.maps import NEUTRAL, family_order
from legspring.peterson2011.claims.evidence import exists
from legspring.peterson2011.report import Section
from legspring.peterson2011.tables import Cell, Table

ACTUATIONS = ("fixed", "for stability", "for efficiency")


def section(families: xr.Dataset, optima: xr.Dataset) -> Section:
    """Write the section.

    Parameters
    ----------
    families
        Gaits with fixed actuation, of `legspring.peterson2011.figures.families.of_families`.
    optima
        Gaits with optimised actuation, of `legspring.optima.optimal_atlas` with impulses.
    """
    gaits = {
        "fixed": families,
        "for stability": optima.sel(objective="stability"),
        "for efficiency": optima.sel(objective="efficiency"),
    }
    rows: list[tuple[Cell, ...]] = [
        (actuation, family, *_numbers(dataset.sel(family=family)))
        for actuation, dataset in gaits.items()
        for family in family_order(families)
    ]
    columns = ("actuation", "family", "gaits", "unstable", "eigenvalue", "cost", "recover", "steps")
    table = Table(
        "",
        "Gaits of each family on the map of slopes and headings, whichever family a cell is given to: how many there "
        "are, how many of them are unstable, medians of the largest eigenvalue and of the transport cost, the share "
        "that recovers, of all sideways impulses of -0.8 to 0.8 m v_des, and the median of the steps that it takes.",
        columns,
        tuple(rows),
    )
    return Section("Every family for itself", [_existence(gaits), _recoveries(gaits)], tables=[table])


def _numbers(gaits: xr.Dataset) -> tuple[float, ...]:
    """Return the numbers of a row of the table; nan where there are no gaits."""
    there, unstable = exists(gaits), gaits["reduced_eigenvalue"] > 1.0 + NEUTRAL
    medians = (float(gaits[name].median()) for name in ("reduced_eigenvalue", "transport_cost"))
    recovered, steps = gaits["recovered"], gaits["recovery_steps"]
    often = float(recovered.mean()), float(steps.where(recovered == 1.0).median())
    return (float(there.sum()), float(unstable.sum()), *medians, *often)


def _existence(gaits: dict[str, xr.Dataset]) -> str:
    """Say in how many cells there are gaits of how many families."""
    words = []
    for actuation, dataset in gaits.items():
        there = exists(dataset)
        number = there.sum("family").values
        counts = ", ".join(f"{np.count_nonzero(number == n)} of {n}" for n in range(int(number.max()), 0, -1))
        words.append(f"{actuation if actuation == 'fixed' else 'optimised ' + actuation}: {counts}")
    return (
        "A map of the best gaits shows one family in each cell. These show them all. With actuation "
        f"{'; '.join(words)} families have gaits in a cell (number of cells, number of families)."
    )


def _recoveries(gaits: dict[str, xr.Dataset]) -> str:
    """Say how robust optimised gaits are beside those with fixed actuation in the same cells."""
    fixed = gaits["fixed"]
    parts = []
    for actuation in ACTUATIONS[1:]:
        both = exists(fixed) & exists(gaits[actuation])
        before, after = (float(each["recovered"].where(both).mean()) for each in (fixed, gaits[actuation]))
        parts.append(f"{actuation} from {after:.0%} instead of {before:.0%}")
    return (
        "Robustness is no part of either objective. In cells and families that have gaits with fixed and with "
        f"optimised actuation, those optimised recover {' and '.join(parts)} of all impulses."
    )
