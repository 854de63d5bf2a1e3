"""Gaits that nothing but the return map asks about: published numbers of templates, and laws that they must keep."""

import math

import numpy as np
import pytest

from legspring import Animal, Gait, find_gaits, load_animal, search_gaits
from legspring.asking import problem_for

COSINE = math.cos(math.radians(10.0))

TEMPLATES = [
    "climbing_template",
    "hexapod",
    "lateral_leg_spring",
    "lateral_leg_spring_point",
    "single_leg",
    "spring_loaded_inverted_pendulum",
]


def template(name: str) -> tuple[Animal, float]:
    """Return a template and a slope (deg) for it."""
    animal = load_animal(name)
    return animal, 45.0 if name == "single_leg" else 0.0 if animal.sagittal else animal.speed_law.domain_deg[0]


def pendulum(mass: float, stiffness: float, angle_deg: float, gravity: float, speed: float) -> Animal:
    """Return a spring-loaded inverted pendulum of length 1; angle from the vertical, speed at touch-down."""
    return load_animal("spring_loaded_inverted_pendulum").replace(
        mass=mass, stiffness=stiffness, angle_deg=angle_deg - 180.0, gravity=gravity, speed_law=speed
    )


def apex(gait: Gait) -> tuple[float, float]:
    """Return speed and height (m) at the highest point of the flight of a pendulum."""
    vx, vy = -gait.speed * math.sin(gait.heading), gait.speed * math.cos(gait.heading)
    leg = gait.animal.legs[0]
    return vx, leg.length * -math.cos(leg.angle) + vy**2 / (2.0 * gait.animal.gravity)


@pytest.mark.parametrize(
    ("mass", "stiffness", "angle_deg", "speed", "height", "multiplier"),
    [
        (1.0, 100.0, 10.0, 1.017450873821607, 1.182441943200824, 3.89595),
        (100.0, 10000.0, 5.0, 0.513806075894484, 1.238312718076982, None),
    ],
)
def test_published_apexes_of_the_inverted_pendulum(
    mass: float, stiffness: float, angle_deg: float, speed: float, height: float, multiplier: float | None
) -> None:
    fall = height - math.cos(math.radians(angle_deg))
    animal = pendulum(mass, stiffness, angle_deg, 10.0, math.hypot(speed, math.sqrt(20.0 * fall)))
    (gait,) = find_gaits(animal)
    assert apex(gait) == pytest.approx((speed, height), abs=1e-11)
    assert np.sort(np.abs(gait.multipliers))[0] == pytest.approx(1.0, abs=1e-9)
    if multiplier is not None:
        assert abs(gait.multipliers[0]) == pytest.approx(multiplier, abs=1e-5)


def test_a_stride_of_the_inverted_pendulum_in_time() -> None:
    """Up to the apex and down again, from touch-down to touch-down."""
    speed, height = 1.017450873821607, 1.182441943200824
    (gait,) = find_gaits(pendulum(1.0, 100.0, 10.0, 10.0, math.hypot(speed, math.sqrt(20.0 * (height - COSINE)))))
    run = gait.simulate(strides=2)
    above = run.position[:, 1] - run.foot[0, 0, 1]
    assert above.max() == pytest.approx(height, abs=1e-4)
    assert list(run.event_kind.values) == ["lift-off", "touch-down"] * 2
    assert run.time[-1] == run.event_time[-1] == pytest.approx(2.0 * gait.step_duration)


def test_published_pair_of_gaits_and_where_it_is_gone() -> None:
    """At an energy of 1.61 m g l0, 30 deg from the vertical: two gaits at k l0 = 10.7 m g, which meet before 10.8."""
    speed = math.sqrt(2.0 * (1.61 - math.cos(math.radians(30.0))))
    low, high = sorted(find_gaits(pendulum(1.0, 10.7, 30.0, 1.0, speed)), key=lambda gait: apex(gait)[1])
    for gait, height, multiplier in ((low, 0.876815, 0.488), (high, 0.916831, 1.346)):
        assert apex(gait)[1] == pytest.approx(height, abs=1e-6)
        assert np.prod(np.abs(gait.multipliers)) == pytest.approx(multiplier, abs=1e-3)
    assert all(apex(gait)[1] > 1.0 for gait in find_gaits(pendulum(1.0, 10.8, 30.0, 1.0, speed)))


