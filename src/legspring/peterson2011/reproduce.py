"""The whole thesis: everything computed, every figure and table, and the report on its claims."""

import csv
import shutil
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from legspring.checks import checked_whole, checked_workers
from legspring.figures import save_figure
from legspring.files import PathLike, make_directory, whole_file
from legspring.optimum import Method
from legspring.parallel import processes
from legspring.peterson2011.claims import Verdict, judge
from legspring.peterson2011.coverage import coverage_table, facts
from legspring.peterson2011.figures import FIGURES, ThesisFigure
from legspring.peterson2011.figures.beyond import BEYOND
from legspring.peterson2011.notes import notes
from legspring.peterson2011.report import CHAPTERS, File, Picture, write_report
from legspring.peterson2011.store import BEYOND_CHAPTER, Store, kind
from legspring.peterson2011.tables import save_table
from legspring.progress import progress_bar

TABLES = ("3.1", "4.1", "6.1", "6.2", "6.3", "6.errors", "6.agreement", "6.differences")
"""Those of the thesis; how far forces are from measured ones, how many of its numbers are ours, why others are not."""
MOST_STARTS = 100


def reproduce(
    out: PathLike,
    *,
    only: Sequence[str] = (),
    method: Method = "default",
    fresh: bool = False,
    starts: int = 0,
    workers: int | None = None,
    progress: bool = False,
) -> Path:
    """Recompute the thesis: every figure and table, and a report that judges each of its claims.

    What was computed is stored as it comes; a run that was stopped goes on where it was.

    Parameters
    ----------
    out
        Directory for report.html and the folders figures, tables and data; it is made if it is missing.
    only
        Numbers of figures and tables, such as ``"4.2"``: only these are drawn, from what they need; no report.
    method
        Of the optimisation in chapter 5: ``"default"``, or ``"nelder-mead"`` for the thesis's own.
    fresh
        Whether to compute everything again.
    starts
        How many further starts to try of the thesis's own search, whose starts are not known: what depends on them
        is said. Each takes about as long as a fifth of the rest.
    workers
        Processes and threads; by default one a core.
    progress
        Whether to show progress bars.

    Returns
    -------
    Path
        The report, or the directory if there is none.

    Raises
    ------
    ValueError
        For an unknown number or method, or a number of starts out of range.
    OSError
        If files cannot be written.
    """
    numbers = check_numbers(only)
    if method not in ("default", "nelder-mead"):
        raise ValueError(f"method = {method!r}: must be 'default' or 'nelder-mead'")
    directory, count, further = Path(out), checked_workers(workers), checked_whole("starts", starts, 0, MOST_STARTS)
    for folder in (directory, *(directory / name for name in ("figures", "tables", "data"))):
        make_directory(folder)
    if fresh:
        shutil.rmtree(directory / "data")
        make_directory(directory / "data")
    with processes(count):
        store = Store(directory / "data", method, further, count, progress)
        return make(store, directory, numbers, whole=not only)


def make(store: Store, directory: Path, numbers: Sequence[str], *, whole: bool) -> Path:
    """Draw figures and tables, and if it is the whole thesis, write the report."""
    drawing = {}
    for chapter in CHAPTERS:
        here = [number for number in numbers if number.startswith(f"{chapter}.")]
        figures = [FIGURES[number] for number in here if number in FIGURES]
        drawing[chapter] = draw(store, directory, [*figures, *filter(None, (one.by_thesis for one in figures))])
        # Figures and tables share numbers.
        for number in here:
            if number in TABLES:
                table = store.table(number)
                save_table(table, directory / "tables" / f"{table.stem}.csv")
    if not whole:
        return directory
    drawing[BEYOND_CHAPTER] = draw(store, directory, list(BEYOND.values()))
    return finish(store, directory, drawing)


def check_numbers(only: Sequence[str]) -> tuple[str, ...]:
    """Return the numbers of figures and tables to make: all, unless said otherwise."""
    known = tuple(dict.fromkeys((*FIGURES, *TABLES)))
    if unknown := [number for number in only if number not in known]:
        raise ValueError(f"only = {unknown[0]!r}: must be among {', '.join(known)}")
    return tuple(only) or known


