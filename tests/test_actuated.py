"""Gaits with their actuation free, against the gaits themselves."""

import math

import numpy as np
import pytest

from legspring import Animal, Gait, search_gaits
from legspring.actuated import GOAL, Actuated
from legspring.gait import Invalid
from legspring.kernel.walker import Floats
from legspring.layout import TIGHT
from legspring.measures.stability import multipliers
from legspring.returnmap import complete_map, reduced_map
from tests.conftest import Cells

Z = np.array([1.03, 0.2, 0.1, -0.6])
U = np.array([0.55, 0.45, 0.5])


def seen_from(gait: Gait) -> tuple[Actuated, Floats]:
    """Return the actuated of a gait's family and cell, and the gait as a candidate."""
    actuated = Actuated(gait.animal, gait.slope, gait.heading, gait.family)
    return actuated, np.concatenate([gait.actuation / actuated.lengths, actuated.problem.z_of(gait)])


@pytest.fixture
def actuated(roach: Animal) -> Actuated:
    return Actuated(roach, math.radians(60), 0.15, "B")


def test_derivatives_of_the_conditions(actuated: Actuated) -> None:
    here = actuated.conditions(U, Z[None])
    assert here is not None
    x, h = np.concatenate([U, Z]), 1e-5
    for column, step in enumerate(h * np.eye(7)):
        points = ((x + change)[:3] for change in (step, -step)), (x + step, x - step)
        ahead, behind = (actuated.conditions(u, whole[None, 3:]) for u, whole in zip(*points, strict=True))
        assert ahead is not None and behind is not None
        assert here[1][0, :, column] == pytest.approx((ahead[0][0] - behind[0][0]) / (2.0 * h), rel=1e-5, abs=1e-6)


def test_conditions_are_those_that_a_problem_solves(actuated: Actuated) -> None:
    found = actuated.solve(np.array([U, [0.9, 0.2, 0.7]]), np.array([Z, Z]))
    for ratio, z, residual, squares in zip((U, [0.9, 0.2, 0.7]), found.z, found.residuals, found.squares, strict=True):
        there = actuated.conditions(np.array(ratio), z[None])
        assert there is not None
        assert np.max(np.abs(there[0])) == pytest.approx(residual, rel=1e-6, abs=1e-12)
        assert np.sum(there[0] ** 2) == pytest.approx(squares, rel=1e-6, abs=1e-12)
    # A gait at the one actuation, none near at the other.
    assert found.residuals[0] < GOAL < 1e-3 < found.residuals[1]


def test_what_cannot_be_simulated_has_no_conditions(roach: Animal) -> None:
    actuated = Actuated(roach.replace(stiffness=1e9), 0.0, 0.15, "A")
    assert actuated.conditions(U, Z[None]) is None
    seen = actuated.measure(np.concatenate([U, Z]), "complete")
    assert not seen.is_gait[0]
    assert np.all(np.isnan(seen.jacobians)) and np.all(np.isnan(seen.angles[:, :, 1]))


@pytest.mark.parametrize("cell", [(0, 0.2), (15, 0.3), (75, 0.15)])
def test_jacobians_are_those_of_the_return_maps(thesis_map: Cells, cell: tuple[float, float]) -> None:
    for gait in thesis_map[cell]:
        actuated, candidate = seen_from(gait)
        speed, length = gait.system.desired_speed, gait.system.step_length
        for which, what, units in (
            (reduced_map, "reduced", [speed, 1.0]),
            (complete_map, "complete", [speed, 1.0, length, length]),
        ):
            _, jacobian = which(gait.system, gait.point, accuracy=TIGHT)
            seen = actuated.measure(candidate, what).jacobians[0]  # type: ignore[arg-type]
            assert seen == pytest.approx(jacobian * np.array(units) / np.array(units)[:, None], abs=1e-7)
        assert np.abs(multipliers(seen)) == pytest.approx(np.abs(gait.multipliers), abs=1e-6)


def test_costs_angles_and_liftoffs_are_those_of_gaits(thesis_map: Cells) -> None:
    for cell in ((5, 0.15), (20, 0.3), (90, 0.45)):
        for gait in thesis_map[cell]:
            actuated, candidate = seen_from(gait)
            assert actuated.measure(candidate, "cost").cost == pytest.approx([gait.transport_cost], abs=1e-8)
            # At lift-off the lengths are equal: the angle between them follows from their rates in the time series.
            angles = actuated.measure(candidate, "ends").angles[0]
            assert angles[:, 1] == pytest.approx([liftoff_angle(gait, pair) for pair in range(3)], abs=0.05)


def liftoff_angle(gait: Gait, pair: int) -> float:
    """Angle (deg) between length and force-free length at lift-off, from the ends of their time series."""
    moment = gait.liftoff[pair] * gait.system.step_duration
    run = gait.simulate(strides=1).isel(leg=gait.first_legs[pair])
    rows = np.flatnonzero((run.time.values < moment) & (run.time.values > 0.0))[-5:]
    rates = [
        np.polyval(np.polyder(np.polyfit(run.time.values[rows] - moment, series.values[rows], 3)), 0.0)
        for series in (run.leg_length, run.free_length)
    ]
    return abs(math.degrees(math.atan(rates[0]) - math.atan(rates[1])))


