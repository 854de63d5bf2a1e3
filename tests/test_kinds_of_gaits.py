"""Whatever repeats itself: limping, waves, walking, bounding; against published numbers, and identities."""

import math
from functools import partial
from typing import Any

import numpy as np
import pytest

import legspring as ls
from legspring import Animal, Gait, load_animal
from legspring.asking import contact_sets, earlier_by_events, problem_for
from legspring.gait import Invalid
from legspring.starts import contacts_met

PLACE: dict[str, Any] = {"slope_deg": 45, "heading": 0.15}


@pytest.fixture(scope="module")
def intact(roach: Animal) -> Gait:
    return ls.find_gaits(roach, **PLACE)[0]


@pytest.fixture(scope="module")
def given(roach: Animal, intact: Gait) -> Animal:
    """The cockroach with the phases of its gait."""
    return roach.replace(phase=intact.phase)


# Limping ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("injury", "speed", "heading", "velocity", "multipliers"),
    [
        ("gone", 0.2464310, 0.0732260, (0.06714, 0.17845), (0.26092, 0.05353)),
        ("soft", 0.258939, 0.105316, (0.03471, 0.22764), (0.22838, 0.03172)),
    ],
)
def test_a_cockroach_that_limps(
    given: Animal, injury: str, speed: float, heading: float, velocity: tuple[float, float], multipliers: Any
) -> None:
    """Its front left leg gone, or half as stiff; the phases are those of the intact gait."""
    limping = given.without("FL") if injury == "gone" else given.replace(**{"FL.stiffness": 0.75})
    assert limping.pairs == ("F", "M", "B") and not limping.mirrored
    (gait,) = [one for one in ls.find_gaits(limping, slope_deg=45) if abs(one.heading - heading) < 0.01]
    assert (gait.speed, gait.heading) == pytest.approx((speed, heading), abs=1e-6)
    x, y = gait.stride.states[-1, :2] / gait.stride.times[-1]
    assert (x, y) == pytest.approx(velocity, abs=1e-5)
    assert (gait.lateral_drift, gait.mean_speed) == pytest.approx((x, math.hypot(x, y)), rel=1e-9)
    assert np.abs(gait.multipliers[:2]) == pytest.approx(multipliers, abs=1e-5)
    assert not gait.mirrored and gait.half_multipliers == pytest.approx(gait.multipliers)


def test_the_preset_that_limps_is_that_one(given: Animal) -> None:
    one, other = (ls.find_gaits(a, slope_deg=45) for a in (load_animal("injured_cockroach"), given.without("FL")))
    assert [g.speed for g in one] == pytest.approx([g.speed for g in other], abs=1e-9)


def test_legs_that_differ_by_nothing_do_not_limp(roach: Animal, intact: Gait, given: Animal) -> None:
    """The gait of the symmetric animal is found as one that closes after a stride, and counted once."""
    both = ls.find_gaits(given, slope_deg=45, mirrored=False)
    (same,) = [gait for gait in both if abs(gait.heading - 0.15) < 1e-6]
    assert same.mirrored
    assert same.multipliers == pytest.approx(intact.multipliers, abs=1e-9)
    as_stride = problem_for(given, math.radians(45), "B", mirrored=False)
    values, by = as_stride.residual(as_stride.z_of(same), accuracy=1e-12)
    assert np.max(np.abs(values)) < 1e-10
    # What is left of the conditions grows by the multipliers of a stride, less 1.
    units = np.array([as_stride.unit(name) for name in as_stride.conditions])
    found = np.linalg.eigvals(units[:, None] * by[0] / units) + 1.0
    assert sorted(np.abs(found)) == pytest.approx(sorted(np.abs(same.multipliers)), abs=1e-8)


def test_a_pair_that_is_gone_leaves_its_families(roach: Animal) -> None:
    four = roach.without("F")
    assert four.pairs == ("M", "B") and dict(four.families) == {"MB": ("M", "B"), "B": ("B",)}
    with pytest.raises(ls.ModelError, match="'X': must be a pair"):
        roach.without("X")
    with pytest.raises(ls.ModelError, match="legs are missing"):
        roach.without("F", "M", "B")


