"""The penalised objective."""

import math

import numpy as np
import pytest

from legspring import Animal, Gait
from legspring.actuated import Map
from legspring.constraints import Constraint
from legspring.kernel.walker import Floats
from legspring.objective import Goal, Objective
from legspring.solve import gait_near
from tests.conftest import Cells


def around(gait: Gait, goal: Goal, of: Map = "complete") -> tuple[Objective, Floats, Floats]:
    """Return the objective of a gait's family and cell, and the gait's actuation and unknowns."""
    objective = Objective(gait.animal, gait.slope, gait.heading, gait.family, goal, of)
    return objective, gait.actuation / objective.actuated.lengths, objective.actuated.problem.z_of(gait)


def test_an_unconstrained_gait_scores_its_measure(thesis_map: Cells) -> None:
    gait = thesis_map[45, 0.15][0]
    for goal, of, value in (
        ("stability", "reduced", gait.reduced_eigenvalue),
        ("stability", "complete", abs(gait.multipliers[0])),
        ("efficiency", "complete", gait.transport_cost),
    ):
        objective, actuation, z = around(gait, goal, of)  # type: ignore[arg-type]
        score = objective(actuation, z + 0.01)
        assert score.penalties == ()
        assert score.total == score.value == pytest.approx(value, abs=1e-8)
        assert score.unknowns == pytest.approx(z, abs=1e-8)
        found = objective.gait(score)
        assert found is not None
        assert found.phase == pytest.approx(gait.phase, abs=1e-9)


def test_crossing_angles_are_those_of_the_time_series(thesis_map: Cells) -> None:
    gait = thesis_map[15, 0.15][0]
    objective, actuation, z = around(gait, "stability")
    angles = objective.actuated.measure(np.concatenate([actuation, z]), "ends").angles[0]
    run = gait.simulate(strides=1)
    for pair, leg in enumerate(gait.first_legs):
        length, free = run.leg_length.values[:, leg], run.free_length.values[:, leg]
        stance = np.flatnonzero(~np.isnan(length))
        stance = stance[: np.append(np.flatnonzero(np.diff(stance) > 1) + 1, len(stance))[0]]
        time = run.time.values
        ends = []
        for rows, moment in ((stance[:5], 0.0), (stance[-5:], gait.liftoff[pair] * gait.system.step_duration)):
            slopes = [
                np.polyval(np.polyder(np.polyfit(time[rows] - moment, series[rows], 3)), 0.0)
                for series in (length, free)
            ]
            ends.append(math.degrees(abs(math.atan(slopes[0]) - math.atan(slopes[1]))))
        assert angles[pair] == pytest.approx(ends, abs=0.05)


def test_legs_that_hardly_part_are_penalised(thesis_map: Cells) -> None:
    objective, actuation, z = around(thesis_map[15, 0.25][0], "stability")
    (penalty,) = objective(actuation, z).penalties
    assert (penalty.constraint, penalty.pair) == (Constraint.ANGLE_TOUCHDOWN, "B")
    assert penalty.amount == pytest.approx(0.05 * (10.0 - 2.3285), abs=1e-5)


def test_gaits_at_the_edge_do_not_survive_a_larger_heading(thesis_map: Cells) -> None:
    for cell, lost in (((50, 0.45), True), ((45, 0.15), False)):
        objective, actuation, z = around(thesis_map[cell][0], "efficiency")
        score = objective(actuation, z)
        amounts = {penalty.constraint: penalty.amount for penalty in score.penalties}
        assert (Constraint.FIXED_POINT_BESIDE in amounts) is lost
        assert (score.beside is None) is lost
        assert amounts.get(Constraint.FIXED_POINT_BESIDE, 0.5) >= 0.5


def test_the_fixed_point_beside_is_one(thesis_map: Cells) -> None:
    gait = thesis_map[45, 0.15][0]
    objective, actuation, z = around(gait, "efficiency")
    beside = objective(actuation, z).beside
    assert beside is not None
    problem = Objective(gait.animal, gait.slope, 1.05 * gait.heading, gait.family, "efficiency").actuated.problem
    assert problem.system.magnitudes == pytest.approx(gait.actuation)
    fixed = gait_near(problem, beside)
    assert fixed is not None
    assert problem.z_of(fixed) == pytest.approx(beside, abs=1e-8)


def test_where_there_is_no_gait(thesis_map: Cells) -> None:
    objective, _, z = around(thesis_map[45, 0.15][0], "stability")
    nowhere = objective([0.2, 0.9, 0.005], z)
    assert nowhere.unknowns is None and nowhere.value == 0.0
    assert nowhere.total >= 32.0
    assert objective.gait(nowhere) is None and objective.active(nowhere) == ()
    outside = objective([-0.03, 0.4, 0.5], z)
    assert [penalty.constraint for penalty in outside.penalties] == [
        Constraint.ACTUATION_LEAST,
        Constraint.FIXED_POINT,
    ]
    assert objective.evaluations == 2


def test_a_solution_that_is_no_gait_has_no_score(thesis_map: Cells) -> None:
    objective, actuation, z = around(thesis_map[45, 0.15][0], "stability")
    for change in ([0.0, 0.0, 0.0, math.pi], [0.0, 1.5, 0.0, 0.0]):
        assert objective.alone(actuation, z + change) is None
        assert objective.totals(np.concatenate([actuation, z + change])[None])[0] == math.inf


