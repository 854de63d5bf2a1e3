"""Recovery from pushes, against the published numbers of steps and by its own rules."""

import numpy as np
import pytest

import legspring as ls
from legspring import cockroach
from legspring.flow import NO_PUSH, flow
from legspring.layout import System
from legspring.measures.robustness import push_knots, recover, settled_elsewhere, steps_to_recover
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
        pushed, calm = (flow(gait.system, gait.point, push=knots).state[0, 0] for knots in (push, NO_PUSH))
        assert (pushed - calm) * impulse > 0.0


def test_the_slowest_recovery(thesis_map: Cells) -> None:
    # The slope of 15 deg is the slowest, with 54 steps, as published; there for the push to the other side.
    found = [thesis_map[15, 0.15][0].recover(impulse).steps for impulse in (-0.8, 0.8)]
    assert found == [50, 54]


def test_a_push_that_breaks_the_simulation_says_so(thesis_map: Cells) -> None:
    stiff = System(cockroach().replace(stiffness=1e15), 0.0, "A")
    start = thesis_map[45, 0.15][0]
    recovery = recover(stiff, stiff.point((0.3, 0.3, -0.3), speed=start.speed, heading=start.heading), 0.5)
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


def test_steps_of_many_pushes_are_those_of_each(thesis_map: Cells) -> None:
    for cell in ((0, 0.40), (15, 0.15), (75, 0.45)):
        for gait in thesis_map[cell]:
            impulses = (-0.8, -0.1, 0.4, 2.0)
            expected = [np.nan if (steps := gait.recover(one).steps) is None else steps for one in impulses]
            np.testing.assert_array_equal(gait.recovery_steps(impulses), expected)


@pytest.mark.parametrize("impulse", [0.02, -0.05])
def test_a_limp_recovers_as_quickly_as_its_multipliers_say(impulse: float) -> None:
    """Each step is compared with that of the gait: left ones with left ones, right ones with right ones."""
    gaits = ls.find_gaits(ls.load_animal("injured_cockroach"), slope_deg=45, family="B")
    gait = min(gaits, key=lambda one: abs(one.multipliers[0]))
    recovery = gait.recover(impulse)
    assert recovery.recovered and recovery.distance[0] == 0.0
    strides = recovery.distance[8:15:2]
    assert strides[1:] / strides[:-1] == pytest.approx(abs(gait.multipliers[0]), rel=0.05)
    assert gait.recovery_steps([impulse]) == [recovery.steps]