def test_many_candidates_are_looked_at_as_one_by_one(actuated: Actuated) -> None:
    candidates = np.random.default_rng(2).uniform(
        [0.2] * 3 + [0.8] + [-1.0] * 3, [0.9] * 3 + [1.2] + [1.0] * 3, (20, 7)
    )
    together = actuated.measure(candidates, "cost")
    for row, candidate in enumerate(candidates):
        alone = actuated.measure(candidate, "cost")
        for name in ("angles", "is_gait", "cost"):
            np.testing.assert_array_equal(getattr(alone, name)[0], getattr(together, name)[row])


def test_valid_gaits_are_gaits(thesis_map: Cells) -> None:
    for gaits in thesis_map.values():
        for gait in gaits:
            actuated, candidate = seen_from(gait)
            assert actuated.measure(candidate, "ends").is_gait[0]


def test_rejected_solutions_are_none(roach: Animal) -> None:
    reasons = set()
    for slope_deg, heading in ((0, 0.15), (20, 0.05), (45, 0.15), (60, 0.3), (80, 0.4)):
        for rejection in search_gaits(roach, slope_deg=slope_deg, heading=heading).rejections:
            actuated, candidate = seen_from(rejection.solution)
            if rejection.reason != Invalid.IDLE:
                assert not actuated.measure(candidate, "ends").is_gait[0], str(rejection)
                reasons.add(rejection.reason)
    assert Invalid.WRONG_SIGN in reasons


LOW, HIGH = [0.2, 0.2, 0.2, 0.8, -1.8, -1.8, -1.8], [0.9, 0.9, 0.9, 1.2, 1.8, 1.8, 1.8]


def stride_of(actuated: Actuated, candidate: Floats) -> Gait:
    """A candidate in the form of a gait, whether it is one or not."""
    return Gait(
        animal=actuated.system.animal,
        slope=actuated.system.slope,
        heading=actuated.heading,
        family=actuated.family,
        speed=candidate[3] * actuated.system.desired_speed,
        phase=tuple(candidate[4:]),
        actuation=tuple(candidate[:3] * actuated.lengths),
        residual=math.nan,
    )


def test_solutions_are_judged_alike(actuated: Actuated) -> None:
    """What is_gait says of strides that close is what Gait.invalid says, but for idle legs."""
    starts, reasons = np.random.default_rng(3).uniform(LOW, HIGH, (400, 7)), set()
    found = actuated.solve(starts[:, :3], starts[:, 3:])
    closed = np.concatenate([starts[:, :3], found.z], axis=1)[found.residuals < GOAL]
    for candidate, verdict in zip(closed, actuated.measure(closed, "ends").is_gait, strict=True):
        wrong = stride_of(actuated, candidate).invalid()
        if wrong is None or wrong[0] != Invalid.IDLE:
            assert verdict == (wrong is None or wrong[0] == Invalid.DEPARTS), wrong
        reasons.add(wrong and wrong[0])
    assert {None, Invalid.WRONG_SIGN, Invalid.NO_LIFTOFF} <= reasons


def test_what_begins_with_other_legs_down_than_it_leaves_down_is_no_gait(actuated: Actuated) -> None:
    candidates = np.random.default_rng(3).uniform(LOW, HIGH, (200, 7))
    wrong = [stride_of(actuated, candidate).invalid() for candidate in candidates]
    others = np.array([found is not None and found[0] == Invalid.OLD_LEGS for found in wrong])
    assert np.sum(others) > 5
    assert not np.any(actuated.measure(candidates[others], "ends").is_gait)


def test_beside_is_the_same_at_another_heading(actuated: Actuated) -> None:
    other = actuated.beside(0.2)
    assert (other.heading, other.family, other.system) == (0.2, "B", actuated.system)
    here, there = actuated.conditions(U, Z[None]), other.conditions(U, Z[None])
    assert here is not None and there is not None
    assert there[0][0, 1] != pytest.approx(here[0][0, 1], abs=1e-3)


def test_bodies_that_yaw_are_refused(roach: Animal) -> None:
    with pytest.raises(ValueError, match="yaw held"):
        Actuated(roach.replace(yaw="free", inertia=2.04e-7), 0.5, 0.15, "B")
    with pytest.raises(ValueError, match="heading = 2"):
        Actuated(roach, 0.5, 2.0, "B")


@pytest.mark.parametrize("change", [{"length_law": "l0 - ldev*sin(pi*t + phi)"}, {"damping": 0.01}, {"stance": 0.8}])
def test_legs_with_other_rules_are_refused(roach: Animal, change: dict[str, object]) -> None:
    """The constraints of Table 3.1 are about the sinusoid and zero force."""
    with pytest.raises(ValueError, match="must have legs without length_law, stance and damping"):
        Actuated(roach.replace(**change), 0.5, 0.15, "B")
