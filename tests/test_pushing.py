"""The largest push that a gait survives."""

import math

import numpy as np
import pytest
import xarray as xr

import legspring as ls
from legspring import Animal, Gait
from legspring.figures import draw_pushes
from legspring.flow import flow

SIDEWAYS = 1.0 / 16.0
"""Moment of the thesis's push, as a part of the stride."""


@pytest.fixture(scope="module")
def flat(roach: Animal) -> Gait:
    return ls.find_gaits(roach, slope_deg=15, heading=0.2)[0]


@pytest.fixture(scope="module")
def found(flat: Gait) -> xr.Dataset:
    return ls.pushes(flat, directions=8, moments=4, impulses=[0.5 * n for n in range(1, 11)])


@pytest.mark.parametrize("impulse", [-2.0, -0.5, 0.3, 0.8, 1.5, 3.0])
def test_the_sideways_push_is_that_of_a_recovery(flat: Gait, impulse: float) -> None:
    recovery = flat.recover(impulse)
    direction = 0.0 if impulse > 0.0 else math.pi
    one = ls.pushes(flat, directions=[direction], moments=[SIDEWAYS], impulses=[abs(impulse)])
    steps = float(one["recovery_steps"].item())
    assert recovery.recovered == math.isfinite(steps)
    assert recovery.steps is None or steps == recovery.steps
    assert bool(one["lost"].isnull()) == recovery.recovered


def test_limits_lie_between_what_is_survived_and_what_is_not(flat: Gait, found: xr.Dataset) -> None:
    """Of pushes of their own, a little smaller and larger than the limits."""
    rows = np.argwhere(found["lost"].notnull().values)
    assert len(rows) and found["lost"].isnull().any()
    assert np.all((found["lost"] - found["survived"]).values[tuple(rows.T)] == pytest.approx(0.5 / 2**6))
    for row, column in rows[:4]:
        at = {"directions": [float(found["direction"][row])], "moments": [float(found["moment"][column])]}
        sizes = [float(found[name][row, column]) for name in ("survived", "lost")]
        back = ls.pushes(flat, **at, impulses=sizes)["recovery_steps"].values.ravel()  # type: ignore[arg-type]
        assert np.isfinite(back).tolist() == [True, False]


def test_a_push_gives_what_it_says(flat: Gait) -> None:
    """The velocity after a push differs by the impulse, but for what legs have done meanwhile."""
    from legspring.pushing import Trial

    trial = Trial(flat, 1e-5, 100, 1)
    direction, moment, impulse = 1.0, 0.2, 0.3
    knots = np.zeros((3, 3))
    knots[:, 0] = moment * trial.stride + trial.times
    knots[1, 1:] = impulse * trial.peak * np.array([math.cos(direction), math.sin(direction)])
    system = flat.system
    pushed, free = (flow(system, flat.point, steps=2, push=push, record=True) for push in (knots, np.zeros((0, 3))))
    change = [run.samples(knots[-1:, 0] + 1e-9).states[0, 2:4] for run in (pushed, free)]
    expected = impulse * system.desired_speed * np.array([math.cos(direction), math.sin(direction)])
    assert change[0] - change[1] == pytest.approx(expected, rel=1e-3)


def test_workers_change_nothing(flat: Gait) -> None:
    one, two = (ls.pushes(flat, directions=3, moments=2, impulses=[1.0, 3.0], workers=n) for n in (1, 2))
    assert np.array_equal(one["recovery_steps"], two["recovery_steps"], equal_nan=True)
    assert np.array_equal(one["survived"], two["survived"])


def test_the_figure_shows_the_limits(found: xr.Dataset) -> None:
    figure = draw_pushes(found, 1.0)
    values = figure.axes[0].collections[0].get_array()
    assert np.array_equal(np.asarray(values), found["survived"])
    with pytest.raises(ValueError, match=r"impulse = 0\.7: must be one of 0\.5, 1"):
        draw_pushes(found, 0.7)


def test_errors_say_what_would_be_valid(flat: Gait) -> None:
    rigid = ls.find_gaits(ls.load_animal("cockroach_rigid"), slope_deg=45, heading=0.15)
    unstable = next(gait for gait in rigid if abs(gait.multipliers[0]) > 1.0)
    with pytest.raises(ValueError, match="gait: must be stable, to come back"):
        ls.pushes(unstable)
    for options, words in (
        ({"impulses": [0.0, 1.0]}, "must be above 0"),
        ({"moments": [0.5, 1.0]}, "must be parts of a stride"),
        ({"directions": 0}, "directions = 0: must be"),
        ({"duration": -1.0}, "duration = -1"),
    ):
        with pytest.raises(ValueError, match=words):
            ls.pushes(flat, **options)
    runner = ls.find_gaits(ls.load_animal("spring_loaded_inverted_pendulum"))[1]
    with pytest.raises(ValueError, match="must have legs that do work"):
        ls.pushes(runner)
