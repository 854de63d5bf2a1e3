"""What a measure varies with: Sobol indices of a sweep."""

import math
import warnings
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import sobol_indices as of_values

from legspring.checks import LARGEST_SEED, checked_whole, shown

if TYPE_CHECKING:
    import xarray as xr

FEWEST = 8
"""Base points from which on indices are worth anything."""
CONFIDENCE, RESAMPLES = 0.95, 500


def sobol_indices(dataset: "xr.Dataset", name: str, *, branch: int = 0, seed: int = 0) -> "xr.Dataset":
    """Say which share of a measure's variance comes from which parameter.

    First-order indices are the shares that parameters have by themselves, total ones those with all that they have
    together with others (Saltelli 2010); by SciPy.

    Parameters
    ----------
    dataset
        Of `legspring.sweep` with ``sampling="saltelli"``, or its store or file opened with xarray.
    name
        A measure that is one number for each gait.
    branch
        Which gait. Base points without it are left out; what is left is cut to a power of two.
    seed
        Of the resampling by which confidence intervals are found.

    Returns
    -------
    xarray.Dataset
        Over ``parameter``: ``first_order`` and ``total_order``, with the ends of their 95 % confidence intervals
        (``_low``, ``_high``). Attribute ``base_points``: how many were left.

    Raises
    ------
    ValueError
        For another dataset or name, or too few base points that have the gait.

    Examples
    --------
    >>> import legspring as ls
    >>> roach = ls.cockroach()
    >>> gait = ls.find_gaits(roach, slope_deg=45, heading=0.15)[0]
    >>> over = {"slope_deg": (40, 50), "M.stiffness": (1.4, 1.6)}
    >>> found = ls.sweep(roach, over, samples=16, sampling="saltelli", gaits=gait)
    >>> shares = ls.sobol_indices(found, "step_duration")
    >>> shares["first_order"].values.round(0).tolist()
    [1.0, 0.0]
    """
    import xarray as xr

    if not isinstance(dataset, xr.Dataset) or dataset.attrs.get("sampling") != "saltelli":
        raise ValueError(
            f"dataset = {shown(type(dataset).__name__)}: must be of legspring.sweep, sampling = 'saltelli'"
        )
    each = {str(one): values for one, values in dataset.data_vars.items() if values.dims == ("point", "branch")}
    valid = [one for one, values in each.items() if "flag_values" not in values.attrs]
    if name not in valid:
        raise ValueError(f"name = {shown(name)}: must be one of {', '.join(valid)}")
    if branch not in dataset["branch"].values:
        raise ValueError(f"branch = {shown(branch)}: must be one of {', '.join(map(str, dataset['branch'].values))}")
    luck = checked_whole("seed", seed, 0, LARGEST_SEED)
    names = [str(one) for one, values in dataset.coords.items() if values.dims == ("point",) and one != "point"]
    values = dataset[name].sel(branch=branch).values.astype(float)
    if len(values) != (len(names) + 2) * int(dataset.attrs["samples"]):
        raise ValueError(f"dataset: has {len(values)} points; must have all of those of legspring.sweep")
    values = values.reshape(len(names) + 2, -1)
    known = np.flatnonzero(np.all(np.isfinite(values), axis=0))
    count = 2 ** int(math.log2(len(known))) if len(known) else 0
    if count < FEWEST:
        raise ValueError(f"branch = {branch}: is there at {len(known)} base points; must be at {FEWEST} or more")
    first, second, *mixed = values[:, known[:count]]
    found = of_values(
        func={"f_A": first[None], "f_B": second[None], "f_AB": np.array(mixed)[:, None]}, n=count, rng=luck
    )
    # What does not vary at all has no interval.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        spread = found.bootstrap(confidence_level=CONFIDENCE, n_resamples=RESAMPLES)
    variables = {}
    for kind, words in (("first_order", "by itself"), ("total_order", "together with others")):
        interval = getattr(spread, kind).confidence_interval
        about = {"units": "1", "long_name": f"share of the variance of {name.replace('_', ' ')}, {words}"}
        variables[kind] = ("parameter", np.atleast_1d(getattr(found, kind)), about)
        for end in ("low", "high"):
            variables[f"{kind}_{end}"] = ("parameter", np.atleast_1d(getattr(interval, end)), {"units": "1"})
    attrs = {"measure": name, "branch": branch, "base_points": count, "animal": dataset.attrs.get("animal", "")}
    return xr.Dataset(variables, {"parameter": names}, attrs)
