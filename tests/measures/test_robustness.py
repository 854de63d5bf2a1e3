"""Recovery from pushes, against the published numbers of steps and by its own rules."""

import numpy as np
import pytest
from legspring.layout import System

from legspring import cockroach
from legspring.kernel.walker import X
from legspring.measures.robustness import push_knots, recover, settled_elsewhere, steps_to_recover
from legspring.returnmap import NO_PUSH, flow
from tests.conftest import Cells, read_reference


def test_steps_to_recover_are_the_published_ones(thesis_map: Cells) -> None:
    rows = read_reference("recovery.csv")
    for row in rows:
        gait = thesis_map[float(row["slope_deg"]), 0.15][0]
        recovery = gait.recover(float(row["impulse"]))
        assert recovery.recovered == (row["recovered"] == "1")
        assert recovery.steps is not None
        assert abs(recovery.steps - int(row["steps"])) <= 1
    assert len(rows) == 68


@pytest.mark.parametrize(("slope", "steps"), [(0, 36), (20, 29), (30, 17), (45, 10), (60, 5), (75, 8), (90, 12)])
def test_recovery_from_the_hardest_push(slope: float, steps: int, thesis_map: Cells) -> None:
    found = thesis_map[slope, 0.15][0].recover(-0.8).steps
    assert found is not None
    assert abs(found - steps) <= 1


def test_push_has_its_impulse(thesis_map: Cells) -> None:
    system = thesis_map[45, 0.15][0].system
    knots = push_knots(system, 0.5)
    change = np.trapezoid(knots[:, 1], knots[:, 0])
    assert change == pytest.approx(0.5 * system.step_length)
    assert np.diff(knots[:, 0]) * system.step_duration == pytest.approx([2.985e-3, 1.015e-3])


def test_no_push_no_distance(thesis_map: Cells) -> None:
    recovery = thesis_map[45, 0.15][0].recover(0.0)
    assert recovery.steps == 1
    assert np.max(recovery.distance) < 1e-7


def test_a_push_to_the_right_moves_right(thesis_map: Cells) -> None:
    gait = thesis_map[45, 0.15][0]
    for impulse in (0.3, -0.3):
        push = push_knots(gait.system, impulse)
        pushed, calm = (flow(gait.system, gait.phase, gait.start, push=knots)[0].y[X, 0] for knots in (push, NO_PUSH))
        assert (pushed - calm) * impulse > 0.0


def test_the_slowest_recovery(thesis_map: Cells) -> None:
    # The slope of 15 deg is the slowest, with 54 steps, as published; there for the push to the other side.
    found = [thesis_map[15, 0.15][0].recover(impulse).steps for impulse in (-0.8, 0.8)]
    assert found == [50, 54]


def test_a_push_that_breaks_the_simulation_says_so(thesis_map: Cells) -> None:
    stiff = System(cockroach().replace(stiffness=1e15), 0.0, (-1, -1, -1))
    recovery = recover(stiff, (0.3, 0.3, -0.3), thesis_map[45, 0.15][0].start, 0.5)
    assert not recovery.recovered
    assert recovery.failure is not None


def test_rules_of_recovery() -> None:
    assert steps_to_recover(np.array([0.0, 0.5, 0.009, 0.008, 0.007])) == 2
    assert steps_to_recover(np.array([0.0, 0.5, 0.009, 0.02, 0.005, 0.004])) == 4
    assert steps_to_recover(np.array([0.0, 0.5, 0.0009, 0.02])) == 2
    assert steps_to_recover(np.array([0.0, 0.5, 0.4, 0.3])) is None
    assert steps_to_recover(np.array([0.0, np.nan, np.nan])) is None
    assert settled_elsewhere(np.array([0.0, 2.0, 1.5, 2.0, 1.5, 2.0]))
    assert not settled_elsewhere(np.array([0.0, 0.5, 0.4, 0.5, 0.4]))


def test_bad_impulse(thesis_map: Cells) -> None:
    with pytest.raises(ValueError, match="impulse = nan"):
        thesis_map[45, 0.15][0].recover(float("nan"))
