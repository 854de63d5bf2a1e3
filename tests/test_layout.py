"""Every parameter of every preset: its name, its place, and exact derivatives against differences of the oracle."""

import math
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import legspring as ls
from legspring import Animal, ModelError, load_animal
from legspring.flow import flow
from legspring.layout import BODY, START, System
from tests.oracle.animals import before_of, states_of
from tests.places import place_of

SLOPES = {"cockroach_rigid": 30.0}
STARTS = {"quadruped": 96, "walker": 32}
FASTER = {"hexapod": 1.1}
"""Of the gait of the hexapod one leg lifts off right when a step ends: a faster start keeps these apart."""
PRESETS = [pytest.param(name, marks=[pytest.mark.long] * (name == "centipede")) for name in ls.presets()]
Array = Any


def gait_of(name: str) -> ls.Gait:
    """Return a preset's first gait."""
    animal = load_animal(name)
    return ls.find_gaits(animal, starts=STARTS.get(name, 16), **place_of(animal, SLOPES.get(name, 45.0)))[0]


def end_of(gait: ls.Gait, p: Array) -> Callable[[str, float], Array]:
    """Return the end of a stride as a function of the change of a parameter, made by the animal's own means."""
    system = gait.system
    legs = [leg.name for leg in gait.animal.legs]
    phases = {name: float(p[system.place(i, "phase")]) for i, name in enumerate(legs)}
    starts = dict(zip(START, p.tolist(), strict=False))
    given = gait.animal.replace(**{f"{name}.actuation": p[system.place(i, "actuation")] for i, name in enumerate(legs)})

    def end(name: str, change: float) -> Array:
        animal, slope, start, phase = given, gait.slope, dict(starts), dict(phases)
        if name in START:
            start[name] += change
        elif name == "slope":
            slope += change
        elif name in BODY:
            here = system.values[system.along([name]).nonzero()[1][0]]
            animal = animal.replace(**{name: here + change})
        elif name.endswith("phase"):
            for leg in animal.legs_named(name[: -len(".phase")]) if "." in name else range(len(legs)):
                phase[legs[leg]] += change
        else:
            owner, _, quantity = name.rpartition(".")
            named = animal.legs_named(owner) if owner else animal.first_legs
            first = min(named, key=lambda i: animal.legs[i].offset)
            animal = animal.replace(**{name: system.values[system.place(first, quantity)] + change})
        asked = animal, slope, gait.family, start, phase
        return states_of(*asked, gait.system.steps_per_stride, before_of(gait))[-1]

    return end


def scale_of(system: System, name: str) -> float:
    """A natural size of a parameter."""
    length, duration = max(leg.length for leg in system.animal.legs), system.step_duration
    quantity = name.rpartition(".")[2]
    sizes = {"speed": system.desired_speed, "yaw_rate": 1.0 / duration, "damping": system.animal.body.mass / duration}
    sizes |= dict.fromkeys(("Dx", "Dy", "hip_x", "hip_y", "actuation"), length)
    if quantity in sizes or quantity in ("heading", "yaw", "turn", "slope", "phase", "angle", "offset", "stance"):
        return sizes.get(quantity, 1.0)
    return abs(float(system.values[system.direction(name).nonzero()[0][0]]))


def difference(end: Callable[[float], Array], h: float, side: int) -> Array:
    """Extrapolated differences, central or to one side."""
    if side:
        rows = [(end(side * h / 2**n) - end(0.0)) / (side * h / 2**n) for n in range(4)]
        for order in range(1, 4):
            rows = [b + (b - a) / (2**order - 1) for a, b in pairwise(rows)]
    else:
        rows = [(end(h / 2**n) - end(-h / 2**n)) / (2.0 * h / 2**n) for n in range(4)]
        for order in range(1, 4):
            rows = [b + (b - a) / (4**order - 1) for a, b in pairwise(rows)]
    return rows[0]


