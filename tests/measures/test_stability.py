"""Multipliers against what simulated perturbations do."""

import math
from dataclasses import replace

import numpy as np
import pytest
from legspring.layout import TIGHT

from legspring.gait import Gait
from legspring.kernel.walker import VX, VY, YAW, YAW_RATE, X, Y
from legspring.measures.stability import largest_magnitude, multipliers
from legspring.returnmap import Start, complete_map, flow
from tests.conftest import Cells

CELLS = [(75.0, 0.15, 0.127, 0.203), (60.0, 0.40, 0.054, 0.084)]


def touchdowns(gait: Gait, start: Start, steps: int) -> np.ndarray:
    """Return the complete state (speed, heading, Dx, Dy), mirrored to that of an even step, at each touch-down."""
    states = [np.array([start.speed * gait.system.step_duration, start.heading, *(start.displacement or ())])]
    before = np.zeros(2)
    for n in range(1, steps + 1):
        y = flow(gait.system, gait.phase, start, steps=n, accuracy=TIGHT)[0].y[:, 0]
        state = np.array([math.hypot(y[VX], y[VY]), math.atan2(-y[VX], y[VY]), y[X] - before[0], y[Y] - before[1]])
        before = y[[X, Y]]
        states.append(state * (np.array([1, -1, -1, 1]) if n % 2 else 1))
    return np.array(states)


@pytest.mark.parametrize(("slope", "heading", "reduced", "true"), CELLS)
def test_multipliers_are_the_decay_of_simulated_perturbations(
    slope: float, heading: float, reduced: float, true: float, thesis_map: Cells
) -> None:
    gait = thesis_map[slope, heading][0]
    length = gait.system.step_length
    rng = np.random.default_rng(1)
    before, after = [], []
    home = np.array([gait.speed * gait.system.step_duration, gait.heading, 0.0, length])
    for _ in range(24):
        kick = 1e-5 * rng.standard_normal(4) * [length, 1.0, length, length]
        start = Start(
            (home[0] + kick[0]) / gait.system.step_duration,
            home[1] + kick[1],
            displacement=(home[2] + kick[2], home[3] + kick[3]),
        )
        deviations = touchdowns(gait, start, 4) - home
        before += list(deviations[:-1])
        after += list(deviations[1:])
    scale = np.array([length, 1.0, length, length])
    fitted = np.linalg.lstsq(np.array(before) / scale, np.array(after) / scale, rcond=None)[0].T
    assert multipliers(fitted) == pytest.approx(gait.multipliers, abs=1e-4)
    assert abs(gait.multipliers[0]) == pytest.approx(true, abs=5e-4)
    assert gait.reduced_eigenvalue == pytest.approx(reduced, abs=5e-4)


def test_multipliers_of_a_body_that_yaws_are_those_of_simulated_perturbations(rigid_map: Cells) -> None:
    for cell in ((30.0, 0.15), (90.0, 0.45)):
        gait = rigid_map[cell][-1]
        system, t_des = gait.system, gait.system.step_duration
        length = system.step_length
        scale = np.array([length, 1.0, length, length, 1.0, 1.0, 1.0])
        home = np.array(
            [gait.speed * t_des, gait.heading, 0.0, length, gait.yaw, gait.yaw_rate * t_des, 2.0 * gait.yaw]
        )
        rng = np.random.default_rng(1)
        kicks = 1e-6 * rng.standard_normal((40, 7)) * scale
        after = []
        for speed, heading, dx, dy, yaw, yaw_rate, turn in home + kicks:
            start = Start(speed / t_des, heading, (dx, dy), yaw, yaw_rate / t_des, turn)
            y = flow(system, gait.phase, start, accuracy=1e-13)[0].y[:, 0]
            direction = math.atan2(-y[VX], y[VY]) - y[YAW]
            end = np.array(
                [math.hypot(y[VX], y[VY]), -direction, -y[X], y[Y], -y[YAW], -y[YAW_RATE], -(y[YAW] - start.yaw)]
            )
            after.append((end - home) / scale)
        fitted = np.linalg.lstsq(kicks / scale, np.array(after), rcond=None)[0].T
        assert multipliers(fitted)[:4] == pytest.approx(gait.multipliers[:4], abs=1e-3)


def test_disturbances_of_a_body_that_yaws_grow_as_the_multiplier_says(rigid_map: Cells) -> None:
    # One that grows alone, and alone leads.
    gait = next(g for here in rigid_map.values() for g in here if abs(g.multipliers[0]) > 1.5 * abs(g.multipliers[1]))
    change = replace(gait.start, speed=gait.speed * (1.0 + 1e-9))
    runs = [
        flow(gait.system, gait.phase, start, steps=12, accuracy=1e-13)[1].touchdowns for start in (gait.start, change)
    ]
    away = np.linalg.norm((runs[1] - runs[0])[[8, 10, 12], VX:], axis=1)
    assert away[-1] < 1e-3, "still small"
    assert away[1:] / away[:-1] == pytest.approx(abs(gait.multipliers[0]), rel=0.02)


def test_complete_map_returns_the_gait_to_itself(thesis_map: Cells) -> None:
    for cell in ((0.0, 0.15), (30.0, 0.35), (90.0, 0.30)):
        gait = thesis_map[cell][0]
        state, _ = complete_map(gait.system, gait.phase, gait.start)
        length = gait.system.step_length
        expected = [gait.speed * gait.system.step_duration, gait.heading, 0.0, length]
        assert state == pytest.approx(expected, abs=1e-9)


def test_without_old_legs_both_maps_agree(thesis_map: Cells) -> None:
    alone = [g for gaits in thesis_map.values() for g in gaits if np.all(g.liftoff < 1.0)]
    assert len(alone) > 10
    for gait in alone:
        assert abs(gait.multipliers[0]) == pytest.approx(gait.reduced_eigenvalue, abs=1e-9)


def test_eigenvalues_of_a_known_matrix() -> None:
    rotation = 0.5 * np.array([[0.0, -1.0], [1.0, 0.0]])
    assert largest_magnitude(rotation) == pytest.approx(0.5)
    assert multipliers(rotation) == pytest.approx([-0.25, -0.25])
