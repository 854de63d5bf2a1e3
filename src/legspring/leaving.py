"""Leaving the program at once: what has to be undone then, such as half-written files and worker processes."""

import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import NoReturn

LONGEST = 0.7
"""Seconds after which the program has left, whatever happens."""
_undoings: dict[object, Callable[[], object]] = {}


@contextmanager
def undone_by(undo: Callable[[], object]) -> Iterator[None]:
    """While the block runs, leaving at once calls a function first."""
    key = object()
    _undoings[key] = undo
    try:
        yield
    finally:
        _undoings.pop(key, None)


def leave(message: str, status: int) -> NoReturn:
    """Undo what is half done, print a line on the error stream, and end the process without waiting for anything."""
    # A pipe that nobody reads must not hold it up.
    timer = threading.Timer(LONGEST, os._exit, [status])
    timer.daemon = True
    timer.start()
    if message:
        # A progress bar leaves an unfinished line, and no cursor.
        start = "\r\x1b[K\x1b[?25h" if sys.stderr.isatty() else ""
        with suppress(OSError):
            # Another thread may hold the stream's lock.
            os.write(2, f"{start}{message}\n".encode())
    with suppress(OSError):
        # What other threads say when they find that their processes are gone is of no interest.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    for undo in [*_undoings.values()]:
        with suppress(Exception):
            undo()
    with suppress(Exception):
        sys.stdout.flush()
    os._exit(status)
