"""Whether stability and robustness rank gaits alike, by what gaits survive. A section of the report."""

import math

import numpy as np
import xarray as xr
from scipy.stats import spearmanr

from legspring.gait import Gait
from legspring.model import Animal
from legspring.parallel import in_threads
from legspring.peterson2011.report import Section
from legspring.peterson2011.tables import Cell, Table
from legspring.pushing import pushes
from legspring.roughness import rough
from legspring.solve import find_gaits

SLOPES_DEG, HEADINGS = (0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0), (0.05, 0.15, 0.25, 0.35)
"""Where gaits are taken from: the first of each place, as the thesis has it."""
DIRECTIONS, MOMENTS, IMPULSES = 8, 4, (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 6.0, 10.0)
RUNS, STRIDES = 40, 20
SCALES = (2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 14.0, 16.0, 18.0, 20.0, 23.0, 26.0, 30.0, 35.0, 40.0, 50.0, 60.0)
"""Runs over slopes that change from step to step, and their standard deviations, deg."""
IMPULSE = 0.5
MEASURES = {
    "recovery_steps": (f"steps back from a sideways push of {IMPULSE:g} m v_des", -1.0),
    "least_push": ("largest push survived in any direction at any moment", 1.0),
    "sideways_push": ("largest sideways push survived, as the thesis pushes", 1.0),
    "roughest": ("largest slope noise that half of the runs survive", 1.0),
}
"""What robustness may mean, and whether more of it is more robust."""
ALIKE, UNLIKE = 0.7, 0.3
"""Rank correlations from which on rankings are alike, and below which they are not."""


def survivals(animal: Animal, workers: int) -> xr.Dataset:
    """Measure what the thesis's gaits survive.

    Returns
    -------
    xarray.Dataset
        Over gait: where it is, its family, ``max_multiplier``, ``reduced_eigenvalue``, and the measures of robustness;
        missing where a gait survives all that was tried, or does not come back.
    """
    places = [(slope, heading) for slope in SLOPES_DEG for heading in HEADINGS]
    gaits = [found[0] for slope, heading in places if (found := find_gaits(animal, slope_deg=slope, heading=heading))]
    rows = in_threads(measured, gaits, workers)
    words = {"slope_deg": "slope", "heading": "heading", "max_multiplier": "largest multiplier"}
    words |= {"reduced_eigenvalue": "eigenvalue, as the thesis has it"} | {
        n: about for n, (about, _) in MEASURES.items()
    }
    units = {"slope_deg": "degrees", "heading": "rad", "roughest": "degrees"}
    units |= {"least_push": "m v_des", "sideways_push": "m v_des"}
    dataset = xr.Dataset(
        {
            name: ("gait", [row[name] for row in rows], {"long_name": about, "units": units.get(name, "1")})
            for name, about in words.items()
        }
    )
    return dataset.assign(family=("gait", np.array([gait.family for gait in gaits], dtype=object)))


def measured(gait: Gait) -> dict[str, float]:
    """Measure what a gait survives."""
    hit = pushes(gait, directions=DIRECTIONS, moments=MOMENTS, impulses=IMPULSES, workers=1)
    thesis = pushes(gait, directions=[0.0, math.pi], moments=[1.0 / 16.0], impulses=IMPULSES, workers=1)
    ground = rough(gait, {"slope_deg": 1.0}, runs=RUNS, strides=STRIDES, scales=SCALES, workers=1)
    steps = thesis["recovery_steps"].sel(impulse=IMPULSE).values
    return {
        "slope_deg": gait.slope_deg,
        "heading": gait.heading,
        "max_multiplier": float(abs(gait.multipliers[0])),
        "reduced_eigenvalue": gait.reduced_eigenvalue,
        "recovery_steps": float(steps.mean()),
        "least_push": _least(hit),
        "sideways_push": _least(thesis),
        "roughest": _roughest(ground),
    }


def _least(found: xr.Dataset) -> float:
    """Return the least push that is not survived, about; missing where all are."""
    return float(found["lost"].min())


def _roughest(found: xr.Dataset) -> float:
    """Return the largest noise that half of the runs survive; missing where they survive all."""
    largest = float(found.attrs["largest_scale"])
    return math.nan if largest == SCALES[-1] else largest


def correlations(found: xr.Dataset) -> dict[str, tuple[float, float]]:
    """Return rank correlations of stability, by both eigenvalues, with each measure of robustness.

    Gaits that survive all that was tried share the first place. 1 means that the more stable is the more robust.
    """
    out = {}
    for name, (_, sign) in MEASURES.items():
        values = sign * found[name].values
        values = np.where(np.isnan(values), np.inf if sign > 0.0 else -np.inf, values)
        both = [float(spearmanr(-found[which].values, values)[0]) for which in ("max_multiplier", "reduced_eigenvalue")]
        out[name] = (both[0], both[1])
    return out


def section(found: xr.Dataset) -> Section:
    """Write the section.

    Parameters
    ----------
    found
        Of `survivals`.
    """
    ranks = correlations(found)
    rows: list[tuple[Cell, ...]] = [
        (MEASURES[name][0], *ranks[name], int(found[name].isnull().sum())) for name in MEASURES
    ]
    table = Table(
        "",
        f"Rank correlations (Spearman) of stability with what may be called robustness, of {found.sizes['gait']} gaits "
        "with the thesis's actuation: 1 where the more stable gait is always the more robust one, 0 where one says "
        "nothing of the other. Last: how many survive all that was tried (or, of the steps, do not come back).",
        ("robustness", "by_multiplier", "by_thesis_eigenvalue", "beyond_what_was_tried"),
        tuple(rows),
    )
    return Section(
        "Stable or robust?",
        [
            "The thesis says that stability and robustness rank gaits alike, and measures robustness by the steps that "
            "a gait takes to come back from a sideways push. How soon a push is forgotten is what eigenvalues are "
            f"about. By these steps the rankings are {verdict(ranks['recovery_steps'][0])}.",
            "How large a push, or how rough a ground, a gait survives is another question. By the largest push that is "
            f"survived in any of {DIRECTIONS} directions at any of {MOMENTS} moments of a stride they are "
            f"{verdict(ranks['least_push'][0])}; by the largest noise of the slope from step to step that half of "
            f"{RUNS} runs of {STRIDES} strides survive, {verdict(ranks['roughest'][0])}.",
        ],
        tables=[table],
    )


def verdict(rank: float) -> str:
    """Say what a rank correlation means for the claim."""
    words = "alike" if rank >= ALIKE else "not alike" if rank < UNLIKE else "alike in part"
    return f"{words} (rank correlation {rank:.2f} with the true multipliers)"
