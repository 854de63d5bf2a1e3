"""Curves of gaits: where they bend, branch, lose what they are, and end."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import legspring as ls
from legspring import Animal, Gait, charts, load_animal
from legspring.continuation import Continuation
from legspring.curve import Tracer
from legspring.figures import draw_bifurcations
from legspring.footing import Reason
from legspring.gait import Invalid
from legspring.landmarks import Kind
from legspring.stretch import Stretch
from tests.oracle.periods import Period, largest_allowed


def values(curve: Continuation, kind: Kind) -> list[float]:
    return [one.value for one in curve.special if one.kind is kind]


def gait_at(animal: Animal, slope_deg: float, heading: float, branch: int = 0) -> Gait:
    return ls.find_gaits(animal, slope_deg=slope_deg, heading=heading)[branch]


@pytest.fixture(scope="module")
def steep(roach: Animal) -> Continuation:
    """Family B at 40 deg, from one branch over the fold to the other."""
    return ls.follow(gait_at(roach, 40, 0.4), "heading", within=(0.0, 0.6))


# Folds ------------------------------------------------------------------------------------------------------


def test_known_folds(roach: Animal, steep: Continuation) -> None:
    assert values(steep, Kind.FOLD) == pytest.approx([0.4382000525], abs=2e-10)
    flat = ls.follow(gait_at(roach, 15, 0.2), "heading", within=(0.0, 0.7))
    assert values(flat, Kind.FOLD) == pytest.approx([0.4761894947], abs=2e-10)
    fast = ls.follow(gait_at(roach, 30, 0.45, branch=1), "slope_deg", within=(0.0, 90.0))
    assert [one for one in values(fast, Kind.FOLD) if one > 31.5] == pytest.approx([31.6233465021], abs=1e-8)


def test_beyond_a_fold_the_curve_goes_on_to_the_other_branch(roach: Animal, steep: Continuation) -> None:
    both = ls.find_gaits(roach, slope_deg=40, heading=0.4)
    found = sorted(steep.at(0.4), key=lambda gait: gait.phase[2])
    assert [gait.speed for gait in found] == pytest.approx([gait.speed for gait in both], rel=1e-10)
    for mine, theirs in zip(found, both, strict=True):
        assert mine.phase == pytest.approx(theirs.phase, abs=1e-8)
        assert mine.multipliers == pytest.approx(theirs.multipliers, abs=1e-7)
        assert mine.invalid() is None


def test_a_fold_of_tuned_gaits_is_no_multiplier_of_one(steep: Continuation) -> None:
    (fold,) = (one for one in steep.special if one.kind is Kind.FOLD)
    assert np.max(np.abs(fold.gait.half_multipliers)) < 0.9
    assert not values(steep, Kind.BRANCHING)


def test_points_are_what_gaits_say_of_themselves(steep: Continuation) -> None:
    """Validity and multipliers as for any gait; and the motion comes back in an integration of another make."""
    for n in range(0, len(steep), 5):
        gait = steep.gaits[n]
        assert (gait.invalid() is None) == steep.valid[n]
        assert gait.multipliers == pytest.approx(steep.multipliers[n], abs=1e-9)
        if steep.valid[n]:
            assert Period(gait).departure() < largest_allowed(gait)


def test_what_varies_does_so_as_if_the_animal_had_been_changed(roach: Animal) -> None:
    gait = gait_at(roach, 45, 0.15)
    for name, value in (("F.stiffness", 1.8), ("mass", 0.0024), ("step_duration", 1.03 * gait.step_duration)):
        curve = ls.follow(gait, name, to=value)
        assert curve.ending.reason is Reason.ARRIVED and curve.values[-1] == value
        others = ls.find_gaits(roach.replace(**{name: value}), slope_deg=45, heading=0.15)
        assert min(abs(curve.gaits[-1].speed - one.speed) for one in others) < 1e-10
    slope = ls.follow(gait, "slope_deg", to=50)
    assert (
        min(abs(slope.gaits[-1].speed - one.speed) for one in ls.find_gaits(roach, slope_deg=50, heading=0.15)) < 1e-10
    )


def test_several_at_once(roach: Animal) -> None:
    gait = gait_at(roach, 45, 0.15)
    pairs = [f"{pair}.stiffness" for pair in roach.pairs]
    by_factor = ls.follow(gait, pairs, to=1.1)
    other = roach.replace(stiffness=1.65)
    by_way = ls.follow(gait, other, to=1.0)
    by_values = ls.follow(gait, dict.fromkeys(pairs, 1.65), to=1.0)
    speeds = [one.gaits[-1].speed for one in (by_factor, by_way, by_values)]
    assert speeds == pytest.approx([speeds[0]] * 3, rel=1e-12)
    assert min(abs(speeds[0] - one.speed) for one in ls.find_gaits(other, slope_deg=45, heading=0.15)) < 1e-10


# How they end ------------------------------------------------------------------------------------------------


def test_ends_have_reasons_and_legs(steep: Continuation) -> None:
    assert steep.beginning is not None and steep.beginning.reason is Reason.EDGE and steep.values[0] == 0.0
    assert (steep.ending.reason, steep.ending.leg) == (Reason.WINDOW, "BL")
    last = steep.special[-1]
    assert (last.kind, last.leg, last.value) == (Kind.WINDOW, "BL", steep.ending.value)
    assert last.gait.liftoff[2] == pytest.approx(0.02, abs=1e-7)
    assert last.gait.invalid() == (Invalid.IDLE, "BL")


def test_both_gaits_of_a_runner_end_at_the_same_places() -> None:
    """Soft legs let go in mid-stance; at the other end the foot comes down at a rate of zero, as seen from both."""
    curves = [ls.follow(gait, "stiffness") for gait in ls.find_gaits(load_animal("spring_loaded_inverted_pendulum"))]
    ends = [sorted((end.value, end.reason) for end in (one.ending, one.beginning) if end) for one in curves]
    assert [reason for _, reason in ends[0]] == [Reason.GRAZING_LIFTOFF, Reason.GRAZING_TOUCHDOWN]
    for (one, reason), (other, same) in zip(*ends, strict=True):
        assert one == pytest.approx(other, rel=1e-8)
        assert reason == same
    assert not any(one.special and Kind.NO_LIFTOFF in [mark.kind for mark in one.special] for one in curves)


def test_an_idle_leg_is_one_before_it_ends(steep: Continuation) -> None:
    """The curve goes on as a solution, and says so."""
    (idle,) = (one for one in steep.special if one.kind is Kind.IDLE)
    assert idle.leg == "BL"
    run = idle.gait.stride
    from legspring.measures.forces import peak_magnitude

    assert peak_magnitude(run, idle.gait.first_legs[2]) == pytest.approx(1e-3, rel=1e-8)
    before = [why for why, value in zip(steep.reasons, steep.values, strict=True) if value < idle.value]
    assert any("less than a thousandth" in why for why in before)


def test_events_change_places_smoothly(steep: Continuation) -> None:
    some = [one for one in steep.special if one.kind is Kind.SEQUENCE]
    assert len(some) == 7
    for one in some:
        around = steep.at(one.value - 1e-7) + steep.at(one.value + 1e-7)
        near = [gait for gait in around if abs(gait.speed - one.gait.speed) < 1e-5 * one.gait.speed]
        assert len({gait.events for gait in near}) > 1
        assert max(np.max(np.abs(gait.multipliers - one.gait.multipliers)) for gait in near) < 1e-4


def test_family_to_family_where_a_leg_is_idle(roach: Animal) -> None:
    """With it one gait reaches all families."""
    met: set[str] = set()
    waiting = [gait_at(roach, 15, 0.2)]
    while waiting:
        gait = waiting.pop()
        if gait.family in met:
            continue
        met.add(gait.family)
        for parameter, limits in (("heading", (0.0, 0.7)), ("slope_deg", (-30.0, 90.0))):
            curve = ls.follow(gait, parameter, within=limits)
            waiting += [other for one in curve.special if one.kind is Kind.WINDOW for other in one.switch()]
    assert set(roach.families) <= met


def test_the_point_mass_has_no_bifurcations_but_folds(roach: Animal) -> None:
    for slope, heading in ((15, 0.2), (45, 0.15), (70, 0.3)):
        for gait in ls.find_gaits(roach, slope_deg=slope, heading=heading):
            for parameter, limits in (("heading", (0.0, 0.7)), ("slope_deg", (-30.0, 90.0))):
                kinds = {one.kind for one in ls.follow(gait, parameter, within=limits).special}
                assert not kinds & {
                    Kind.PERIOD_DOUBLING,
                    Kind.NEIMARK_SACKER,
                    Kind.SYMMETRY_BREAKING,
                    Kind.BRANCHING,
                }


def test_a_kink_of_a_law(roach: Animal) -> None:
    """The step law is constant above 0.35 m/s, the speed on the level: the curve has a corner there."""
    curve = ls.follow(gait_at(roach, 25, 0.45), "slope_deg", within=(-10.0, 30.0))
    kinks = values(curve, Kind.KINK)
    assert kinks and kinks == [0.0] * len(kinks)
    n = int(np.argmin(np.abs(curve.values)))
    assert curve.values[n] == 0.0 and curve.gaits[n].speed == pytest.approx(curve.gaits[n + 1].speed, rel=1e-11)


# From the side --------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def runner() -> Animal:
    return load_animal("spring_loaded_inverted_pendulum").replace(angle_deg=-158.0)


def test_the_inverted_pendulum_is_stable_between_a_fold_and_a_period_doubling(runner: Animal) -> None:
    """66.306 and 68.854 deg."""
    gait = ls.find_gaits(runner, energy=1784.8)[0]
    curve = ls.follow(gait, "angle", within=(math.radians(-162.0), math.radians(-155.0)))
    (fold,), (flip,) = values(curve, Kind.FOLD), values(curve, Kind.PERIOD_DOUBLING)
    angles = [math.degrees(-value) - 90.0 for value in (fold, flip)]
    assert angles == pytest.approx([66.3055, 68.8536], abs=1e-4)
    stable = np.degrees(-curve.values[curve.stable & curve.valid]) - 90.0
    assert stable.min() > angles[0] and stable.max() < angles[1]


def test_gaits_that_take_two_strides(runner: Animal) -> None:
    gait = ls.find_gaits(runner, energy=1784.8)[1]
    curve = ls.follow(gait, "angle", to=math.radians(-159.5))
    (flip,) = (one for one in curve.special if one.kind is Kind.PERIOD_DOUBLING)
    (double,) = flip.switch()
    assert double.strides == 2 and double.invalid() is None
    begin, middle, end = double.stride.states[:, 2:4]
    assert np.max(np.abs(middle - begin)) > 0.05 and end == pytest.approx(begin, abs=1e-9)
    further = ls.follow(double, "angle", within=(math.radians(-160.0), math.radians(-158.0)), most_points=60)
    # Both halves of the curve are the same gaits, begun one stride later: it turns where it was born.
    assert min(abs(one - flip.value) for one in values(further, Kind.FOLD)) < 1e-7


def test_walking_gaits_meet_where_they_become_alike() -> None:
    """The gait that is symmetric in time and the one that is not, followed in the angle."""
    even, odd = ls.find_gaits(load_animal("walker"), energy=816.0)
    (one,), (other,) = (values(ls.follow(gait, "angle"), Kind.BRANCHING) for gait in (even, odd))
    assert one == pytest.approx(other, abs=1e-8)
    (meeting,) = (s for s in ls.follow(odd, "angle").special if s.kind is Kind.BRANCHING)
    across = meeting.switch()
    assert len(across) == 2 and all(gait.invalid() is None for gait in across)
    # From the even gait's side: those that branch off are the odd ones.
    assert all(gait.energy == pytest.approx(816.0, rel=1e-9) for gait in across)


def test_a_limp_is_followed_from_the_gait_of_an_intact_animal(roach: Animal) -> None:
    """Its phases stay as they are; speed and heading are what they come to."""
    intact = gait_at(roach, 45, 0.15)
    curve = ls.follow(intact, "FL.stiffness", to=0.75)
    assert curve.ending.reason is Reason.ARRIVED
    gait = curve.gaits[-1]
    assert (gait.speed, gait.heading) == pytest.approx((0.258939, 0.105316), abs=1e-6)
    assert not gait.mirrored and gait.phase == pytest.approx(intact.phase, abs=1e-12)


# What is refused -------------------------------------------------------------------------------------------------


def test_errors_say_what_would_be_valid(roach: Animal) -> None:
    gait = gait_at(roach, 45, 0.15)
    for arguments, words in (
        (("speed",), "must be no coordinate of the start"),
        (("F.phase",), "must be no parameter that was free"),
        (("wings",), "must be one of"),
        ((7,), "must be a name, several names, values by name, or an animal"),
        ((roach,), "must be an animal that differs"),
    ):
        with pytest.raises(ValueError, match=words):
            ls.follow(gait, *arguments)
    with pytest.raises(ValueError, match="to = 45: must be another value"):
        ls.follow(gait, "slope_deg", to=45)
    with pytest.raises(ValueError, match=r"within = \(0, 10\): must hold the gait's value, 45"):
        ls.follow(gait, "slope_deg", within=(0, 10))
    with pytest.raises(ValueError, match="gait: must be one that a search has found"):
        ls.follow(replace(gait, origin=None), "slope_deg", to=50)


# What is kept ---------------------------------------------------------------------------------------------------


def test_a_curve_comes_back_from_its_file(steep: Continuation, tmp_path: Path) -> None:
    path = tmp_path / "curve.nc"
    steep.save(path)
    again = ls.load_curve(path)
    assert np.array_equal(again.values, steep.values) and np.array_equal(again.valid, steep.valid)
    assert [(one.kind, one.leg, one.after) for one in again.special] == [
        (one.kind, one.leg, one.after) for one in steep.special
    ]
    assert [one.value for one in again.special] == pytest.approx([one.value for one in steep.special], abs=1e-12)
    assert (again.ending, again.beginning) == (steep.ending, steep.beginning)
    # And goes on from there: its gaits can be followed.
    assert ls.follow(again.gaits[3], "slope_deg", to=41.0).ending.reason is Reason.ARRIVED
    with xr.open_dataset(path) as data:
        figure = draw_bifurcations(data.load(), "phase_B")
    assert len(figure.axes) == 3


@pytest.mark.parametrize("kill_after", [3, 40])
def test_a_run_that_is_stopped_goes_on_where_it_was(
    roach: Animal, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kill_after: int
) -> None:
    gait, path = gait_at(roach, 15, 0.2), tmp_path / "curve.nc"
    whole = ls.follow(gait, "heading", within=(0.0, 0.7))
    monkeypatch.setattr(charts, "SECONDS", 0.0)
    keep, count = charts.Shelf.note, 0

    def noting(shelf: charts.Shelf, stretches: list[Stretch]) -> None:
        nonlocal count
        keep(shelf, stretches)
        count += 1
        if count == kill_after:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(charts.Shelf, "note", noting)
        with pytest.raises(KeyboardInterrupt):
            ls.follow(gait, "heading", within=(0.0, 0.7), store=path)
    with pytest.raises(ValueError, match="must hold a curve of gaits that was followed to its end"):
        ls.load_curve(path)
    with pytest.raises(ValueError, match="must be a new file, or one of the same curve"):
        ls.follow(gait, "heading", within=(0.0, 0.6), store=path)
    resumed = ls.follow(gait, "heading", within=(0.0, 0.7), store=path)
    assert np.array_equal(resumed.values, whole.values)
    assert [one.value for one in resumed.special] == [one.value for one in whole.special]
    # What is finished is read.
    monkeypatch.setattr(Tracer, "trace", None)
    assert np.array_equal(ls.follow(gait, "heading", within=(0.0, 0.7), store=path).values, whole.values)


@pytest.mark.parametrize(
    ("preset", "asked", "parameter", "within"),
    [
        ("injured_cockroach", {"slope_deg": 45}, "slope_deg", (30, 60)),
        ("cockroach_rigid", {"slope_deg": 30, "heading": 0.15}, "heading", (0.1, 0.3)),
        ("cockroach", {"slope_deg": 45, "heading": 0.15}, "F.offset", (0.0, 0.2)),
        ("walker", {"energy": 816.0}, "energy", (812.0, 830.0)),
        ("lateral_leg_spring", {}, "mass", (2e-3, 4e-3)),
        ("quadruped", {"speed": 4.75}, "mass", (19.0, 24.0)),
        ("centipede", {}, "gravity", (5.0, 15.0)),
    ],
)
def test_gaits_of_any_animal_are_what_another_integrator_says(
    preset: str, asked: dict[str, Any], parameter: str, within: tuple[float, float]
) -> None:
    """Along curves of all kinds: validity as of any gait, motions that come back, and multipliers to 1e-6."""
    gait = ls.find_gaits(load_animal(preset), **asked)[0]
    curve = ls.follow(gait, parameter, within=within)
    rows = range(0, len(curve), max(1, len(curve) // 4))
    assert len(curve) >= 3
    for n in rows:
        one = curve.gaits[n]
        assert (one.invalid() is None) == curve.valid[n]
        trivial = len(one.multipliers) - curve.multipliers.shape[1]
        kept = sorted(np.abs(one.multipliers))
        assert all(min(abs(value - other) for other in kept) < 1e-7 for value in np.abs(curve.multipliers[n]))
        assert trivial == len(one.conserved)
        if curve.valid[n]:
            period = Period(one)
            assert period.departure() < largest_allowed(one)
            if n == rows[len(rows) // 2]:
                theirs = np.sort(np.abs(np.linalg.eigvals(period.jacobian())))
                assert np.sort(np.abs(one.half_multipliers)) == pytest.approx(theirs, abs=1e-6)


def test_a_fold_of_a_passive_animal_is_no_branch_point() -> None:
    gait = ls.find_gaits(load_animal("quadruped"), speed=4.75)[0]
    curve = ls.follow(gait, "mass", within=(15.0, 22.0))
    assert len(values(curve, Kind.FOLD)) == 1 and not values(curve, Kind.BRANCHING)


def test_a_body_that_yaws_on_the_level_has_no_events_of_its_own(rigid: Animal) -> None:
    """All directions are alike there, so that a multiplier is -1."""
    gait = ls.find_gaits(rigid, slope_deg=5, heading=0.15)[0]
    curve = ls.follow(gait, "slope_deg", within=(-5.0, 10.0))
    assert 0.0 in curve.values and not values(curve, Kind.SYMMETRY_BREAKING)


def test_what_keeps_its_energy_has_no_gaits_beside_the_level(runner: Animal) -> None:
    gait = ls.find_gaits(runner, energy=1784.8)[0]
    for name in ("slope_deg", "L.damping"):
        with pytest.raises(ValueError, match="must be another one; what the animal keeps"):
            ls.follow(gait, name, to=1.0)


def test_multipliers_are_withheld_where_sides_differ(steep: Continuation) -> None:
    by_kind = {one.kind: one for one in steep.special}
    assert by_kind[Kind.SEQUENCE].withheld == "" and np.all(np.isfinite(by_kind[Kind.SEQUENCE].multipliers))
    end = by_kind[Kind.WINDOW]
    assert end.withheld and np.all(np.isnan(end.multipliers))


def test_multipliers_of_one_of_a_body_that_yaws(rigid: Animal) -> None:
    """Its gaits are tuned: stability changes there, and no other curve crosses."""
    gait = ls.find_gaits(rigid, slope_deg=30, heading=0.15)[0]
    curve = ls.follow(gait, "slope_deg", within=(20.0, 90.0))
    some = [one for one in curve.special if one.kind is Kind.PLUS_ONE]
    assert sorted(one.value for one in some) == pytest.approx([34.3839645, 58.6652267], abs=1e-6)
    for one in some:
        assert np.min(np.abs(one.gait.half_multipliers - 1.0)) < 1e-8 and not one.switch()
    assert not values(curve, Kind.BRANCHING)
