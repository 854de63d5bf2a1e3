"""Output files: what is wrong with a path is said at once, and a file appears whole or not at all."""

import csv
import hashlib
import os
import platform
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from legspring.leaving import undone_by

if TYPE_CHECKING:
    import xarray as xr

PathLike = str | os.PathLike[str]
MARK = f"legspring-{hashlib.sha256(platform.node().encode()).hexdigest()[:8]}-"
"""What tells our unfinished files, those of this machine, from everybody else's."""


def check_output(path: PathLike, suffixes: Sequence[str]) -> None:
    """Make sure that a file can be written, before any work is done for it.

    Parameters
    ----------
    path
        The file to write.
    suffixes
        Endings of the formats that can be written, such as ``".png"``.

    Raises
    ------
    ValueError
        If the ending is another.
    OSError
        If the path is a directory, or its directory is missing or read-only.
    """
    target = Path(path)
    if target.suffix.lower() not in suffixes:
        raise ValueError(f"{target}: must end in {', '.join(suffixes)}")
    if target.is_dir():
        raise IsADirectoryError(f"{target}: is a directory; must be a file")
    if not target.parent.is_dir():
        raise FileNotFoundError(f"{target}: the directory {target.parent} must exist")
    if not os.access(target.parent, os.W_OK):
        raise PermissionError(f"{target}: the directory {target.parent} must be writable")


@contextmanager
def whole_file(path: PathLike) -> Iterator[Path]:
    """Yield a path to write to; the file moves to its place when the block ends without an error."""
    # Through links, to the file that they stand for.
    target = Path(os.path.realpath(path))
    # In the same directory, and so on the same disk, where moving is atomic.
    temporary = target.with_name(f".{target.name}.{MARK}{os.getpid()}.part")
    remove_abandoned(target.parent)
    with undone_by(temporary.unlink):
        try:
            yield temporary
            temporary.replace(target)
        except OSError as error:
            raise type(error)(error.errno, error.strerror or str(error), str(path)) from error
        finally:
            temporary.unlink(missing_ok=True)


def remove_abandoned(directory: Path) -> None:
    """Remove what `whole_file` was about to write when its process was killed."""
    for part in directory.glob(f".*.{MARK}*.part"):
        number = part.name.removesuffix(".part").rpartition(MARK)[2]
        if number.isdecimal() and not is_running(int(number)):
            # Where files in use cannot be removed, this fails, and is meant to.
            with suppress(OSError):
                part.unlink()


