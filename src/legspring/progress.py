"""Progress of long work, on the terminal's error stream or in a notebook."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import timedelta
from html import escape
from importlib import import_module
from typing import Any

BETWEEN = 0.2
"""Seconds between two looks of a bar in a notebook, at least."""


@contextmanager
def progress_bar(title: str, total: int, *, show: bool, rate: str = "") -> Iterator[Callable[[int], None]]:
    """Show a bar while the block runs; yield a function that moves it on by so much.

    ``rate`` names what is counted where the bar is to say how many there are in a second, and the time left.
    """
    if not show:
        yield lambda _: None
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        ProgressColumn,
        Task,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )
    from rich.text import Text

    class RateColumn(ProgressColumn):
        """How many there are in a second."""

        def render(self, task: Task) -> Text:
            return Text(f"{task.finished_speed or task.speed or 0.0:.0f} {rate}/s")

    console = Console(stderr=True)
    if console.is_jupyter:
        yield in_notebook(title, total, rate)
        return
    columns: list[ProgressColumn] = [
        # Eighty columns are room enough for all of it.
        TextColumn("{task.description}" if rate else "{task.description:24s}", markup=False),
        BarColumn(16 if rate else 40),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        *([RateColumn(), TimeRemainingColumn()] if rate else []),
    ]
    with Progress(*columns, console=console, speed_estimate_period=300.0) as progress:
        task = progress.add_task(title, total=total)
        yield lambda step: progress.advance(task, step)


def in_notebook(title: str, total: int, rate: str) -> Callable[[int], None]:
    """Show a bar in a notebook, whatever is installed there; return a function that moves it on."""
    # There is one where there is a notebook.
    shown_by: Any = import_module("IPython.display")
    begin = time.monotonic()
    done, shown = 0, begin

    def look() -> Any:
        seconds = time.monotonic() - begin
        words = [f"{done}/{total}", str(timedelta(seconds=round(seconds)))]
        if rate and done:
            left = timedelta(seconds=round(seconds / done * (total - done)))
            words += [f"{done / max(seconds, 1e-9):.0f} {rate}/s", f"{left} left"]
        bar = f'<progress value="{done}" max="{total}" aria-label="{escape(title)}"></progress>'
        return shown_by.HTML(f"{escape(title)} {bar} {escape(' · '.join(words))}")

    handle = shown_by.display(look(), display_id=True)

    def advance(step: int) -> None:
        nonlocal done, shown
        done += step
        if done >= total or time.monotonic() - shown > BETWEEN:
            shown = time.monotonic()
            handle.update(look())

    return advance
