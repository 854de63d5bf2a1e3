"""One step, or one stride, as a map, with its exact Jacobian."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from legspring.kernel import launch as rows
from legspring.kernel.run import run
from legspring.kernel.walker import (
    ACTUATION,
    ANGLE,
    DAMPING,
    EVALUATIONS,
    EVENT_LOST,
    FALLEN,
    LENGTH,
    N_LEG,
    NO_TOUCHDOWN,
    PHASE,
    STEP_TOO_SMALL,
    STIFFNESS,
    TAPE_FULL,
    TIME,
    TOO_MANY_STEPS,
    TOUCHDOWN,
    VX,
    VY,
    YAW,
    YAW_RATE,
    Floats,
    Tape,
    Walker,
    X,
    Y,
)
from legspring.layout import ACCURACY, System

NO_PUSH = np.zeros((0, 3))
START_ROWS = {
    "speed": rows.SPEED,
    "heading": rows.HEADING,
    "Dx": rows.DX,
    "Dy": rows.DY,
    "yaw": rows.START_YAW,
    "yaw_rate": rows.START_YAW_RATE,
    "turn": rows.TURN,
}
LEG_ROWS = {
    "phase": PHASE,
    "actuation": ACTUATION,
    "stiffness": STIFFNESS,
    "length": LENGTH,
    "angle": ANGLE,
    "damping": DAMPING,
}
Direction = str | tuple[str, str]

MOST_STEPS_AT_ONCE = 2000
"""Longest simulation, in steps."""
REASONS = {
    STEP_TOO_SMALL: "the integrator's step became too small: a leg collapsed to its hip, or forces are too stiff",
    TOO_MANY_STEPS: "the integrator needed too many steps: forces are too stiff for the time that a step takes",
    EVENT_LOST: "a lift-off could not be located: the leg's force stays too near zero",
    NO_TOUCHDOWN: "no leg touches down any more",
    FALLEN: "the body falls to the ground",
}


class IntegrationError(ArithmeticError):
    """A simulation could not be carried on; the message says why.

    Attributes
    ----------
    evaluations
        Of the equations of motion, in vain.
    """

    def __init__(self, message: str, evaluations: int = 0) -> None:
        super().__init__(message)
        self.evaluations = evaluations


@dataclass(frozen=True)
class Start:
    """The start of a step.

    Parameters
    ----------
    speed
        m/s.
    heading
        Direction of motion relative to the body, counter-clockwise, rad.
    displacement
        Displacement of the centre of mass over the step before (x, y), m, which says where the legs that are still
        down were put down; by default straight ahead at the desired speed. For an animal of which no leg goes by the
        clock the default is that all legs of the step before are up.
    yaw, yaw_rate
        rad, rad/s; zero for a body whose yaw is held.
    turn
        Change of yaw over the step before, rad; by default twice the yaw, as in a gait.
    """

    speed: float
    heading: float
    displacement: tuple[float, float] | None = None
    yaw: float = 0.0
    yaw_rate: float = 0.0
    turn: float | None = None

    def in_kernel_units(self, system: System) -> Floats:
        """Return the kernel's start, ``(7,)``."""
        # No displacement at all tells the kernel that no leg of the step before is down.
        default = (0.0, 0.0 if system.event_driven else system.step_length)
        dx, dy = default if self.displacement is None else self.displacement
        turn = 2.0 * self.yaw if self.turn is None else self.turn
        t_des = system.step_duration
        return np.array([self.speed * t_des, self.heading, dx, dy, self.yaw, self.yaw_rate * t_des, turn])


