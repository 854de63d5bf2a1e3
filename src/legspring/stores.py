"""Results of long sweeps on disk, as Zarr: block by block, each whole or not there, whatever happens.

A block is written, and only then marked as done, by a checksum: what is damaged, or gone, counts as not done. A store
appears at once with all that it is about, and holds nothing but numbers, texts and JSON.
"""

import hashlib
import json
import math
import os
import shutil
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from legspring.checks import shown
from legspring.leaving import undone_by

if TYPE_CHECKING:
    import xarray as xr
    import zarr

DONE = "done"
"""The array that says which blocks are."""
FORMAT = 1
"""Of the store; another one is refused."""
Block = tuple[int, ...]


@dataclass(frozen=True)
class Variable:
    """An array of a store.

    Attributes
    ----------
    dims
        Those of points, which are cut into blocks, come first.
    shape, dtype, fill
        Of the whole; what stands for what is not there.
    about
        Its attributes.
    """

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    dtype: str
    fill: float | int | str
    about: Mapping[str, Any]


@dataclass(frozen=True)
class Layout:
    """What a store, or a result in memory, consists of.

    Attributes
    ----------
    sizes, block
        Points along each of their dimensions; and how many of them make a block.
    variables, coords, attrs
        Arrays; coordinates as (dimensions, values, attributes); what is said of the whole.
    """

    sizes: Mapping[str, int]
    block: tuple[int, ...]
    variables: Mapping[str, Variable]
    coords: Mapping[str, tuple[Any, ...]]
    attrs: Mapping[str, Any]

    @property
    def counts(self) -> tuple[int, ...]:
        """Blocks along each dimension."""
        return tuple(-(-size // width) for size, width in zip(self.sizes.values(), self.block, strict=True))

    @property
    def blocks(self) -> list[Block]:
        """All blocks."""
        return list(product(*(range(count) for count in self.counts)))

    def where(self, block: Block) -> tuple[slice, ...]:
        """Return the points of a block."""
        sizes = zip(block, self.block, self.sizes.values(), strict=True)
        return tuple(slice(n * width, min((n + 1) * width, size)) for n, width, size in sizes)

    def shaped(self, block: Block, values: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Return the arrays of a block, whose first axis counts its points, in the form that the whole has."""
        shape = tuple(part.stop - part.start for part in self.where(block))
        return {name: array.reshape(*shape, *array.shape[1:]) for name, array in values.items()}

    def count(self, block: Block) -> int:
        """Return how many points a block has."""
        return math.prod(part.stop - part.start for part in self.where(block))


class InMemory:
    """A result that is kept in memory."""

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self.arrays = {name: np.full(v.shape, v.fill, dtype=v.dtype) for name, v in layout.variables.items()}

    def missing(self) -> list[Block]:
        """Return the blocks that are not done."""
        return self.layout.blocks

    def write(self, block: Block, values: Mapping[str, np.ndarray]) -> None:
        """Write a block."""
        for name, array in values.items():
            self.arrays[name][self.layout.where(block)] = array

    def dataset(self) -> "xr.Dataset":
        """Return the result."""
        import xarray as xr

        variables = {name: (v.dims, self.arrays[name], dict(v.about)) for name, v in self.layout.variables.items()}
        return xr.Dataset(variables, dict(self.layout.coords), dict(self.layout.attrs))


class OnDisk:
    """A result that is kept on disk, which `opened` opens."""

    def __init__(self, path: Path, layout: Layout, group: "zarr.Group") -> None:
        self.path, self.layout, self.group = path, layout, group

    def missing(self) -> list[Block]:
        """Return the blocks that are not done, or damaged."""
        return [block for block in self.layout.blocks if not self._is_done(block)]

    def _is_done(self, block: Block) -> bool:
        try:
            mark = int(self._array(DONE)[tuple(slice(n, n + 1) for n in block)].item())
            where = self.layout.where(block)
            return mark != 0 and mark == checksum(self._array(name)[where] for name in self.layout.variables)
        except Exception:  # whatever a damaged chunk leads to
            return False

    def write(self, block: Block, values: Mapping[str, np.ndarray]) -> None:
        """Write a block, and then that it is done."""
        for name, array in values.items():
            self._array(name)[self.layout.where(block)] = array
        mark = checksum(np.asarray(values[name], self._array(name).dtype) for name in self.layout.variables)
        self._array(DONE)[tuple(slice(n, n + 1) for n in block)] = mark

    def _array(self, name: str) -> Any:
        return self.group[name]

    def dataset(self) -> "xr.Dataset":
        """Return the result, of which only what is looked at is read."""
        return open_sweep(self.path)


def checksum(arrays: Iterable[np.ndarray]) -> int:
    """Return what proves that arrays are what was written; never 0."""
    digest = hashlib.blake2b(digest_size=8)
    for array in arrays:
        # One nan is as good as another.
        same = np.where(np.isnan(array), np.nan, array) if array.dtype.kind == "f" else array
        digest.update(np.ascontiguousarray(same).tobytes())
    return int.from_bytes(digest.digest(), "little") or 1


def open_sweep(path: str | os.PathLike[str]) -> "xr.Dataset":
    """Open the store of a sweep, finished or not; only what is looked at is read.

    Raises
    ------
    ValueError
        If it is no such store, or of another format.
    """
    import xarray as xr

    place = place_of(path)
    read_attrs(place, "the store of a sweep")
    try:
        with quiet():
            return xr.open_zarr(place, chunks=None, consolidated=False)
    except Exception:
        raise ValueError(f"store = {os.fspath(path)!r}: is damaged; the call that made it mends it") from None


def place_of(path: Any) -> Path:
    """Return where a store is: no link, so that there is one lock for it.

    Raises
    ------
    ValueError
        If it is no name of a folder.
    """
    if not isinstance(path, str | os.PathLike) or not isinstance(os.fspath(path), str) or not os.fspath(path):
        raise ValueError(f"store = {shown(path)}: must be the name of a folder")
    place = Path(os.path.realpath(path))
    if not place.name:
        raise ValueError(f"store = {os.fspath(path)!r}: must be the name of a folder")
    return place


def read_attrs(path: Path, wanted: str = "the store of a sweep, or a new folder") -> dict[str, Any]:
    """Return what is said of the whole; raise ValueError if a folder is no store of a sweep, or of another format."""
    import zarr

    try:
        attrs: dict[str, Any] = dict(zarr.open_group(path, mode="r").attrs)
        number = int(attrs["sweep_format"])
        attrs |= {"identity": json.loads(attrs["identity"]), "points": json.loads(attrs["points"])}
        attrs |= {name: tuple(map(int, attrs[name])) for name in ("block", "sizes")}
    except Exception:
        raise ValueError(f"store = {os.fspath(path)!r}: must be {wanted}") from None
    if number != FORMAT:
        raise ValueError(
            f"store = {os.fspath(path)!r}: is of format {number}, and this version of legspring reads format {FORMAT}"
        )
    return attrs


@contextmanager
def quiet() -> Iterator[None]:
    """Keep quiet about strings, which Zarr has no word for that all programs know."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


@contextmanager
def opened(path: str | os.PathLike[str], layout: Layout, identity: Mapping[str, Any]) -> Iterator[OnDisk]:
    """Open a store for one program, and make it if there is none.

    Parameters
    ----------
    path
        The folder.
    layout
        What it is to consist of; there may be more points along an axis than it has so far.
    identity
        What must be the same for a result to go on.

    Raises
    ------
    ValueError
        If it is something else, another sweep, of another version, or in use.
    """
    from filelock import FileLock, Timeout

    place = place_of(path)
    if not place.parent.is_dir():
        raise ValueError(f"store = {os.fspath(path)!r}: the directory {place.parent} must exist")
    lock = FileLock(place.parent / f".{place.name}.lock", timeout=0)
    try:
        lock.acquire()
    except Timeout:
        raise ValueError(f"store = {os.fspath(path)!r}: is in use by another program") from None
    try:
        restore(place)
        if place.exists() and not place.is_dir():
            raise ValueError(f"store = {os.fspath(path)!r}: must be a folder, and is a file")
        if not place.exists() or not any(place.iterdir()):
            create(place, layout, identity)
        yield join(place, layout, identity)
    finally:
        lock.release()


def block_in(path: str | os.PathLike[str] | None) -> tuple[int, ...] | None:
    """Return how many points make a block of a store; None if there is no such store yet."""
    if path is None:
        return None
    # Another program may just be putting a larger store in its place.
    place = place_of(path)
    there = [one for one in (place, before_of(place)) if one.is_dir() and any(one.iterdir())]
    block: tuple[int, ...] | None = read_attrs(there[0])["block"] if there else None
    return block


def before_of(place: Path) -> Path:
    """Return where a store is while a larger one takes its place."""
    return place.with_name(f".{place.name}.before")


def create(
    place: Path, layout: Layout, identity: Mapping[str, Any], fill: Callable[[Path], None] = lambda _: None
) -> None:
    """Make a store, which appears at once, in the place of what is there."""
    import zarr

    part, before = place.with_name(f".{place.name}.part"), before_of(place)

    def clean() -> None:
        shutil.rmtree(part, ignore_errors=True)

    clean()
    with undone_by(clean), quiet():
        group = zarr.open_group(part, mode="w", zarr_format=3)
        for name, variable in layout.variables.items():
            make_array(group, name, variable, layout)
        about = {"long_name": "checksum of a block; 0: it is not done"}
        done = Variable(tuple(layout.sizes), layout.counts, "uint64", 0, about)
        make_array(group, DONE, done, layout, ones=True)
        for name, (dims, values, *more) in layout.coords.items():
            write_coordinate(group, name, dims, values, more[0] if more else {})
        own: dict[str, Any] = {"sweep_format": FORMAT, "identity": json.dumps(identity), "block": list(layout.block)}
        own |= {
            "sizes": list(layout.sizes.values()),
            "points": json.dumps(digests_of(layout, tuple(layout.sizes.values()))),
        }
        group.attrs.update({**layout.attrs, **own})
        fill(part)
        if place.exists():
            place.rename(before)
        part.rename(place)
        shutil.rmtree(before, ignore_errors=True)


def restore(place: Path) -> None:
    """Put back a store that was to be replaced when its program was killed."""
    before = before_of(place)
    if before.exists():
        if place.exists():
            shutil.rmtree(before, ignore_errors=True)
        else:
            before.rename(place)


def make_array(group: Any, name: str, variable: Variable, layout: Layout, *, ones: bool = False) -> None:
    """Make an array, of which a block is a file with a checksum."""
    from zarr.codecs import Crc32cCodec, ZstdCodec

    chunks = (1,) * len(variable.shape) if ones else (*layout.block, *variable.shape[len(layout.block) :])
    array = group.create_array(
        name=name,
        shape=variable.shape,
        chunks=tuple(max(1, min(c, s)) if not ones else 1 for c, s in zip(chunks, variable.shape, strict=True)),
        dtype=variable.dtype,
        fill_value=variable.fill,
        compressors=[ZstdCodec(level=3), Crc32cCodec()],
        dimension_names=[f"block_{dim}" for dim in variable.dims] if ones else list(variable.dims),
    )
    array.attrs.update(dict(variable.about))


def write_coordinate(group: Any, name: str, dims: Any, values: Any, about: Mapping[str, Any]) -> None:
    """Write a coordinate."""
    numbers = np.asarray(values)
    if numbers.dtype.kind in "OU":
        numbers = numbers.astype(f"<U{max(1, *(len(str(one)) for one in numbers.ravel()))}")
    names = [dims] if isinstance(dims, str) else list(dims)
    group.create_array(name=name, data=numbers, dimension_names=names).attrs.update(dict(about))


def join(place: Path, layout: Layout, identity: Mapping[str, Any]) -> OnDisk:
    """Open a store that there is; let it grow if there are more points now, and mend what is not as it was made.

    A larger store, or a whole one, is made of the blocks of the old one, whose place it takes at once.

    Raises
    ------
    ValueError
        If it is of something else, or has other points, or more of them.
    """
    import zarr

    attrs, name = read_attrs(place), os.fspath(place)
    for key, value in identity.items():
        if attrs["identity"].get(key) != value:
            raise ValueError(
                f"store = {name!r}: is of another sweep, of which {key} is different; must be a new folder"
            )
    old, new = attrs["sizes"], tuple(layout.sizes.values())
    if len(old) != len(new) or any(n < o for o, n in zip(old, new, strict=True)):
        raise ValueError(f"store = {name!r}: has more points than are asked for; must not have fewer")
    for one, digest in digests_of(layout, old).items():
        if attrs["points"].get(one) != digest:
            raise ValueError(f"store = {name!r}: has other values of {one}; must be the same, or more after them")
    if old != new or not is_whole(place, layout):
        create(place, layout, identity, partial(with_blocks_of, place, old, layout))
    return OnDisk(place, layout, zarr.open_group(place, mode="r+"))


def digests_of(layout: Layout, sizes: tuple[int, ...]) -> dict[str, str]:
    """Return what tells coordinates of points from others, as far as there are so many points along each dimension."""
    count = dict(zip(layout.sizes, sizes, strict=True))
    found = {}
    for name, (dims, values, *_) in layout.coords.items():
        dim = dims if isinstance(dims, str) else dims[0]
        if dim in count:
            part = np.ascontiguousarray(np.asarray(values)[: count[dim]])
            found[name] = hashlib.sha256(part.tobytes()).hexdigest()
    return found


def is_whole(place: Path, layout: Layout) -> bool:
    """Whether all arrays of a store are there, as large as they are to be, and coordinates are what they were."""
    import zarr

    try:
        group: Any = zarr.open_group(place, mode="r")
        shapes = {name: variable.shape for name, variable in layout.variables.items()} | {DONE: layout.counts}
        if any(group[name].shape != shape for name, shape in shapes.items()):
            return False
        return all(np.array_equal(group[name][...], np.asarray(one[1])) for name, one in layout.coords.items())
    except Exception:  # whatever a damaged file leads to
        return False


def with_blocks_of(place: Path, old: tuple[int, ...], layout: Layout, part: Path) -> None:
    """Put the blocks of a store into a larger one."""
    import zarr

    for name in (*layout.variables, DONE):
        for path in sorted((place / name / "c").rglob("*")):
            if path.is_file():
                target = part / path.relative_to(place)
                target.parent.mkdir(parents=True, exist_ok=True)
                # A file that is written anew takes the place of another one, so both may be one till then.
                try:
                    os.link(path, target)
                except OSError:
                    shutil.copyfile(path, target)
    done: Any = zarr.open_group(part, mode="r+")[DONE]
    edges = zip(old, layout.sizes.values(), layout.block, strict=True)
    for axis, (before, after, width) in enumerate(edges):
        if after > before and before % width:
            last = slice(before // width, before // width + 1)
            done[tuple(last if n == axis else slice(None) for n in range(len(old)))] = 0


def finished(path: str | os.PathLike[str]) -> tuple[int, int]:
    """Return how many blocks of a store are done, and how many there are."""
    import zarr

    read_attrs(place_of(path), "the store of a sweep")
    done: Any = zarr.open_group(place_of(path), mode="r")[DONE]
    return int(np.count_nonzero(done[:])), int(np.prod(done.shape))
