"""What is kept comes back bit by bit; what is damaged, foreign or of other code is missing; nothing of it can run."""

import json
import math
import pickle
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import legspring as ls
from legspring import pushing, roughness, settling
from legspring.constraints import Constraint
from legspring.exchange import KINDS
from legspring.memory import Memory
from legspring.objective import Candidate, Penalty, Score
from legspring.optimisation import End

ODD = np.array([0.1, -0.0, math.inf, math.nan, 5e-324, 1 / 3])
PENALTIES = (Penalty(Constraint.PHASE_LATEST, "F", 0.25), Penalty(Constraint.FIXED_POINT, "", math.inf))
VALUES: list[Any] = [
    [{"stability": [End(Score(ODD, ODD[:4], None, 1 / 3, PENALTIES), "converged")], "efficiency": []}],
    [None, {"phase": (0.1, -0.2), "peak_force": np.ones((3, 2)), "recovered": [], "grazing": np.float64(1 / 7)}],
    [Candidate(ODD, ODD)],
    [np.zeros((0, 3)), np.arange(3), np.array([True]), np.array(["B", ""])],
]


def same(one: Any, other: Any) -> bool:
    """Whether two values are alike to the last bit."""
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and one.shape == other.shape and one.tobytes() == other.tobytes()
    if isinstance(one, float):
        return np.float64(one).tobytes() == np.float64(other).tobytes()
    if isinstance(one, dict):
        return list(one) == list(other) and all(same(one[key], other[key]) for key in one)
    if isinstance(one, Score):
        return all(same(getattr(one, name), getattr(other, name)) for name in vars(one))
    if isinstance(one, list | tuple):
        return type(one) is type(other) and all(map(same, one, other)) and len(one) == len(other)
    return type(one) is type(other) and bool(one == other)


@pytest.fixture
def memory(tmp_path: Path) -> Memory:
    return Memory(tmp_path / "new" / "folder", "1", KINDS)


@pytest.mark.parametrize("value", VALUES)
def test_what_is_kept_comes_back(memory: Memory, value: Any) -> None:
    key = memory.key("f", [1.0])
    assert memory.get(key) is None and memory.spared == 0.0
    memory.put(key, value, 2.5)
    assert same(memory.get(key), value)
    assert memory.spared == 2.5


def test_keys_tell_arguments_and_versions_apart(memory: Memory, roach: ls.Animal) -> None:
    ways = [
        memory.key("f", [roach]),
        memory.key("g", [roach]),
        memory.key("f", [roach.replace(mass=3e-3)]),
        memory.key("f", (roach,)),
        memory.key("f", [roach, Candidate(ODD, ODD)]),
        memory.key("f", [roach, Candidate(ODD, ODD * 2)]),
        Memory(memory.directory, "2", KINDS).key("f", [roach]),
    ]
    assert len(set(ways)) == len(ways)
    assert memory.key("f", [roach.model_copy()]) == ways[0]


class Trap:
    """Leaves a trace where it is unpickled."""

    def __init__(self, trace: Path) -> None:
        self.trace = trace

    def __reduce__(self) -> tuple[Callable[..., None], tuple[Path]]:
        return Path.touch, (self.trace,)


DAMAGE: list[Callable[[bytes], bytes]] = [
    lambda _: b"",
    lambda data: data[:-5],
    lambda data: data[: len(data) // 2],
    lambda data: data.replace(b"0.5", b"0.6"),
    lambda _: b"\xff\xfe" * 50,
    lambda _: json.dumps([1, 2, 3]).encode(),
    lambda _: b"[" * 100_000,
]


@pytest.mark.parametrize("damage", DAMAGE)
def test_damaged_files_are_missing(memory: Memory, damage: Callable[[bytes], bytes]) -> None:
    key = memory.key("f")
    memory.put(key, [0.5, "x"], 1.0)
    (file,) = memory.directory.iterdir()
    file.write_bytes(damage(file.read_bytes()))
    assert memory.get(key) is None
    memory.put(key, [0.5, "x"], 1.0)
    assert memory.get(key) == [0.5, "x"]


def test_nothing_that_is_kept_runs(memory: Memory, tmp_path: Path) -> None:
    key = memory.key("f")
    memory.put(key, 1, 1.0)
    (file,) = memory.directory.iterdir()
    file.write_bytes(pickle.dumps(Trap(tmp_path / "trace")))
    assert memory.get(key) is None and not (tmp_path / "trace").exists()


def test_a_result_in_the_place_of_another_is_missing(memory: Memory) -> None:
    memory.put(memory.key("f"), 1, 1.0)
    (file,) = memory.directory.iterdir()
    file.rename(memory.directory / f"{memory.key('g')}.json")
    assert memory.get(memory.key("g")) is None


OVER = {"speed": np.linspace(0.1, 1.5, 65), "heading": np.linspace(-1.2, 1.2, 65)}


@pytest.mark.parametrize(
    ("where", "name", "ask"),
    [
        (settling.Settling, "__call__", partial(ls.basin, over=OVER)),
        (pushing.Trial, "__call__", partial(ls.pushes, directions=4, moments=2, impulses=[1, 5])),
        (roughness, "run_all", partial(ls.rough, roughness={"slope_deg": 20}, runs=64, strides=10)),
    ],
)
def test_what_was_stopped_goes_on_to_the_same_end(
    where: Any, name: str, ask: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gait = ls.find_gaits(ls.cockroach(), slope_deg=45, heading=0.15)[0]
    whole, work, calls = ask(gait, workers=1), getattr(where, name), list[int]()

    def counting(*arguments: Any, most: int = 1000) -> Any:
        calls.append(1)
        if len(calls) > most:
            raise KeyboardInterrupt
        return work(*arguments)

    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(where, name, lambda *arguments: counting(*arguments, most=1))
        ask(gait, workers=1, store=tmp_path)
    kept = len(list(tmp_path.iterdir()))
    with monkeypatch.context() as patch:
        patch.setattr(where, name, lambda *arguments: counting(*arguments))
        calls.clear()
        resumed, first = ask(gait, workers=1, store=tmp_path), len(calls)
        again = ask(gait, workers=1, store=tmp_path)
        assert kept == 1 and 0 < first == len(calls)
    for other in (resumed, again):
        xr.testing.assert_equal(whole, other)
