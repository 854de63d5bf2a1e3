"""The nonlinear programme whose solution is the best actuation."""

import math
from itertools import combinations

import numpy as np
import pytest

from legspring import Animal, Gait
from legspring.actuated import Map
from legspring.kernel.circle import characteristic, inside
from legspring.kernel.walker import Floats
from legspring.objective import Goal, Objective
from legspring.programme import Programme, steps_taken
from tests.conftest import Cells

RANDOM = np.random.default_rng(7).normal
CASES = [("stability", "complete"), ("stability", "reduced"), ("efficiency", "complete")]


def random_polynomials(degree: int, count: int = 300) -> list[Floats]:
    """Return coefficients with real and complex zeros, in and outside the unit circle."""
    return [np.array(np.poly(RANDOM(size=(degree, degree)) / math.sqrt(degree))[1:], float) for _ in range(count)]


def largest_zero(c: Floats) -> float:
    return float(np.max(np.abs(np.roots([1.0, *c]))))


@pytest.mark.parametrize("n", [1, 2, 4])
def test_characteristic_polynomials(n: int) -> None:
    matrices = RANDOM(size=(20, n, n))
    assert characteristic(matrices) == pytest.approx(np.array([np.poly(matrix)[1:] for matrix in matrices]))


@pytest.mark.parametrize("degree", [2, 4])
def test_conditions_of_a_circle_are_products_of_the_zeros(degree: int) -> None:
    for c in random_polynomials(degree):
        t = 0.3 + abs(RANDOM())
        z = np.roots([1.0, *c]) / t
        pairs = np.prod([1.0 - a * b for a, b in combinations(z, 2)])
        expected = t * np.array([np.prod(1.0 - z), np.prod(1.0 + z), pairs])
        assert inside(c, t)[0] == pytest.approx(expected.real, rel=1e-6, abs=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize("degree", [2, 4])
def test_a_shrinking_circle_meets_the_first_zero_where_a_condition_first_fails(degree: int) -> None:
    for c in random_polynomials(degree):
        largest = largest_zero(c)
        for factor in (1.0 + 1e-6, 1.01, 1.3, 3.0, 100.0):
            assert np.all(inside(c, factor * largest)[0] > 0.0)
        assert np.min(inside(c, largest)[0]) == pytest.approx(0.0, abs=1e-7 * largest)
        assert np.min(inside(c, (1.0 - 1e-6) * largest)[0]) < 0.0


def test_two_zeros_are_inside_just_where_all_conditions_hold() -> None:
    verdicts = []
    for c in random_polynomials(2):
        verdicts.append(largest_zero(c) < 1.0)
        assert np.all(inside(c, 1.0)[0] > 0.0) == verdicts[-1]
    assert 50 < sum(verdicts) < 250


def test_four_zeros_may_be_outside_unnoticed_only_if_several_are() -> None:
    # What is met on the way in is seen, but two pairs of zeros too many make up for each other.
    assert np.all(inside(np.array(np.poly([2.0, 3.0, 0.4, 0.1])[1:], float), 1.0)[0] > 0.0)
    for c in random_polynomials(4):
        outside = int(np.sum(np.abs(np.roots([1.0, *c])) > 1.0))
        if outside == 0:
            assert np.all(inside(c, 1.0)[0] > 0.0)
        if outside == 1:
            assert np.any(inside(c, 1.0)[0] < 0.0)


@pytest.mark.parametrize("degree", [2, 4])
def test_derivatives_of_the_conditions_of_a_circle(degree: int) -> None:
    h = 1e-6
    for c in random_polynomials(degree, 20):
        t = 0.5 + abs(RANDOM())
        _, by_c, by_t = inside(c, t)
        size = np.abs(by_c).max() + np.abs(by_t).max()
        assert by_t == pytest.approx((inside(c, t + h)[0] - inside(c, t - h)[0]) / (2 * h), abs=1e-7 * size)
        for column, step in enumerate(h * np.eye(degree)):
            slope = (inside(c + step, t)[0] - inside(c - step, t)[0]) / (2 * h)
            assert by_c[:, column] == pytest.approx(slope, abs=1e-7 * size)


def test_steps_taken_are_all_that_newton_takes() -> None:
    residual, jacobian = RANDOM(size=4), RANDOM(size=(4, 7))
    along = steps_taken(residual, jacobian)
    assert along.T @ along == pytest.approx(np.eye(4))
    for factor in (0.0, 0.3, 1.0):
        x = np.linalg.lstsq(jacobian, -factor * residual)[0] + steps_taken(0.0 * residual, jacobian) @ RANDOM(size=3)
        assert along @ (along.T @ x) == pytest.approx(x)
    assert steps_taken(0.0 * residual, jacobian).shape == (7, 3)


def programme_near(gait: Gait, goal: Goal, of: Map) -> tuple[Programme, Floats]:
    """Return a programme, and variables near a gait, but not at it."""
    objective = Objective(gait.animal, gait.slope, gait.heading, gait.family, goal, of)
    programme, z = Programme(objective), objective.actuated.problem.z_of(gait)
    x = programme.start(gait.actuation / objective.actuated.lengths * [1.01, 0.99, 1.0], z, z + 0.01)
    assert 1e-3 < np.abs(programme.equations(x)).max() < 0.1
    return programme, x


@pytest.fixture
def late(thesis_map: Cells) -> Gait:
    """Return a gait whose middle legs are later than they should be."""
    return thesis_map[10, 0.15][0]


@pytest.mark.parametrize(("goal", "of"), CASES)
def test_derivatives_of_the_equations(late: Gait, goal: Goal, of: Map) -> None:
    programme, x = programme_near(late, goal, of)
    by, h = programme.equations_by(x), 1e-5
    assert by.shape == (8, 21)
    for column, step in enumerate(h * np.eye(len(x))):
        slope = (programme.equations(x + step) - programme.equations(x - step)) / (2.0 * h)
        assert by[:, column] == pytest.approx(slope, rel=1e-5, abs=1e-5)


@pytest.mark.parametrize(("goal", "of"), CASES)
def test_derivatives_of_the_margins_along_the_steps_taken(late: Gait, goal: Goal, of: Map) -> None:
    programme, x = programme_near(late, goal, of)
    by, h, n = programme.margins_by(x), 1e-5, programme.z.stop
    point = programme.point(x)
    assert point is not None
    along = np.zeros((len(x), 4))
    along[:n] = steps_taken(point.left[0], point.by[0])
    others = np.eye(len(x))[:, programme.t :]
    for step in np.hstack([along, others]).T:
        slope = (programme.margins(x + h * step) - programme.margins(x - h * step)) / (2.0 * h)
        assert by @ step == pytest.approx(slope, rel=2e-4, abs=2e-4)


@pytest.mark.parametrize(("goal", "of"), CASES)
def test_a_start_keeps_all_margins(late: Gait, goal: Goal, of: Map) -> None:
    programme, x = programme_near(late, goal, of)
    assert np.all(programme.margins(x) > -1e-9)
    score = programme.objective.alone(x[programme.u], x[programme.z])
    assert score is not None and score.penalties
    assert np.sum(x[programme.t :]) == pytest.approx(score.total, abs=1e-6)


@pytest.mark.parametrize(("goal", "of"), CASES)
def test_a_minimised_programme_fulfils_its_equations_and_margins(late: Gait, goal: Goal, of: Map) -> None:
    programme, start = programme_near(late, goal, of)
    x, message = programme.minimise(start)
    # A search has twenty iterations; some need two more starts from where they ended.
    for _ in range(3):
        x, message = programme.minimise(x)
    assert message == "converged"
    assert np.abs(programme.equations(x)).max() < 1e-5
    assert programme.margins(x).min() > -1e-5
    assert np.all((programme.bounds[:, 0] <= x) & (x <= programme.bounds[:, 1]))
    score = programme.objective(x[programme.u], x[programme.z], x[programme.beside])
    assert score.total == pytest.approx(np.sum(x[programme.t :]), abs=1e-4)
    assert score.total < np.sum(start[programme.t :]) - 0.05


def test_the_least_actuation_that_is_good_enough(late: Gait) -> None:
    programme, start = programme_near(late, "efficiency", "complete")
    x, _ = programme.minimise(start)
    most = 0.02 + np.sum(x[programme.t :])
    least, _ = programme.minimise(x, most)
    assert np.sum(least[programme.t :]) < most + 1e-5
    assert np.abs(programme.equations(least)).max() < 1e-5
    assert programme.margins(least).min() > -1e-5
    assert np.sum(least[programme.u] ** 2) < np.sum(x[programme.u] ** 2) - 1e-3


def test_nothing_to_evaluate_is_no_error(roach: Animal) -> None:
    stiff = roach.replace(stiffness=1e9)
    for goal, of in CASES:
        programme = Programme(Objective(stiff, 0.0, 0.15, "A", goal, of))  # type: ignore[arg-type]
        x = programme.start(np.full(3, 0.5), np.array([1.0, 0.2, 0.1, -0.6]))
        assert programme.point(x) is None
        assert programme.equations(x).shape == programme.equations_by(x).shape[:1]
        assert programme.margins(x).shape == programme.margins_by(x).shape[:1]
        assert programme.equations(x).min() > 100.0 and programme.margins(x).max() < -100.0


def test_a_gait_within_all_constraints_starts_at_its_measure(thesis_map: Cells) -> None:
    gait = thesis_map[45, 0.15][0]
    for goal, of, value in (
        ("stability", "reduced", gait.reduced_eigenvalue),
        ("stability", "complete", abs(gait.multipliers[0])),
        ("efficiency", "complete", gait.transport_cost),
    ):
        objective = Objective(gait.animal, gait.slope, gait.heading, gait.family, goal, of)  # type: ignore[arg-type]
        programme = Programme(objective)
        x = programme.start(gait.actuation / objective.actuated.lengths, objective.actuated.problem.z_of(gait))
        assert x[programme.t] == pytest.approx(value, abs=1e-7)
        assert x[programme.slack] == pytest.approx(0.0)


def test_a_point_off_the_equations_is_moved_onto_them(late: Gait) -> None:
    programme, start = programme_near(late, "stability", "reduced")
    x, _ = programme.minimise(start)
    n = programme.beside.stop
    for change in 1e-3 * np.random.default_rng(4).uniform(-1.0, 1.0, (5, n)):
        off = x.copy()
        off[:n] = np.clip(off[:n] + change, *programme.bounds[:n].T)
        back = programme.restored(off)
        assert np.abs(programme.equations(off)).max() > 1e-5
        assert np.abs(programme.equations(back)).max() < 1e-8
        # By no more than it takes, and not beyond the bounds.
        assert np.linalg.norm(back - off) < 2.0 * np.linalg.norm(off - x)
        assert np.all((programme.bounds[:, 0] <= back) & (back <= programme.bounds[:, 1]))


@pytest.mark.parametrize("degree", [1, 3, 5, 6])
def test_other_degrees_are_refused(degree: int) -> None:
    with pytest.raises(ValueError, match="2 or 4 coefficients"):
        inside(np.full(degree, 0.1), 1.0)
