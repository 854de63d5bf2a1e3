"""The whole thesis: everything computed, every figure and table, and the report on its claims."""

import csv
import hashlib
import logging
import math
import shutil
import time
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import legspring as ls
from legspring.checks import checked_workers
from legspring.figures import animate, save_figure
from legspring.files import PathLike, check_output, code_stamp, make_directory, save_csv, save_netcdf, whole_file
from legspring.layout import System
from legspring.model import Animal, cockroach
from legspring.optima import optimal_atlas, select
from legspring.optimum import Method
from legspring.parallel import processes
from legspring.peterson2011 import families, single_leg, yawing
from legspring.peterson2011.beyond import sections
from legspring.peterson2011.claims import Results, Verdict, judge
from legspring.peterson2011.decay import decays
from legspring.peterson2011.figures import FIGURES, GAIT, SIMULATION, ThesisFigure
from legspring.peterson2011.figures.beyond import BEYOND
from legspring.peterson2011.figures.families import of_families
from legspring.peterson2011.fronts import fronts
from legspring.peterson2011.published import published_forces
from legspring.peterson2011.report import CHAPTERS, File, Moving, Picture, Section, write_report
from legspring.peterson2011.tables import (
    Table,
    constraint_table,
    difference_table,
    differences,
    force_ranges,
    force_tables,
    parameter_table,
    save_table,
)
from legspring.progress import progress_bar
from legspring.sweep import HEADINGS, IMPULSES, SLOPES_DEG

LOG = logging.getLogger("legspring")
TABLES = ("3.1", "4.1", "6.1", "6.2", "6.3", "6.1-6.3")
"""The last one explains how ours differ from the thesis's."""
BEYOND_CHAPTER = 7
"""Number under which the time of what goes beyond the thesis is kept."""
FILMED: Mapping[str, Any] = {"slope_deg": 45.0, "heading": 0.15}
"""The gait that is seen in motion."""
FILMED_IMPULSE, FILM_WIDTH = 0.5, 400
BACK_PULLS: Mapping[str, tuple[str, ...]] = {"FM": ("F", "M"), "F": ("F",), "M": ("M",), "none": ()}
"""Families in which the back legs pull."""

DATA = {
    "atlas": (4, "Gaits with the thesis's actuation, all branches", ("slope_deg", "heading", "branch")),
    "nelder_mead": (
        5,
        "Gaits with optimised actuation, as the thesis searches for them",
        ("objective", "slope_deg", "heading", "family"),
    ),
    "optima": (5, "Gaits with optimised actuation", ("objective", "slope_deg", "heading", "family")),
    "single_leg": (2, "Gaits of one leg", ("variant", "function", "slope_deg", "heading")),
    "back_pulls": (BEYOND_CHAPTER, "Gaits whose back legs pull", ("slope_deg", "heading", "branch")),
    "decays": (BEYOND_CHAPTER, "Decay of simulated perturbations", ("gait",)),
    "fronts": (BEYOND_CHAPTER, "Trade-off of stability and efficiency", ("slope_deg", "family", "point")),
    "yawing": (BEYOND_CHAPTER, "Gaits of a body that yaws", ("slope_deg", "heading", "branch")),
    "yaw_held": (BEYOND_CHAPTER, "Gaits of the same body with its yaw held", ("slope_deg", "heading", "branch")),
    "yaw_fates": (BEYOND_CHAPTER, "Gaits of the point mass, followed to it", ("slope_deg", "heading", "branch")),
    "yaw_hips": (BEYOND_CHAPTER, "Its stability with hips further back", ("back",)),
}
"""Datasets that are stored: the chapter they belong to, what they hold, and the dimensions of their rows in a table."""


