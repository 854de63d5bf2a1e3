"""Progress of long work, on the terminal's error stream."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager


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

    columns: list[ProgressColumn] = [
        TextColumn("{task.description:24s}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        *([RateColumn(), TimeRemainingColumn()] if rate else []),
    ]
    with Progress(*columns, console=Console(stderr=True), speed_estimate_period=300.0) as progress:
        task = progress.add_task(title, total=total)
        yield lambda step: progress.advance(task, step)
