"""The penalised objective of Table 3.1."""

import math
from dataclasses import replace

import numpy as np
import pytest

from legspring.objective import (
    Constraint,
    Objective,
    angle_penalties,
    bound_penalties,
    crossing_angles,
    missing_fixed_point,
    pair_lengths,
    phase_penalties,
)
from tests.conftest import Cells


def test_an_unconstrained_gait_scores_its_measure(thesis_map: Cells) -> None:
    gait = thesis_map[45, 0.15][0]
    assert Objective(gait, "stability", "reduced").best.total == pytest.approx(gait.reduced_eigenvalue, abs=1e-9)
    assert Objective(gait, "stability").best.total == pytest.approx(abs(gait.multipliers[0]), abs=1e-9)
    best = Objective(gait, "efficiency").best
    assert best.total == pytest.approx(gait.transport_cost, abs=1e-9)
    assert best.penalties == ()
    assert best.gait is not None
    assert best.gait.phase == pytest.approx(gait.phase, abs=1e-9)


def test_bounds_of_the_actuation(thesis_map: Cells) -> None:
    animal = thesis_map[45, 0.15][0].animal
    lengths = pair_lengths(animal)
    assert bound_penalties(animal, 0.5 * lengths) == []
    low, high = bound_penalties(animal, lengths * [0.1, 0.95, 0.5])
    assert (low.constraint, low.pair) == (Constraint.ACTUATION_LEAST, "F")
    assert low.amount == pytest.approx(30.5)
    assert (high.constraint, high.pair) == (Constraint.ACTUATION_MOST, "M")
    assert high.amount == pytest.approx(30.5)


def test_bounds_of_the_phases(thesis_map: Cells) -> None:
    gait = replace(thesis_map[45, 0.15][0], phase=tuple(map(math.radians, (75.0, 60.0, -120.0))))
    late, early = phase_penalties(gait)
    assert (late.constraint, late.pair, early.constraint, early.pair) == (
        Constraint.PHASE_LATEST,
        "F",
        Constraint.PHASE_EARLIEST,
        "B",
    )
    assert (late.amount, early.amount) == pytest.approx((0.25, 1.0))


def test_crossing_angles_are_those_of_the_time_series(thesis_map: Cells) -> None:
    gait = thesis_map[15, 0.15][0]
    run = gait.simulate(strides=1)
    for pair, leg in enumerate(gait.first_legs):
        length, free = run.leg_length.values[:, leg], run.free_length.values[:, leg]
        stance = np.flatnonzero(~np.isnan(length))
        stance = stance[: np.append(np.flatnonzero(np.diff(stance) > 1) + 1, len(stance))[0]]
        time = run.time.values
        ends = []
        for rows, moment in ((stance[:5], 0.0), (stance[-5:], gait.liftoff[pair] * gait.setting.step_duration)):
            slopes = [
                np.polyval(np.polyder(np.polyfit(time[rows] - moment, series[rows], 3)), 0.0)
                for series in (length, free)
            ]
            ends.append(math.degrees(abs(math.atan(slopes[0]) - math.atan(slopes[1]))))
        assert crossing_angles(gait, leg) == pytest.approx(ends, abs=0.05)


def test_legs_that_hardly_part_are_penalised(thesis_map: Cells) -> None:
    gait = thesis_map[15, 0.25][0]
    (penalty,) = angle_penalties(gait)
    assert (penalty.constraint, penalty.pair) == (Constraint.ANGLE_TOUCHDOWN, "B")
    assert penalty.amount == pytest.approx(0.05 * (10.0 - crossing_angles(gait, gait.first_legs[2])[0]))
    assert penalty.amount == pytest.approx(0.05 * (10.0 - 2.3285), abs=1e-5)


def test_gaits_at_the_edge_do_not_survive_a_larger_heading(thesis_map: Cells) -> None:
    for cell, lost in (((50, 0.45), True), ((45, 0.15), False)):
        penalties = Objective(thesis_map[cell][0], "efficiency").best.penalties
        assert (Constraint.FIXED_POINT_BESIDE in {penalty.constraint for penalty in penalties}) is lost


def test_where_there_is_no_gait(thesis_map: Cells) -> None:
    objective = Objective(thesis_map[45, 0.15][0], "stability")
    before = objective.best
    nowhere = objective((0.0064, 0.0234, 0.0001))
    assert nowhere.gait is None
    assert nowhere.total >= 32.0
    outside = objective((-0.001, 0.01, 0.01))
    assert [penalty.constraint for penalty in outside.penalties] == [
        Constraint.ACTUATION_LEAST,
        Constraint.FIXED_POINT,
    ]
    assert objective.best is before
    assert objective.evaluations == 3


def test_distance_from_a_fixed_point() -> None:
    assert missing_fixed_point(1e-12) == 0.0
    assert missing_fixed_point(0.0) == 0.0
    assert missing_fixed_point(1e-8) == pytest.approx(2.0)


def test_unknown_goals(thesis_map: Cells) -> None:
    with pytest.raises(ValueError, match="goal = 'beauty'"):
        Objective(thesis_map[45, 0.15][0], "beauty")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="of = 'some'"):
        Objective(thesis_map[45, 0.15][0], "stability", "some")  # type: ignore[arg-type]
