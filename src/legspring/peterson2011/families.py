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
        "are, how many are unstable by the complete map, medians of the thesis's eigenvalue and of the cost, the share "
        "that recovers, of all sideways impulses of -0.8 to 0.8 m v_des, and the median of the steps that it takes.",
        columns,
        tuple(rows),
    )
    return Section("Every family for itself", [_existence(gaits), _recoveries(gaits)], tables=[table])


def _numbers(gaits: xr.Dataset) -> tuple[float, ...]:
    """Return the numbers of a row of the table; nan where there are no gaits."""
    there, unstable = exists(gaits), gaits["max_multiplier"] > 1.0 + NEUTRAL
    medians = (float(gaits[name].median()) for name in ("reduced_eigenvalue", "transport_cost"))
    recovered, steps = gaits["recovered"], gaits["recovery_steps"]
    often = float(recovered.mean()), float(steps.where(recovered == 1.0).median())
    return (float(there.sum()), float(unstable.sum()), *medians, *often)


def _existence(gaits: dict[str, xr.Dataset]) -> str:
    """Say in how many cells there are gaits of how many families."""
    sentences = []
    for actuation, dataset in gaits.items():
        number = exists(dataset).sum("family").values
        counts = [f"{np.count_nonzero(number == n)} cells have {n}" for n in range(int(number.max()), 0, -1)]
        words = "With fixed actuation" if actuation == "fixed" else f"Optimised {actuation}"
        sentences.append(f"{words}, {', '.join(counts)}.")
    return (
        "A map of the best gaits shows one family in each cell; these show all that there are. How many families have "
        f"gaits in a cell: {' '.join(sentences)}"
    )


def _recoveries(gaits: dict[str, xr.Dataset]) -> str:
    """Say how robust gaits are, in all cells and families that have them."""
    parts = []
    for actuation, dataset in gaits.items():
        words = "with fixed actuation" if actuation == "fixed" else f"of those optimised {actuation}"
        stable = exists(dataset) & (dataset["max_multiplier"] <= 1.0 + NEUTRAL)
        half = dataset["recovered"].sel(impulse=0.5, method="nearest", tolerance=1e-6)
        lost = int((stable & (half == 0.0)).sum())
        share = f"{float(dataset['recovered'].mean()):.0%}"
        parts.append(f"{words} {share} ({lost} of {int(stable.sum())} stable gaits do not)")
    return (
        "Robustness is no part of either objective. From all impulses of the map, taken together, recover "
        f"{'; '.join(parts)}; in brackets, from an impulse of 0.5. A gait that is stable and does not come back from a "
        "push has but a small neighbourhood from which it attracts."
    )
