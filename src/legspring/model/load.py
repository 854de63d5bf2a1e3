"""Animals from files: the presets of the package and those of the user, in the same form."""

import tomllib
from functools import cache
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from legspring.model._base import ModelError
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
    each leg, as the presets do; or it names a preset in ``like`` and then gives any changes that
    `Animal.replace` takes. Units are SI, angles radians; ``angle_deg`` is in degrees.

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
    if name_or_path in presets():
        return _read(_PRESETS / f"{name_or_path}.toml")
    path = Path(name_or_path)
    if not path.exists() and path.suffix != ".toml":
        raise ModelError(
            f"no animal {fspath(name_or_path)!r}: must be a preset ({', '.join(presets())}) or a TOML file"
        )
    return _read(path)


def _read(path: Path) -> Animal:
    try:
        with path.open("rb") as file:
            fields = tomllib.load(file)
        return _build({"name": path.stem} | fields)
    except OSError as error:
        raise ModelError(f"{path}: {error.strerror}") from None
    except ValueError as error:  # of TOML, of its encoding or of the animal
        raise ModelError(f"{path}: {error}") from None


def _build(fields: dict[str, Any]) -> Animal:
    if "like" not in fields:
        return Animal(**fields)
    if (like := fields.pop("like")) not in presets():
        raise ModelError(f"like = {like!r}: must be a preset ({', '.join(presets())})")
    return load_animal(like).replace(**fields)