class Store:
    """Everything that the thesis's figures and claims are about, computed when it is asked for, and stored.

    Parameters
    ----------
    directory
        Where datasets are stored; what lies there already is used if this version of the package has computed it.
    method
        Of the optimisation.
    workers
        Processes and threads.
    progress
        Whether to show progress bars.
    """

    def __init__(self, directory: Path, method: Method, workers: int, progress: bool) -> None:
        self.directory, self.method, self.workers, self.progress = directory, method, workers, progress
        self.animal: Animal = cockroach()
        self.seconds: dict[str, float] = {}

    def _stored(self, name: str, compute: Callable[[], xr.Dataset], key: str = "") -> xr.Dataset:
        """Return a dataset, from its file if there is one, made by the same code and with the same key."""
        path, table = (self.directory / f"{name}{suffix}" for suffix in (".nc", ".csv"))
        for file in (path, table):
            check_output(file, [file.suffix])
        stamp = f"{code_stamp()} {key}".strip()
        dataset = stored(path, stamp)
        if dataset is None:
            start = time.perf_counter()
            dataset = compute()
            # What goes on where it was knows better.
            seconds = dataset.attrs.get("seconds", time.perf_counter() - start)
            dataset.attrs |= {"code": stamp, "seconds": seconds, "checksum": contents(dataset)}
            save_netcdf(dataset, path)
        self.seconds[name] = float(dataset.attrs["seconds"])
        save_csv(dataset, table, DATA[name][2])
        return dataset

    @cached_property
    def atlas(self) -> xr.Dataset:
        """Gaits with the thesis's actuation."""
        return self._stored("atlas", lambda: ls.atlas(self.animal, workers=self.workers, progress=self.progress))

    @cached_property
    def families(self) -> xr.Dataset:
        """The first gait of each family in each cell, with the thesis's actuation."""
        return of_families(self.atlas)

    @cached_property
    def nelder_mead(self) -> xr.Dataset:
        """Gaits with optimised actuation, as the thesis searches for them."""
        return self._stored("nelder_mead", lambda: self._optimised("nelder-mead"))

    @cached_property
    def optima(self) -> xr.Dataset:
        """Gaits with optimised actuation, by the method that was asked for."""
        if self.method == "nelder-mead":
            return self.nelder_mead
        starts = self.nelder_mead
        return self._stored("optima", lambda: self._optimised("default", starts))

    def _optimised(self, method: Method, starts: xr.Dataset | None = None) -> xr.Dataset:
        cache = self.directory / ".unfinished"
        optima = optimal_atlas(
            self.animal,
            map="reduced",
            method=method,
            starts=starts,
            workers=self.workers,
            cache=cache,
            progress=self.progress,
            impulses=IMPULSES,
        )
        shutil.rmtree(cache, ignore_errors=True)
        return optima

    @cached_property
    def selected(self) -> xr.Dataset:
        """Optimised gaits of the best family in each cell."""
        return select(self.optima)

    @cached_property
    def back_pulls(self) -> xr.Dataset:
        """Gaits whose back legs pull."""
        animal = self.animal.replace(families=BACK_PULLS)
        return self._stored("back_pulls", lambda: ls.atlas(animal, impulses=(), workers=self.workers))

    @cached_property
    def single_leg(self) -> xr.Dataset:
        """Gaits of the model that the thesis starts from."""
        return self._stored("single_leg", lambda: single_leg.map_single_legs(SLOPES_DEG, self.workers))

    @cached_property
    def decays(self) -> xr.Dataset:
        """Decay of simulated perturbations."""
        return self._stored("decays", lambda: decays(self.animal))

    @cached_property
    def fronts(self) -> xr.Dataset:
        """Trade-off of stability and efficiency."""
        optima = self.optima
        return self._stored("fronts", lambda: fronts(self.animal, optima, self.workers), self.method)

    @cached_property
    def yawing(self) -> xr.Dataset:
        """Gaits of the cockroach as a rigid body."""
        animal = yawing.rigid_cockroach()
        return self._stored("yawing", lambda: ls.atlas(animal, impulses=(), workers=self.workers))

    @cached_property
    def yaw_held(self) -> xr.Dataset:
        """Gaits of the rigid body with its yaw held."""
        return self._stored("yaw_held", lambda: yawing.held(self.workers))

    @property
    def yaw_forces(self) -> xr.Dataset:
        """Ranges of forces, measured and of bodies with and without hips and yaw."""
        return yawing.force_ranges(yawing.bodies_of(self.atlas, self.yaw_held, self.yawing))

    @property
    def yaw_section(self) -> Section:
        """What yaw changes."""
        atlas = self.atlas
        fates = self._stored("yaw_fates", lambda: yawing.fates(atlas, self.workers))
        hips = self._stored("yaw_hips", lambda: yawing.hips_moved_back(self.workers))
        return yawing.section(atlas, self.yawing, self.yaw_held, fates, hips)

    def beyond(self, pictures: Mapping[str, Path]) -> list[Section]:
        """Write the chapter beyond the thesis."""
        each_family = families.section(self.families, self.optima)
        one_leg = single_leg.section(self.single_leg)
        results = self.atlas, self.decays, self.back_pulls, self.fronts
        return sections(*results, each_family, one_leg, self.yaw_section, pictures)

    @property
    def gait(self) -> ls.Gait:
        """The gait of the sketches."""
        return ls.find_gaits(self.animal, **GAIT)[0]

    @property
    def films(self) -> list[Moving]:
        """A stride of a gait, and how it recovers from a push."""
        gait = ls.find_gaits(self.animal, **FILMED)[0]
        recovery = gait.recover(FILMED_IMPULSE)
        return [
            Moving(3, animate(gait, strides=1, width=FILM_WIDTH), "A stride of a gait, seen from above on the slope."),
            Moving(
                3,
                animate(recovery, width=FILM_WIDTH),
                f"The same gait after a sideways push, from which it is back after {recovery.steps} steps.",
            ),
        ]

    @property
    def simulation(self) -> xr.Dataset:
        """The simulation of Figure 2.2."""
        return ls.simulate(self.animal, **SIMULATION)

    @property
    def system(self) -> System:
        """The animal on the level."""
        return System(self.animal, 0.0, next(iter(self.animal.families)))

    @property
    def measured(self) -> xr.Dataset:
        """Forces measured on animals."""
        return published_forces()

    @property
    def results(self) -> Results:
        """All that claims are judged by."""
        return Results(
            atlas=self.atlas,
            optima=self.optima,
            nelder_mead=self.nelder_mead,
            selected=self.selected,
            selected_nelder_mead=self.nelder_mead_selected,
            measured=self.measured,
            back_pulls=self.back_pulls,
            single_leg=self.single_leg,
        )

    @cached_property
    def force_tables(self) -> dict[str, Table]:
        """Tables 6.1-6.3."""
        tables = force_tables(force_ranges(self.atlas, self.selected, self.nelder_mead_selected))
        return {table.number: table for table in tables}

    def table(self, number: str) -> Table:
        """Make one of the thesis's tables, of what it needs."""
        if number == "3.1":
            return constraint_table()
        if number == "4.1":
            return parameter_table(self.animal, SLOPES_DEG, HEADINGS)
        if number in self.force_tables:
            return self.force_tables[number]
        return difference_table(differences(self.optima, self.selected, self.nelder_mead_selected))

    @cached_property
    def nelder_mead_selected(self) -> xr.Dataset:
        """The thesis's own optima of the best family in each cell."""
        return select(self.nelder_mead)


