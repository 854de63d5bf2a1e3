"""What stability costs: gaits from the most stable to the cheapest of each family, on a few slopes."""

import numpy as np
import xarray as xr
from threadpoolctl import threadpool_limits

from legspring.exchange import candidate_of
from legspring.kernel.walker import Floats
from legspring.model import Animal
from legspring.objective import Objective
from legspring.optimisation import front
from legspring.parallel import processes

SLOPES_DEG, HEADING, POINTS = (0.0, 10.0, 20.0, 45.0), 0.15, 9
SAME = 1e-3
"""Differences of eigenvalues and of costs that count as none."""


def fronts(animal: Animal, optima: xr.Dataset, workers: int) -> xr.Dataset:
    """Trade stability for efficiency in each family, on a few slopes, between the optima for either.

    Returns
    -------
    xarray.Dataset
        ``reduced_eigenvalue`` and ``transport_cost`` over slope_deg, family and point, missing where there is none, or
        where another one of the family is at least as good in both; heading (rad) is among its attributes.
    """
    families = list(animal.families)
    cells = [(slope, family) for slope in SLOPES_DEG for family in families]
    tasks = [(one_front, animal, optima.sel(slope_deg=s, heading=HEADING, family=f)) for s, f in cells]
    with processes(workers) as pool:
        both = np.array([*pool.map(pool.call, tasks)]).reshape(len(SLOPES_DEG), len(families), 2, POINTS)
    dims = ("slope_deg", "family", "point")
    coords = {"slope_deg": list(SLOPES_DEG), "family": families, "point": np.arange(POINTS)}
    values = {name: (dims, both[:, :, n]) for n, name in enumerate(("reduced_eigenvalue", "transport_cost"))}
    return xr.Dataset(values, coords, {"heading": HEADING})


def one_front(animal: Animal, optima: xr.Dataset) -> Floats:
    """Eigenvalues and costs, ``(2, POINTS)``, between the two optima of one family in one cell; nan for none."""
    slope, heading, family = np.radians(optima["slope_deg"]), float(optima["heading"]), str(optima["family"].item())
    objective = Objective(animal, float(slope), heading, family, "efficiency", "reduced")
    values = np.full((2, POINTS), np.nan)
    if not np.all(np.isfinite(optima["speed"])):
        return values
    stable, cheap = (candidate_of(optima.sel(objective=goal), animal) for goal in ("stability", "efficiency"))
    with threadpool_limits(1):
        scores = front(objective, stable, cheap, POINTS)
    worth = [score for score in scores if score.total < objective.constraints.no_gait]
    found = np.array([(objective.eigenvalue(score), score.value) for score in worth]).reshape(-1, 2)
    kept = found[undominated(found)]
    values[:, : len(kept)] = kept.T
    return values


def undominated(points: Floats) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Tell which of some points, ``(N, 2)``, are not worse than another in one number and no better in the other.

    Of points that are all the same, the first one counts.
    """
    less = points[None, :, :] - points[:, None, :]
    no_worse, better = np.all(less <= SAME, axis=2), np.any(less < -SAME, axis=2)
    before = np.tri(len(points), k=-1, dtype=bool)
    alike = np.all(np.abs(less) <= SAME, axis=2) & before
    result: np.ndarray[tuple[int], np.dtype[np.bool_]] = ~np.any((no_worse & better) | alike, axis=1)
    return result
