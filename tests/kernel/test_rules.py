"""Every rule of touch-down and lift-off, damper and length law, against the oracle: states, events, derivatives."""

from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from legspring.kernel.many import many, new_ends
from legspring.kernel.measure import leg_work
from legspring.kernel.pack import FIRST_LEG, GRAVITATION, INERTIA
from legspring.kernel.walker import (
    ACTUATION,
    DAMPING,
    GROUND,
    LIFTOFF,
    N_VARIED,
    NO_TOUCHDOWN,
    OFFSET,
    OK,
    STAY,
    TIME,
    VX,
    VY,
    YAW_RATE,
    Y,
    new_tape,
    new_walker,
)
from legspring.kernel.written import address
from tests.oracle import heyoka_rules
from tests.oracle.heyoka_rules import Law, Walker, sinusoid

ACCURACY = 1e-14
KINDS = ("hip_x", "hip_y", "stiffness", "length", "ldev", "phase", "angle", "damping", "trigger", "stay")
"""Numbers of a leg, as the oracle has them."""
SINUSOID = "l0 - ldev*sin(pi*t + phi)"
Direction = tuple[str, Any]


def rising(m: Any, t: Any, l0: Any, ldev: Any, phi: Any) -> Any:
    """A law with nothing of a sinusoid: it goes to another length, and swings about it."""
    return l0 - ldev * (1 - m.exp(-3 * t)) + 0.1 * phi * l0 * t**2 / (1 + t**2)


LAWS: dict[Law, str | None] = {
    sinusoid: None,
    rising: "l0 - ldev*(1 - exp(-3*t)) + 0.1*phi*l0*t**2/(1 + t**2)",
}


@dataclass(frozen=True)
class Case:
    """A walker, for how many steps to follow it, and along what to differentiate."""

    walker: Walker
    steps: int = 2
    along: list[Direction] = field(default_factory=list)

    @property
    def directions(self) -> list[Direction]:
        """Those asked for, speed and heading, gravity, and every parameter of a leg.

        A damper that is not there cannot be made weaker: a leg would lift off right away.
        """
        all_legs = self.walker.legs
        legs: list[Direction] = [("legs", (row % len(all_legs), row)) for row in range(8)]
        legs = [(which, index) for which, index in legs if index[1] != DAMPING or all_legs[index] > 0.0]
        # Where stances last whole steps, the order of events changes.
        stays = np.flatnonzero(all_legs[:, KINDS.index("stay")] % 1.0)
        legs += [("legs", (leg, KINDS.index("stay"))) for leg in stays]
        yaw: list[Direction] = [("start", 4), ("start", 5), ("body", 1)] if self.walker.yaws else []
        return [("start", 0), ("start", 1), ("body", 0), *yaw, *legs, *self.along]


def leg(
    hip: tuple[float, float] = (0.0, 0.0),
    k: float = 40.0,
    length: float = 1.0,
    ldev: float = 0.0,
    phase: float = 0.0,
    angle: float = 0.5,
    damping: float = 0.0,
    trigger: float = 0.0,
    stay: float = 0.0,
) -> list[float]:
    """Return the parameters of a leg."""
    return [*hip, k, length, ldev, phase, angle, damping, trigger, stay]


def case(
    legs: list[list[float]],
    start: list[float],
    offset: list[float],
    gravity: float = 0.0,
    mobility: float | None = None,
    law: Law = sinusoid,
    steps: int = 2,
    along: tuple[Direction, ...] = (),
) -> Case:
    """Return a case; a start has speed and heading, and may have displacement, yaw, yaw rate and turn."""
    whole = np.zeros(7)
    whole[: len(start)] = start
    body = np.array([gravity, mobility or 0.0])
    side = np.full(len(legs), -1.0)
    walker = Walker(body, np.array(legs), side, np.array(offset), whole, mobility is not None, law)
    return Case(walker, steps, list(along))


