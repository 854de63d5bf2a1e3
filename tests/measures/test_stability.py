"""Multipliers against what simulated perturbations do."""

import math

import numpy as np
import pytest

from legspring.gait import Gait
from legspring.kernel.walker import VX, VY, X, Y
from legspring.measures.stability import largest_magnitude, multipliers
from legspring.returnmap import Start, complete_map, flow
from legspring.setting import TIGHT
from tests.conftest import Cells

CELLS = [(75.0, 0.15, 0.127, 0.203), (60.0, 0.40, 0.054, 0.084)]


def touchdowns(gait: Gait, start: Start, steps: int) -> np.ndarray:
    """Return the complete state (speed, heading, Dx, Dy), mirrored to that of an even step, at each touch-down."""
    states = [np.array([start.speed * gait.setting.step_duration, start.heading, *(start.displacement or ())])]
    before = np.zeros(2)
    for n in range(1, steps + 1):
        y = flow(gait.setting, gait.phase, start, steps=n, accuracy=TIGHT)[0].y[:, 0]
        state = np.array([math.hypot(y[VX], y[VY]), math.atan2(-y[VX], y[VY]), y[X] - before[0], y[Y] - before[1]])
        before = y[[X, Y]]
        states.append(state * (np.array([1, -1, -1, 1]) if n % 2 else 1))
    return np.array(states)


@pytest.mark.parametrize(("slope", "heading", "reduced", "true"), CELLS)
def test_multipliers_are_the_decay_of_simulated_perturbations(
    slope: float, heading: float, reduced: float, true: float, thesis_map: Cells
) -> None:
    gait = thesis_map[slope, heading][0]
    length = gait.setting.step_length
    rng = np.random.default_rng(1)
    before, after = [], []
    home = np.array([gait.speed * gait.setting.step_duration, gait.heading, 0.0, length])
    for _ in range(24):
        kick = 1e-5 * rng.standard_normal(4) * [length, 1.0, length, length]
        start = Start(
            (home[0] + kick[0]) / gait.setting.step_duration,
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


def test_complete_map_returns_the_gait_to_itself(thesis_map: Cells) -> None:
    for cell in ((0.0, 0.15), (30.0, 0.35), (90.0, 0.30)):
        gait = thesis_map[cell][0]
        state, _ = complete_map(gait.setting, gait.phase, gait.start)
        length = gait.setting.step_length
        expected = [gait.speed * gait.setting.step_duration, gait.heading, 0.0, length]
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