def is_running(number: int) -> bool:
    """Whether there may be a process of this number: where files in use can be removed, whether there is."""
    if os.name == "nt":
        return number == os.getpid()
    try:
        os.kill(number, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        pass
    return True


def make_directory(path: PathLike) -> None:
    """Make sure that there is a directory to write files to, before any work is done for them.

    Raises
    ------
    OSError
        If the path is a file, or the directory can be neither made nor written to.
    """
    directory = Path(path)
    if directory.exists() and not directory.is_dir():
        raise NotADirectoryError(f"{directory}: is a file; must be a directory")
    if not directory.parent.is_dir():
        raise FileNotFoundError(f"{directory}: the directory {directory.parent} must exist")
    directory.mkdir(exist_ok=True)
    if not os.access(directory, os.W_OK):
        raise PermissionError(f"{directory}: must be writable")


def save_netcdf(dataset: "xr.Dataset", path: PathLike) -> None:
    """Save a dataset as netCDF.

    Parameters
    ----------
    dataset
        Of `legspring.atlas` or `legspring.simulate`.
    path
        The file; it appears whole, or not at all.
    """
    # By way of memory: its library knows neither names of files that are no text nor full disks.
    written = dataset.to_netcdf(engine="netcdf4")
    with whole_file(path) as file:
        file.write_bytes(written)


def save_mat(dataset: "xr.Dataset", path: PathLike) -> None:
    """Save a dataset for MATLAB: its variables and coordinates by name, texts as cells.

    What is said about them is in three structures: units and long_name, by variable, and attributes, of the dataset.

    Parameters
    ----------
    dataset
        Of `legspring.atlas` or `legspring.simulate`.
    path
        The file; it appears whole, or not at all.
    """
    from scipy.io import savemat

    variables = {str(name): _for_matlab(array.values) for name, array in dataset.variables.items()}
    about = {
        what: {str(name): array.attrs[what] for name, array in dataset.variables.items() if what in array.attrs}
        for what in ("units", "long_name")
    }
    structures = about | {"attributes": {str(name): value for name, value in dataset.attrs.items()}}
    with whole_file(path) as file, file.open("wb") as stream:
        savemat(stream, variables | structures, long_field_names=True, do_compression=True, oned_as="column")


def _for_matlab(values: Any) -> Any:
    """Return texts as objects, which become cells; all else as it is."""
    return values.astype(object) if values.dtype.kind in "US" else values


def save_csv(
    dataset: "xr.Dataset", path: PathLike, rows: Sequence[str] | None = None, *, whole: bool | None = None
) -> None:
    """Save a dataset as a table: a row for each place in some dimensions, a column such as force_FL_lateral (m g).

    Parameters
    ----------
    dataset
        Of `legspring.simulate`, whose events, which have times of their own, are left out; or of gaits. Numbers that
        stand for words, as in ``outcome``, are written as these.
    path
        The file; it appears whole, or not at all.
    rows
        Dimensions that make the rows; the others make columns. By default, those of gaits in a sweep or a map, else
        ``time``.
    whole
        Whether rows in which all numbers are missing are not left out; by default in a sweep, where words say why.
    """
    is_sweep = "outcome" in dataset
    rows = rows if rows is not None else tuple(map(str, dataset["outcome"].dims)) if is_sweep else ("time",)
    whole = is_sweep if whole is None else whole
    dataset = in_words(dataset)
    table = dataset[
        [name for name, series in dataset.data_vars.items() if set(rows) <= set(series.dims) and series.size]
    ]
    table = table.stack(row=list(rows)) if len(rows) > 1 else table.rename({rows[0]: "row"})
    columns = {dim: table[dim].values for dim in rows if len(rows) > 1} or {rows[0]: table["row"].values}
    units = {name: dataset[name].attrs.get("units", "") for name in columns}
    for name, series in table.data_vars.items():
        values = series.transpose("row", ...)
        labels = [[str(label) for label in dataset[dim].values] for dim in values.dims[1:]]
        for index in np.ndindex(values.shape[1:]):
            column = "_".join([str(name), *(labels[axis][number] for axis, number in enumerate(index))])
            columns[column], units[column] = values.values[:, *index], series.attrs.get("units", "")
    if len(rows) > 1 and not whole:
        numbers = [column for name, column in columns.items() if name not in rows and column.dtype.kind == "f"]
        known = np.any(np.isfinite(np.array(numbers)), axis=0)
        columns = {name: column[known] for name, column in columns.items()}
    with whole_file(path) as file, file.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow([name if units[name] in ("", "1") else f"{name} ({units[name]})" for name in columns])
        for row in zip(*columns.values(), strict=True):
            writer.writerow([cell if isinstance(cell, str) else f"{cell:.12g}" for cell in row])


def in_words(dataset: "xr.Dataset") -> "xr.Dataset":
    """Return a dataset with words in the place of numbers that stand for them."""
    words = {}
    for name, series in dataset.data_vars.items():
        if "flag_meanings" in series.attrs:
            meanings = str(series.attrs["flag_meanings"]).split("; ")
            known = dict(zip(np.atleast_1d(series.attrs["flag_values"]).tolist(), meanings, strict=True))
            texts = np.array([known.get(one, "") for one in series.values.ravel().tolist()], dtype=object)
            words[name] = (series.dims, texts.reshape(series.shape))
    return dataset.assign(words)


SAVERS = {".nc": save_netcdf, ".csv": save_csv, ".mat": save_mat}
"""How datasets are saved, by the ending of a file."""


def code_stamp() -> str:
    """Return what identifies this version of the package: results of another one are not to be mixed with its own."""
    sources = sorted(Path(__file__).parent.rglob("*.py"))
    digest = hashlib.sha256(b"\0".join(path.read_bytes() for path in sources)).hexdigest()
    return f"{version('legspring')} {digest[:16]}"