# Any number of pairs, any offsets -----------------------------------------------------------------------------


def halved(roach: Animal, **changes: Any) -> Animal:
    """The cockroach with each middle leg made of two, of half the stiffness."""
    middle = [leg.model_copy(update={"stiffness": 0.75}) for leg in roach.legs if leg.pair == "M"]
    others = [leg.model_copy(update={"name": leg.name.replace("M", "N"), "pair": "N"} | changes) for leg in middle]
    legs = [*(leg for leg in roach.legs if leg.pair != "M"), *middle, *others]
    return Animal(**dict(roach) | {"legs": tuple(legs), "families": {"B": ("B",)}})


def test_four_pairs_of_which_two_are_one(roach: Animal, intact: Gait) -> None:
    four = halved(roach, phase=intact.phase[1])
    assert four.pairs == ("F", "B", "M", "N")
    gait = min(ls.find_gaits(four, **PLACE), key=lambda one: abs(one.speed - intact.speed))
    assert gait.speed == pytest.approx(intact.speed, rel=1e-10)
    f, b, m, n = gait.phase
    assert (f, m, b) == pytest.approx(intact.phase, abs=1e-9) and n == intact.phase[1]
    assert gait.multipliers == pytest.approx(intact.multipliers, abs=1e-9)
    with pytest.raises(ValueError, match=r"4 unknowns of its own .* must have 1 more phase given, .*, or 1 more of"):
        ls.find_gaits(halved(roach), **PLACE)
    # Or one more thing is asked for.
    assert ls.find_gaits(halved(roach), **PLACE, speed=intact.speed)


@pytest.mark.parametrize("known", [("F",), ("F", "M"), ("F", "M", "B")])
def test_fewer_phases_open_leave_more_to_the_gait(roach: Animal, intact: Gait, known: tuple[str, ...]) -> None:
    """With two the sideways displacement, with one the heading, too, with none the speed as well."""
    phases = dict(zip(roach.pairs, intact.phase, strict=True))
    some = roach.replace(**{f"{pair}.phase": phases[pair] for pair in known})
    heading: dict[str, Any] = {"heading": 0.15} if len(known) == 1 else {}
    gait = min(ls.find_gaits(some, slope_deg=45, **heading), key=lambda one: abs(one.speed - intact.speed))
    assert (gait.speed, gait.heading) == pytest.approx((intact.speed, 0.15), abs=1e-8)
    assert gait.phase == pytest.approx(intact.phase, abs=1e-7) and abs(gait.lateral_drift) < 1e-8


def test_one_leg_out_of_thirty(roach: Animal) -> None:
    """A wave along thirty pairs; the middle ones are alike, so that every other one may be taken for two."""
    many = wave(30)
    (gait,) = ls.find_gaits(many, slope_deg=0, starts=6)
    down = gait.contacts or ()
    instants = {round(leg.offset, 9) for leg in many.legs if leg.name in down}
    # A leg of the first half of the pairs is put down with the other one of a pair of the second half.
    assert len(down) > 20 and 2 * len(instants) == len(down)
    assert len(gait.multipliers) == 2 + 2 * len(instants)
    assert abs(gait.multipliers[0]) < 1.0


def wave(pairs: int, lag: float | None = None) -> Animal:
    """Return a centipede with so many pairs."""
    seven = load_animal("centipede")
    first = seven.legs[0]
    legs = []
    for n in range(pairs):
        offset = (n * (2.0 / pairs if lag is None else lag)) % 2.0
        stiffness = 0.1 * 7 / pairs
        one = first.model_copy(update={"name": f"L{n}", "pair": f"{n}", "offset": offset, "stiffness": stiffness})
        legs += [one, one.mirrored(f"R{n}")]
    return Animal(**dict(seven) | {"legs": tuple(legs)})