DOWN = [1.6, -2.2]  # fast and falling
HOPPING: dict[str, Any] = {"k": 150.0, "angle": -2.9, "trigger": -1.0}
LEFT: dict[str, Any] = {"angle": 0.8, "hip": (0.0, -0.1), "k": 12.0, "trigger": 2.0}
RIGHT: dict[str, Any] = {"angle": -0.8, "hip": (0.0, -0.1), "k": 12.0, "trigger": 1.0}
RUNNING = [1.0, -0.1, 0.0, 0.0, 0.1, -0.2]
TRIPODS = [
    leg((0.1, 0.3), angle=0.4, length=1.0, ldev=-0.4, phase=0.3),
    leg((0.2, 0.1), angle=-1.0, length=0.9, ldev=0.3, phase=0.5),
    leg((-0.1, -0.3), angle=2.0, length=0.7, ldev=-0.3, phase=-0.6),
    leg((-0.1, 0.3), angle=-0.4, length=1.0, ldev=-0.4, phase=0.3),
    leg((-0.2, 0.1), angle=1.0, length=0.9, ldev=0.3, phase=0.5),
    leg((0.1, -0.3), angle=-2.0, length=0.7, ldev=-0.3, phase=-0.6),
]
RUN = [0.9, 0.15, 0.02, 0.8, 0.05, -0.1, 0.03]
TRIPOD_OFFSETS = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]
MEMORY: tuple[Direction, ...] = (("start", 2), ("start", 3))


def tripods(mobility: float | None, changes: dict[int, float], law: Law = sinusoid) -> Case:
    """Return a hexapod by the clock with some parameters of all legs changed."""
    legs = np.array(TRIPODS)
    for row, value in changes.items():
        legs[:, row] = value
    start = RUN if mobility else RUN[:4]
    return case(legs.tolist(), start, TRIPOD_OFFSETS, 0.4, mobility, law, 2, MEMORY)


CASES = {
    "hopper": case([leg(**HOPPING)], DOWN, [0.0], 10.0),
    "hopper that yaws": case([leg((0.02, 0.05), **HOPPING)], [*DOWN, 0.0, 0.0, 0.02, -0.1], [0.0], 10.0, 5.0),
    "active hopper": case([leg(ldev=-0.1, phase=0.2, **HOPPING)], DOWN, [0.0], 10.0),
    "damped hopper": case([leg(damping=0.8, **HOPPING)], DOWN, [0.0], 10.0),
    "hopper by a formula": case([leg(ldev=-0.1, phase=0.2, damping=0.3, **HOPPING)], DOWN, [0.0], 10.0, law=rising),
    "hopper that lifts off by the clock": case([leg(stay=0.3, damping=0.2, **HOPPING)], DOWN, [0.0], 10.0),
    "walker": case(
        [leg(k=150.0, angle=-2.8, trigger=-1.0)] * 2, [1.2, -1.75, 0.45, 0.0], [0.0, 1.0], 10.0, along=MEMORY
    ),
    "runner": case([leg(**LEFT), leg(**RIGHT)], RUNNING, [0.0, 1.0], 0.0, 40.0, steps=3),
    "runner that does not yaw": case([leg(**LEFT), leg(**RIGHT)], RUNNING[:2], [0.0, 1.0], 0.05),
    "active runner": case(
        [leg(ldev=-0.1, phase=0.1, **LEFT), leg(ldev=-0.1, phase=0.1, **RIGHT)], RUNNING, [0.0, 1.0], 0.1, 40.0, steps=3
    ),
    "damped active runner": case(
        [leg(ldev=-0.2, phase=0.1, damping=0.2, **LEFT), leg(ldev=-0.2, phase=0.1, damping=0.2, **RIGHT)],
        RUNNING,
        [0.0, 1.0],
        0.1,
        40.0,
        steps=3,
    ),
    "runner by a formula": case(
        [leg(ldev=-0.2, phase=0.1, damping=0.2, **LEFT), leg(ldev=-0.2, phase=0.1, **RIGHT)],
        RUNNING,
        [0.0, 1.0],
        0.1,
        40.0,
        rising,
        steps=3,
    ),
    "damped climber by the clock": case(
        [
            leg((-0.1, 0.2), angle=0.2, ldev=0.3, damping=1.5, stay=1.0),
            leg((0.1, 0.2), angle=-0.2, ldev=0.3, damping=1.5, stay=1.0),
        ],
        [0.5, 0.1, 0.0, 0.4],
        [0.0, 1.0],
        1.0,
        30.0,
        steps=3,
        along=MEMORY,
    ),
    "duty factor": tripods(None, {9: 0.7}),
    "double support": tripods(30.0, {9: 1.3}),
    "damped tripods": tripods(None, {DAMPING: 1.0}),
    "damped tripods that yaw": tripods(30.0, {DAMPING: 0.6}),
    "tripods by a formula": tripods(None, {5: -0.4}, rising),
    "damped tripods by a formula": tripods(30.0, {DAMPING: 0.5}, rising),
    "followers of legs by the clock": case(
        [leg(angle=0.5, ldev=-0.1, phase=0.2), leg(angle=-0.5, ldev=-0.1, damping=0.2, trigger=1.0)],
        [0.8, 0.0],
        [0.0, 0.5],
        0.0,
        steps=3,
    ),
}
each = pytest.mark.parametrize("name", CASES)


