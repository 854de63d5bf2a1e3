"""Time series of a simulation, as an xarray.Dataset."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from legspring.checks import checked_angle, checked_number, checked_positive, checked_vector, shown
from legspring.flow import MOST_STEPS_AT_ONCE, NO_PUSH, Flow, Samples, flow
from legspring.kernel.walker import Floats
from legspring.layout import ACCURACY, PLACES, System, slope_for
from legspring.measures.energy import energies
from legspring.model import Animal, Body

SAMPLES = 100
"""Samples a step."""


def turning(run: Flow) -> tuple[float, float]:
    """Largest yaw (rad) and largest moment about the centre of mass (N m), either way, in the first step.

    Among as many samples as a simulation has.
    """
    samples = run.samples(np.linspace(0.0, run.step_ends[1], SAMPLES + 1))
    _, moment, _ = _legs(run, samples)["moment"]
    return float(np.max(np.abs(samples.states[:, 4]))), float(np.max(np.abs(moment)))


def simulation(
    system: System, p: Floats, strides: float, *, push: Floats = NO_PUSH, accuracy: float = ACCURACY
) -> xr.Dataset:
    """Simulate an animal on its slope, pushed or not (see `flow`); see `simulate` for the result."""
    steps = steps_in(system, strides)
    run = flow(system, p, steps=steps, push=push, record=True, accuracy=accuracy)
    s = np.linspace(0.0, run.step_ends[-1], steps * SAMPLES + 1)
    samples = run.samples(s)
    y, firsts = samples.states, list(system.animal.first_legs)
    # Where steps end at touch-downs, they last as long as they do.
    step_duration = system.step_duration * (float(s[-1]) / steps if system.event_driven else 1.0)
    return xr.Dataset(
        {
            "position": (("time", "axis"), y[:, :2], _about("m", "centre of mass")),
            "velocity": (("time", "axis"), y[:, 2:4], _about("m/s", "velocity of the centre of mass")),
            "yaw": ("time", y[:, 4], _about("rad", "yaw, counter-clockwise from uphill")),
            "yaw_rate": ("time", y[:, 5], _about("rad/s", "yaw rate")),
            **_legs(run, samples),
            **_energies(run, s, push),
            **_events(run),
            "leg_function": (
                "pairs",
                ["push" if side < 0 else "pull" for side in system.functions],
                {"long_name": "what the legs of a pair do"},
            ),
            "phase": ("pairs", p[[system.place(leg, "phase") for leg in firsts]], _about("rad", "phase")),
            "actuation": ("pairs", np.array(system.magnitudes), _about("m", "magnitude of the actuation")),
        },
        coords={
            "time": ("time", s * system.step_duration, _about("s", "time")),
            "axis": list(system.axes),
            "leg": [leg.name for leg in system.animal.legs],
            "pairs": list(system.animal.pairs),
            "pair": ("leg", [leg.pair for leg in system.animal.legs], {"long_name": "pair that the leg belongs to"}),
        },
        attrs={
            "animal": system.animal.name,
            "view": "side" if system.animal.sagittal else "above",
            "slope_deg": round(math.degrees(system.slope), 12),
            "heading": float(p[PLACES["heading"]]),
            "speed": float(p[PLACES["speed"]]),
            "desired_speed": system.desired_speed,
            "step_duration": step_duration,
            "stride_duration": system.steps_per_stride * step_duration,
            **_about_body(system.animal.body),
            **(_about_push(push, system.step_duration) if len(push) else {}),
        },
    )


def _about_push(push: Floats, step_duration: float) -> dict[str, Floats]:
    """When a push begins and ends (s), and the velocity that it gives (m/s)."""
    velocity = np.asarray(np.trapezoid(push[:, 1:], push[:, 0], axis=0)) / step_duration
    return {"push_time": push[[0, -1], 0] * step_duration, "push": velocity}


def _about_body(body: Body) -> dict[str, float]:
    """Mass (kg) and, where it can turn, moment of inertia (kg m^2)."""
    return {"mass": body.mass} | ({"inertia": body.inertia} if body.yaw == "free" and body.inertia else {})


def steps_in(system: System, strides: float) -> int:
    """Return the number of steps in so many strides; raise ValueError if they cannot be simulated."""
    per_stride = system.steps_per_stride
    number = per_stride * checked_positive("strides", strides)
    steps = round(number)
    if abs(steps - number) > 1e-9 or not 1 <= steps <= MOST_STEPS_AT_ONCE:
        multiple = "a multiple of 1/2" if per_stride == 2 else "a whole number"
        raise ValueError(f"strides = {shown(strides)}: must be {multiple}, up to {MOST_STEPS_AT_ONCE // per_stride}")
    return steps


def _about(units: str, name: str) -> dict[str, str]:
    return {"units": units, "long_name": name}


def _legs(run: Flow, samples: Samples) -> dict[str, tuple[tuple[str, ...], Floats | NDArray[np.bool_], dict[str, str]]]:
    """Feet, lengths and forces of the legs, missing in swing, where the force is zero; and the moment of all."""
    y, down, foot, legs = samples.states, samples.down, samples.feet, samples.legs
    length = np.hypot(legs[..., 0], legs[..., 1])
    with np.errstate(divide="ignore", invalid="ignore"):
        pull = np.where(down, samples.force / length, 0.0)
    missing = np.where(down, 1.0, np.nan)
    force = pull[..., None] * legs
    arm = foot - y[:, None, :2]
    moment = np.sum(arm[..., 0] * force[..., 1] - arm[..., 1] * force[..., 0], axis=1)
    weight = run.system.animal.body.mass * run.system.animal.gravity
    return {
        "stance": (("time", "leg"), down, _about("1", "whether the leg is in stance")),
        "hip": (("time", "leg", "axis"), y[:, None, :2] + samples.hips, _about("m", "hip")),
        "foot": (("time", "leg", "axis"), foot * missing[..., None], _about("m", "foot in stance")),
        "leg_length": (("time", "leg"), length * missing, _about("m", "length of the leg in stance")),
        "free_length": (("time", "leg"), samples.free * missing, _about("m", "force-free length in stance")),
        "force": (("time", "leg", "axis"), force, _about("m g", "force on the body")),
        "moment": (("time",), weight * moment, _about("N m", "moment of all legs about the centre of mass")),
    }


def _energies(run: Flow, s: Floats, push: Floats) -> dict[str, tuple[tuple[str, ...], Floats, dict[str, str]]]:
    """Return what body and springs have, where it came from, and what is left unaccounted for."""
    seen = energies(run, s, push)
    where = "height" if run.system.animal.sagittal else "height on the slope"
    pushed = {"push_work": (("time",), seen.push, _about("J", "work of the push since the start"))} if len(push) else {}
    return {
        "kinetic_energy": (("time",), seen.kinetic, _about("J", "kinetic energy")),
        "potential_energy": (("time",), seen.height, _about("J", f"energy of {where}, from the start")),
        "spring_energy": (("time", "leg"), seen.springs, _about("J", "energy in the leg's spring")),
        "actuation_work": (("time", "leg"), seen.actuation, _about("J", "work of the leg's actuation since the start")),
        "lost_energy": (
            ("time",),
            seen.lost,
            _about("J", "taken by dampers, and legs lifted off loaded"),
        ),
        **pushed,
        "energy_balance": (("time",), seen.balance, _about("J", "energy from nowhere since the start: the error")),
    }


def _events(run: Flow) -> dict[str, tuple[str | tuple[str, ...], NDArray[np.generic], dict[str, str]]]:
    events = run.events
    names = np.array([leg.name for leg in run.system.animal.legs])
    kinds = np.where(events.lifts, "lift-off", "touch-down")
    return {
        "event_time": ("event", events.time, _about("s", "time of a touch-down or lift-off")),
        "event_leg": ("event", names[events.leg], {"long_name": "whose event it is"}),
        "event_kind": ("event", kinds, {"long_name": "touch-down or lift-off"}),
        "event_position": (("event", "axis"), events.place, _about("m", "centre of mass then")),
    }


def simulate(
    animal: Animal,
    *,
    heading: float,
    speed: float,
    phase: Sequence[float] | None = None,
    family: str | None = None,
    slope: float | None = None,
    slope_deg: float | None = None,
    actuation: ArrayLike | None = None,
    displacement: tuple[float, float] | None = None,
    yaw: float = 0.0,
    yaw_rate: float = 0.0,
    memory: Mapping[str, float] | None = None,
    strides: float = 2,
    accuracy: float = ACCURACY,
) -> xr.Dataset:
    """Simulate an animal from any start, a gait or not.

    See :ref:`model-touchdown`.

    Parameters
    ----------
    animal
        The animal.
    heading
        Of the initial velocity relative to the body, counter-clockwise, rad.
    speed
        Initial speed, m/s.
    phase
        Of each pair of legs, rad; by default the animal's, if it is not tuned to its desired speed.
    family
        Which pairs push; not needed where the animal has one family only.
    slope, slope_deg
        Either of them; rad or degrees. Not needed where the animal's speed law is for one slope only, nor from the
        side, where the ground is level without.
    actuation
        Magnitudes for each pair of legs, m; by default the animal's.
    displacement
        Displacement of the centre of mass over the step before, m, which says where old feet are (:ref:`model-memory`).
    yaw, yaw_rate
        Of the body, where it is free to yaw; rad, rad/s.
    memory
        What is remembered of each foot that is down from before (see `Gait.memory`), as in ``{"R.foot_x": -0.1}``;
        what is not named is that of a body that has moved straight ahead, and legs that are not named are up.
    strides
        How long; a multiple of 1/2. Half a stride is a step, which lasts a step duration or, where no leg goes by the
        clock, to the next touch-down of a leg whose offset is 0 or 1; if all have one offset, a stride is one step.
    accuracy
        Relative accuracy of the states after a stride.

    Returns
    -------
    xarray.Dataset
        Time series over time, leg and axis (lateral, fore_aft; in a side view horizontal, vertical) of position,
        velocity, yaw, feet, leg lengths, force-free lengths and forces (in m g), the moment of all legs about the
        centre of mass, energies and works (J, :ref:`model-energy`), and the events. Its attributes say which animal it
        is and where: ``slope_deg``, ``heading`` and ``speed`` at the start, ``stride_duration`` (s); of one that is
        pushed ``push_time``, begin and end (s), and ``push``, the velocity that it gives (m/s).

    Raises
    ------
    ValueError
        For a number out of range.
    IntegrationError
        If a leg collapses, for instance.
    """
    magnitudes = None if actuation is None else tuple(checked_vector("actuation", actuation, len(animal.pairs)))
    label = only_family(animal) if family is None else family
    if phase is None:
        check_phase(animal)
    system = System(animal, slope_for(animal, slope, slope_deg), label, magnitudes, legs_remembered(animal, memory))
    for name in memory or ():
        if name not in system.memory:
            raise ValueError(f"memory = {shown(name)}: must be one of {', '.join(system.memory)}")
    p = system.point(
        phase,
        speed=checked_positive("speed", speed),
        # Gaits that are not tuned to a heading may have any.
        heading=checked_angle("heading", heading, math.pi / 2 if animal.tuned else math.pi),
        displacement=None if displacement is None else checked_vector("displacement", displacement, 2).tolist(),
        yaw=checked_angle("yaw", yaw, math.pi),
        yaw_rate=checked_number("yaw_rate", yaw_rate),
    )
    for name, value in (memory or {}).items():
        p[system.direction(name) != 0.0] = checked_number(f"memory[{name!r}]", value)
    return simulation(system, p, strides, accuracy=accuracy)


def legs_remembered(animal: Animal, memory: Mapping[str, float] | None) -> tuple[str, ...] | None:
    """Return the legs of which something is remembered; those put down at the same instant are, too."""
    if memory is None:
        return None
    named = {name.rpartition(".")[0] for name in memory if isinstance(name, str)}
    times = {leg.offset for leg in animal.legs if leg.name in named and leg.touchdown == "clock"}
    return tuple(leg.name for leg in animal.legs if leg.name in named or leg.offset in times)


def only_family(animal: Animal) -> str:
    """Return the label of an animal's only family; raise ValueError if there are more."""
    if len(animal.families) > 1:
        raise ValueError(f"family is missing: must be one of {', '.join(animal.families)}")
    return next(iter(animal.families))


def check_phase(animal: Animal) -> None:
    """Raise ValueError if the phases of an animal's legs are not given, but tuned."""
    if animal.tuned:
        raise ValueError(f"phase is missing: must be an angle in rad for each of {', '.join(animal.pairs)}")
