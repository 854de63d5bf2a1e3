"""Return maps: their derivatives, and what they refuse."""

import math

import numpy as np
import pytest
from legspring.layout import TIGHT, System, slope_for

from legspring import Animal, find_gaits, load_animal
from legspring.kernel.run import run
from legspring.kernel.walker import (
    ACTUATION,
    GRAVITY,
    NO_TOUCHDOWN,
    OK,
    STIFFNESS,
    TAPE_FULL,
    TIME,
    TOUCHDOWN,
    VX,
    VY,
    X,
    Y,
)
from legspring.returnmap import (
    NO_PUSH,
    Direction,
    IntegrationError,
    Start,
    complete_map,
    flow,
    jets,
    reduced_map,
)
from tests.conftest import Cells

PHASE = np.array([0.3, 0.6, -0.7])
START = Start(0.27, 0.15)
CHANGES: list[tuple[Direction, float]] = [
    ("speed", 1e-6),
    ("heading", 1e-4),
    ("Dx", 1e-6),
    ("Dy", 1e-6),
    (("phase", "M"), 1e-4),
    (("actuation", "F"), 1e-6),
    (("stiffness", "B"), 1e-4),
    (("length", "F"), 1e-6),
    (("angle", "M"), 1e-4),
]


def end(animal: Animal, direction: Direction, change: float) -> np.ndarray:
    """Return the state after a stride from a start, or of an animal, that is a little changed."""
    slope, functions = math.radians(60), animal.functions("B")
    t_des = animal.step_duration(slope)
    length = animal.desired_speed(slope) * t_des
    phase, start = PHASE.copy(), START
    match direction:
        case "speed":
            start = Start(START.speed + change / t_des, START.heading)
        case "heading":
            start = Start(START.speed, START.heading + change)
        case "Dx":
            start = Start(START.speed, START.heading, (change, length))
        case "Dy":
            start = Start(START.speed, START.heading, (0.0, length + change))
        case ("phase", pair):
            phase[animal.pairs.index(pair)] += change
        case (name, pair):
            unit = t_des**2 / animal.body.mass if name == "stiffness" else 1.0
            value = [
                getattr(leg, name) + (change / unit if leg.pair == pair else 0.0)
                for leg in animal.legs
                if leg.offset == 0.0
            ]
            animal = animal.replace(**{name: value})
    return flow(System(animal, slope, functions), phase, start, steps=2, accuracy=1e-13)[0].y[:, 0]


def test_derivatives_are_those_of_the_numbers(roach: Animal) -> None:
    system = System(roach, math.radians(60), roach.functions("B"))
    y = flow(system, PHASE, START, steps=2, along=[d for d, _ in CHANGES], accuracy=TIGHT)[0].y
    for column, (direction, h) in enumerate(CHANGES, start=1):
        difference = (end(roach, direction, h) - end(roach, direction, -h)) / (2.0 * h)
        assert y[:, column] == pytest.approx(difference, rel=1e-6, abs=1e-6 * np.abs(difference).max())


def test_maps_have_the_derivatives_of_their_states(thesis_map: Cells) -> None:
    gait = thesis_map[75, 0.15][0]
    t_des, h = gait.system.step_duration, 1e-5
    for which in (complete_map, reduced_map):
        _, jacobian = which(gait.system, gait.phase, gait.start, accuracy=TIGHT)
        ahead, behind = (
            which(gait.system, gait.phase, Start(gait.speed, gait.heading + change), accuracy=1e-13)[0]
            for change in (h, -h)
        )
        assert jacobian[:, 1] == pytest.approx((ahead - behind) / (2.0 * h), abs=1e-7)
        speed = h * gait.system.step_length
        ahead, behind = (
            which(gait.system, gait.phase, Start(gait.speed + change / t_des, gait.heading), accuracy=1e-13)[0]
            for change in (speed, -speed)
        )
        assert jacobian[:, 0] == pytest.approx((ahead - behind) / (2.0 * speed), abs=1e-5)


