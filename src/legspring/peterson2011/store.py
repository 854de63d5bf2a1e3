"""What the thesis's figures, tables and claims are made from: computed when it is asked for, and stored."""

import hashlib
import logging
import math
import shutil
import time
from collections.abc import Callable, Mapping
from functools import cached_property, partial
from pathlib import Path
from typing import Any, NamedTuple

import xarray as xr

import legspring as ls
from legspring.figures import animate
from legspring.files import check_output, code_stamp, save_csv, save_netcdf
from legspring.layout import System
from legspring.mapping import HEADINGS, IMPULSES, SLOPES_DEG
from legspring.model import Animal, cockroach
from legspring.optima import optimal_atlas, select
from legspring.optimum import Method
from legspring.peterson2011 import families, single_leg, surfaces, survival, yawing
from legspring.peterson2011.beyond import sections
from legspring.peterson2011.claims import Results
from legspring.peterson2011.decay import decays
from legspring.peterson2011.differences import difference_table, differences
from legspring.peterson2011.figures import GAIT, SIMULATION
from legspring.peterson2011.figures.families import of_families
from legspring.peterson2011.force_tables import agreement_table, error_table, force_ranges, force_tables, peak_ranges
from legspring.peterson2011.fronts import fronts
from legspring.peterson2011.limits import limits
from legspring.peterson2011.published import published_forces
from legspring.peterson2011.report import Moving, Section
from legspring.peterson2011.tables import Table, constraint_table, parameter_table

LOG = logging.getLogger("legspring")
BEYOND_CHAPTER = 7
"""Number under which the time of what goes beyond the thesis is kept."""
FILMED: Mapping[str, Any] = {"slope_deg": 45.0, "heading": 0.15}
"""The gait that is seen in motion."""
FILMED_IMPULSE, FILM_WIDTH = 0.5, 400
BACK_PULLS: Mapping[str, tuple[str, ...]] = {"FM": ("F", "M"), "F": ("F",), "M": ("M",), "none": ()}
"""Families in which the back legs pull."""


class Kind(NamedTuple):
    """A kind of dataset that is stored: chapter it belongs to, what it holds, dimensions of its rows in a table."""

    chapter: int
    words: str
    rows: tuple[str, ...]


DATA = {
    "atlas": Kind(4, "Gaits with the thesis's actuation, all branches", ("slope_deg", "heading", "branch")),
    "nelder_mead": Kind(
        5,
        "Gaits with optimised actuation, as the thesis searches for them",
        ("objective", "slope_deg", "heading", "family"),
    ),
    "optima": Kind(5, "Gaits with optimised actuation", ("objective", "slope_deg", "heading", "family")),
    "start": Kind(
        6,
        "Forces of Tables 6.1 to 6.3 by the thesis's search from another start",
        ("leg", "axis", "slope_deg", "extreme"),
    ),
    "single_leg": Kind(2, "Gaits of one leg", ("variant", "function", "slope_deg", "heading")),
    "back_pulls": Kind(BEYOND_CHAPTER, "Gaits whose back legs pull", ("slope_deg", "heading", "branch")),
    "decays": Kind(BEYOND_CHAPTER, "Decay of simulated perturbations", ("gait",)),
    "fronts": Kind(BEYOND_CHAPTER, "Trade-off of stability and efficiency", ("slope_deg", "family", "point")),
    "surfaces": Kind(BEYOND_CHAPTER, "Lines at which families of gaits end", ("line", "point")),
    "limits": Kind(
        BEYOND_CHAPTER, "Where optimised gaits cease to exist", ("objective", "family", "slope_deg", "heading", "axis")
    ),
    "survivals": Kind(BEYOND_CHAPTER, "What gaits survive", ("gait",)),
    "yawing": Kind(BEYOND_CHAPTER, "Gaits of a body that yaws", ("slope_deg", "heading", "branch")),
    "yaw_held": Kind(BEYOND_CHAPTER, "Gaits of the same body with its yaw held", ("slope_deg", "heading", "branch")),
    "yaw_fates": Kind(BEYOND_CHAPTER, "Gaits of the point mass, followed to it", ("slope_deg", "heading", "branch")),
    "yaw_hips": Kind(BEYOND_CHAPTER, "Its stability with hips further back", ("back",)),
}
"""Datasets that are stored, by name; those of several starts are numbered."""


def kind(name: str) -> Kind:
    """Return what kind of dataset one is."""
    return DATA["start" if name.startswith("start_") else name]


class Store:
    """Everything that the thesis's figures and claims are about, computed when it is asked for, and stored.

    Parameters
    ----------
    directory
        Where datasets are stored; what lies there already is used if this version of the package has computed it.
    method
        Of the optimisation.
    starts
        How many further starts to try of the thesis's own search.
    workers
        Processes and threads.
    progress
        Whether to show progress bars.
    """

    def __init__(
        self, directory: Path, method: Method = "default", starts: int = 0, workers: int = 1, progress: bool = False
    ) -> None:
        self.directory, self.method, self.further = directory, method, starts
        self.workers, self.progress = workers, progress
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
        save_csv(dataset, table, kind(name).rows)
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
    def starts(self) -> xr.Dataset | None:
        """Forces of Tables 6.1-6.3 by the thesis's search from further starts; None if there shall be none."""
        numbers = range(1, self.further + 1)
        found = [self._stored(f"start_{number}", partial(self._from_start, number)) for number in numbers]
        return xr.concat(found, dim="start").assign_coords(start=list(numbers)) if found else None

    def _from_start(self, number: int) -> xr.Dataset:
        optima = optimal_atlas(
            self.animal,
            map="reduced",
            method="nelder-mead",
            seed=number,
            workers=self.workers,
            progress=self.progress,
        )
        return peak_ranges(select(optima))

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
    def surfaces(self) -> xr.Dataset:
        """Lines at which families of gaits end."""
        return self._stored("surfaces", lambda: surfaces.lines(self.animal))

    @cached_property
    def limits(self) -> xr.Dataset:
        """Where optimised gaits cease to exist."""
        optima = self.optima
        return self._stored("limits", lambda: limits(self.animal, optima, self.workers), self.method)

    @cached_property
    def survivals(self) -> xr.Dataset:
        """What gaits with the thesis's actuation survive."""
        return self._stored("survivals", lambda: survival.survivals(self.animal, self.workers))

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
        robust = survival.section(self.survivals)
        others = surfaces.section(self.surfaces), robust, each_family, one_leg, self.yaw_section
        return sections(*results, *others, pictures)

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
            starts=self.starts,
        )

    @cached_property
    def force_ranges(self) -> xr.Dataset:
        """Numbers of Tables 6.1-6.3."""
        return force_ranges(self.atlas, self.selected, self.nelder_mead_selected)

    @cached_property
    def force_tables(self) -> dict[str, Table]:
        """Tables 6.1-6.3."""
        return {table.number: table for table in force_tables(self.force_ranges)}

    def table(self, number: str) -> Table:
        """Make a table, of what it needs."""
        if number == "3.1":
            return constraint_table()
        if number == "4.1":
            return parameter_table(self.animal, SLOPES_DEG, HEADINGS)
        if number == "6.agreement":
            return agreement_table(self.force_ranges, self.starts)
        if number == "6.errors":
            return error_table(self.force_ranges)
        if number == "6.differences":
            return difference_table(differences(self.optima, self.selected, self.nelder_mead_selected, self.starts))
        return self.force_tables[number]

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