def simulate(
    walker: Walker, steps: int, along: list[Direction], text: str | None = None, accuracy: float = ACCURACY
) -> Any:
    """Let the kernel do it: status, walker, tape, and states at the starts of steps. Its unit of time is 1 s."""
    p = parameters(walker)
    directions = np.array([direction(walker, which, index) for which, index in along]).reshape(len(along), len(p))
    laws = np.full(len(walker.legs), address(text or LAWS[walker.law]))
    rows = 6 if walker.yaws else 4
    triggers, even = walker.legs[:, KINDS.index("trigger")], np.zeros(len(laws))
    w = new_walker(walker.side, triggers, laws, even, np.zeros((0, 3)), rows, len(along))
    tape, ends = new_tape(3000, 200, w), new_ends(1, steps, len(along), w)
    many(w, tape, p[None], directions, np.zeros((0, 0, 3)), float(steps), steps, 0.4 * accuracy, False, ends)
    return int(ends.status[0]), w, tape, ends.states[0]


def parameters(walker: Walker) -> Any:
    """The kernel's parameters: of a body of mass 1 on a wall or, from the side, on level ground."""
    gravity, mobility = walker.body
    slope = 0.0 if GROUND in walker.legs[:, KINDS.index("trigger")] else np.pi / 2
    rest = [slope, gravity, 1.0, 1.0 / mobility if walker.yaws else np.inf, 1.0, 1.0]
    legs = np.zeros((len(walker.legs), N_VARIED))
    legs[:, : DAMPING + 1], legs[:, STAY] = walker.legs[:, : DAMPING + 1], walker.legs[:, KINDS.index("stay")]
    legs[:, ACTUATION] *= walker.side
    legs[:, OFFSET] = walker.offset
    return np.concatenate([walker.start, rest, legs.ravel()])


def direction(walker: Walker, which: str, index: Any) -> Any:
    """The direction in the space of the kernel's parameters of a number of the oracle's."""
    unit = np.zeros(len(parameters(walker)))
    if which == "start":
        unit[index] = 1.0
    elif which == "body":
        unit[GRAVITATION if index == 0 else INERTIA] = 1.0 if index == 0 else -1.0 / walker.body[1] ** 2
    elif which == "offset":
        unit[FIRST_LEG + N_VARIED * index + OFFSET] = 1.0
    else:
        leg, row = index
        row = STAY if row == KINDS.index("stay") else row
        unit[FIRST_LEG + N_VARIED * leg + row] = walker.side[leg] if row == ACTUATION else 1.0
    return unit


