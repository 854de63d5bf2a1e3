"""Limits of an optimised gait, and what it costs to pass them."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from legspring.constraints import LIMITS, Constraint, Constraints, Price, named_constraints

RULES = Constraints(
    actuation=(0.1, 0.6),
    phase=(-1.0, 0.5),
    angle=5.0,
    beside=(0.01, 0.002),
    digits=8.0,
    prices={constraint: Price(0.0, 1.0 + n, 2.0) for n, constraint in enumerate(Constraint)},
)


def test_one_candidate_is_a_row_of_many() -> None:
    random = np.random.default_rng(0).uniform
    u, phases, angles = random(0.0, 1.0, (50, 3)), random(-2.0, 2.0, (50, 3)), random(-10.0, 20.0, (50, 3, 2))
    for signed in (True, False):
        excess = RULES.excess(u, phases, angles, signed=signed)
        penalties = RULES.penalties(excess)
        assert excess.shape == penalties.shape == (50, 3, len(LIMITS))
        assert np.array_equal(penalties > 0.0, excess > 0.0)
        for n in range(50):
            alone = RULES.excess(u[n], phases[n], angles[n], signed=signed)
            assert np.array_equal(alone, excess[n]) and np.array_equal(RULES.penalties(alone), penalties[n])
            late, touchdown, liftoff = (excess[n][:, place] for place in (2, 4, 5))
            ends = RULES.rates[4:] * np.column_stack([touchdown, liftoff])
            assert RULES.soft(alone) == pytest.approx(np.concatenate([RULES.rates[2] * late, ends.ravel()]))


def test_the_sign_of_an_angle() -> None:
    angles = np.array([[7.0, -7.0], [4.0, -4.0]])
    away, least = (RULES.excess([0.3, 0.3], [0.0, 0.0], angles, signed=signed)[:, 4:] for signed in (True, False))
    assert away == pytest.approx(np.array([[-2.0, 12.0], [1.0, 9.0]]))
    assert least == pytest.approx(np.array([[-2.0, -2.0], [1.0, 1.0]]))


def test_what_is_not_known_costs_nothing() -> None:
    nothing = np.full((2, 2), np.nan)
    amounts = RULES.penalties(RULES.excess([0.05, 0.3], nothing[0], nothing, signed=True))
    assert amounts.sum() == amounts[0, 0] > 0.0


def test_words_have_the_numbers() -> None:
    assert RULES.words(Constraint.ACTUATION_MOST) == "the actuation is at most 0.6 l0"
    assert RULES.words(Constraint.PHASE_EARLIEST) == "the phase is at least -57.2958 deg"
    assert RULES.words(Constraint.FIXED_POINT) == "there is a gait"


def test_constraints_have_names() -> None:
    assert named_constraints(RULES) is RULES
    assert named_constraints("peterson2011").actuation == (0.2, 0.9)
    for name in ("none", None, ["peterson2011"]):
        with pytest.raises(ValueError, match="must be 'peterson2011'"):
            named_constraints(name)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"actuation": (0.6, 0.1)}, "actuation = "),
        ({"actuation": (0.2, 1.0)}, "actuation = "),
        ({"phase": (0.5, float("nan"))}, "phase = "),
        ({"angle": float("inf")}, "angle, digits = "),
        ({"beside": (-0.1, 0.0)}, "beside = "),
        ({"prices": {}}, "one for each constraint"),
        ({"prices": RULES.prices | {Constraint.FIXED_POINT: Price(-1.0, 1.0)}}, "price of FIXED_POINT"),
        ({"prices": RULES.prices | {Constraint.PHASE_LATEST: Price(1.0, 1.0)}}, "PHASE_LATEST: must have no jump"),
    ],
)
def test_what_is_no_constraint(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        replace(RULES, **change)