def test_a_wave_that_runs_the_other_way_is_the_same_for_a_point_mass() -> None:
    """All legs are at one hip: only the times matter at which they are put down."""
    (one,), (other,) = (ls.find_gaits(wave(7, lag)) for lag in (2.0 / 7.0, 12.0 / 7.0))
    assert one.mean_speed == pytest.approx(other.mean_speed, rel=1e-9)
    assert np.abs(one.multipliers[:4]) == pytest.approx(np.abs(other.multipliers[:4]), abs=1e-8)
    assert one.phase_lag[2] == pytest.approx(1.0 / 7.0) and other.phase_lag[2] == pytest.approx(6.0 / 7.0)


def test_a_wave_may_begin_anywhere() -> None:
    """Later by a seventh of a step for all: the same gait, seen at another time."""
    (one,) = ls.find_gaits(wave(7))
    legs = tuple(leg.model_copy(update={"offset": (leg.offset + 0.1) % 2.0}) for leg in wave(7).legs)
    (other,) = ls.find_gaits(Animal(**dict(wave(7)) | {"legs": legs}))
    assert one.mean_speed == pytest.approx(other.mean_speed, rel=1e-9)
    assert np.abs(one.multipliers[:4]) == pytest.approx(np.abs(other.multipliers[:4]), abs=1e-8)


def test_the_centipede_is_stable_because_its_legs_pull() -> None:
    pulling = load_animal("centipede")
    pushing = pulling.replace(function="push", phase=0.5, families={"P": pulling.pairs})
    assert abs(ls.find_gaits(pulling)[0].multipliers[0]) < 0.3
    assert all(abs(gait.multipliers[0]) > 1.0 for gait in ls.find_gaits(pushing))


# From the side ------------------------------------------------------------------------------------------------


def test_walking() -> None:
    """The symmetric gait of Geyer et al. (2006), and one that is asymmetric in time."""
    even, odd = ls.find_gaits(load_animal("walker"), energy=816.0)
    assert even.energy == pytest.approx(816.0, rel=1e-12) and odd.energy == pytest.approx(816.0, rel=1e-12)
    assert (even.mean_speed, even.distance) == pytest.approx((1.15680, 0.514236), abs=5e-6)
    assert odd.mean_speed == pytest.approx(1.126778, abs=1e-6)
    for gait, height, expected in (
        (even, 0.970835, (1.0, 0.80399 + 0.55686j, 0.80399 - 0.55686j)),
        (odd, 0.96695, (1.43126, 1.0, 0.53609)),
    ):
        assert height_over_foot(gait) == pytest.approx(height, abs=1e-5)
        assert gait.half_multipliers == pytest.approx(expected, abs=1e-5)
        # Both legs are down at times, one always is.
        assert np.all(gait.duty_factor > 0.5) and gait.missing["apex_height"] == "no flight begins in a step"
        assert gait.contacts == ("R",) and gait.phase_lag == pytest.approx([0.0, 0.5])


def height_over_foot(gait: Gait) -> float:
    """Height of the centre of mass when the leg put down first is vertical, for the last time."""
    run = gait.simulate(strides=1)
    foot, place = run.foot.values[:, 0], run.position.values
    across = place[:, 0] - foot[:, 0]
    (n,) = np.flatnonzero((across[:-1] < 0.0) & (across[1:] >= 0.0))
    times = np.linspace(run.time.values[n], run.time.values[n + 1], 400) / gait.system.step_duration
    fine = gait.stride.samples(times)
    nearest = int(np.argmin(np.abs(fine.states[:, 0] - fine.feet[:, 0, 0])))
    return float(fine.states[nearest, 1] - fine.feet[nearest, 0, 1])


def test_bounding() -> None:
    """4 m/s forward as the back legs are put down, of the two gaits that fall as fast the one that pitches more."""
    gaits = ls.find_gaits(load_animal("quadruped"), speed=math.hypot(4.0, 2.57283))
    gait = max(gaits, key=lambda one: one.yaw)
    course = gait.heading + gait.yaw
    assert (-gait.speed * math.sin(course), gait.speed * math.cos(course)) == pytest.approx((4.0, -2.57283), abs=2e-5)
    assert (gait.yaw, gait.yaw_rate) == pytest.approx((0.348914, 1.33038), abs=2e-5)
    assert gait.multipliers == pytest.approx((11.3512, -2.0012, 1.0, -0.0997), abs=1e-4)