@pytest.mark.parametrize("preset", PRESETS)
def test_exact_derivatives_along_every_parameter(preset: str) -> None:
    gait = gait_of(preset)
    system, names = gait.system, [p.name for p in ls.parameters(gait.animal, slope=gait.slope)]
    start = gait.point * np.where(np.arange(len(gait.point)) == 0, FASTER.get(preset, 1.0), 1.0)
    end = end_of(gait, start)
    names = [name for name in names if name != "slope_deg"]
    assert {"speed", "heading", "mass", "gravity", "step_duration"} <= set(names)
    run = flow(system, start, steps=system.steps_per_stride, along=names, accuracy=1e-14)
    found = np.vstack([np.pad(run.state, ((0, 6 - system.rows), (0, 0))), run.seen[7:8]])
    home = end("speed", 0.0)
    length, speed, duration = max(leg.length for leg in gait.animal.legs), gait.speed, run.times[-1]
    units = np.array([length, length, speed, speed, 1.0, 1.0 / duration, duration])
    np.testing.assert_allclose(found[:, 0] / units, home / units, rtol=0, atol=1e-11)
    for column, name in enumerate(names, start=1):
        quantity, scale = name.rpartition(".")[2], scale_of(system, name)
        side = {"offset": 1, "stance": -1}.get(quantity, 0)
        if quantity in ("damping", "actuation") and not any(getattr(leg, quantity) for leg in gait.animal.legs):
            # There is none that could become less.
            side = 1
        # Old feet are on the point of leaving, too.
        h = 8e-6 if side else 2e-5 if preset in FASTER else 1e-4
        expected = difference(partial(end, name), scale * h, side) * scale / units
        exact = found[:, column] * scale / units
        # What is extrapolated from one side is not as good.
        tolerance = (3e-8 if side else 1e-8) * max(1.0, np.max(np.abs(expected)))
        np.testing.assert_allclose(exact, expected, rtol=0, atol=tolerance, err_msg=f"{preset}: {name}")


def test_a_list_of_what_can_vary(roach: Animal) -> None:
    found = {p.name: p for p in ls.parameters(roach, slope_deg=60, family="A")}
    assert found["mass"][1:3] == (2.5e-3, "kg")
    assert found["slope"].value == pytest.approx(math.radians(60)) and found["slope_deg"].value == pytest.approx(60)
    assert found["desired_speed"].value == pytest.approx(0.25)
    assert found["step_duration"].value == roach.step_duration(math.radians(60))
    assert found["M.angle"].value == pytest.approx(math.radians(-55))
    assert found["ML.angle"].value == pytest.approx(math.radians(55))
    assert found["MR.offset"].value == 0.0 and found["ML.offset"].value == 1.0
    # Phases are found, and the start is what a gait has.
    assert all(math.isnan(found[name].value) for name in ("F.phase", "BR.phase", "speed", "Dy"))
    assert not {"yaw", "turn", "inertia", "F.stance"} & set(found)
    # What all legs have alike.
    assert (found["stiffness"].value, found["damping"].value) == (1.5, 0.0)
    assert not {"length", "angle", "phase"} & set(found)
    assert all(p.unit and p.words for p in found.values())


def test_names_of_pairs_and_legs() -> None:
    single = load_animal("single_leg")
    assert {p.name for p in ls.parameters(single, slope_deg=45)} >= {"speed", f"{single.pairs[0]}.stiffness"}
    # A pair and a leg of one name are the same where the pair has one leg; else the name has two readings.
    leg = single.legs[0].model_copy(update={"name": "L", "pair": "L", "offset": 0.0})
    alone = single.replace(legs=[leg], families={"P": ("L",)})
    assert alone.legs_named("L") == (0,)
    names = [leg.model_copy(update={"name": {"FL": "F"}.get(leg.name, leg.name)}) for leg in ls.cockroach().legs]
    twofold = ls.cockroach().replace(legs=names)
    with pytest.raises(ModelError, match="'F' is both the pair of legs F, FR and the leg F"):
        twofold.replace(**{"F.stiffness": 1.0})
    with pytest.raises(ValueError, match="'F' is both the pair"):
        System(twofold, 0.5, "A").direction("F.stiffness")


def test_directions_of_all_legs_need_legs_that_are_alike(roach: Animal) -> None:
    system = System(roach, 0.5, "A")
    all_legs = system.direction("stiffness")
    pairs = sum(system.direction(f"{pair}.stiffness") for pair in roach.pairs)
    legs = sum(system.direction(f"{leg.name}.stiffness") for leg in roach.legs)
    np.testing.assert_array_equal(all_legs, pairs)
    np.testing.assert_array_equal(all_legs, legs)
    # Angles are mirrored.
    angle = system.direction("F.angle")
    assert angle[system.place(0, "angle")] == 1.0 and angle[system.place(3, "angle")] == -1.0
    with pytest.raises(ValueError, match=r"length.*must be that of one pair or leg, such as F\.length"):
        system.direction("length")
    for name in ("colour", "F.colour", "X.length", "FL", ""):
        with pytest.raises(ValueError):
            system.direction(name)


