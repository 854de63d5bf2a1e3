"""Multipliers against what simulated perturbations do."""

import math
from dataclasses import replace

import numpy as np
import pytest

from legspring.flow import flow
from legspring.gait import Gait
from legspring.layout import TIGHT
from legspring.measures.stability import largest_magnitude, multipliers
from legspring.returnmap import complete_map
from tests.conftest import Cells

CELLS = [(75.0, 0.15, 0.127, 0.203), (60.0, 0.40, 0.054, 0.084)]


MIRROR = np.array([1, -1, -1, 1, -1, -1, -1])


def touchdowns(gait: Gait, p: np.ndarray, steps: int) -> np.ndarray:
    """Return the complete state (speed, heading, Dx, Dy), mirrored to that of an even step, at each touch-down."""
    states, before = [p[:4]], np.zeros(2)
    for n in range(1, steps + 1):
        x, y, vx, vy = flow(gait.system, p, steps=n, accuracy=TIGHT).state[:, 0]
        state = np.array([math.hypot(vx, vy), math.atan2(-vx, vy), x - before[0], y - before[1]])
        before = np.array([x, y])
        states.append(state * (MIRROR[:4] if n % 2 else 1))
    return np.array(states)


@pytest.mark.parametrize(("slope", "heading", "reduced", "true"), CELLS)
def test_multipliers_are_the_decay_of_simulated_perturbations(
    slope: float, heading: float, reduced: float, true: float, thesis_map: Cells
) -> None:
    gait = thesis_map[slope, heading][0]
    system, home = gait.system, gait.point[:4]
    scale = np.array([system.desired_speed, 1.0, system.step_length, system.step_length])
    rng = np.random.default_rng(1)
    before, after = [], []
    for _ in range(24):
        p = gait.point.copy()
        p[:4] += 1e-5 * rng.standard_normal(4) * scale
        deviations = touchdowns(gait, p, 4) - home
        before += list(deviations[:-1])
        after += list(deviations[1:])
    fitted = np.linalg.lstsq(np.array(before) / scale, np.array(after) / scale, rcond=None)[0].T
    assert multipliers(fitted) == pytest.approx(gait.multipliers, abs=1e-4)
    assert np.sort(np.linalg.eigvals(fitted).real) == pytest.approx(np.sort(gait.half_multipliers.real), abs=2e-3)
    assert abs(gait.multipliers[0]) == pytest.approx(true, abs=5e-4)
    assert gait.reduced_eigenvalue == pytest.approx(reduced, abs=5e-4)


def test_multipliers_of_a_body_that_yaws_are_those_of_simulated_perturbations(rigid_map: Cells) -> None:
    for cell in ((30.0, 0.15), (90.0, 0.45)):
        gait = rigid_map[cell][-1]
        system, length = gait.system, gait.system.step_length
        scale = np.array([system.desired_speed, 1.0, length, length, 1.0, 1.0 / system.step_duration, 1.0])
        rng = np.random.default_rng(1)
        kicks = 1e-6 * rng.standard_normal((40, 7)) * scale
        after = []
        for kick in kicks:
            p = gait.point.copy()
            p[:7] += kick
            x, y, vx, vy, yaw, rate = flow(system, p, accuracy=1e-13).state[:, 0]
            end = np.array([math.hypot(vx, vy), math.atan2(-vx, vy) - yaw, x, y, yaw, rate, yaw - p[4]]) * MIRROR
            after.append((end - gait.point[:7]) / scale)
        fitted = np.linalg.lstsq(kicks / scale, np.array(after), rcond=None)[0].T
        assert multipliers(fitted)[:4] == pytest.approx(gait.multipliers[:4], abs=1e-3)


def test_disturbances_of_a_body_that_yaws_grow_as_the_multiplier_says(rigid_map: Cells) -> None:
    # One that grows alone, and alone leads.
    gait = next(g for here in rigid_map.values() for g in here if abs(g.multipliers[0]) > 1.5 * abs(g.multipliers[1]))
    change = replace(gait, speed=gait.speed * (1.0 + 1e-9))
    runs = [flow(gait.system, one.point, steps=12, accuracy=1e-13).states for one in (gait, change)]
    away = np.linalg.norm(((runs[1] - runs[0]) * gait.system.step_duration)[[8, 10, 12], 2:], axis=1)
    assert away[-1] < 1e-3, "still small"
    assert away[1:] / away[:-1] == pytest.approx(abs(gait.multipliers[0]), rel=0.02)


def test_complete_map_returns_the_gait_to_itself(thesis_map: Cells) -> None:
    for cell in ((0.0, 0.15), (30.0, 0.35), (90.0, 0.30)):
        gait = thesis_map[cell][0]
        state, _ = complete_map(gait.system, gait.point)
        assert state == pytest.approx([gait.speed, gait.heading, 0.0, gait.system.step_length], abs=1e-9)


def test_without_old_legs_both_maps_agree(thesis_map: Cells) -> None:
    alone = [g for gaits in thesis_map.values() for g in gaits if np.all(g.liftoff < 1.0)]
    assert len(alone) > 10
    for gait in alone:
        assert abs(gait.multipliers[0]) == pytest.approx(gait.reduced_eigenvalue, abs=1e-9)


def test_eigenvalues_of_a_known_matrix() -> None:
    rotation = 0.5 * np.array([[0.0, -1.0], [1.0, 0.0]])
    assert largest_magnitude(rotation) == pytest.approx(0.5)
    assert multipliers(rotation) == pytest.approx([-0.25, -0.25])