def test_running_at_an_energy() -> None:
    """Apexes of the spring-loaded inverted pendulum; outside the window of angles there is none."""
    runner = load_animal("spring_loaded_inverted_pendulum")
    found = {gait.apex_height: gait for gait in ls.find_gaits(runner, energy=1784.8)}
    assert sorted(found) == pytest.approx([0.940267, 1.337686], abs=1e-6)
    for height, multiplier in ((0.940267, -0.16131), (1.337686, 1.68697)):
        gait = min(found.values(), key=lambda one: abs(one.apex_height - height))
        (other,) = [value for value in gait.multipliers if abs(value - 1.0) > 1e-6]
        assert other == pytest.approx(multiplier, abs=1e-5)
    search = ls.search_gaits(runner.replace(angle_deg=-156.25), energy=1784.8)
    assert not search.gaits and search.summary() == "96 starts: 96 stalled at a local minimum of the residuals"


def test_targets_and_what_is_let_go() -> None:
    runner = load_animal("spring_loaded_inverted_pendulum")
    (gait,) = ls.find_gaits(runner, apex_height=1.2)
    assert gait.apex_height == pytest.approx(1.2, rel=1e-12)
    fast = ls.find_gaits(runner, mean_speed=4.5)
    assert [one.mean_speed for one in fast] == pytest.approx([4.5, 4.5], rel=1e-12)
    both = ls.find_gaits(runner, energy=1784.8, apex_height=1.0, free=("L.angle",))
    for one in both:
        assert (one.energy, one.apex_height) == pytest.approx((1784.8, 1.0), rel=1e-10)
        assert one.animal.legs[0].angle != runner.legs[0].angle and one.invalid() is None
        # The animal that was found has this gait when it is asked for the energy alone.
        again = ls.find_gaits(one.animal, energy=1784.8)
        assert min(abs(other.apex_height - 1.0) for other in again) < 1e-9
    with pytest.raises(ValueError, match=r"apex_height = 1\.0: must be left out for an animal that is seen from above"):
        ls.find_gaits(load_animal("lateral_leg_spring"), apex_height=1.0)
    with pytest.raises(ValueError, match=r"lateral_drift = 0\.1: must be left out for an animal that is seen from the"):
        ls.find_gaits(runner, lateral_drift=0.1)
    with pytest.raises(ValueError, match=r"2 unknowns .* for 3 conditions .* must have 1 more free"):
        ls.find_gaits(runner, energy=1784.8, mean_speed=4.0)


def test_a_passive_animal_at_a_heading_has_a_speed_that_goes_with_it() -> None:
    spring = load_animal("lateral_leg_spring")
    (gait,) = ls.find_gaits(spring, heading=0.1)
    assert gait.heading == pytest.approx(0.1, rel=1e-12) and gait.speed != pytest.approx(0.51)
    (again,) = ls.find_gaits(spring, speed=gait.speed)
    assert again.heading == pytest.approx(0.1, abs=1e-9)
    (other,) = ls.find_gaits(spring, energy=gait.energy)
    assert other.speed == pytest.approx(gait.speed, rel=1e-9)


def test_a_parameter_that_is_free_takes_the_value_that_it_has_to(roach: Animal, intact: Gait) -> None:
    """The phases, the stiffness and the step duration of a gait, each found from the rest."""
    single = load_animal("single_leg")
    (gait,) = ls.find_gaits(single, slope_deg=45)
    (found,) = ls.find_gaits(
        single.replace(stiffness=0.97 * single.legs[0].stiffness),
        slope_deg=45,
        mean_speed=gait.mean_speed,
        free=("T.stiffness",),
    )
    assert found.animal.legs[0].stiffness == pytest.approx(single.legs[0].stiffness, rel=1e-9)
    given = roach.replace(phase=intact.phase, step_duration=1.02 * intact.step_duration)
    gaits = ls.find_gaits(given, slope_deg=45, family="B", heading=0.15, free=("step_duration",))
    assert min(abs(one.step_duration - intact.step_duration) for one in gaits) < 1e-9 * intact.step_duration


