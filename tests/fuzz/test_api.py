"""The functions of the package: whatever they are given, there is a result, or an error of one line."""

import math
import time
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import assume, given
from hypothesis import strategies as st

import legspring as ls
from legspring.layout import System
from tests.fuzz.trying import OUTCOMES, examples, odd, refused
from tests.places import place_of

LONGEST = 120.0
"""Most that one call may take, s of processor time; almost all take less than one."""
MISSING = {"foot", "leg_length", "free_length"}
"""What a simulation says of legs in stance only."""
FACTORS = {
    "mass": 3,
    "inertia": 3,
    "stiffness": 10,
    "length": 2,
    "damping": 10,
    "gravity": 3,
    "speed_law": 3,
    "step_law": 3,
}
"""By how much a number is changed, up or down."""
CHOICES: dict[str, list[Any]] = {
    "angle_deg": [-158.0, -60.0, 0.0, 30.0, 90.0], "hip": [[0.0, 0.0], [0.003, 0.01]], "phase": [0.0, 0.3],
    "touchdown": ["clock", "ground"], "stance": [0.5, 0.9, 1.5], "actuation": [0.0, 0.003, 0.01],
    "yaw": ["free", "held"], "length_law": ["l0 - ldev*sin(pi*t + phi)", "l0 + ldev*(1 - exp(-t))"], "offset": [0, 0.3],
}  # fmt: skip


@st.composite
def animals(draw: st.DrawFn) -> ls.Animal:
    """Return presets, and others with numbers and rules of their own."""
    animal = ls.load_animal(draw(st.sampled_from(ls.presets())))
    changes: dict[str, Any] = {}
    for name in draw(st.lists(st.sampled_from([*FACTORS, *CHOICES]), max_size=3)):
        if name in CHOICES:
            changes[name] = draw(st.sampled_from(CHOICES[name]))
        else:
            usual = {
                "mass": animal.body.mass, "inertia": animal.body.inertia or 1e-7, "gravity": animal.gravity,
                "stiffness": animal.legs[0].stiffness, "length": animal.legs[0].length, "damping": 0.01,
                "speed_law": animal.speed_law.vertical, "step_law": 0.05,
            }[name]  # fmt: skip
            changes[name] = usual * FACTORS[name] ** draw(st.floats(-1.0, 1.0))
    # A number of one pair or one leg, after which the animal may limp.
    for owner in draw(st.lists(st.sampled_from([*animal.pairs, *(leg.name for leg in animal.legs)]), max_size=1)):
        number, factor = draw(st.sampled_from(["stiffness", "length", "angle", "offset"])), draw(st.floats(0.5, 1.5))
        here = getattr(animal.legs[animal.legs_named(owner)[0]], number)
        changes[f"{owner}.{number}"] = here * factor
    try:
        return animal.replace(**changes)
    except ls.ModelError as error:
        refused("replace", error)
        return animal


def spoilt(draw: st.DrawFn, arguments: dict[str, Any]) -> dict[str, Any]:
    """Return arguments, one of which may be replaced by something odd."""
    for name in draw(st.lists(st.sampled_from([*arguments]), max_size=1)):
        arguments[name] = draw(odd())
    return arguments


@st.composite
def place(draw: st.DrawFn, animal: ls.Animal) -> dict[str, Any]:
    """Return a slope, and a heading where the animal needs one."""
    low, high = animal.speed_law.domain_deg
    slope = {"slope_deg": draw(st.sampled_from([*2 * [low, high, 0.5 * (low + high)], 45.0]))}
    return slope | ({"heading": draw(st.floats(0.0, 0.5))} if animal.tuned else {})


def tried(what: str, call: Callable[[], Any]) -> Any:
    """Return what a call returns; None if it ends with an error that is allowed."""
    before = time.process_time()
    with np.errstate(all="ignore"):
        try:
            result = call()
        except (ValueError, ArithmeticError) as error:
            refused(what, error)
            return None
        finally:
            # The first one may compile.
            assert time.process_time() - before < LONGEST, "it takes too long"
    OUTCOMES[f"{what}: result"] += 1
    return result