def stored(path: Path, stamp: str) -> xr.Dataset | None:
    """Return what a file holds, if this code has written it and it is as it was then; say so if it is damaged."""
    if not path.exists():
        return None
    try:
        with xr.open_dataset(path, engine="netcdf4") as file:
            if file.attrs["code"] != stamp:
                return None
            dataset = file.load()
        whole = dataset.attrs["checksum"] == contents(dataset) and math.isfinite(float(dataset.attrs["seconds"]))
    except Exception:  # whatever a damaged file leads to
        whole = False
    if not whole:
        LOG.warning("%s: is damaged, or not ours; computing it again", path)
    return dataset if whole else None


def contents(dataset: xr.Dataset) -> str:
    """Return a checksum of the numbers and words in a dataset."""
    digest = hashlib.sha256()
    for name in sorted(map(str, dataset.variables)):
        variable = dataset[name]
        text = variable.dtype.kind not in "biuf"
        values = (
            "\0".join(map(str, variable.values.ravel())).encode() if text else variable.values.astype(float).tobytes()
        )
        digest.update(f"{name} {variable.dims} {variable.shape} ".encode() + values)
    return digest.hexdigest()


def reproduce(
    out: PathLike,
    *,
    only: Sequence[str] = (),
    method: Method = "default",
    fresh: bool = False,
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
        For an unknown number or method.
    OSError
        If files cannot be written.
    """
    numbers = check_numbers(only)
    if method not in ("default", "nelder-mead"):
        raise ValueError(f"method = {method!r}: must be 'default' or 'nelder-mead'")
    directory, count = Path(out), checked_workers(workers)
    for folder in (directory, *(directory / name for name in ("figures", "tables", "data"))):
        make_directory(folder)
    if fresh:
        shutil.rmtree(directory / "data")
        make_directory(directory / "data")
    with processes(count):
        return make(Store(directory / "data", method, count, progress), directory, numbers, whole=not only)


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
    known = (*FIGURES, *TABLES)
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
    for suffix in (".png", ".pdf"):
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
        chapter: seconds
        + sum(store.seconds[name] for name, (where, *_) in DATA.items() if where == chapter and name in store.seconds)
        for chapter, seconds in drawing.items()
    }
    write_report(
        directory / "report.html",
        results=results,
        verdicts=verdicts,
        cells=cells,
        figures={number: picture(directory, figure) for number, figure in FIGURES.items()},
        twins={number: picture(directory, figure.by_thesis) for number, figure in FIGURES.items() if figure.by_thesis},
        tables={number: store.table(number) for number in TABLES},
        timings=timings,
        films=store.films,
        beyond=store.beyond({name: picture(directory, figure).path for name, figure in BEYOND.items()}),
        data=[
            File(directory / "data" / f"{name}{suffix}", f"{text}, {kind}")
            for name, (_, text, _) in DATA.items()
            for suffix, kind in ((".nc", "netCDF"), (".csv", "CSV"))
            if (directory / "data" / f"{name}{suffix}").is_file()
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
