"""The command `legspring`, as a program that a signal ends at once.

The command works in a thread of its own, so that this one is free to answer, also while a library works in compiled
code. Only what is needed for that is imported here.
"""

import logging
import signal
import sys
import threading
from types import FrameType

from legspring.leaving import leave

WORDS = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}


def stop(number: int, _: FrameType | None = None) -> None:
    """Leave the program for a signal; further ones change nothing."""
    ignore()
    leave(f"legspring: {WORDS[signal.Signals(number)]}", 128 + number)


def ignore() -> None:
    """Heed no more signals."""
    for number in WORDS:
        signal.signal(number, signal.SIG_IGN)


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
            print(f"legspring: {message}", file=sys.stderr, flush=True)


def work(outcome: list[BaseException]) -> None:
    """Carry out the command; note how it ended."""
    try:
        from legspring.cli import app

        app(prog_name="legspring")
    except BaseException as error:
        outcome.append(error)


def main() -> None:
    """Run the command `legspring` with the program's arguments."""
    for number in WORDS:
        # What a shell runs in the background is to ignore interruptions.
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, stop)
    log = logging.getLogger("legspring")
    log.addHandler(Notices())
    log.setLevel(logging.INFO)
    log.propagate = False
    outcome: list[BaseException] = []
    thread = threading.Thread(target=work, args=[outcome], daemon=True)
    thread.start()
    while thread.is_alive():
        # Without an end, waiting would not let signals through on Windows.
        thread.join(0.1)
    ignore()
    if outcome:
        raise outcome[0]


if __name__ == "__main__":
    main()