def check_run(run: xr.Dataset) -> None:
    """Make sure that nothing is missing in a simulation but what legs in the air do not have."""
    for name, series in run.variables.items():
        if series.dtype.kind == "f":
            values = series.values
            if name in MISSING:
                down = run["stance"].values
                values = values[down]
            assert np.all(np.isfinite(values)), name


def check_gait(gait: ls.Gait) -> None:
    """Make sure that a gait says nothing that is no number, and repeats itself."""
    numbers = ["speed", "heading", "phase", "actuation", "multipliers", "mean_speed", "peak_force", "yaw_amplitude"]
    for name in (*numbers, "transport_cost", "reduced_eigenvalue"):
        assert np.all(np.isfinite(getattr(gait, name))) or name in gait.missing, (name, gait)
    run = ls.simulate(
        gait.animal,
        slope_deg=gait.slope_deg,
        heading=gait.heading,
        speed=gait.speed,
        phase=[*gait.phase],
        family=gait.family,
        actuation=gait.actuation,
        displacement=gait.displacement,
        yaw=gait.yaw,
        yaw_rate=gait.yaw_rate,
        memory=None if gait.contacts is None else gait.memory,
        strides=2,
    )
    check_run(run)
    velocity = run["velocity"].values
    growth = abs(gait.multipliers[0])
    allowed = 1e-6 * max(1.0, growth**2 if math.isfinite(growth) else math.inf)
    for later in (velocity[len(velocity) // 2], velocity[-1]):
        assert np.max(np.abs(later - velocity[0])) <= allowed * gait.speed, (gait, velocity[0], later)


@st.composite
def starts(draw: st.DrawFn) -> tuple[ls.Animal, dict[str, Any]]:
    """Return arguments of `simulate`."""
    animal = draw(animals())
    arguments = draw(place(animal)) | {
        "heading": draw(st.floats(-0.5, 0.5)),
        "speed": draw(st.floats(0.05, 2.0)),
        "phase": [draw(st.floats(-1.0, 1.0)) for _ in animal.pairs],
        "family": draw(st.sampled_from([*animal.families])),
        "actuation": draw(st.sampled_from([None, 0.005, [0.005] * len(animal.pairs)])),
        "displacement": draw(st.sampled_from([None, (0.0, 0.01)])),
        "yaw": draw(st.sampled_from([0.0, 0.1 if animal.body.yaw == "free" else 0.0])),
        "yaw_rate": draw(st.sampled_from([0.0, 1.0 if animal.body.yaw == "free" else 0.0])),
        "strides": draw(st.sampled_from([0.5, 1, 1, 2, 3])),
        "accuracy": draw(st.sampled_from([1e-9, 1e-11])),
    }
    return animal, spoilt(draw, arguments)


@examples(in_ci=300, share=0.1)
@given(given=starts())
def test_simulations(given: tuple[ls.Animal, dict[str, Any]]) -> None:
    animal, arguments = given
    run = tried("simulate", lambda: ls.simulate(animal, **arguments))
    if run is not None:
        check_run(run)


@examples(in_ci=60, share=0.03)
@given(animal=animals(), slope_deg=st.one_of(st.floats(-90.0, 90.0), odd()), family=st.one_of(st.none(), odd()))
def test_parameters(animal: ls.Animal, slope_deg: Any, family: Any) -> None:
    """What is listed has a direction, and an animal that is given its own numbers stays as it is."""
    where = {"slope_deg": slope_deg, "family": family}
    found = tried("parameters", lambda: ls.parameters(animal, **where))
    for one in found or ():
        assert one.unit and one.words and not math.isinf(one.value)
        if "." in one.name and math.isfinite(one.value) and not one.name.endswith(".phase"):
            assert animal.replace(**{one.name: one.value}) == animal, one
    if found:
        system = System(animal, next(p.value for p in found if p.name == "slope"), next(iter(animal.families)))
        for one in found:
            assert np.any(system.direction(one.name)) and np.all(np.isfinite(system.direction(one.name)))


@st.composite
def searches(draw: st.DrawFn) -> tuple[ls.Animal, dict[str, Any]]:
    """Return arguments of `find_gaits`."""
    animal = draw(animals())
    arguments = draw(place(animal)) | {"starts": draw(st.integers(1, 6))}
    more = {"family": draw(st.sampled_from([None, *animal.families]))}
    return animal, spoilt(draw, arguments | more)


@examples(in_ci=120, share=0.05)
@given(given=searches())
def test_gaits_repeat_themselves(given: tuple[ls.Animal, dict[str, Any]]) -> None:
    animal, arguments = given
    for gait in tried("find_gaits", lambda: ls.find_gaits(animal, **arguments)) or ():
        check_gait(gait)
        OUTCOMES["a gait that repeats itself"] += 1


@cache
def gaits() -> list[ls.Gait]:
    """Return a gait of each preset."""
    found = []
    for name in ls.presets():
        animal = ls.load_animal(name)
        found += ls.find_gaits(animal, starts=24, **place_of(animal))[:1]
    return found


@examples(in_ci=30, share=0.03)
@given(which=st.integers(0, 7), impulse=st.one_of(st.floats(-1.0, 1.0), odd()))
def test_recoveries(which: int, impulse: Any) -> None:
    # Of those that keep what a push gives them there is not much to ask.
    gait = gaits()[which % len(gaits())]
    recovery = tried("recover", lambda: gait.recover(impulse))
    if recovery is not None:
        assert np.all(np.isfinite(recovery.distance[: recovery.steps]))


def tuned() -> st.SearchStrategy[ls.Animal]:
    """Return animals that have atlases."""
    return animals().filter(lambda animal: animal.tuned)


@st.composite
def maps(draw: st.DrawFn) -> tuple[ls.Animal, dict[str, Any]]:
    """Return arguments of `atlas`."""
    arguments = {
        "slopes_deg": draw(st.sampled_from([(45.0,), (0.0, 90.0)])),
        "headings": (0.15,),
        "actuation": None,
        "impulses": draw(st.sampled_from([(), (0.1,)])),
        "starts": draw(st.integers(1, 4)),
        "workers": 1,
    }
    return draw(st.one_of(animals(), tuned())), spoilt(draw, arguments)


@examples(in_ci=25, share=0.02)
@given(given=maps())
def test_maps(given: tuple[ls.Animal, dict[str, Any]]) -> None:
    animal, arguments = given
    assume(not (isinstance(arguments["slopes_deg"], xr.DataArray) or isinstance(arguments["headings"], range)))
    found = tried("atlas", lambda: ls.atlas(animal, **arguments))
    if found is not None:
        there = found["family"].values != ""
        for name in ("speed", "reduced_eigenvalue", "transport_cost"):
            known = np.isfinite(found[name].values)
            assert not np.any(known & ~there), name
            assert np.array_equal(known, there) or found[name].attrs["missing"], name


@examples(in_ci=60, share=0.05)
@given(animal=animals(), name=st.sampled_from(["family", "objective", "map", "method"]), value=odd())
def test_words_of_the_optimisation(animal: ls.Animal, name: str, value: Any) -> None:
    # What is valid by chance takes long.
    assume(not (value is None or (isinstance(value, str) and value in animal.families)))
    here: dict[str, Any] = {"slope_deg": 45.0, "heading": 0.15, name: value}
    with pytest.raises(ValueError) as caught:
        ls.optimize(animal, **here)
    refused("optimize", caught.value)


@examples(in_ci=80, share=0.05)
@given(
    animal=animals(), name=st.sampled_from([*FACTORS, *CHOICES, "name", "legs", "body", "families", "[b]"]), value=odd()
)
def test_changes(animal: ls.Animal, name: str, value: Any) -> None:
    try:
        changed = animal.replace(**{name: value})
    except ls.ModelError as error:
        refused("replace", error)
    else:
        assert ls.Animal(**changed.model_dump()) == changed
        OUTCOMES["replace: result"] += 1
