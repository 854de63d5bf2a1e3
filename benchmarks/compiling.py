"""Compile everything once, and print as JSON how long it took and which functions took it.

Run in a process of its own with an empty NUMBA_CACHE_DIR: with a filled one, it only loads.
"""

import json
import sys
import time
from collections import defaultdict
from typing import Any

from numba.core import event


class Stopwatch(event.Listener):
    """Takes the time that numba spends on each function, without that for the functions that it calls."""

    def __init__(self) -> None:
        self.open: list[list[float]] = []
        self.seconds: dict[str, float] = defaultdict(float)
        self.times: dict[str, int] = defaultdict(int)

    def on_start(self, _: Any) -> None:
        """Begin a function."""
        self.open.append([time.perf_counter(), 0.0])

    def on_end(self, what: Any) -> None:
        """End it, and take its time off its caller's."""
        function = what.data["dispatcher"].py_func
        begin, inner = self.open.pop()
        whole = time.perf_counter() - begin
        if self.open:
            self.open[-1][1] += whole
        name = f"{function.__module__}.{function.__name__}".removeprefix("legspring.kernel.")
        self.seconds[name] += whole - inner
        self.times[name] += 1


def main() -> None:
    """Find the gaits of one cell, then make an atlas of it."""
    watch = Stopwatch()
    event.register("numba:compile", watch)  # type: ignore[no-untyped-call]
    begin = time.perf_counter()
    import legspring

    animal = legspring.cockroach()
    legspring.find_gaits(animal, slope_deg=45, heading=0.15)
    middle = time.perf_counter()
    legspring.atlas(animal, slopes_deg=[45], headings=[0.15], workers=1)
    end = time.perf_counter()
    slowest = sorted(watch.seconds, key=lambda name: -watch.seconds[name])[:15]
    result = {
        "first_gait_s": middle - begin,
        "atlas_of_one_cell_s": end - middle,
        "compiling_s": sum(watch.seconds.values()),
        "functions": sum(watch.times.values()),
        "slowest_s": {f"{name} x{watch.times[name]}": watch.seconds[name] for name in slowest},
    }
    json.dump(result, sys.stdout)


if __name__ == "__main__":
    main()
