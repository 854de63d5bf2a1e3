"""Output files: what is wrong with a path is said at once, and a file appears whole or not at all."""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

PathLike = str | os.PathLike[str]


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
    target = Path(path)
    # In the same directory, and so on the same disk, where moving is atomic.
    temporary = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        yield temporary
        temporary.replace(target)
    except OSError as error:
        raise type(error)(error.errno, error.strerror or str(error), str(target)) from error
    finally:
        temporary.unlink(missing_ok=True)


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
    with whole_file(path) as file:
        dataset.to_netcdf(file, engine="netcdf4")


def save_csv(dataset: "xr.Dataset", path: PathLike) -> None:
    """Save the time series of a simulation as a table: a row for each time, a column such as force_FL_lateral.

    Parameters
    ----------
    dataset
        Of `legspring.simulate`; its events, which have times of their own, are left out.
    path
        The file; it appears whole, or not at all.
    """
    columns = {"time": dataset["time"].values}
    for name, series in dataset.data_vars.items():
        if series.dims[0] == "time":
            labels = [[str(label) for label in dataset[dim].values] for dim in series.dims[1:]]
            for index in np.ndindex(series.shape[1:]):
                place = [labels[axis][number] for axis, number in enumerate(index)]
                columns["_".join([str(name), *place])] = series.values[:, *index]
    with whole_file(path) as file:
        table = np.column_stack(list(columns.values()))
        np.savetxt(file, table, fmt="%.12g", delimiter=",", header=",".join(columns), comments="")
