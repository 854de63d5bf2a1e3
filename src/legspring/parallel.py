"""Work shared among threads, for what runs without Python's lock, or among processes.

A process is a Python of its own that waits for work at its standard input and ends when that closes: with the program
that started it, however that ended, it leaves nothing behind. They are out of the terminal's reach, so that only their
program answers Ctrl-C. Unlike those of `multiprocessing` they do not run the user's script again.
"""

import logging
import os
import pickle
import queue
import subprocess
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, nullcontext, suppress
from contextvars import ContextVar
from typing import Any, BinaryIO, TypeVar

from legspring.leaving import leave, undone_by

S = TypeVar("S")
T = TypeVar("T")
LOG = logging.getLogger("legspring")
START = "import sys; sys.path[:] = {}; from legspring.parallel import serve; serve()"
PORTIONS = 16
"""Portions that each thread's share of the work comes in."""
PATIENCE = 0.4
"""Seconds that a process has to end by itself."""


def in_threads(
    work: Callable[[S], T], items: Iterable[S], workers: int, tick: Callable[[int], None] = lambda _: None
) -> list[T]:
    """Return what a function returns for each of some items, in their order."""
    tasks, results = list(items), list[T]()
    # A thread takes some at a time: to hand over one costs as much as to do what is small.
    size = max(1, len(tasks) // (PORTIONS * workers))
    portions = [tasks[n : n + size] for n in range(0, len(tasks), size)]

    def work_on(portion: list[S]) -> list[T]:
        return [work(item) for item in portion]

    with ThreadPoolExecutor(workers) if workers > 1 else nullcontext() as pool:
        for done in map(work_on, portions) if pool is None else pool.map(work_on, portions):
            results += done
            tick(len(done))
    return results


class Worker:
    """A process that works on one thing after another."""

    def __init__(self) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-c", START.format(sys.path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            # Away from the terminal, each system in its way.
            start_new_session=True,
            creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
        )

    def call(self, function: Callable[..., T], arguments: tuple[Any, ...]) -> T:
        """Return what a function returns there; raise what it raises."""
        assert self.process.stdin is not None and self.process.stdout is not None
        try:
            send(self.process.stdin, pickle.dumps((function, arguments)))
            while True:
                kind, value = pickle.load(self.process.stdout)
                if kind != "notice":
                    break
                LOG.log(*value)
        except (OSError, EOFError, pickle.UnpicklingError):
            raise ChildProcessError("a worker process ended by itself; fewer workers need less memory") from None
        if kind == "error":
            raise value
        result: T = value
        return result

    def close(self) -> None:
        """Tell the process to end."""
        assert self.process.stdin is not None
        with suppress(OSError):
            self.process.stdin.close()

    def wait(self, seconds: float) -> None:
        """Wait until it has ended, not for long."""
        try:
            self.process.wait(seconds)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()


def send(stream: Any, value: Any) -> None:
    """Write something to another process."""
    pickle.dump(value, stream)
    stream.flush()


class Processes:
    """So many processes, started as they are needed; for one, this process itself does."""

    def __init__(self, count: int) -> None:
        self.count = count
        self._all: list[Worker] = []
        self._idle: queue.SimpleQueue[Worker] = queue.SimpleQueue()
        self._threads = ThreadPoolExecutor(count)

    def call(self, function: Callable[..., T], *arguments: Any) -> T:
        """Call a function in one of the processes."""
        if self.count == 1:
            return function(*arguments)
        try:
            worker = self._idle.get_nowait()
        except queue.Empty:
            worker = Worker()
            self._all.append(worker)
        try:
            return worker.call(function, arguments)
        finally:
            self._idle.put(worker)

    def map(self, function: Callable[..., T], tasks: Sequence[tuple[Any, ...]]) -> Iterator[T]:
        """Call a function, which may use `call`, here with each of some tuples of arguments; results in their order."""
        if self.count == 1:
            return (function(*task) for task in tasks)
        return self._threads.map(lambda task: function(*task), tasks)

    def close(self) -> None:
        """End all processes, whatever they do."""
        end = time.monotonic() + PATIENCE
        for worker in self._all:
            worker.close()
        for worker in self._all:
            worker.wait(end - time.monotonic())


_open: ContextVar[Processes | None] = ContextVar("_open", default=None)


@contextmanager
def processes(count: int) -> Iterator[Processes]:
    """Yield processes that end with the block; a block within another of as many takes those of the other."""
    outer = _open.get()
    if outer is not None and outer.count == count:
        yield outer
        return
    pool = Processes(count)
    token = _open.set(pool)
    with undone_by(pool.close):
        try:
            yield pool
        finally:
            _open.reset(token)
            pool._threads.shutdown(wait=False, cancel_futures=True)
            pool.close()


class Notices(logging.Handler):
    """Passes what is to be said to the program that started this one."""

    def __init__(self, stream: BinaryIO) -> None:
        super().__init__()
        self.stream = stream

    def emit(self, record: logging.LogRecord) -> None:
        """Pass on a message."""
        send(self.stream, ("notice", (record.levelno, record.getMessage())))


def serve() -> None:
    """Work on what comes in at the standard input, until it closes."""
    # What libraries print must not get among the results.
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    LOG.addHandler(Notices(out))
    LOG.setLevel(logging.INFO)
    requests: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=receive, args=[requests], daemon=True).start()
    while True:
        try:
            function, arguments = pickle.loads(requests.get())
            answer = ("result", function(*arguments))
        except Exception as error:
            error.add_note(f"in a worker process:\n{traceback.format_exc()}")
            answer = ("error", error)
        send(out, answer)


def receive(requests: "queue.SimpleQueue[bytes]") -> None:
    """Take in requests, also during work, so as to notice that there will be no more."""
    with suppress(EOFError, OSError, pickle.UnpicklingError):
        while True:
            requests.put(pickle.load(sys.stdin.buffer))
    leave("", 0)
