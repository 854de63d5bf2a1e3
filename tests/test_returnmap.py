"""Return maps: their derivatives, and what they refuse."""

import math
from typing import Any

import numpy as np
import pytest

from legspring import Animal, find_gaits, load_animal
from legspring.flow import IntegrationError, flow, flows
from legspring.kernel.many import many, new_ends
from legspring.kernel.measure import leg_work
from legspring.kernel.walker import NO_TOUCHDOWN, OK, TAPE_FULL, TOUCHDOWN, new_tape, new_walker
from legspring.layout import TIGHT, System, slope_for
from legspring.returnmap import complete_map, reduced_map
from tests.conftest import Cells

PHASE = np.array([0.3, 0.6, -0.7])
START: dict[str, Any] = {"speed": 0.27, "heading": 0.15}


def differences(which: Any, system: System, p: np.ndarray, ways: np.ndarray, h: float) -> np.ndarray:
    """Derivatives of a map along some directions, by differences."""
    ends = [[which(system, p + sign * h * way, accuracy=1e-13)[0] for sign in (1.0, -1.0)] for way in ways]
    return np.array([(ahead - behind) / (2.0 * h) for ahead, behind in ends]).T


@pytest.mark.parametrize("cell", [(75, 0.15), (30, 0.3)])
def test_maps_have_the_derivatives_of_their_states(cell: tuple[float, float], thesis_map: Cells) -> None:
    gait = thesis_map[cell][0]
    for which, names in ((complete_map, ["speed", "heading", "Dx", "Dy"]), (reduced_map, ["speed", "heading"])):
        _, jacobian = which(gait.system, gait.point, accuracy=TIGHT)
        expected = differences(which, gait.system, gait.point, gait.system.along(names), 1e-6)
        assert jacobian == pytest.approx(expected, abs=1e-6 * np.max(np.abs(expected)))


def test_maps_of_a_body_that_yaws_have_the_derivatives_of_their_states(rigid_map: Cells) -> None:
    gait = rigid_map[60, 0.15][0]
    names = ["speed", "heading", "Dx", "Dy", "yaw", "yaw_rate", "turn"]
    ways = gait.system.along(names)
    # The old feet are those of a body that had the opposite yaw, and moved straight ahead.
    reduced = ways[[0, 1, 4, 5]] + np.outer([0, 0, 1, 0], 2.0 * ways[6])
    for which, along, size in ((complete_map, ways, 7), (reduced_map, reduced, 4)):
        _, jacobian = which(gait.system, gait.point, accuracy=TIGHT)
        assert jacobian.shape == (size, size)
        expected = differences(which, gait.system, gait.point, along, 1e-7)
        assert jacobian == pytest.approx(expected, rel=1e-5, abs=1e-6 * np.max(np.abs(expected)))


def test_a_body_that_yaws_has_a_larger_state(roach: Animal) -> None:
    free = roach.replace(yaw="free", inertia=2.04e-7)
    system = System(free, math.radians(45), "B")
    p = system.point(PHASE, **START, yaw=0.05, yaw_rate=1.0)
    state, jacobian = complete_map(system, p)
    assert jacobian.shape == (7, 7)
    # Hips at the centre: nothing turns the body.
    spin = 1.0 * system.step_duration
    assert state[4:] == pytest.approx([-(0.05 + spin), -1.0, -spin])
    state, jacobian = reduced_map(system, p)
    assert jacobian.shape == (4, 4)
    time = 2.0 * system.step_duration
    assert jacobian[2:] == pytest.approx(np.array([[0.0, 0.0, 1.0, time], [0.0, 0.0, 0.0, 1.0]]))


@pytest.mark.parametrize("direction", ["weight", "X.phase", "F.colour"])
def test_unknown_directions(roach: Animal, direction: str) -> None:
    system = System(roach, 0.0, "A")
    with pytest.raises(ValueError, match="must be"):
        flow(system, system.point(PHASE, **START), along=[direction])


def test_a_start_must_move(roach: Animal) -> None:
    with pytest.raises(ValueError, match="positive speed"):
        System(roach, 0.0, "A").point(PHASE, speed=0.0, heading=0.1)
    with pytest.raises(ValueError, match="steps = -1"):
        flow(System(roach, 0.0, "A"), System(roach, 0.0, "A").point(PHASE, **START), steps=-1)


def test_progress_is_that_of_the_velocity(roach: Animal) -> None:
    system = System(roach, 0.0, "A")
    run = flow(system, system.point(PHASE, **START), steps=3, record=True)
    assert run.states.shape == (4, 4)
    assert run.states[-1] == pytest.approx(run.state[:, 0])
    assert run.times == pytest.approx(system.step_duration * np.arange(4.0))
    assert run.states[0] == pytest.approx([0, 0, -0.27 * math.sin(0.15), 0.27 * math.cos(0.15)])


