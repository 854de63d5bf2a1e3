"""Animals from files: the presets of the package and those of the user, in the same form."""

import os
import tomllib
from collections.abc import Callable
from functools import cache
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from legspring.checks import shown
from legspring.model._base import LONGEST_LABEL, ModelError
from legspring.model.animal import Animal

# Not in a folder named "presets": imported as a package, it would hide the function of that name.
_PRESETS = Path(__file__).with_name("animals")


def presets() -> tuple[str, ...]:
    """Return the names of the animals that come with the package.

    Returns
    -------
    tuple of str
        The names, sorted.
    """
    return tuple(sorted(file.stem for file in _PRESETS.glob("*.toml")))


@cache
def cockroach() -> Animal:
    """Return the cockroach of the thesis (Table 4.1): a point mass on six actuated legs.

    Returns
    -------
    Animal
        The preset "cockroach".

    Examples
    --------
    >>> cockroach().pairs
    ('F', 'M', 'B')
    """
    return load_animal("cockroach")


def load_animal(name_or_path: str | PathLike[str]) -> Animal:
    """Read an animal from a preset or a TOML file.

    A file either describes an animal in full, with the fields of `Animal` and a table ``[[legs]]`` for
    each leg, as the presets do; or it names a preset or another file in ``like``, its path as seen from
    this one, and then gives any changes that `Animal.replace` takes, and legs that it is ``without``, as in
    ``without = ["FL"]``. Units are SI, angles radians; ``angle_deg`` is in degrees.

    Parameters
    ----------
    name_or_path : str or path
        A preset's name, or the path of a TOML file.

    Returns
    -------
    Animal
        The animal; its name is the file's, without the ending, unless the file says another.

    Raises
    ------
    ModelError
        If there is no such preset or file, or the file's text or its animal is not valid.
    """
    if not isinstance(name_or_path, str | PathLike):
        raise ModelError(f"no animal {shown(name_or_path)}: must be a preset ({', '.join(presets())}) or a TOML file")
    return _read(_find(fspath(name_or_path), Path(), "no animal {}"), ())


def _find(name: str, folder: Path, about: str) -> Path:
    """Return the file of a preset, or another one, seen from a folder."""
    if name in presets():
        return _PRESETS / f"{name}.toml"
    path = folder / name
    # No system has such a name; one that is too long does not exist.
    if "\0" in name or not (os.path.exists(path) or path.suffix == ".toml"):
        raise ModelError(f"{about.format(shown(name))}: must be a preset ({', '.join(presets())}) or a TOML file")
    return path


def _read(path: Path, before: tuple[Path, ...]) -> Animal:
    """Read a file that others, read before, are like."""
    # The path in words, whatever bytes the system has in its name.
    words, stem = (text.encode("utf-8", "backslashreplace").decode() for text in (str(path), path.stem))
    make: Callable[..., Animal] = Animal
    gone: list[str] = []
    fields = {"name": stem[:LONGEST_LABEL]} | _fields(path, words)
    if "like" in fields:
        like, here = fields.pop("like"), path.resolve()
        if not isinstance(like, str):
            raise ModelError(f"{words}: like = {shown(like)}: must be the name of a preset or of a TOML file")
        other = _find(like, path.parent, f"{words}: like = {{}}")
        if other.resolve() in (*before, here):
            raise ModelError(f"{words}: like = {shown(like)}: must be a file that is not like this one")
        make = _read(other, (*before, here)).replace
        gone = _legs_gone(fields.pop("without", []), words)
    try:
        animal = make(**fields)
        return animal.without(*gone) if gone else animal
    except ValueError as error:
        raise ModelError(f"{words}: {error}") from None


def _legs_gone(without: Any, words: str) -> list[str]:
    """Return the legs that an animal is without, if that is what they are."""
    if not isinstance(without, list) or not all(isinstance(leg, str) for leg in without):
        raise ModelError(f"{words}: without = {shown(without)}: must be a list of names of legs, or of pairs")
    return without


def _fields(path: Path, words: str) -> dict[str, Any]:
    """Return what a file says."""
    try:
        # Editors of Windows put a mark at the beginning.
        return tomllib.loads(path.read_bytes().decode("utf-8-sig").replace("\r\n", "\n"))
    except OSError as error:
        raise ModelError(f"{words}: {error.strerror}") from None
    except ValueError as error:  # of TOML, or of its encoding
        raise ModelError(f"{words}: {error}") from None
    except RecursionError:
        raise ModelError(f"{words}: must be no deeper than what an animal is made of") from None