def test_maps_of_a_body_that_yaws_have_the_derivatives_of_their_states(rigid_map: Cells) -> None:
    gait = rigid_map[60, 0.15][0]
    t_des, length = gait.system.step_duration, gait.system.step_length
    home = np.array([gait.speed, gait.heading, 0.0, length, gait.yaw, gait.yaw_rate, 2.0 * gait.yaw])
    units = np.array([1.0 / t_des, 1.0, 1.0, 1.0, 1.0, 1.0 / t_des, 1.0])

    def complete(h: np.ndarray) -> Start:
        speed, heading, dx, dy, yaw, yaw_rate, turn = home + h * units
        return Start(speed, heading, (dx, dy), yaw, yaw_rate, turn)

    def reduced(h: np.ndarray) -> Start:
        # The old feet are those of a body that had the opposite yaw, and moved straight ahead.
        changed = home[[0, 1, 4, 5]] + h * units[[0, 1, 4, 5]]
        return Start(changed[0], changed[1], yaw=changed[2], yaw_rate=changed[3])

    for which, start, size in ((complete_map, complete, 7), (reduced_map, reduced, 4)):
        _, jacobian = which(gait.system, gait.phase, gait.start, accuracy=TIGHT)
        assert jacobian.shape == (size, size)
        for column, h in enumerate(1e-6 * np.eye(size)):
            ahead, behind = (which(gait.system, gait.phase, start(d), accuracy=1e-13)[0] for d in (h, -h))
            assert jacobian[:, column] == pytest.approx((ahead - behind) / 2e-6, rel=1e-5, abs=1e-5)


def test_a_body_that_yaws_has_a_larger_state(roach: Animal) -> None:
    free = roach.replace(yaw="free", inertia=2.04e-7)
    system = System(free, math.radians(45), free.functions("B"))
    start = Start(0.27, 0.15, yaw=0.05, yaw_rate=1.0)
    state, jacobian = complete_map(system, PHASE, start)
    assert jacobian.shape == (7, 7)
    # Hips at the centre: nothing turns the body.
    spin = 1.0 * system.step_duration
    assert state[4:] == pytest.approx([-(0.05 + spin), -spin, -spin])
    state, jacobian = reduced_map(system, PHASE, start)
    assert jacobian.shape == (4, 4)
    assert jacobian[2:] == pytest.approx(np.array([[0.0, 0.0, 1.0, 2.0], [0.0, 0.0, 0.0, 1.0]]))


@pytest.mark.parametrize("direction", ["mass", ("phase", "X"), ("colour", "F"), 3])
def test_unknown_directions(roach: Animal, direction: Direction) -> None:
    system = System(roach, 0.0, roach.functions("A"))
    with pytest.raises(ValueError, match="along"):
        flow(system, PHASE, START, along=[direction])


def test_a_start_must_move(roach: Animal) -> None:
    with pytest.raises(ValueError, match="positive speed"):
        flow(System(roach, 0.0, roach.functions("A")), PHASE, Start(0.0, 0.1))
    with pytest.raises(ValueError, match="steps = -1"):
        flow(System(roach, 0.0, roach.functions("A")), PHASE, START, steps=-1)


def test_progress_is_that_of_the_velocity(roach: Animal) -> None:
    system = System(roach, 0.0, roach.functions("A"))
    walker, tape = flow(system, PHASE, START, steps=3, record=True)
    assert tape.touchdowns.shape == (4, 4)
    assert tape.touchdowns[-1] == pytest.approx(walker.y[:, 0])
    assert tape.touchdowns[0, [X, Y, VX, VY]] == pytest.approx(
        [0, 0, -0.27 * math.sin(0.15) * system.step_duration, 0.27 * math.cos(0.15) * system.step_duration]
    )


def test_derivatives_by_angles_of_pairs_with_any_offsets(roach: Animal) -> None:
    """The leg of a pair that is put down first keeps its sign, whenever that is."""
    offsets = {"F": 0.3, "M": 0.0, "B": 1.25}
    animal = roach.replace(offset=tuple(offsets.values()))
    assert [animal.legs[i].name for i in animal.first_legs] == ["FL", "MR", "BR"]
    slope, h = math.radians(60), 1e-5
    system = System(animal, slope, animal.functions("B"))
    along: list[Direction] = [("angle", pair) for pair in animal.pairs]
    y = flow(system, PHASE, START, steps=2, along=along, accuracy=TIGHT)[0].y
    first = [animal.legs[i] for i in animal.first_legs]
    for column, leg in enumerate(first):
        states = []
        for change in (h, -h):
            angles = [other.angle + (change if other is leg else 0.0) for other in first]
            changed = System(animal.replace(angle=tuple(angles)), slope, animal.functions("B"))
            states.append(flow(changed, PHASE, START, steps=2, accuracy=1e-13)[0].y[:, 0])
        difference = (states[0] - states[1]) / (2.0 * h)
        assert y[:, 1 + column] == pytest.approx(difference, rel=1e-6, abs=1e-6 * np.abs(difference).max())


