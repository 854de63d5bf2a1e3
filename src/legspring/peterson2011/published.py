"""The thesis's printed numbers, to compare with.

``forces.csv``: Tables 6.1-6.3 of D. E. Peterson, Reduced Order Multi-Legged Mathematical Modeling of
Cockroach Locomotion on Inclines, thesis, 2011; two decimals as printed. The columns ``experiment`` are measured
on animals, the others computed.
"""

import csv
from functools import cache
from importlib.resources import files

import numpy as np
import xarray as xr

LEGS = {"front": "F", "middle": "M", "back": "B"}


@cache
def published_forces() -> xr.Dataset:
    """Return the peak forces of the thesis's Tables 6.1-6.3.

    Returns
    -------
    xarray.Dataset
        Over leg, axis, slope_deg and extreme (``"min"``, ``"max"`` over headings of 0.05 to 0.40 rad), in units of
        m g: ``experiment`` as measured, ``model`` with fixed actuation, and optimised for ``stability`` and
        ``efficiency``. Missing where nothing was measured.
    """
    text = (files("legspring.peterson2011") / "forces.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(text.splitlines()))
    coords = {
        "leg": list(LEGS.values()),
        "axis": ["lateral", "fore_aft"],
        "slope_deg": ("slope_deg", sorted({float(row["slope_deg"]) for row in rows}), {"units": "degrees"}),
        "extreme": ["min", "max"],
    }
    names = dict.fromkeys(column.rpartition("_")[0] for column in rows[0] if column.endswith(("_min", "_max")))
    empty = xr.DataArray(np.nan, coords=coords, dims=list(coords), attrs={"units": "m g"})
    forces = xr.Dataset({name: empty.copy() for name in names})
    forces["slope_deg"].attrs["long_name"] = "slope"
    for row in rows:
        place = {"leg": LEGS[row["leg"]], "axis": row["direction"], "slope_deg": float(row["slope_deg"])}
        for name in names:
            for extreme in ("min", "max"):
                number = row[f"{name}_{extreme}"]
                forces[name].loc[place | {"extreme": extreme}] = float(number) if number else np.nan
    return forces