def test_rejections_say_how_many_and_why() -> None:
    legs = load_animal("lateral_leg_spring").replace(speed_law=0.3)
    search = ls.search_gaits(legs, slope_deg=3.0, starts=24)
    *lines, _ = search.summary().splitlines()
    assert all(line.startswith("rejected, family P: ") and " x " in line for line in lines)
    assert len(search.rejections) == sum(int(line.split(": ")[1].split(" x ")[0]) for line in lines)


def test_nothing_fixes_a_tuned_gait_whose_strides_may_differ_from_its_steps(roach: Animal) -> None:
    """Asked for no drift over a stride, steps that mirror one another may drift as they like: that is no gait."""
    search = ls.search_gaits(roach, **PLACE, mirrored=False, family="B")
    assert all(gait.mirrored for gait in search.gaits) and len(search.gaits) == 2
    assert Invalid.NOT_ISOLATED in {rejection.reason for rejection in search.rejections}


# On a slope ---------------------------------------------------------------------------------------------------


def test_a_slope_is_a_tilt_of_gravity() -> None:
    """On a slope of s, with gravity g, a stride is that on the level with g cos(s) and a pull backwards of g sin(s)."""
    runner, slope = load_animal("spring_loaded_inverted_pendulum"), math.radians(4.0)
    up = ls.simulate(runner, slope=slope, speed=5.2, heading=-1.66, strides=1)
    lighter = runner.replace(gravity=9.81 * math.cos(slope))
    level = ls.simulate(lighter, speed=5.2, heading=-1.66, strides=1)
    # Until the foot lifts off the two differ by little; in flight by just the pull.
    n = 5
    gap = up.velocity.values[:n, 0] - level.velocity.values[:n, 0]
    assert gap == pytest.approx(-9.81 * math.sin(slope) * up.time.values[:n], rel=0.05, abs=1e-9)


def driven(slope_deg: float) -> Gait:
    """Return the fast gait of a runner whose leg lengthens in stance, and whose damper takes the energy back."""
    runner = load_animal("spring_loaded_inverted_pendulum").replace(actuation=0.05, phase=-0.5, damping=60.0)
    return max(ls.find_gaits(runner, slope_deg=slope_deg), key=lambda one: one.mean_speed)


def test_legs_that_do_work_run_uphill_more_slowly() -> None:
    level, uphill = driven(0.0), driven(2.0)
    assert level.mean_speed > 1.5 * uphill.mean_speed > 6.0
    assert "energy" not in level.conserved and abs(uphill.multipliers[0]) < 1.0
    # What the legs do is the weight lifted.
    assert np.sum(uphill.work) == pytest.approx(math.sin(math.radians(2.0)), abs=1e-7)
    assert np.sum(level.work) == pytest.approx(0.0, abs=1e-7)


def test_of_many_feet_those_sets_are_looked_at_that_are_met() -> None:
    """Two to the power of seven sets would be too many; of two legs all are met that a walker's gaits have."""
    walker = load_animal("walker")
    ask = partial(problem_for, walker, 0.0, "P", {"energy": 816.0})
    assert set(contacts_met(lambda some: ask(contacts=some), ["R"])) == {(), ("R",)}
    leg = walker.legs[0].model_copy(update={"stiffness": 3500.0})
    hips = [(0.15 * n - 0.25, 0.0) for n in range(8)]
    legs = tuple(
        leg.model_copy(update={"name": f"L{n}", "pair": f"{n}", "hip": hip, "offset": 0.5 if n else 0.0})
        for n, hip in enumerate(hips)
    )
    body = {"body": {"mass": 80.0, "inertia": 12.0, "yaw": "free"}}
    many = Animal(**dict(walker) | body | {"legs": legs, "families": {"P": tuple(str(n) for n in range(8))}})
    assert contact_sets(many) is None
    names = earlier_by_events(many)
    some = contacts_met(lambda some: problem_for(many, 0.0, "P", contacts=some), names)
    assert some[0] == () and tuple(names) in some and 9 < len(some) <= 48 and len(set(some)) == len(some)