def jets(
    system: System, phase: ArrayLike, start: Start, along: Sequence[Direction] = ()
) -> tuple[Floats, Floats, Floats]:
    """Return body, legs and start for the kernel, with their derivatives along some directions.

    Parameters
    ----------
    system, phase, start
        See `flow`.
    along
        Directions: ``"speed"``, ``"heading"``, ``"Dx"``, ``"Dy"``, ``"yaw"``, ``"yaw_rate"``, ``"turn"`` of the start;
        or pairs such as ``("phase", "F")`` of ``"phase"``, ``"actuation"`` (magnitude), ``"stiffness"``, ``"length"``,
        ``"angle"`` or ``"damping"`` and a pair of legs, which changes both legs alike (the angle: in mirror image).
        All in the kernel's units.

    Raises
    ------
    ValueError
        For an unknown direction, or a start that is not one.
    """
    values = start.in_kernel_units(system)
    if not np.all(np.isfinite(values)) or values[0] <= 0.0:
        raise ValueError(f"{start}: must have a positive speed and finite numbers")
    if system.rows == 4 and np.any(values[[rows.START_YAW, rows.START_YAW_RATE, rows.TURN]] != 0.0):
        raise ValueError(f"yaw = {start.yaw!r}, yaw_rate = {start.yaw_rate!r}: must be 0 for a body whose yaw is held")
    animal, width = system.animal, 1 + len(along)
    start_jet = np.zeros((rows.N_START, width))
    legs = np.zeros((len(animal.legs), N_LEG, width))
    body = np.zeros((2, width))
    start_jet[:, 0], legs[:, :, 0], body[:, 0] = values, system.legs(phase), system.body
    for d, direction in enumerate(along, start=1):
        match direction:
            case str(name) if name in START_ROWS:
                start_jet[START_ROWS[name], d] = 1.0
            case (name, pair) if name in LEG_ROWS and pair in animal.pairs:
                for i, leg in enumerate(animal.legs):
                    mirrored = {"actuation": system.side[i], "angle": 1.0 if i in animal.first_legs else -1.0}
                    legs[i, LEG_ROWS[name], d] = mirrored.get(name, 1.0) if leg.pair == pair else 0.0
            case _:
                valid = f"one of {', '.join(START_ROWS)}, or one of {', '.join(LEG_ROWS)} with a pair of legs"
                raise ValueError(f"along = {direction!r}: must be {valid}")
    return body, legs, start_jet


def flow(
    system: System,
    phase: ArrayLike,
    start: Start,
    *,
    steps: int = 1,
    along: Sequence[Direction] = (),
    push: Floats = NO_PUSH,
    record: bool = False,
    accuracy: float = ACCURACY,
) -> tuple[Walker, Tape]:
    """Simulate a number of steps.

    A step lasts a step duration; that of an animal of which no leg goes by the clock ends at the next touch-down.

    Parameters
    ----------
    system, phase
        The animal on its slope, and the phase of each pair of legs, rad.
    start
        Where from.
    steps
        How far.
    along
        Directions to take exact derivatives in (see `jets`).
    push
        ``(P, 3)``: knots of an acceleration from outside, in the kernel's units.
    record
        Whether to fill the tape.
    accuracy
        Relative accuracy of the states after a stride.

    Returns
    -------
    walker, tape
        The end, whose state ``y`` is ``(n, 1 + D)`` for D directions, and what happened. Where steps end at
        touch-downs, the derivatives are those of the state at the touch-down, whose time varies.

    Raises
    ------
    IntegrationError
        If the simulation cannot be carried to its end.
    """
    if not 0 <= steps <= MOST_STEPS_AT_ONCE:
        raise ValueError(f"steps = {steps!r}: must be from 0 to {MOST_STEPS_AT_ONCE}")
    body, legs, start_jet = jets(system, phase, start, along)
    scale, end, rows = system.error_scale(accuracy), float(steps), system.rows
    room = 60 * steps + 60 if record else 0
    status = TAPE_FULL
    while status == TAPE_FULL:
        status, walker, tape = run(
            body, legs, system.side, system.offset, push, start_jet, rows, end, scale, room, room // 2
        )
        room *= 2
    if status in REASONS:
        time = walker.clock[TIME] * system.step_duration
        raise IntegrationError(f"stopped at t = {time:.6g} s: {REASONS[status]}", int(walker.clock[EVALUATIONS]))
    return walker, tape


