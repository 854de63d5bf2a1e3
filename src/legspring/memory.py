"""What a long computation has done, kept on disk, so that one that was stopped goes on where it was.

JSON, and nothing that could run: folders travel. Floats come back bit by bit. Each file holds its own checksum; what is
damaged, or foreign, counts as missing.
"""

import base64
import hashlib
import json
import os
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import fields, is_dataclass
from enum import Enum
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from pydantic import BaseModel

from legspring.files import code_stamp, whole_file

T = TypeVar("T")


class Memory:
    """Results by keys.

    Parameters
    ----------
    directory
        Where they are kept; it is made if it is missing.
    stamp
        What all results depend on, such as the version of the code.
    kinds
        Dataclasses, named tuples and enumerations that results may contain, beside numbers, text, None, arrays, lists,
        tuples and dictionaries.
    """

    def __init__(self, directory: Path, stamp: str, kinds: Sequence[type]) -> None:
        self.directory, self.stamp = directory, stamp
        self._kinds = {kind.__name__: kind for kind in kinds}
        self._spared: list[float] = []
        directory.mkdir(parents=True, exist_ok=True)

    def key(self, *what: Any) -> str:
        """Return the key of something: of what was called, and with which arguments."""
        return hashlib.sha256(json.dumps([self.stamp, encoded(what)]).encode()).hexdigest()

    def get(self, key: str) -> Any:
        """Return what is kept, or None."""
        with suppress(Exception):  # whatever a damaged or foreign file leads to
            digest, text = self._path(key).read_text(encoding="utf-8").split("\n", 1)
            if digest == checksum(key, text):
                seconds, kept = json.loads(text)
                value = self._decoded(kept)
                self._spared.append(float(seconds))
                return value
        return None

    def put(self, key: str, value: Any, seconds: float) -> None:
        """Keep something that took so long."""
        text = json.dumps([seconds, encoded(value)])
        with whole_file(self._path(key)) as file:
            file.write_text(f"{checksum(key, text)}\n{text}", encoding="utf-8")

    @property
    def spared(self) -> float:
        """How long it took at its time, in seconds, what did not have to be done again."""
        return sum(self._spared)

    def _path(self, key: str) -> Path:
        return self.directory / f"{key}.json"

    def _decoded(self, value: Any) -> Any:
        """Return what was encoded."""
        if isinstance(value, list):
            return [self._decoded(item) for item in value]
        if not isinstance(value, dict):
            return value
        ((name, inside),) = value.items()
        if name == "array":
            kind, shape, text = inside
            # A copy, which may be written to.
            return np.frombuffer(base64.b64decode(text), dtype=kind).reshape(shape).copy()
        parts = self._decoded(inside)
        if name == "tuple":
            return tuple(parts)
        return dict(parts) if name == "dict" else self._kinds[name](*parts)


def opened(store: str | os.PathLike[str] | None, *about: Any) -> Memory | None:
    """Return the memory, in a directory, of a computation about something; None if nothing is to be kept."""
    if store is None:
        return None
    memory = Memory(Path(store), code_stamp(), ())
    memory.stamp = memory.key(*about)
    return memory


def recalled(memory: Memory | None, work: Callable[[], T], *what: Any) -> T:
    """Return what is kept under some words, or what the work gives, which is kept then."""
    if memory is None:
        return work()
    key = memory.key(*what)
    found: T | None = memory.get(key)
    if found is None:
        begin = time.perf_counter()
        found = work()
        memory.put(key, found, time.perf_counter() - begin)
    return found


def digest(*arrays: np.ndarray) -> str:
    """Return what tells arrays from others, in short."""
    return hashlib.sha256(b"\0".join(np.ascontiguousarray(array).tobytes() for array in arrays)).hexdigest()


def checksum(key: str, text: str) -> str:
    """Return what proves that a text is whole, and in its place."""
    return hashlib.sha256(f"{key} {text}".encode()).hexdigest()


def encoded(value: Any) -> Any:
    """Return a value as JSON has it: what JSON has no word for, as an object of one name."""
    match value:
        case Enum():
            return {type(value).__name__: [value.value]}
        case None | bool() | int() | float() | str():
            return value
        case np.generic():
            return encoded(value.item())
        case np.ndarray() if value.dtype.kind in "bifU":
            return {"array": [value.dtype.str, value.shape, base64.b64encode(value.tobytes()).decode()]}
        case dict():
            return {"dict": [[encoded(key), encoded(item)] for key, item in value.items()]}
        case list():
            return [encoded(item) for item in value]
        case tuple():
            name = type(value).__name__ if type(value) is not tuple else "tuple"
            return {name: [encoded(item) for item in value]}
        case BaseModel():
            return {type(value).__name__: value.model_dump(mode="json")}
    if is_dataclass(value):
        return {type(value).__name__: [encoded(getattr(value, field.name)) for field in fields(value)]}
    raise TypeError(f"{type(value).__name__}: cannot be kept")