def events(tape: Any) -> list[tuple[float, int, str]]:
    """Time, leg and kind of what happened after the start."""
    rows = tape.events[: tape.counts[1], :3]
    return [(t, int(leg), "liftoff" if kind == LIFTOFF else "touchdown") for t, leg, kind in rows if t > 0.0]


@each
def test_states_and_events(name: str) -> None:
    expected = heyoka_rules.simulate(CASES[name].walker, CASES[name].steps)
    status, walker, tape, states = simulate(CASES[name].walker, CASES[name].steps, [])
    assert status == OK
    found = events(tape)
    assert sorted(event[1:] for event in found) == sorted(expected.sequence)
    assert {event[2] for event in found} == {"liftoff", "touchdown"}
    times = [sorted(event[0] for event in what) for what in (found, expected.events)]
    np.testing.assert_allclose(times[0], times[1], rtol=0, atol=1e-11)
    rows = len(walker.y)
    np.testing.assert_allclose(states, expected.states[:, :rows], rtol=0, atol=1e-11)
    assert walker.clock[TIME] == pytest.approx(expected.times[-1], abs=1e-11)


@each
def test_derivatives(name: str) -> None:
    case = CASES[name]
    _, walker, _, _ = simulate(case.walker, case.steps, case.directions)
    for d, (which, index) in enumerate(case.directions, start=1):
        expected, error = heyoka_rules.central_derivative(case.walker, which, index, case.steps, 2e-4)
        size = max(1.0, float(np.max(np.abs(expected[:-1]))))
        assert np.max(error) < 1e-7 * size
        np.testing.assert_allclose(walker.y[:, d], expected[: len(walker.y)], rtol=0, atol=1e-8 * size)


def by_clock(walker: Walker) -> list[int]:
    """Legs that the clock puts down, but for those that it lifts when a step ends: they are up when the next begins."""
    down, stay = walker.legs[:, KINDS.index("trigger")], walker.legs[:, KINDS.index("stay")]
    return np.flatnonzero((down == 0.0) & (stay != 1.0)).tolist()


@pytest.mark.parametrize("name", [name for name in CASES if by_clock(CASES[name].walker)])
def test_derivatives_by_the_times_of_touch_downs(name: str) -> None:
    """They are those of later ones: a step ends before the touch-down that begins the next one."""
    case, h = CASES[name], 3e-5
    walker = case.walker
    for leg in by_clock(walker):
        _, w, *_ = simulate(walker, case.steps, [("offset", leg)])
        states = [heyoka_rules.simulate(walker, case.steps).states[-1]]
        # A foot of two steps ago is up by then.
        up = [leg] if walker.offset[leg] == 0.0 else []
        later = [walker.perturbed("offset", leg, h / 2**n) for n in range(5)]
        slopes = [
            (heyoka_rules.simulate(other, case.steps, up).states[-1] - states[0]) / (h / 2**n)
            for n, other in enumerate(later)
        ]
        for order in range(1, 5):
            slopes = [b + (b - a) / (2**order - 1) for a, b in pairwise(slopes)]
        size = max(1.0, float(np.max(np.abs(slopes[0]))))
        np.testing.assert_allclose(w.y[:, 1], slopes[0][: len(w.y)], rtol=0, atol=3e-8 * size)


@pytest.mark.parametrize("name", [name for name in CASES if CASES[name].walker.law is sinusoid])
def test_the_sinusoid_as_a_formula(name: str) -> None:
    case = CASES[name]
    _, plain, tape, _ = simulate(case.walker, case.steps, case.directions)
    _, walker, written, _ = simulate(case.walker, case.steps, case.directions, SINUSOID)
    assert events(tape) == [(pytest.approx(t, abs=1e-12), *rest) for t, *rest in events(written)]
    size = np.max(np.abs(plain.y))
    np.testing.assert_allclose(walker.y, plain.y, rtol=0, atol=1e-11 * size)