def human_runs_stably(angle_deg: float) -> bool:
    """Whether a human runner who is at 5 m/s, 1 m high at the apex runs stably with this angle of the leg (to ground).

    Energy is that of the apex; the gait at this angle has an apex of its own.
    """
    tilt = 90.0 - angle_deg
    speed = math.sqrt(25.0 + 2.0 * 9.81 * (1.0 - math.cos(math.radians(tilt))))
    gaits = find_gaits(pendulum(80.0, 20e3, tilt, 9.81, speed), starts=32)
    return any(np.prod(np.abs(gait.multipliers)) < 1.0 for gait in gaits)


def test_published_window_of_landing_angles() -> None:
    """Stable from 66.306 to 68.854 deg."""
    assert [human_runs_stably(angle) for angle in (66.304, 66.308, 67.5, 68.852, 68.856)] == [
        False, True, True, True, False,
    ]  # fmt: skip


def test_the_lateral_leg_spring_conserves_energy_and_direction() -> None:
    (gait,) = find_gaits(load_animal("lateral_leg_spring"))
    sizes = np.abs(gait.multipliers)
    assert sizes[:2] == pytest.approx([1.0, 1.0], abs=1e-9)
    assert gait.liftoff == pytest.approx([1.0]) and gait.system.event_driven
    # Its steps are left and right by turns, and a stride leads straight ahead.
    across, ahead = gait.simulate(strides=1)["position"].values[-1]
    assert across == pytest.approx(0.0, abs=1e-12)
    assert ahead == pytest.approx(2.0 * gait.distance, rel=1e-9)
    assert 0.9 * gait.speed < gait.mean_speed < gait.speed


def test_the_lateral_leg_spring_is_stable_with_the_hip_behind_the_centre_of_mass() -> None:
    for place in (-0.004, -0.002, -0.001, 0.001, 0.002, 0.004):
        (gait,) = find_gaits(load_animal("lateral_leg_spring").replace(hip=(0.0, place)))
        sizes = np.abs(gait.multipliers)
        conserved = np.abs(gait.multipliers - 1.0) < 1e-6
        assert conserved.sum() == 2
        assert (sizes[~conserved].max() < 1.0) == (place < 0.0)


def test_a_hip_at_the_centre_of_mass_is_the_point_mass() -> None:
    rigid, point = load_animal("lateral_leg_spring").replace(hip=(0.0, 0.0)), load_animal("lateral_leg_spring_point")
    (one,) = find_gaits(point)
    # The body, which nothing turns, may be turned and turning already: that it does not is one case of many.
    problem = problem_for(rigid, 0.0, "P")
    assert problem.unknowns == ("heading",)
    (gait,) = find_gaits(rigid)
    assert (gait.yaw, gait.yaw_rate) == (0.0, 0.0)
    assert gait.heading == pytest.approx(one.heading, abs=1e-10)


def test_six_legs_at_one_hip_are_the_lateral_leg_spring() -> None:
    """Three legs of a third of the stiffness each are one; that the clock puts them down in time changes nothing."""
    (one,) = find_gaits(load_animal("lateral_leg_spring"))
    angles = {"hip": (0.0, -0.002), "angle_deg": (45.0, 45.0, 45.0), "offset": 0.0}
    many = load_animal("hexapod").replace(step_law=one.step_duration, **angles)
    (gait,) = find_gaits(many)
    assert gait.heading == pytest.approx(one.heading, abs=1e-7)
    assert gait.mean_speed == pytest.approx(one.mean_speed, rel=1e-7)
    forces = gait.peak_force.sum(axis=0) * many.body.mass, one.peak_force[0] * one.animal.body.mass
    assert forces[0] == pytest.approx(forces[1], rel=1e-6)


def test_the_climbing_template_climbs_as_published() -> None:
    """About 20 cm/s with a yaw of +-3 deg."""
    gait = min(find_gaits(load_animal("climbing_template")), key=lambda gait: gait.yaw_amplitude)
    assert 0.17 < gait.mean_speed < 0.22
    assert 2.0 < math.degrees(gait.yaw_amplitude) < 4.0
    # The arms pull all the time: they carry the weight.
    assert gait.peak_force[0, 1] > 1.0


@pytest.mark.parametrize("slope_deg", [20.0, 45.0, 90.0])
def test_a_leg_that_only_pushes_uphill_costs_the_least_there_can_be(slope_deg: float) -> None:
    """Eq. 4.1: the work against gravity."""
    (gait,) = find_gaits(load_animal("single_leg"), slope_deg=slope_deg)
    assert np.all(gait.work[:, 1] > -1e-9)
    assert gait.transport_cost == pytest.approx(math.sin(math.radians(slope_deg)), abs=1e-7)