def test_derivatives_by_angles_of_pairs_with_any_offsets(roach: Animal) -> None:
    """The leg of a pair that is put down first keeps its sign, whenever that is."""
    offsets = {"F": 0.3, "M": 0.0, "B": 1.25}
    animal = roach.replace(offset=tuple(offsets.values()))
    assert [animal.legs[i].name for i in animal.first_legs] == ["FL", "MR", "BR"]
    slope, h = math.radians(60), 1e-5
    system = System(animal, slope, "B")
    p = system.point(PHASE, **START)
    y = flow(system, p, steps=2, along=[f"{pair}.angle" for pair in animal.pairs], accuracy=TIGHT).state
    for column, pair in enumerate(animal.pairs):
        here = animal.legs[animal.first_legs[column]].angle
        states = []
        for change in (h, -h):
            changed = System(animal.replace(**{f"{pair}.angle": here + change}), slope, "B")
            states.append(flow(changed, changed.point(PHASE, **START), steps=2, accuracy=1e-13).state[:, 0])
        difference = (states[0] - states[1]) / (2.0 * h)
        assert y[:, 1 + column] == pytest.approx(difference, rel=1e-6, abs=1e-6 * np.abs(difference).max())


def test_an_animal_with_a_leg_that_has_no_image_is_not_mirrored(roach: Animal) -> None:
    tail = roach.legs[2].model_copy(update={"name": "T", "pair": "T"})
    limping = roach.replace(legs=(*roach.legs, tail), families={"B": ("B", "T")})
    for animal, mirrored in ((roach, True), (limping, False)):
        system = System(animal, math.radians(45), "B")
        assert system.mirrored == mirrored
        p = system.point(np.resize(PHASE, len(animal.pairs)), **START)
        image, ends = complete_map(system, p)[0], flow(system, p, steps=system.period).states
        last = ends[-1, 0] - ends[-2, 0]
        assert image[2] == pytest.approx(-last if mirrored else last, abs=1e-15)


# Nothing is lost without a word ---------------------------------------------------------------------------


def test_a_recorded_stride_takes_as_many_steps_as_it_needs() -> None:
    stiff = load_animal("climbing_template").replace(stiffness=300.0, damping=0.64)
    system = System(stiff, math.pi / 2, "P")
    p = system.point(speed=0.17, heading=-0.413, displacement=(0.0032, 0.0187), yaw=0.06, yaw_rate=5.99)
    tape = flow(system, p, steps=2, record=True, accuracy=TIGHT).tape
    assert tape.counts[0] > 60 * 2 + 60
    assert tape.time[tape.counts[0]] == 2.0


def test_all_events_of_many_legs_are_recorded(roach: Animal) -> None:
    system = System(roach, 0.0, "B")
    p = system.point(PHASE, **START)
    leg = p[13:26] * np.where(np.isin(np.arange(13), (2, 4)), 0.05, 1.0)
    legs = np.repeat(leg[None], 60, axis=0)
    legs[:, 9] = np.arange(60) / 30.0
    many_legs, none = np.concatenate([p[:13], legs.ravel()]), np.zeros(60)
    touchdowns = {}
    for room in (20, 500):
        w = new_walker(-np.ones(60), none, none, none, np.zeros((0, 3)), 4, 0)
        tape, ends = new_tape(500, room, w), new_ends(1, 2, 0, w)
        ways = np.zeros((0, len(many_legs)))
        many(w, tape, many_legs[None], ways, np.zeros((0, 0, 3)), 2.0, 2, 1e-12, False, ends)
        touchdowns[room] = ends.status[0], int(np.count_nonzero(tape.events[: tape.counts[1], 2] == TOUCHDOWN))
    assert touchdowns[20][0] == TAPE_FULL
    assert touchdowns[500] == (OK, 60)


@pytest.mark.parametrize("name", ["spring_loaded_inverted_pendulum", "lateral_leg_spring"])
def test_nothing_depends_on_a_unit_of_time(name: str) -> None:
    animal = load_animal(name)
    states = []
    for unit in (10.0, 0.4, 0.05, 0.012, 0.004, 0.001):
        same = animal.replace(step_law=unit)
        system = System(same, slope_for(same, None, None), "P")
        hopping: dict[str, Any] = {"speed": 5.2, "heading": -1.66}
        swerving: dict[str, Any] = {"speed": 0.51, "heading": 0.08, "yaw_rate": -1.0}
        run = flow(system, system.point(**(hopping if "inverted" in name else swerving)), steps=2)
        states.append([run.times[-1], *run.state[:4, 0]])
    assert np.array(states) == pytest.approx(np.array(states[:1] * 6), rel=1e-9, abs=1e-10)