def step_ends(system: System, tape: Tape) -> Floats:
    """Return the times between the steps on a tape, its start and end among them, in step durations."""
    count = len(tape.touchdowns)
    if not system.event_driven:
        return np.arange(float(count))
    time, leg, kind = tape.events[: tape.counts[1], :3].T
    ending = (kind == TOUCHDOWN) & np.isin(system.offset[leg.astype(int)], (0.0, 1.0))
    return np.unique([0.0, *time[ending]])[:count]


def speed_and_heading(y: Floats) -> Floats:
    """Speed and heading, relative to the body, of a state jet: ``(2, C)``, in the kernel's units."""
    vx, vy = y[VX, 0], y[VY, 0]
    speed = math.hypot(vx, vy)
    out = np.vstack([(vx * y[VX] + vy * y[VY]) / speed, (vx * y[VY] - vy * y[VX]) / speed**2])
    out[:, 0] = speed, math.atan2(-vx, vy)
    if len(y) > 4:
        out[1] -= y[YAW]
    return out


def state_names(system: System, memory: bool) -> list[str]:
    """Name what the complete map maps; with or without memory of the step before."""
    names = ["speed", "heading"] + (["Dx", "Dy"] if memory else [])
    return names + (["yaw", "yaw_rate"] + (["turn"] if memory else []) if system.rows == 6 else [])


def complete_map(
    system: System, phase: ArrayLike, start: Start, *, accuracy: float = ACCURACY
) -> tuple[Floats, Floats]:
    """Map the complete state at a touch-down to that one step later, mirrored.

    The state is (speed, heading, Dx, Dy), with (Dx, Dy) the displacement of the centre of mass over the last step,
    which says where the feet of the last tripod are; a yawing body adds (yaw, yaw rate, turn over the last step).
    Where a start has no displacement, because no leg of the step before is down, there are no (Dx, Dy) and no turn.
    Lengths in m, times in step durations. An animal whose legs have no mirror images is not mirrored.

    Returns
    -------
    state, jacobian
        ``(n,)`` and ``(n, n)``, n from 2 to 7.
    """
    names = state_names(system, start.displacement is not None or not system.event_driven)
    return image_of(system, start, names, flow(system, phase, start, along=names, accuracy=accuracy)[0].y)


def image_of(system: System, start: Start, names: Sequence[str], y: Floats) -> tuple[Floats, Floats]:
    """Return what `complete_map` does, from the state at the end of a step, with derivatives along ``names``."""
    speed, heading = speed_and_heading(y)
    images = {"speed": speed, "heading": heading, "Dx": y[X], "Dy": y[Y]}
    if system.rows == 6:
        turn = y[YAW].copy()
        turn[0] -= start.yaw
        turn[1 + names.index("yaw")] -= 1.0
        images |= {"yaw": y[YAW], "yaw_rate": y[YAW_RATE], "turn": turn}
    side = -1.0 if system.mirrored else 1.0
    image = np.array([images[name] * (1.0 if name in ("speed", "Dy") else side) for name in names])
    return image[:, 0], image[:, 1:]


def reduced_map(system: System, phase: ArrayLike, start: Start, *, accuracy: float = ACCURACY) -> tuple[Floats, Floats]:
    """Map (speed, heading) to itself over a stride, every start rebuilding the old feet: the thesis's stability map.

    A yawing body adds (yaw, yaw rate). Lengths in m, times in step durations.

    Returns
    -------
    state, jacobian
        ``(n,)`` and ``(n, n)``, n = 2 or 4.
    """
    yaws = system.rows == 6
    along = ["speed", "heading"] + (["yaw", "yaw_rate", "turn"] if yaws else [])
    y = flow(system, phase, start, steps=2, along=along, accuracy=accuracy)[0].y
    if yaws:
        # Rebuilding the old feet, a change of yaw is one of the turn before, too.
        y[:, 3] += 2.0 * y[:, 5]
        y = y[:, :5]
    image = speed_and_heading(y)
    if yaws:
        image = np.vstack([image, y[YAW], y[YAW_RATE]])
    return image[:, 0], image[:, 1:]
