"""Output files: what is wrong with a path is said at once, and a file appears whole or not at all."""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

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
        raise ValueError(f"{target}: should end in {' or '.join(suffixes)}")
    if target.is_dir():
        raise IsADirectoryError(f"{target}: is a directory; should be a file")
    if not target.parent.is_dir():
        raise FileNotFoundError(f"{target}: the directory {target.parent} should exist")
    if not os.access(target.parent, os.W_OK):
        raise PermissionError(f"{target}: the directory {target.parent} should be writable")


@contextmanager
def whole_file(path: PathLike) -> Iterator[Path]:
    """Yield a path to write to; the file moves to its place when the block ends without an error."""
    target = Path(path)
    # In the same directory, and so on the same disk, where moving is atomic.
    temporary = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        yield temporary
        temporary.replace(target)
    finally:
        temporary.unlink(missing_ok=True)