def draw(store: Store, directory: Path, figures: Sequence[ThesisFigure]) -> float:
    """Draw figures into PNG and PDF files; return the seconds that this took, once there were the data."""
    data = {figure.source: getattr(store, figure.source) for figure in figures}
    start = time.perf_counter()
    words = f"drawing {figures[0].number} to {figures[-1].number}" if figures else ""
    with progress_bar(words, len(figures), show=store.progress and bool(figures)) as tick:
        tasks = [(draw_one, figure, data[figure.source], directory / "figures") for figure in figures]
        with processes(store.workers) as pool:
            for _ in pool.map(pool.call, tasks):
                tick(1)
    return time.perf_counter() - start


def draw_one(figure: ThesisFigure, data: Any, folder: Path) -> None:
    """Draw a figure into its files."""
    drawn = figure.draw(data)
    # What stands beside another figure is for comparison, and not for print.
    for suffix in (".png",) if figure.suffix else (".png", ".pdf"):
        save_figure(drawn, folder / f"{figure.stem}{suffix}")
        # Everything has its place now: to look for it again takes as long as to draw.
        drawn.set_layout_engine("none")


def finish(store: Store, directory: Path, drawing: Mapping[int, float]) -> Path:
    """Judge the claims and write the report."""
    results = store.results
    verdicts = judge(results)
    save_verdicts(verdicts, directory / "data" / "claims.csv")
    make_directory(directory / "data" / "claims")
    cells = {verdict.number: directory / "data" / "claims" / f"claim_{verdict.number}.csv" for verdict in verdicts}
    for verdict in verdicts:
        save_cells(verdict, cells[verdict.number])

    timings = {
        chapter: seconds + sum(seconds for name, seconds in store.seconds.items() if kind(name).chapter == chapter)
        for chapter, seconds in drawing.items()
    }
    write_report(
        directory / "report.html",
        results=results,
        verdicts=verdicts,
        cells=cells,
        figures={number: picture(directory, figure) for number, figure in FIGURES.items()},
        notes=notes(store.optima, store.nelder_mead, store.force_ranges, store.starts),
        coverage=coverage_table(verdicts, facts(store.atlas, store.force_ranges)),
        twins={number: picture(directory, figure.by_thesis) for number, figure in FIGURES.items() if figure.by_thesis},
        tables={number: store.table(number) for number in TABLES},
        timings=timings,
        films=store.films,
        beyond=store.beyond({name: picture(directory, figure).path for name, figure in BEYOND.items()}),
        data=[
            File(directory / "data" / f"{name}{suffix}", f"{kind(name).words}, {form}")
            for name in store.seconds
            for suffix, form in ((".nc", "netCDF"), (".csv", "CSV"))
        ],
    )
    return directory / "report.html"


def save_verdicts(verdicts: Sequence[Verdict], path: Path) -> None:
    """Save the verdicts as CSV."""
    with whole_file(path) as file, file.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(("number", "chapter", "claim", "verdict", "lenient", "strict", "found", "why"))
        for one in verdicts:
            outcomes = (one.verdict, one.lenient, one.strict)
            writer.writerow((one.number, one.chapter, one.claim, *outcomes, one.found, one.why))


def picture(directory: Path, figure: ThesisFigure) -> Picture:
    """Return a figure as it was drawn."""
    return Picture(directory / "figures" / f"{figure.stem}.png", figure.caption)


def save_cells(verdict: Verdict, path: Path) -> None:
    """Save what the parts of a verdict were judged by, cell by cell, as CSV."""
    arrays = [part.evidence for part in verdict.parts]
    dims = list(dict.fromkeys(str(dim) for each in arrays for array in each.values() for dim in array.dims))
    with whole_file(path) as file, file.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(("part", "quantity", "search", *dims, "value"))
        for number, part in enumerate(verdict.parts, start=1):
            for search, array in part.evidence.items():
                for place in np.argwhere(np.isfinite(array.values)):
                    at = {dim: array[dim].values[n] for dim, n in zip(array.dims, place, strict=True)}
                    value = float(array.values[tuple(place)])
                    writer.writerow((number, part.what, search, *(at.get(dim, "") for dim in dims), f"{value:.9g}"))