def test_the_gaits_do_not_depend_on_a_unit_of_time() -> None:
    animal = load_animal("spring_loaded_inverted_pendulum")
    found = [[gait.heading for gait in find_gaits(animal.replace(step_law=unit))] for unit in (0.4, 10.0, 0.012, 0.001)]
    assert len(found[0]) == 2
    for headings in found[1:]:
        assert headings == pytest.approx(found[0], abs=1e-9)


def test_what_never_touches_down_is_said_at_once() -> None:
    animal = load_animal("spring_loaded_inverted_pendulum")
    system = System(animal, 0.0, "P")
    p = system.point(speed=5.2, heading=-1.66)
    p[list(system.along(["gravity"])[0]).index(1.0)] = 0.0
    assert flows(system, p[None]).status[0] == NO_TOUCHDOWN
    with pytest.raises(IntegrationError, match="no leg touches down any more"):
        flow(system, p)


@pytest.mark.parametrize(("speed", "heading"), [(1.0, -1.6), (5.2, -2.9), (0.5, -3.0)])
def test_a_body_that_falls_to_the_ground_says_so(speed: float, heading: float) -> None:
    animal = load_animal("spring_loaded_inverted_pendulum")
    system = System(animal, 0.0, "P")
    with pytest.raises(IntegrationError, match="the body falls to the ground"):
        flow(system, system.point(speed=speed, heading=heading), steps=3)


# Many at once ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["cockroach", "climbing_template", "lateral_leg_spring", "cockroach_rigid"])
def test_many_are_as_each_alone(name: str) -> None:
    animal = load_animal(name)
    slope = slope_for(animal, None, None if animal.speed_law.domain_deg[0] == animal.speed_law.domain_deg[1] else 50.0)
    system, rng = System(animal, slope, next(iter(animal.families))), np.random.default_rng(2)
    start: dict[str, Any] = {"speed": system.desired_speed, "heading": 0.1}
    points = np.repeat(system.point(0.3, **start)[None], 7, axis=0)
    points[:, :2] *= rng.uniform(0.9, 1.1, (7, 2))
    names = ["speed", "heading", "mass"]
    for workers in (1, 3):
        ends = flows(system, points, steps=2, along=names, liftoffs=True, work=True, workers=workers)
        first = flows(system, points, steps=2, along=names, watched=1, workers=workers)
        np.testing.assert_array_equal(first.seen, flows(system, points, along=names).seen)
        for row, p in enumerate(points):
            run = flow(system, p, steps=2, along=names, record=True)
            np.testing.assert_array_equal(ends.seen[row], run.seen)
            np.testing.assert_array_equal(ends.states[row], run.states)
            np.testing.assert_array_equal(ends.times[row], run.times)
            np.testing.assert_array_equal(ends.down[row] != 0.0, run.down_at_start)
            work = leg_work(run.tape, 0.0, run.step_ends[1]) * animal.body.mass / run.unit**2
            np.testing.assert_allclose(ends.work[row], work, rtol=1e-12, atol=1e-18)
            for leg in range(len(animal.legs)):
                events = run.events
                mine = (events.leg == leg) & events.lifts & (events.time > 0.0) & (events.time < run.times[-1])
                which = np.flatnonzero(mine)
                expected = [events.time[which[0]], events.rate[which[0]]] if len(which) else [np.nan, np.nan]
                np.testing.assert_allclose(ends.liftoffs[row, leg], expected, rtol=1e-12, atol=1e-12)


def test_many_go_on_where_one_fails(roach: Animal) -> None:
    system = System(roach, math.radians(45), "B")
    points = np.repeat(system.point(PHASE, **START)[None], 5, axis=0)
    points[2, system.along(["stiffness"])[0] > 0.0] = 1e15
    ends = flows(system, points, steps=3, workers=2)
    assert (ends.status == OK).tolist() == [True, True, False, True, True]
    assert np.all(np.isnan(ends.seen[2])) and np.isnan(ends.times[2, -1])
    assert np.all(np.isfinite(ends.seen[[0, 1, 3, 4]]))


def test_each_has_its_own_push(roach: Animal) -> None:
    system = System(roach, math.radians(45), "B")
    points = np.repeat(system.point(PHASE, **START)[None], 3, axis=0)
    pushes = np.array([[[0.1, size, 0.0], [0.2, 0.0, 0.0]] for size in (0.0, 0.05, -0.05)])
    ends = flows(system, points, steps=2, pushes=pushes)
    for row, push in enumerate(pushes):
        np.testing.assert_array_equal(ends.states[row], flow(system, points[row], steps=2, push=push).states)
    assert ends.states[1, -1, 0] > ends.states[0, -1, 0] > ends.states[2, -1, 0]
