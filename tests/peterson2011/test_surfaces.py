"""Where families of gaits begin and end, as curves."""

import numpy as np
import pytest
import xarray as xr

import legspring as ls
from legspring.peterson2011.surfaces import names, section


def line(found: xr.Dataset, name: str, n: int = 0) -> xr.Dataset:
    numbers = [number for number, words in names(found).items() if words == name]
    return found.isel(line=numbers[n]).dropna("point", subset=["heading"])


def test_lines_of_folds(family_lines: xr.Dataset) -> None:
    folds = line(family_lines, "folds of B")
    cusp = float(folds["cusp_slope_deg"]), float(folds["cusp_heading"])
    assert cusp == pytest.approx((30.914367, 0.453984), abs=1e-6)
    other = line(family_lines, "folds of FB")
    # Where the line of B ends, that of FB begins: the front legs have nothing to do there.
    ends = [(float(one["slope_deg"][k]), float(one["heading"][k])) for one in (folds, other) for k in (0, -1)]
    gaps = [abs(a[0] - b[0]) / 90 + abs(a[1] - b[1]) for a in ends[:2] for b in ends[2:]]
    assert min(gaps) < 2e-3


def test_between_lines_gaits_are_as_maps_have_them(roach: ls.Animal, family_lines: xr.Dataset) -> None:
    """No gait beyond the folds, two below; the family changes where a leg is idle."""
    folds = line(family_lines, "folds of B")
    n = int(np.argmin(np.abs(folds["slope_deg"].values - 50.0)))
    slope, heading = float(folds["slope_deg"][n]), float(folds["heading"][n])
    assert not ls.find_gaits(roach, slope_deg=slope, heading=heading + 0.01, family="B")
    assert len(ls.find_gaits(roach, slope_deg=slope, heading=heading - 0.01, family="B")) == 2
    idle = line(family_lines, "M legs idle")
    n = len(idle["point"]) // 2
    slope, heading = float(idle["slope_deg"][n]), float(idle["heading"][n])
    families = [ls.find_gaits(roach, slope_deg=slope, heading=heading + side)[0].family for side in (-0.01, 0.01)]
    assert families == ["A", "FB"]


def test_the_section_says_why_there_is_no_gait(family_lines: xr.Dataset) -> None:
    text = " ".join(section(family_lines).paragraphs)
    assert "cusp at 30.9144 deg and 0.45398 rad" in text and "dips to 0.4375 rad" in text
    assert "goes up to 0.4382000525 rad" in text
