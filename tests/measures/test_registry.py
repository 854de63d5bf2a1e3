"""The registry of measures, and that what it says is so."""

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import legspring as ls
from legspring import Animal, Gait, load_animal
from legspring.measures.registry import BY_NAME, MEASURES, OF_OPTIMA, OF_RECOVERIES, mapped, measured
from legspring.printing import describe_gait
from tests.places import place_of

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "gait.md"
each = pytest.mark.parametrize("name", ls.presets())


def first_gait(animal: Animal) -> Gait:
    return ls.find_gaits(animal, **place_of(animal))[0]


def numbers(value: object) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    return np.abs(np.asarray(value))


def test_names_are_unique() -> None:
    names = [measure.name for measure in (*MEASURES, *OF_RECOVERIES, *OF_OPTIMA)]
    assert len(set(names)) == len(names)


@each
def test_what_is_nan_is_missing_and_says_why(name: str) -> None:
    gait = first_gait(load_animal(name))
    values = measured(mapped(gait.animal), gait)
    nans = {of for of, value in values.items() if BY_NAME[of].unit and np.isnan(numbers(value)).any()}
    assert nans == set(gait.missing) & set(values)
    assert all(gait.missing.values())


@each
def test_shapes_are_those_of_the_dimensions(name: str) -> None:
    gait = first_gait(load_animal(name))
    sizes = {"leg": len(gait.animal.pairs), "single_leg": len(gait.animal.legs), "axis": 2}
    for measure in mapped(gait.animal):
        assert np.shape(measure.of(gait)) == tuple(sizes[dim] for dim in measure.dimensions), measure.name
        assert set(measure.attributes) == {"long_name", "units"} - (set() if measure.unit else {"units"})


@each
def test_json_has_all_of_them(name: str) -> None:
    gait = first_gait(load_animal(name))
    described = describe_gait(gait)
    assert list(described) == [measure.name for measure in MEASURES]
    assert described["net_force_max"] is gait.net_force[0] and described["missing"] == gait.missing


@each
def test_strides_speeds_and_lengths(name: str) -> None:
    gait = first_gait(load_animal(name))
    run = gait.simulate(strides=1)
    assert 1.0 / gait.stride_frequency == pytest.approx(run["time"].values[-1])
    way = run["position"].values[-1] - run["position"].values[0]
    assert gait.stride_length == pytest.approx(math.hypot(*way), rel=1e-6)
    assert gait.stride_length == pytest.approx(gait.mean_speed / gait.stride_frequency)
    lengths = [leg.length for leg in gait.animal.legs]
    assert gait.froude_number == pytest.approx(gait.mean_speed**2 / (gait.animal.gravity * sum(lengths) / len(lengths)))


def test_a_larger_runner_of_the_same_shape() -> None:
    """Four times as long and thirty times as heavy: times go with the root of the length."""
    small, large = load_animal("spring_loaded_inverted_pendulum"), 4.0
    big = small.replace(length=large, mass=30.0 * 80.0, stiffness=30.0 / large * 20e3, speed_law=2.0 * 5.20)
    for one, other in zip(ls.find_gaits(small), ls.find_gaits(big), strict=True):
        assert other.stride_frequency == pytest.approx(one.stride_frequency / math.sqrt(large))
        assert other.stride_length == pytest.approx(one.stride_length * large)
        assert other.froude_number == pytest.approx(one.froude_number)
        assert other.duty_factor == pytest.approx(one.duty_factor)
        assert other.energy == pytest.approx(30.0 * large * one.energy)


def test_hopping_in_place_has_strides_of_no_length() -> None:
    upright = load_animal("spring_loaded_inverted_pendulum").replace(angle_deg=180.0, speed_law=1.0)
    (gait,) = [gait for gait in ls.find_gaits(upright) if not gait.gets_on][:1]
    assert set(gait.missing) == {"transport_cost", "work", "reduced_eigenvalue", "lateral_drift"}
    assert (gait.stride_length, gait.froude_number) == pytest.approx((0.0, 0.0), abs=1e-6)
    assert 0.0 < gait.duty_factor[0] < 1.0 and gait.phase_lag == [0.0] and gait.stride_frequency > 0.0


def test_a_leg_that_is_not_put_down_has_no_phase_lag_and_is_named() -> None:
    gait = ls.find_gaits(load_animal("spring_loaded_inverted_pendulum"))[0]
    idle = gait.animal.legs[0].model_copy(update={"name": "R", "pair": "R", "offset": 0.5, "length": 0.1})
    animal = gait.animal.replace(legs=(*gait.animal.legs, idle))
    two = replace(gait, animal=animal, phase=(0.0, 0.0), actuation=(0.0, 0.0))
    np.testing.assert_array_equal(two.phase_lag, [0.0, math.nan])
    assert two.duty_factor == pytest.approx([gait.duty_factor[0], 0.0])
    assert two.missing["phase_lag"] == "not put down in a stride: R"


OTHER_NAMES = {"net_force": ("net_force_max", "net_force_min"), "multipliers": ("multipliers", "max_multiplier")}
"""Attributes that have another name, or more than one, in JSON and maps."""


def rows_of_the_page() -> list[tuple[list[str], str]]:
    """Return names and unit of each row of the page's table of what a gait offers."""
    _, rest = PAGE.read_text(encoding="utf-8").split("## What a gait offers", 1)
    rows = [line.split("|")[1:3] for line in rest.split("\n## ", 1)[0].splitlines() if line.startswith("| `")]
    return [(re.findall(r"`(\w+)[^`]*`", names), unit.strip()) for names, unit in rows]


def test_the_page_has_all_measures_with_their_units() -> None:
    units = {}
    for names, unit in rows_of_the_page():
        for attribute in names:
            assert attribute in Gait.__dataclass_fields__ or hasattr(Gait, attribute)
            for name in OTHER_NAMES.get(attribute, (attribute,)):
                assert name not in units
                units[name] = unit
    for measure in MEASURES:
        assert units.pop(measure.name) == measure.unit.replace("1", ""), measure.name
    assert list(units) == ["simulate", "animate", "recover"]
