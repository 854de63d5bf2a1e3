"""Derivatives of gaits and of what is measured of them."""

import math
from typing import Any

import numpy as np
import pytest
import xarray as xr

import legspring as ls
from legspring import Animal, Gait, load_animal
from legspring.measures.sensitivity import scale_of
from tests.places import place_of

CASES: dict[str, tuple[dict[str, Any], tuple[str, ...]]] = {
    "cockroach": ({}, ("slope_deg", "mass", "F.stiffness", "B.actuation", "M.angle", "heading", "step_duration")),
    "cockroach_rigid": ({}, ("inertia", "F.hip_y", "stiffness")),
    "walker": ({"energy": 816.0}, ("energy", "T.stiffness", "T.angle", "gravity")),
    "quadruped": ({}, ("inertia", "F.length", "desired_speed")),
    "lateral_leg_spring": ({"mean_speed": 0.5}, ("mean_speed", "T.hip_y", "inertia")),
    "injured_cockroach": ({}, ("slope_deg", "FR.stiffness", "M.phase")),
    "climbing_template": ({}, ("T.damping", "T.stance", "mass")),
    "centipede": ({}, ("1.stiffness", "3.offset", "phase")),
}


def gait_of(name: str) -> Gait:
    asked, _ = CASES[name]
    animal = load_animal(name)
    return ls.find_gaits(animal, **{**place_of(animal), **asked})[0]


@pytest.mark.parametrize("name", CASES)
def test_measures_move_as_the_exact_derivatives_say(name: str) -> None:
    """What is known exactly is also measured, by differences of gaits that were found anew."""
    gait, (asked, names) = gait_of(name), CASES[name]
    found = gait.sensitivity(*names)
    assert list(found.parameter.values) == list(names)
    assert gait.origin is not None
    for column, parameter in enumerate(names):
        value = float(found.value[column])
        h = 1e-4 * scale_of(gait.system, parameter, value)
        one, other = (gait.origin.moved(gait, parameter, sign * h) for sign in (1.0, -1.0))
        assert one is not None and other is not None
        for measure in ("speed", "heading"):
            difference = (getattr(one, measure) - getattr(other, measure)) / (2.0 * h)
            scale = max(abs(difference), 1e-3 * abs(getattr(gait, measure)) / abs(h) * 1e-3)
            assert float(found[measure][column]) == pytest.approx(difference, rel=1e-4, abs=1e-5 * scale)
    for target in asked:
        for column, name_of in enumerate(names):
            size = scale_of(gait.system, name_of, float(found.value[column])) / abs(float(asked[target]))
            expected = size if name_of == target else 0.0
            assert float(found[target][column]) * size == pytest.approx(expected, abs=1e-9)


def test_sensitivities_of_the_thesis_s_gait_to_the_slope(roach: Animal) -> None:
    """Family B's cost is the sine of the slope; the desired speed falls by 0.15 m/s in 90 degrees."""
    gait = ls.find_gaits(roach, slope_deg=45, heading=0.15)[0]
    found = gait.sensitivity("slope_deg", "mass", "stiffness")
    slope = math.pi / 180.0 * math.cos(math.radians(45.0))
    assert found.transport_cost.values == pytest.approx([slope, 0.0, 0.0], abs=1e-8)
    assert found.mean_speed.values == pytest.approx([-0.15 / 90.0, 0.0, 0.0], abs=1e-9)
    assert found.attrs["slope_deg"] == 45.0 and list(found.unit.values) == ["deg", "kg", "N/m"]
    # A heavier animal on legs that are stiffer by as much has the same gait.
    relative = found * found.value
    for name in ("speed", "max_multiplier", "duty_factor_missing", "froude_number"):
        if name in relative:
            total = float(relative[name][1] + relative[name][2])
            assert total == pytest.approx(0.0, abs=1e-6 * abs(float(relative[name][1])) + 1e-9)
    assert (relative.phase[1] + relative.phase[2]).values == pytest.approx([0.0] * 3, abs=1e-8)


def test_multipliers_as_from_gaits_beside(roach: Animal) -> None:
    gait = ls.find_gaits(roach, slope_deg=45, heading=0.15)[0]
    found = gait.sensitivity("slope_deg").multipliers[0]
    h = 0.01
    one, other = (ls.find_gaits(roach, slope_deg=45.0 + s * h, heading=0.15)[0].multipliers for s in (1.0, -1.0))
    assert found.sel(part="real").values == pytest.approx(((one - other) / (2.0 * h)).real, rel=1e-5, abs=1e-9)


