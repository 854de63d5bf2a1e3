"""Files of animals, near to valid ones and far from them: each gives an animal, or an error of one line."""

import copy
import json
import math
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import legspring as ls
from legspring.figures import draw_animal
from legspring.printing import describe_animal, plain
from tests.fuzz.trying import OUTCOMES, deep, examples, refused, text

FULL = [ls.load_animal(name).model_dump(mode="json", exclude_defaults=True) for name in ls.presets()]
CHANGES: dict[str, Any] = {
    "mass": 3e-3, "inertia": 2e-7, "yaw": "free", "gravity": 1.6, "speed_law": 0.3, "step_law": 0.05,
    "hip": [[0.0, 0.001]], "length": 0.03, "stiffness": [1.5, 1.5, 2.0], "angle_deg": 30.0, "angle": 0.3,
    "actuation": 0.004, "phase": 0.2, "function": "pull", "offset": 0, "touchdown": "ground", "follows": "FL",
    "stance": 0.9, "damping": 0.1, "length_law": "l0 - ldev*sin(pi*t + phi)", "name": "n", "families": {"A": ["F"]},
    "legs": [], "domain_deg": [0, 90], "summary": "s",
}  # fmt: skip
FORMULAS = [
    "l0",
    "t/0",
    "sqrt(-1)",
    "l0**t",
    "((((" * 40,
    "exp(exp(exp(t)))",
    "l0+ldev*t**2",
    "__import__('os')",
    "1e400",
    "x",
]


def toml(value: Any) -> str:
    """Write a value as TOML does, if it can."""
    match value:
        case dict():
            return "{" + ", ".join(f"{json.dumps(str(key))} = {toml(part)}" for key, part in value.items()) + "}"
        case list() | tuple():
            return "[" + ", ".join(map(toml, value)) + "]"
        case float() if not math.isfinite(value):
            return str(value)
        case bool() | str():
            return json.dumps(value)
    return repr(value)


def values() -> st.SearchStrategy[Any]:
    """Return values of all kinds, some of them valid somewhere."""
    return st.one_of(
        st.floats(),
        st.floats(0.001, 2.0),
        st.integers(),
        st.sampled_from(
            [
                10**400,
                1e308,
                5e-324,
                True,
                [],
                {},
                deep(100),
                [[0.1, 0.2]],
                "free",
                "ground",
                "lift-off",
                "a\0.toml",
                "a.toml",
            ]
        ),
        st.sampled_from(FORMULAS),
        text(),
        st.sampled_from([*CHANGES.values()]),
        st.lists(st.floats(), max_size=4),
    )


def places(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Return the ways to all parts of a value."""
    found = [path] if path else []
    parts = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return found + [place for key, part in parts for place in places(part, (*path, key))]


def spoil(draw: st.DrawFn, whole: Any, place: tuple[Any, ...]) -> None:
    """Change something in one place."""
    *way, last = place
    for key in way:
        whole = whole[key]
    match draw(st.sampled_from(["replace", "scale", "scale", "remove", "add", "twice"])):
        case "scale" if isinstance(whole[last], float):
            whole[last] *= draw(st.floats(-2.0, 3.0))
        case "remove":
            del whole[last]
        case "add" if isinstance(whole, dict):
            whole[draw(text())] = copy.deepcopy(draw(values()))
        case "twice" if isinstance(whole, list):
            whole.append(copy.deepcopy(whole[last]))
        case _:
            whole[last] = copy.deepcopy(draw(values()))


@st.composite
def fields(draw: st.DrawFn) -> dict[str, Any]:
    """Return what a file may say: an animal in full or like another one, with something changed here and there."""
    if draw(st.booleans()):
        whole = copy.deepcopy(draw(st.sampled_from(FULL)))
    else:
        names = draw(st.lists(st.sampled_from([*CHANGES]), max_size=4))
        whole = {"like": draw(st.sampled_from(ls.presets()))} | {name: copy.deepcopy(CHANGES[name]) for name in names}
    for _ in range(draw(st.integers(0, 3))):
        if everywhere := places(whole):
            spoil(draw, whole, draw(st.sampled_from(everywhere)))
    return whole


@st.composite
def files(draw: st.DrawFn) -> bytes:
    """Return what may be in a file."""
    if draw(st.integers(0, 19)) == 0:
        return draw(st.one_of(st.binary(max_size=200), st.sampled_from([b"a=" + b"[" * 5000, b"a." * 5000 + b"a=1"])))
    ending = draw(st.sampled_from(["\n", "\n", "\n", "\r\n", "\r"]))
    lines = ending.join(f"{json.dumps(str(name))} = {toml(value)}" for name, value in draw(fields()).items())
    encoding = draw(st.sampled_from(["utf-8"] * 6 + ["utf-8-sig", "utf-16", "latin-1"]))
    content = lines.encode(encoding, "replace")
    if draw(st.integers(0, 9)) == 0:
        place = draw(st.integers(0, len(content)))
        content = content[:place] + draw(st.binary(max_size=3)) + content[place + draw(st.integers(0, 3)) :]
    return content


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("animals")


@examples(in_ci=350, share=0.6)
@given(content=files(), drawn=st.integers(0, 19))
def test_a_file_is_an_animal_or_an_error_of_one_line(folder: Path, content: bytes, drawn: int) -> None:
    file = folder / "animal.toml"
    file.write_bytes(content)
    try:
        animal = ls.load_animal(file)
    except ls.ModelError as error:
        refused("file", error)
        return
    assert ls.Animal(**animal.model_dump()) == animal
    assert ls.Animal(**json.loads(animal.model_dump_json())) == animal
    json.dumps({name: plain(value) for name, value in describe_animal(animal).items()}, allow_nan=False)
    if drawn == 0:
        draw_animal(animal)
    OUTCOMES["file: animal"] += 1


@examples(in_ci=60, share=0.01)
@given(name=st.one_of(text(), st.text(max_size=300).map(lambda text: f"{text}.toml")))
def test_a_name_is_that_of_an_animal_or_an_error_of_one_line(name: str) -> None:
    try:
        ls.load_animal(name)
    except ls.ModelError as error:
        refused("name", error)