@pytest.mark.parametrize("name", ["hopper", "hopper that yaws", "runner"])
def test_passive_legs_keep_energy(name: str) -> None:
    """At each of their touch-downs no leg is loaded."""
    case = CASES[name]
    status, _, _, states = simulate(case.walker, case.steps, [])
    assert status == OK
    gravity, mobility = case.walker.body
    energy = (states[:, VX] ** 2 + states[:, VY] ** 2) / 2 + gravity * states[:, Y]
    if case.walker.yaws:
        energy += states[:, YAW_RATE] ** 2 / mobility / 2
    np.testing.assert_allclose(energy, energy[0], rtol=0, atol=1e-12 * energy[0])


def test_a_damper_takes_what_a_leg_does_not_give() -> None:
    """Work of the leg, that of its spring and damper together, is the change of the energy, and a loss."""
    walker = CASES["damped hopper"].walker
    _, _, tape, states = simulate(walker, 2, [])
    times = [0.0, *(t for t, _, kind in events(tape) if kind == "touchdown")]
    energy = (states[:, VX] ** 2 + states[:, VY] ** 2) / 2 + walker.body[0] * states[:, Y]
    for step in range(2):
        work = np.sum(leg_work(tape, times[step], times[step + 1]))
        assert work == pytest.approx(energy[step + 1] - energy[step], abs=1e-11)
        assert work < -0.01


def test_two_steps_are_one_after_the_other() -> None:
    """The derivatives of a step are those from touch-down to touch-down: those of two steps are their product."""
    walker = CASES["hopper"].walker
    along: list[Direction] = [("start", 0), ("start", 1)]

    def step(walker: Walker, steps: int) -> tuple[Any, Any]:
        vx, vy = (y := simulate(walker, steps, along)[1].y[:, : 1 + len(along)])[[VX, VY]]
        speed, course = np.hypot(vx[0], vy[0]), np.arctan2(-vx[0], vy[0])
        rows = [(vx[0] * vx[1:] + vy[0] * vy[1:]) / speed, (vx[0] * vy[1:] - vy[0] * vx[1:]) / speed**2]
        assert np.max(np.abs(y[Y])) < 1e-12  # the section: where the foot touches the ground
        return np.array([speed, course]), np.array(rows)

    middle, first = step(walker, 1)
    start = walker.start.copy()
    start[:2] = middle
    end, second = step(replace(walker, start=start), 1)
    both_end, both = step(walker, 2)
    np.testing.assert_allclose(both_end, end, rtol=1e-12)
    np.testing.assert_allclose(both, second @ first, rtol=1e-10, atol=1e-12)


def test_a_body_that_flies_off() -> None:
    walker = replace(CASES["runner"].walker, start=np.array([0.5, np.pi, 0, 0, 0, 0, 0.0]))
    walker.legs[:, KINDS.index("trigger")] = -1.0
    status, *_ = simulate(replace(walker, body=np.array([-1.0, 40.0])), 5, [])
    assert status == NO_TOUCHDOWN


def test_feet_that_come_down_together() -> None:
    """Two legs that are one leg of twice the stiffness."""
    single = CASES["hopper"].walker
    legs = np.repeat(single.legs, 2, axis=0)
    legs[:, 2] /= 2.0
    double = replace(single, legs=legs, side=np.full(2, -1.0), offset=np.zeros(2))
    along: list[Direction] = [("start", 0), ("start", 1), ("body", 0)]
    _, one, *_ = simulate(single, 2, along)
    _, two, tape, _ = simulate(double, 2, along)
    assert [event[1:] for event in events(tape)][2:4] == [(0, "touchdown"), (1, "touchdown")]
    np.testing.assert_allclose(two.y, one.y, rtol=0, atol=1e-11)
