"""Simulations as datasets."""

import math
from typing import Any

import numpy as np
import pytest

import legspring as ls
from legspring.returnmap import IntegrationError
from tests.conftest import Cells, read_reference


def test_a_published_stride(roach: ls.Animal) -> None:
    row = {name: float(value) for name, value in read_reference("strides.csv")[0].items()}
    data = ls.simulate(
        roach,
        slope_deg=row["slope_deg"],
        heading=row["heading"],
        speed=row["v0"],
        phase=[row[f"phi_{leg}"] for leg in "FMB"],
        family="A",
        strides=1,
    )
    assert data.position.values[-1] == pytest.approx([row["x_stride"], row["y_stride"]], abs=1e-10)
    assert data.velocity.values[-1] == pytest.approx([row["vx_stride"], row["vy_stride"]], abs=1e-9)
    events = [event for event in read_reference("events.csv") if event["case"] == "1"]
    assert data.event_time.values == pytest.approx([float(e["t"]) for e in events], abs=1e-10)
    assert [kind.replace("-", "") for kind in data.event_kind.values] == [e["kind"] for e in events]
    position = data.event_position.values
    assert position == pytest.approx(np.array([[float(e["x"]), float(e["y"])] for e in events]), abs=1e-10)


def test_forces_are_those_that_accelerate_the_body(thesis_map: Cells) -> None:
    gait = thesis_map[45, 0.15][0]
    data = gait.simulate(strides=1)
    acceleration = np.gradient(data.velocity.values, data.time.values, axis=0)
    force = data.force.sum("leg").values * gait.animal.gravity
    force[:, 1] -= gait.animal.gravity * math.sin(gait.slope)
    inner = slice(5, -5)
    assert acceleration[inner] == pytest.approx(force[inner], abs=0.02 * np.abs(force).max())


def test_the_moment_is_that_of_the_legs(rigid_map: Cells) -> None:
    gait = rigid_map[30, 0.15][0]
    data = gait.simulate(strides=1)
    arm = (data.foot - data.position).fillna(0.0)
    parts = arm.sel(axis="lateral") * data.force.sel(axis="fore_aft") - arm.sel(axis="fore_aft") * data.force.sel(
        axis="lateral"
    )
    weight = gait.animal.body.mass * gait.animal.gravity
    assert data.moment.values == pytest.approx(weight * parts.sum("leg").values, abs=1e-15)
    assert data.moment.attrs["units"] == "N m"


def test_a_start_with_yaw(rigid_map: Cells) -> None:
    gait = rigid_map[60, 0.15][0]
    data = ls.simulate(
        gait.animal,
        slope_deg=60,
        heading=0.15,
        speed=gait.speed,
        phase=gait.phase,
        family=gait.family,
        yaw=gait.yaw,
        yaw_rate=gait.yaw_rate,
        strides=0.5,
    )
    np.testing.assert_allclose(data.yaw, gait.simulate(0.5).yaw, rtol=0, atol=1e-9)
    assert data.yaw.values[-1] == pytest.approx(-gait.yaw, abs=1e-8)


def test_a_gait_repeats_itself(thesis_map: Cells) -> None:
    gait = thesis_map[60, 0.15][0]
    data = gait.simulate(strides=3)
    steps = data.isel(time=slice(None, None, 100))
    assert steps.velocity.values[::2] == pytest.approx(np.tile(steps.velocity.values[0], (4, 1)), abs=1e-8)
    assert steps.velocity.sel(axis="lateral").values[1] == pytest.approx(
        -steps.velocity.sel(axis="lateral").values[0], abs=1e-8
    )
    assert data.position.values[-1, 1] == pytest.approx(3 * 2 * gait.system.step_length, abs=1e-9)


def test_swing_has_no_foot_and_no_force(thesis_map: Cells) -> None:
    data = thesis_map[45, 0.15][0].simulate(strides=1)
    swing = ~data.stance.values
    assert swing.any()
    assert np.all(np.isnan(data.foot.values[swing]))
    assert np.all(data.force.values[swing] == 0.0)
    gap = (data.leg_length - data.free_length).values
    assert not np.any(np.isnan(gap[~swing]))


def test_animals_of_any_heading_may_run_backwards() -> None:
    start: dict[str, Any] = {"heading": 2.0, "speed": 0.2, "strides": 1}
    run = ls.simulate(ls.load_animal("climbing_template"), **start)
    assert run.attrs["heading"] == 2.0
    with pytest.raises(ValueError, match=r"^heading = 2\.0: must be"):
        ls.simulate(ls.cockroach(), slope_deg=45, phase=[0, 0, 0], family="B", **start)


def test_collapse_is_said(roach: ls.Animal) -> None:
    with pytest.raises(IntegrationError, match="stopped at t"):
        ls.simulate(
            roach.replace(stiffness=1e15), slope_deg=0, heading=0.1, speed=0.3, phase=(0, 0, 0), family="A", strides=1
        )


@pytest.mark.parametrize(
    "changes",
    [
        {"speed": 0.0},
        {"speed": -1.0},
        {"speed": math.nan},
        {"heading": 3.0},
        {"phase": (0, math.inf, 0)},
        {"phase": (0, 1e9, 0)},
        {"phase": (0, 0)},
        {"strides": 0.3},
        {"strides": 0},
        {"strides": 1e9},
        {"accuracy": 1.0},
        {"family": "Z"},
        {"yaw": math.nan},
        {"yaw": 0.3},
        {"yaw_rate": 5.0},
        {"yaw_rate": "fast"},
        {"speed": "fast"},
        {"phase": ("a", 0, 0)},
        {"displacement": (1, 2, 3)},
    ],
)
def test_bad_input_is_named(roach: ls.Animal, changes: dict[str, object]) -> None:
    arguments = {"slope_deg": 0, "heading": 0.1, "speed": 0.3, "phase": (0.5, 0.5, -0.5), "family": "A"} | changes
    name = next(iter(changes))
    with pytest.raises(ValueError, match=name) as caught:
        ls.simulate(roach, **arguments)  # type: ignore[arg-type]
    assert "\n" not in str(caught.value)