def test_an_animal_with_a_leg_that_has_no_image_is_not_mirrored(roach: Animal) -> None:
    tail = roach.legs[2].model_copy(update={"name": "T", "pair": "T"})
    limping = roach.replace(legs=(*roach.legs, tail), families={"B": ("B", "T")})
    for animal, mirrored in ((roach, True), (limping, False)):
        system = System(animal, math.radians(45), animal.functions("B"))
        assert system.mirrored == mirrored
        phase = np.resize(PHASE, len(animal.pairs))
        image, end = complete_map(system, phase, START)[0], flow(system, phase, START)[0].y[:, 0]
        assert image[2] == pytest.approx(-end[X] if mirrored else end[X], abs=1e-15)


# Nothing is lost without a word ---------------------------------------------------------------------------


def test_a_recorded_stride_takes_as_many_steps_as_it_needs() -> None:
    stiff = load_animal("climbing_template").replace(stiffness=300.0, damping=0.64)
    system = System(stiff, math.pi / 2, stiff.functions("P"))
    start = Start(0.17, -0.413, (0.0032, 0.0187), yaw=0.06, yaw_rate=5.99)
    tape = flow(system, stiff.phase, start, steps=2, record=True, accuracy=TIGHT)[1]
    assert tape.counts[0] > 60 * 2 + 60
    assert tape.time[tape.counts[0]] == 2.0


def test_all_events_of_many_legs_are_recorded(roach: Animal) -> None:
    system = System(roach, 0.0, roach.functions("B"))
    body, rows, start = jets(system, PHASE, START)
    many = np.repeat(rows[:1], 60, axis=0)
    many[:, [STIFFNESS, ACTUATION]] *= 0.05
    offset = np.arange(60) / 30.0
    touchdowns = {}
    for room in (20, 500):
        status, _, tape = run(body, many, -np.ones(60), offset, NO_PUSH, start, 4, 2.0, 1e-12, 500, room)
        touchdowns[room] = status, int(np.count_nonzero(tape.events[: tape.counts[1], 2] == TOUCHDOWN))
    assert touchdowns[20][0] == TAPE_FULL
    assert touchdowns[500] == (OK, 60)


@pytest.mark.parametrize("name", ["spring_loaded_inverted_pendulum", "lateral_leg_spring"])
def test_nothing_depends_on_a_unit_of_time(name: str) -> None:
    animal = load_animal(name)
    states = []
    for unit in (10.0, 0.4, 0.05, 0.012, 0.004, 0.001):
        same = animal.replace(step_law=unit)
        system = System(same, slope_for(same, None, None), same.functions("P"))
        start = Start(5.2, -1.66) if "inverted" in name else Start(0.51, 0.08, yaw_rate=-1.0)
        walker, _ = flow(system, same.phase, start, steps=2)
        states.append([walker.clock[TIME] * unit, *walker.y[:2, 0], *(walker.y[2:4, 0] / unit)])
    assert np.array(states) == pytest.approx(np.array(states[:1] * 6), rel=1e-9, abs=1e-10)


def test_the_gaits_do_not_depend_on_a_unit_of_time() -> None:
    animal = load_animal("spring_loaded_inverted_pendulum")
    found = [
        [gait.heading for gait in find_gaits(animal.replace(step_law=unit), slope_deg=90)]
        for unit in (0.4, 10.0, 0.012, 0.001)
    ]
    assert len(found[0]) == 2
    for headings in found[1:]:
        assert headings == pytest.approx(found[0], abs=1e-9)


def test_what_never_touches_down_is_said_at_once() -> None:
    animal = load_animal("spring_loaded_inverted_pendulum")
    system = System(animal, math.pi / 2, animal.functions("P"))
    body, legs, start = jets(system, animal.phase, Start(5.2, -1.66))
    body[GRAVITY] = 0.0
    status, walker, _ = run(body, legs, system.side, system.offset, NO_PUSH, start, 4, 1.0, 1e-10, 0, 0)
    assert status == NO_TOUCHDOWN
    assert 0.0 < walker.clock[TIME] < 1.0


@pytest.mark.parametrize(("speed", "heading"), [(1.0, -1.6), (5.2, -2.9), (0.5, -3.0)])
def test_a_body_that_falls_to_the_ground_says_so(speed: float, heading: float) -> None:
    animal = load_animal("spring_loaded_inverted_pendulum")
    system = System(animal, math.pi / 2, animal.functions("P"))
    with pytest.raises(IntegrationError, match="the body falls to the ground"):
        flow(system, animal.phase, Start(speed, heading), steps=3)