def test_the_slope_moves_what_the_laws_say(roach: Animal) -> None:
    h = 1e-6
    for slope in (0.5, 1.0):
        ahead, behind = (System(roach, slope + change, "A") for change in (h, -h))
        direction = System(roach, slope, "A").direction("slope")
        difference = (ahead.values - behind.values) / (2.0 * h)
        # Where the feet of the step before are is given by a start.
        np.testing.assert_allclose(direction[7:], difference[7:], rtol=1e-7, atol=1e-9)
        assert np.all(direction[:7] == 0.0)
        assert System(roach, slope, "A").one_sided("slope") is None
    pinned = System(roach, 0.5, "A").direction("slope", pinned=("desired_speed",))
    assert np.count_nonzero(pinned) == 1
    constant = System(roach.replace(step_duration=0.05), 0.5, "A").direction("slope_deg")
    assert np.count_nonzero(constant) == 2
    assert constant[7] == pytest.approx(math.pi / 180)


def test_derivatives_at_the_kink_of_the_step_law_are_one_sided(roach: Animal) -> None:
    """On level ground the desired speed is the one from which the frequency is constant."""
    system, h = System(roach, 0.0, "A"), 1e-7
    uphill = (System(roach, h, "A").values - system.values)[12] / h
    assert system.direction("slope")[12] == pytest.approx(uphill, rel=1e-5)
    assert system.direction("desired_speed")[12] == 0.0
    assert "kink at 0.35 m/s" in str(system.one_sided("slope"))
    words = {p.name: p.words for p in ls.parameters(roach, slope_deg=0)}
    assert "kink" in words["slope_deg"] and "kink" in words["desired_speed"] and "kink" not in words["mass"]
    assert "later" in words["F.offset"] and "later" not in words["FR.offset"]
    assert "more" in words["damping"] and "more" not in words["F.actuation"]


def test_stances_of_whole_steps_can_only_become_shorter(roach: Animal) -> None:
    for stance, shorter in ((1.0, True), (0.8, False)):
        system = System(roach.replace(stance=stance), 0.5, "A")
        assert ("shorter" in str(system.one_sided("F.stance"))) == shorter


def test_any_number_of_an_animal_may_be_replaced(roach: Animal) -> None:
    changed = roach.replace(**{"FL.stiffness": 0.75, "M.angle": -1.0, "B.hip_x": 0.001, "F.offset": 0.1, "mass": 3e-3})
    assert [leg.stiffness for leg in changed.legs] == [0.75, 1.5, 1.5, 1.5, 1.5, 1.5]
    assert [leg.angle for leg in changed.legs if leg.pair == "M"] == [-1.0, 1.0]
    assert [leg.hip for leg in changed.legs if leg.pair == "B"] == [(0.001, 0.0), (-0.001, 0.0)]
    assert [leg.offset for leg in changed.legs if leg.pair == "F"] == [0.1, 1.1]
    assert changed.body.mass == 3e-3
    assert roach.mirrored and not changed.mirrored and changed.odd_pair == "F"
    fast = roach.replace(desired_speed=0.3, step_duration=0.04)
    assert (fast.desired_speed(0.5), fast.step_duration(0.5)) == (0.3, 0.04)
    for name, value in (("FL.colour", 1.0), ("X.angle", 1.0), ("FL.stiffness", -1.0), ("FL.stiffness", "soft")):
        with pytest.raises(ModelError):
            roach.replace(**{name: value})
    with pytest.raises(ModelError, match="both given"):
        roach.replace(desired_speed=0.3, speed_law=0.3)


def test_a_limping_animal_is_simulated(roach: Animal) -> None:
    limping = roach.replace(**{"FL.stiffness": 0.75})
    start: dict[str, Any] = {
        "slope_deg": 45,
        "heading": 0.15,
        "speed": 0.27,
        "phase": (-0.05, 0.55, -0.67),
        "family": "B",
    }
    one, other = (ls.simulate(animal, **start)["position"].values[-1] for animal in (roach, limping))
    assert np.max(np.abs(one - other)) > 1e-4


@pytest.mark.parametrize("preset", PRESETS)
def test_an_animal_with_its_own_numbers_stays_as_it_is(preset: str) -> None:
    animal = load_animal(preset)
    for one in ls.parameters(animal, slope_deg=place_of(animal)["slope_deg"]):
        # A phase that is not given, because nothing depends on it, counts as 0.
        laws = ("slope", "slope_deg", "desired_speed", "step_duration")
        if math.isfinite(one.value) and one.name not in laws and not one.name.endswith("phase"):
            assert animal.replace(**{one.name: one.value}) == animal, one
