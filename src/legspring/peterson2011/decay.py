"""Small disturbances of gaits, simulated, to see which map tells how fast they decay."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from legspring.flow import flow
from legspring.gait import Gait
from legspring.kernel.walker import Floats
from legspring.layout import TIGHT
from legspring.mapping import provenance
from legspring.model import Animal
from legspring.solve import find_gaits

CELLS = ((75.0, 0.15), (60.0, 0.40), (70.0, 0.05), (60.0, 0.15), (30.0, 0.15), (0.0, 0.30))
"""Slopes (deg) and headings (rad) of the gaits that are disturbed: where the two maps differ, and where they agree."""
NUDGE = 1e-4
"""The disturbances: this share of the speed, and this angle in rad."""
STRIDES = 60
FIT = (1e-12, 1e-7)
"""Distances, in step lengths, from which the decay is fitted: below the transient, above the integration's accuracy."""
FEWEST = 4
"""Least number of touch-downs to fit a decay to."""


def decays(animal: Animal, cells: Sequence[tuple[float, float]] = CELLS) -> xr.Dataset:
    """Disturb gaits slightly and measure how fast the disturbance decays.

    Parameters
    ----------
    animal
        The animal.
    cells
        Slope (deg) and heading (rad) of each gait; of several gaits the first branch is taken.

    Returns
    -------
    xarray.Dataset
        Over gait and stride: ``distance`` from the undisturbed gait at each touch-down; over gait: ``decay``, the
        share of a disturbance that is left after a stride (missing if there are too few touch-downs to fit), beside
        ``reduced_eigenvalue`` and ``max_multiplier``, and ``slope_deg``, ``heading`` and ``family``.

    Raises
    ------
    ValueError
        If there is no gait in a cell.
    legspring.returnmap.IntegrationError
        If a disturbed gait cannot be simulated.
    """
    gaits = [_first_gait(animal, *cell) for cell in cells]
    distances = np.array([_distance(gait) for gait in gaits])
    strides: Floats = 0.5 * np.arange(distances.shape[1], dtype=float)
    about = {"title": f"Decay of small disturbances of gaits of {animal.name}", "fit_from": FIT[0], "fit_to": FIT[1]}
    return xr.Dataset(
        {
            "slope_deg": ("gait", [gait.slope_deg for gait in gaits], {"units": "degrees"}),
            "heading": ("gait", [gait.heading for gait in gaits], {"units": "rad"}),
            "family": ("gait", [gait.family for gait in gaits]),
            "reduced_eigenvalue": ("gait", [gait.reduced_eigenvalue for gait in gaits]),
            "max_multiplier": ("gait", [abs(gait.multipliers[0]) for gait in gaits]),
            "decay": ("gait", [_rate(strides, distance) for distance in distances]),
            "distance": (("gait", "stride"), distances, {"long_name": "distance from the gait", "units": "1"}),
        },
        coords={"gait": [f"{slope:g} deg, {heading:g} rad" for slope, heading in cells], "stride": strides},
        attrs=provenance(animal) | about,
    )


def _first_gait(animal: Animal, slope_deg: float, heading: float) -> Gait:
    gaits = find_gaits(animal, slope_deg=slope_deg, heading=heading)
    if not gaits:
        raise ValueError(f"cells: there is no gait at {slope_deg:g} deg, {heading:g} rad")
    return gaits[0]


def _distance(gait: Gait) -> Floats:
    """Distance at each touch-down of gaits disturbed in speed and in heading, taken together.

    A single disturbance turns in the plane of a complex pair of multipliers, so that its distance goes up and down.
    """
    disturbed = replace(gait, speed=gait.speed * (1.0 + NUDGE)), replace(gait, heading=gait.heading + NUDGE)
    undisturbed = _touchdowns(gait)
    away = np.array([_touchdowns(other) - undisturbed for other in disturbed])
    distance: Floats = np.sqrt(np.sum(np.square(away), axis=(0, 2)))
    return distance


def _touchdowns(gait: Gait) -> Floats:
    """Velocity and displacement over the step before at each touch-down, mirrored after odd steps, in step lengths."""
    length = gait.system.step_length
    states = flow(gait.system, gait.point, steps=2 * STRIDES, accuracy=TIGHT).states
    # The feet that are down at the start are those of the gait.
    moved = np.diff(states[:, :2], axis=0, prepend=[[0.0, -length]])
    complete = np.hstack([states[:, 2:4] * gait.system.step_duration, moved])
    complete[1::2, [0, 2]] *= -1.0
    return complete / length


def _rate(strides: Floats, distance: Floats) -> float:
    """Share of a distance that is left after a stride, by a straight line through its logarithms."""
    used = (distance > FIT[0]) & (distance < FIT[1])
    if np.count_nonzero(used) < FEWEST:
        return float("nan")
    return float(np.exp(np.polyfit(strides[used], np.log(distance[used]), 1)[0]))
