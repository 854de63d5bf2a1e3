"""Optimised gaits that nobody has computed, in the right form."""

import json

import numpy as np
import xarray as xr

from legspring import cockroach
from legspring.mapping import IMPULSE, IMPULSES
from legspring.measures.registry import BY_NAME

FAMILIES = ["A", "FB", "MB", "B"]
DIMENSIONS = {
    "phase": ["leg"],
    "actuation": ["leg"],
    "peak_force": ["leg", "axis"],
    "net_force_max": ["axis"],
    "reduced_eigenvalue": [],
    "max_multiplier": [],
    "transport_cost": [],
    "speed": [],
    "value": [],
    "penalised": [],
    "recovery_steps": ["impulse"],
    "recovered": ["impulse"],
}


def made_up_optima(slopes_deg: tuple[float, ...], headings: tuple[float, ...], seed: int = 1) -> xr.Dataset:
    """Return random numbers for about half of the families of each cell; none in the last cell."""
    random = np.random.default_rng(seed)
    coords = {
        "objective": ["stability", "efficiency"],
        "slope_deg": ("slope_deg", list(slopes_deg), {"units": "degrees", "long_name": "slope"}),
        "heading": ("heading", list(headings), {"units": "rad", "long_name": "initial heading"}),
        "family": FAMILIES,
        "leg": ["F", "M", "B"],
        "single_leg": [leg.name for leg in cockroach().legs],
        "axis": ["lateral", "fore_aft"],
        "impulse": ("impulse", list(IMPULSES), IMPULSE),
    }
    sizes = {"objective": 2, "slope_deg": len(slopes_deg), "heading": len(headings), "family": 4, "leg": 3, "axis": 2}
    sizes["impulse"] = len(IMPULSES)
    cell = ["objective", "slope_deg", "heading", "family"]
    there = random.random([sizes[dim] for dim in cell]) < 0.5
    there[:, -1, -1] = False
    variables = {}
    for name, more in DIMENSIONS.items():
        numbers = random.uniform(-1.0 if "force" in name else 0.0, 1.0, [sizes[dim] for dim in cell + more])
        numbers = np.round(numbers) if name == "recovered" else numbers
        numbers[~there] = np.nan
        attributes = BY_NAME[name].attributes if name in BY_NAME else {"units": "1", "long_name": name}
        variables[name] = (cell + more, numbers, attributes)
    lengths = np.array([0.032, 0.026, 0.019])
    variables["actuation"][1][:] *= lengths
    parameters = json.dumps(cockroach().model_dump(mode="json"))
    optima = xr.Dataset(variables, coords=coords, attrs={"parameters": parameters})
    return optima.assign(active=(cell, np.where(there, "B: a constraint", "")))


def best_of(optima: xr.Dataset) -> xr.Dataset:
    """Return the gait of the lowest value in each cell, its family a variable."""
    value = optima["value"].fillna(np.inf)
    best = optima.isel(family=value.argmin("family"))
    family = best["family"].astype(object).where(np.isfinite(value.min("family")), "")
    return best.drop_vars("family").assign(family=family)


def made_up_limits() -> xr.Dataset:
    """Gaits of one family at 0.1 rad, as far as 0.15 to 0.18 rad, and none of the other, for one objective."""
    limit, there = np.full((1, 2, 3, 2, 2), np.nan), np.zeros((1, 2, 3, 2), dtype=bool)
    limit[0, 0, :, 0, 1], there[0, 0, :, 0] = (0.15, 0.16, 0.18), True
    dims = ("objective", "family", "slope_deg", "heading")
    coords = {"slope_deg": [0.0, 10.0, 20.0], "heading": [0.1, 0.2], "family": ["A", "B"], "objective": ["stability"]}
    return xr.Dataset({"limit": ((*dims, "axis"), limit), "exists": (dims, there)}, coords)