@pytest.mark.parametrize(
    ("goal", "of"), [("stability", "complete"), ("stability", "reduced"), ("efficiency", "reduced")]
)
def test_totals_are_those_of_single_calls(roach: Animal, goal: Goal, of: Map) -> None:
    objective = Objective(roach, math.radians(30), 0.35, "FB", goal, of)
    # Any stride has a total, whether or not it closes.
    low, high = [0.2, 0.2, 0.2, 0.8, -2.0, -1.7, -1.9], [0.9, 0.9, 0.9, 1.2, 1.4, 0.5, 0.5]
    candidates = np.random.default_rng(1).uniform(low, high, (300, 7))
    totals = objective.totals(candidates)
    scores = [objective.alone(row[:3], row[3:]) for row in candidates]
    assert totals == pytest.approx([math.inf if score is None else score.total for score in scores], abs=1e-12)
    assert 50 < np.sum(np.isfinite(totals)) < 250
    kinds = {penalty.constraint for score in scores if score is not None for penalty in score.penalties}
    assert kinds == set(Constraint) - {
        Constraint.ACTUATION_LEAST,
        Constraint.ACTUATION_MOST,
        Constraint.FIXED_POINT,
        Constraint.FIXED_POINT_BESIDE,
    }


def test_a_call_adds_the_fixed_point_beside(thesis_map: Cells) -> None:
    for cell in ((30, 0.35), (50, 0.45), (15, 0.25)):
        objective, actuation, z = around(thesis_map[cell][0], "efficiency")
        score = objective(actuation, z)
        beside = sum(p.amount for p in score.penalties if p.constraint == Constraint.FIXED_POINT_BESIDE)
        total = objective.totals(np.concatenate([actuation, z])[None])[0]
        assert score.total - beside == pytest.approx(total, abs=1e-8)


def test_constraints_that_bind(thesis_map: Cells) -> None:
    for cell, active in (
        ((45, 0.15), ()),
        ((15, 0.25), ("B: length and force-free length part clearly at touch-down",)),
        ((45, 0.0), ("M: the phase is at most 60 deg",)),
        ((50, 0.45), ("there is a fixed point at 1.05 times the heading, too",)),
    ):
        objective, actuation, z = around(thesis_map[cell][0], "stability")
        assert objective.active(objective(actuation, z)) == active


def test_bounds_of_the_actuation_bind_when_they_are_reached(thesis_map: Cells) -> None:
    objective, _, z = around(thesis_map[60, 0.15][0], "stability")
    for ratio, active in (
        ((0.5, 0.3, 0.5), ()),
        ((0.6, 0.22, 0.6), ()),
        ((0.655, 0.2005, 0.644), ("M: the actuation is at least 0.2 l0",)),
        ((0.9, 0.47, 0.51), ("F: the actuation is at most 0.9 l0",)),
    ):
        score = objective(ratio, z)
        assert objective.active(score) == active
        assert score.unknowns is not None
        z = score.unknowns


def test_nothing_is_better_than_the_floor(roach: Animal, thesis_map: Cells) -> None:
    assert Objective(roach, math.radians(30), 0.15, "B", "efficiency").floor == pytest.approx(0.5)
    assert Objective(roach, math.radians(30), 0.15, "B", "stability").floor == 0.0
    for (slope, heading), gaits in thesis_map.items():
        for gait in gaits:
            floor = Objective(roach, math.radians(slope), heading, gait.family, "efficiency").floor
            assert gait.transport_cost > floor - 1e-9


def test_unknown_goals(roach: Animal) -> None:
    with pytest.raises(ValueError, match="objective = 'beauty'"):
        Objective(roach, 0.5, 0.15, "B", "beauty")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="map = 'some'"):
        Objective(roach, 0.5, 0.15, "B", "stability", "some")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="constraints = 'none'"):
        Objective(roach, 0.5, 0.15, "B", "stability", constraints="none")
    with pytest.raises(ValueError, match="'X'"):
        Objective(roach, 0.5, 0.15, "X", "stability")
    with pytest.raises(ValueError, match="actuation"):
        Objective(roach, 0.5, 0.15, "B", "stability")([0.1, 0.2], np.ones(4))


def test_a_gait_beside_a_fold_is_approached_step_by_step(roach: Animal) -> None:
    """From the gait itself, the fixed point beside it is too far to be found."""
    objective = Objective(roach, math.radians(15), 0.15, "FB", "efficiency", "reduced")
    actuation = np.array([0.3705, 0.4779, 0.3998])
    score = objective(actuation, np.array([1.043, 1.2399, 0.5583, -1.2214]))
    assert score.beside is None and score.total > 2.0
    found = objective.approached(score)
    assert found.beside is not None and found.total < 0.8
    residual = objective.beside.conditions(actuation, found.beside[None])
    assert residual is not None and np.max(np.abs(residual[0])) < 1e-9
    # There is nothing to do any more; nor is there where there is no gait.
    assert objective.approached(found) is found
    none = objective(actuation, np.array([1.0, 3.0, 3.0, 3.0]))
    assert objective.approached(none) is none