def test_what_is_double_has_no_derivative() -> None:
    gait = gait_of("lateral_leg_spring")
    assert gait.conserved == ("energy", "direction")
    found = gait.sensitivity("T.hip_y")
    assert np.isnan(found.multipliers[0, :2]).all() and np.isfinite(found.multipliers[0, 2:]).all()
    assert np.isnan(found.max_multiplier[0]) and np.isnan(found.reduced_eigenvalue[0])


def test_passive_legs_have_no_gait_beside_the_level() -> None:
    gait = gait_of("walker")
    found = gait.sensitivity("slope_deg", "T.stiffness")
    assert "there is no such gait beside" in str(found.note[0].item()) and found.note[1] == ""
    assert np.isnan(found.speed[0]) and np.isnan(found.stride_length[0]) and np.isfinite(found.speed[1])


def test_of_what_can_only_grow_the_derivative_is_that_of_growth(roach: Animal) -> None:
    gait = ls.find_gaits(roach, slope_deg=45, heading=0.15)[0]
    found = gait.sensitivity("damping", "B.offset")
    assert "those of more" in str(found.note[0].item()) and "later one" in str(found.note[1].item())
    beside = ls.find_gaits(roach.replace(damping=1e-5), slope_deg=45, heading=0.15)[0]
    assert float(found.speed[0]) == pytest.approx((beside.speed - gait.speed) / 1e-5, rel=1e-3)
    later = ls.find_gaits(roach.replace(**{"B.offset": 1e-4}), slope_deg=45, heading=0.15)
    (same,) = [one for one in later if abs(one.speed - gait.speed) < 1e-4]
    assert float(found.speed[1]) == pytest.approx((same.speed - gait.speed) / 1e-4, rel=1e-2)


def test_wrong_names(roach: Animal) -> None:
    gait = ls.find_gaits(roach, slope_deg=45, heading=0.15)[0]
    for name, message in (
        ("colour", "parameter = 'colour': must be one of speed, heading"),
        ("F.phase", "parameter = 'F.phase': must be no parameter that was free, as are F.phase, M.phase, B.phase"),
        ("speed", "parameter = 'speed': must be no coordinate of the start"),
        (1.5, "parameter = 1.5: must be a name"),
    ):
        with pytest.raises(ValueError, match=message):
            gait.sensitivity(name)  # type: ignore[arg-type]
    nobody = ls.Gait(**{name: getattr(gait, name) for name in gait.__dataclass_fields__ if name != "origin"})
    with pytest.raises(ValueError, match="must be one that a search has found"):
        nobody.sensitivity("mass")


def test_it_is_kept_by_a_file(roach: Animal, tmp_path: Any) -> None:
    found = ls.find_gaits(roach, slope_deg=45, heading=0.15)[0].sensitivity("mass")
    found.to_netcdf(tmp_path / "s.nc")
    with xr.open_dataset(tmp_path / "s.nc") as read:
        xr.testing.assert_identical(read.load(), found)


@pytest.mark.parametrize("parameter", ["FL.stiffness", "FR.length", "MR.angle"])
def test_a_single_leg_of_a_mirrored_gait(parameter: str, roach: Animal) -> None:
    whole = ls.find_gaits(roach, slope_deg=45, heading=0.15)[0]
    given = roach.replace(phase=whole.phase)
    gait = min(ls.find_gaits(given, slope_deg=45, family="B"), key=lambda one: abs(one.speed - whole.speed))
    found = gait.sensitivity(parameter, "F.stiffness")
    assert "mirror" in str(found.note.values[0]) and not str(found.note.values[1])
    value = float(found.value[0])
    h = 1e-4 * scale_of(gait.system, parameter, value)
    beside = []
    for amount in (h, -h):
        others = ls.find_gaits(given.replace(**{parameter: value + amount}), slope_deg=45, family="B")
        beside.append(min(others, key=lambda one: abs(one.speed - gait.speed) + abs(one.heading - gait.heading)))
    for measure in ("speed", "heading", "mean_speed"):
        one, other = (getattr(each, measure) for each in beside)
        assert float(found[measure][0]) == pytest.approx((one - other) / (2.0 * h), rel=1e-4)
    # The phases are given, and stay.
    assert not np.any(found["phase"].values[0])
