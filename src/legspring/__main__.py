"""The command `legspring`, as a program that a signal ends at once.

The command works in a thread of its own, so that this one is free to answer, also while a library works in compiled
code. Only what is needed for that is imported here.
"""

import io
import logging
import os
import signal
import sys
import threading
import traceback
from contextlib import suppress
from types import FrameType

from legspring.leaving import leave
from legspring.messages import one_line

WORDS = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}
NOT_PRINTED, MISTAKE = 1, 70
"""Exit statuses of the program, beside those of the commands: nobody reads on, and an error of its own."""


def stop(number: int, _: FrameType | None = None) -> None:
    """Leave the program for a signal; further ones change nothing."""
    ignore()
    leave(f"legspring: {WORDS[signal.Signals(number)]}", 128 + number)


def ignore() -> None:
    """Heed no more signals."""
    for number in WORDS:
        signal.signal(number, signal.SIG_IGN)


def tell(message: str) -> None:
    """Print a line on the error stream, if anybody listens."""
    with suppress(OSError):
        print(one_line(f"legspring: {message}"), file=sys.stderr, flush=True)


class Notices(logging.Handler):
    """Prints what the package has to say while it works, each thing once, on the error stream."""

    def __init__(self) -> None:
        super().__init__()
        self.said: set[str] = set()

    def emit(self, record: logging.LogRecord) -> None:
        """Print a message."""
        message = record.getMessage()
        if message not in self.said:
            self.said.add(message)
            tell(message)


def streams() -> None:
    """See to it that whatever is said can be printed, and that there is something to print to."""
    # There is none where it has been closed.
    sys.stdout, sys.stderr = (stream or io.StringIO() for stream in (sys.stdout, sys.stderr))
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def work(ends: list[int]) -> None:
    """Carry out the command; note the exit status."""
    try:
        from legspring.cli import app

        app(prog_name="legspring")
    except SystemExit as end:
        ends.append(int(end.code or 0))
    except BrokenPipeError:
        ends.append(NOT_PRINTED)
    except BaseException as error:
        if os.environ.get("LEGSPRING_DEBUG"):
            traceback.print_exc()
        shown = f"a mistake in Legspring itself (LEGSPRING_DEBUG=1 shows where): {type(error).__name__}: {error}"
        ends.append(MISTAKE)
        tell(shown)


def printed(status: int) -> int:
    """Return the exit status, another one if not all that was printed got to where it was to go."""
    try:
        sys.stdout.flush()
    except OSError as error:
        # What is left is not to be tried again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not status and not isinstance(error, BrokenPipeError):
            tell(f"standard output: {error.strerror}")
        return status or NOT_PRINTED
    return status


def main() -> None:
    """Run the command `legspring` with the program's arguments."""
    for number in WORDS:
        # What a shell runs in the background is to ignore interruptions.
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, stop)
    streams()
    log = logging.getLogger("legspring")
    log.addHandler(Notices())
    log.setLevel(logging.INFO)
    log.propagate = False
    ends: list[int] = []
    thread = threading.Thread(target=work, args=[ends], daemon=True)
    thread.start()
    while thread.is_alive():
        # Without an end, waiting would not let signals through on Windows.
        thread.join(0.1)
    ignore()
    sys.exit(printed(ends[0]))


if __name__ == "__main__":
    main()
