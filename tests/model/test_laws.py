import csv
from functools import cached_property
from math import radians
from pathlib import Path
from statistics import fmean
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from legspring.model import Animal, Body, Leg, ModelError, SpeedLaw, StepLaw, cockroach

STRIDES = Path(__file__).parents[1] / "reference" / "strides.csv"

speeds = st.floats(0.01, 1.0)
frequencies = st.floats(1.0, 20.0)


def test_the_cockroachs_laws_agree_with_the_reference() -> None:
    roach = cockroach()
    with STRIDES.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 6
    for row in rows:
        slope = radians(float(row["slope_deg"]))
        assert roach.desired_speed(slope) == pytest.approx(float(row["v_des"]), rel=0, abs=1e-15)
        assert roach.step_duration(slope) == pytest.approx(float(row["t_des"]), rel=0, abs=1e-15)


def test_the_frequency_is_constant_above_the_fastest_level_speed() -> None:
    law = cockroach().step_law
    assert law(0.35) == law(0.36) == law(0.5) == pytest.approx(0.036443763027038, abs=1e-15)
    assert law(0.34) > law(0.35)


@given(st.floats(0.1, 1.0), st.floats(0.1, 1.0), st.floats(-90.0, 90.0))
def test_speed_is_linear_in_the_slope(level: float, vertical: float, slope_deg: float) -> None:
    assume(2 * level - vertical > 0)
    law = SpeedLaw(level=level, vertical=vertical)
    assert law(0.0) == level
    assert law(radians(90)) == pytest.approx(vertical)
    assert law(radians(slope_deg)) + law(radians(-slope_deg)) == pytest.approx(2 * level)


def test_the_speed_law_knows_its_domain() -> None:
    law = SpeedLaw(level=0.35, vertical=0.2, domain_deg=(-10, 45))
    assert law(radians(45)) == pytest.approx(0.275)
    for slope_deg in (-10.1, 45.1, float("nan")):
        with pytest.raises(ModelError, match=r"^slope = .* deg: must be between -10 and 45 deg$"):
            law(radians(slope_deg))


@pytest.mark.parametrize("domain_deg", [(10, -10), (-91, 90), (0, 90.5)])
def test_a_domain_rises_within_a_right_angle(domain_deg: tuple[float, float]) -> None:
    with pytest.raises(ModelError, match=r"domain_deg = .*: should rise, within -90 to 90 deg"):
        SpeedLaw(level=0.35, vertical=0.2, domain_deg=domain_deg)


def test_speed_is_positive_all_over_the_domain() -> None:
    with pytest.raises(ModelError, match=r"speed at -90 deg = -0.1 m/s: must be greater than 0"):
        SpeedLaw(level=0.1, vertical=0.3)
    assert SpeedLaw(level=0.1, vertical=0.3, domain_deg=(0, 90))(0.0) == 0.1


def test_a_step_is_half_a_stride() -> None:
    law = StepLaw(points=((0.1, 5.0), (0.2, 10.0)))
    assert law(0.1) == pytest.approx(0.1)
    assert law(0.2) == pytest.approx(0.05)


@given(st.lists(st.tuples(speeds, frequencies), min_size=2, max_size=20))
def test_the_line_is_the_least_squares_one(points: list[tuple[float, float]]) -> None:
    mean = fmean(speed for speed, _ in points)
    assume(sum((speed - mean) ** 2 for speed, _ in points) > 1e-3)
    law = StepLaw(points=tuple(points))
    try:
        residuals = [frequency - 1 / (2 * law(speed)) for speed, frequency in points]
    except ModelError:
        assume(False)
    # Of all lines, only that of least squares leaves residuals without mean and without trend.
    assert fmean(residuals) == pytest.approx(0, abs=1e-9)
    assert fmean(r * s for r, (s, _) in zip(residuals, points, strict=True)) == pytest.approx(0, abs=1e-9)


def test_a_constant_duration() -> None:
    assert StepLaw(duration=0.05)(0.1) == StepLaw(duration=0.05)(9.0) == 0.05


def test_a_line_without_a_positive_frequency_is_refused_where_it_has_none() -> None:
    law = StepLaw(points=((0.2, 2.0), (0.3, 4.0)))
    with pytest.raises(ModelError, match=r"stride frequency at 0.05 m/s = -1 Hz: must be greater than 0"):
        law(0.05)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({}, "needs points .* or a duration"),
        ({"points": ((0.1, 5.0), (0.2, 6.0)), "duration": 0.05}, "needs points .* or a duration"),
        ({"points": ((0.1, 5.0), (0.1, 6.0))}, "at least two different speeds"),
        ({"points": ((0.1, 5.0), (0.2, -6.0))}, r"points\[1\]\[1\] = -6.0: must be greater than 0"),
        ({"duration": 0.05, "constant_above": 0.3}, "constant_above goes with points"),
        ({"duration": 0.0}, "duration = 0.0: must be greater than 0"),
    ],
)
def test_a_step_law_that_cannot_be_is_refused(fields: dict[str, Any], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        StepLaw(**fields)


def test_a_changed_copy_has_a_line_of_its_own() -> None:
    law = StepLaw(points=((0.1, 5.0), (0.3, 10.0)))
    assert law(0.2) == pytest.approx(1.0 / 15.0)
    changed = law.model_copy(update={"points": ((0.1, 10.0), (0.3, 20.0))})
    assert changed(0.2) == pytest.approx(1.0 / 30.0)
    with pytest.raises(ModelError, match="at least two different speeds"):
        law.model_copy(update={"points": ((0.1, 10.0),)})


def test_nothing_that_is_frozen_remembers_what_a_copy_may_change() -> None:
    for kind in (Animal, Body, Leg, SpeedLaw, StepLaw):
        assert not [name for name, value in vars(kind).items() if isinstance(value, cached_property)]