@pytest.mark.parametrize("name", TEMPLATES)
def test_gaits_are_fixed_points_and_say_so(name: str) -> None:
    animal, slope_deg = template(name)
    gaits = find_gaits(animal, slope_deg=slope_deg)
    assert gaits
    for gait in gaits:
        assert gait.residual < 1e-10 and gait.drift < 1e-7
        problem = problem_for(gait.animal, gait.slope, gait.family)
        assert np.max(np.abs(problem.residual(problem.z_of(gait), accuracy=1e-13)[0])) < 1e-9
        run = gait.simulate(strides=2)
        velocity = run["velocity"].values
        assert np.hypot(*velocity[-1]) == pytest.approx(gait.speed, rel=1e-6)
        assert math.isnan(gait.reduced_eigenvalue)


@pytest.mark.parametrize("name", TEMPLATES)
def test_multipliers_are_those_of_finite_differences(name: str) -> None:
    animal, slope_deg = template(name)
    problem = problem_for(animal, math.radians(slope_deg), next(iter(animal.families)))
    gait = find_gaits(animal, slope_deg=slope_deg)[0]
    z, h = problem.z_of(gait), 1e-6
    exact = problem.residual(z, accuracy=1e-13)[1][0]
    steps = h * np.eye(problem.size)
    ahead, behind = (problem.residual(z + sign * steps, accuracy=1e-13)[0] for sign in (1.0, -1.0))
    assert exact == pytest.approx((ahead - behind).T / (2.0 * h), rel=1e-5, abs=2e-6)


def test_gaits_scale_with_size() -> None:
    """Twice as long and as fast, with the same mass and stiffness: the same gait, in the same time."""
    small = load_animal("lateral_leg_spring")
    law = {"level": 1.02, "vertical": 1.02, "domain_deg": (0, 0)}
    large = small.replace(length=0.034, hip=(0.0, -0.004), inertia=4.0 * 2.5e-7, speed_law=law)
    (one,), (other,) = find_gaits(small), find_gaits(large)
    assert other.heading == pytest.approx(one.heading, abs=1e-9)
    assert other.step_duration == pytest.approx(one.step_duration, rel=1e-9)
    assert np.abs(other.multipliers) == pytest.approx(np.abs(one.multipliers), abs=1e-7)


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("single_leg", {"slope_deg": 45.0, "heading": 0.1}, "heading = 0.1: must have 1 more free"),
        ("lateral_leg_spring", {"actuation": 0.001}, "actuation = 0.001: must be left out"),
        ("lateral_leg_spring", {"slope_deg": 10.0}, "slope"),
        ("single_leg", {}, "slope"),
        ("cockroach", {"slope_deg": 10.0}, "heading is missing"),
        ("hexapod", {"family": "B"}, "family = 'B'"),
        ("hexapod", {"starts": 0}, "starts = 0"),
    ],
)
def test_wrong_arguments(name: str, change: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        search_gaits(load_animal(name), **change)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["spring_loaded_inverted_pendulum", "lateral_leg_spring"])
def test_a_unit_of_time_changes_nothing(name: str) -> None:
    animal = load_animal(name)
    expected = find_gaits(animal)
    for unit in (10.0, 0.012, 0.004, 0.001):
        found = find_gaits(animal.replace(step_law=unit))
        assert len(found) == len(expected)
        for one, other in zip(found, expected, strict=True):
            for what in ("speed", "heading", "mean_speed", "step_duration", "yaw_rate", "transport_cost"):
                assert getattr(one, what) == pytest.approx(getattr(other, what), rel=1e-9, abs=1e-9)
            assert np.sort(np.abs(one.multipliers)) == pytest.approx(np.sort(np.abs(other.multipliers)), abs=1e-7)
            assert one.liftoff == pytest.approx(other.liftoff, rel=1e-9)


def test_three_gaits_of_stiff_arms() -> None:
    """A stride of theirs takes more steps of the integrator than a tape once had room for."""
    stiff = load_animal("climbing_template").replace(stiffness=300, damping=0.64)
    search = search_gaits(stiff)
    assert sorted(gait.mean_speed for gait in search.gaits) == pytest.approx([0.337, 0.551, 0.568], abs=5e-4)
    assert not search.rejections
