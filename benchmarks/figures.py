"""Measured figures, the targets that they have, and how to take times on a busy machine."""

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from statistics import median
from typing import Any


@dataclass(frozen=True)
class Figure:
    """One number.

    Attributes
    ----------
    name, value, unit
        What, how much, of what.
    must, aim
        Targets; None if it has none.
    more_is_better
        Whether a target is a least value; else it is a greatest one.
    detail
        Whatever helps to read it.
    """

    name: str
    value: float
    unit: str
    must: float | None = None
    aim: float | None = None
    more_is_better: bool = False
    detail: dict[str, Any] = field(default_factory=dict)

    def meets(self, target: float) -> bool:
        """Whether the value is as good as a target."""
        return self.value >= target if self.more_is_better else self.value <= target

    @property
    def verdict(self) -> str:
        """The best target that is met: "aim", "must" or "missed"; empty if there is none."""
        if self.aim is not None and self.meets(self.aim):
            return "aim"
        if self.must is not None:
            return "must" if self.meets(self.must) else "missed"
        return ""

    def as_json(self) -> dict[str, Any]:
        """Return what a JSON file holds of it."""
        entries = asdict(self) | {"verdict": self.verdict}
        return {key: rounded(entry) for key, entry in entries.items() if entry not in (None, "", {})}

    def line(self) -> str:
        """Return a line of a table."""
        targets = "" if self.must is None else f"{self.must:g} / {self.aim:g}"
        return f"{self.name:58s} {self.value:10.4g} {self.unit:6s} {targets:>14s} {self.verdict}"


def rounded(entry: Any) -> Any:
    """Round numbers, wherever they are, to five digits."""
    if isinstance(entry, float):
        return float(f"{entry:.5g}")
    if isinstance(entry, dict):
        return {key: rounded(value) for key, value in entry.items()}
    if isinstance(entry, list | tuple):
        return [rounded(value) for value in entry]
    return entry


def seconds(work: Callable[[], object]) -> float:
    """Time that something takes this thread's processor, once: whatever else runs on the machine does not count."""
    begin = time.thread_time()
    work()
    return time.thread_time() - begin


def together(works: dict[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Median time of each of some things: all of them in turn, round after round, so that noise hits all alike."""
    times: dict[str, list[float]] = {name: [] for name in works}
    for work in works.values():
        work()
    for _ in range(rounds):
        for name, work in works.items():
            times[name].append(seconds(work))
    return {name: median(values) for name, values in times.items()}
