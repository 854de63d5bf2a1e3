"""What one good thing costs of another: gaits of which none is better in all that is asked (`legspring.pareto`).

The global part is NSGA-II, of the library pymoo: generations of candidates all over the ranges of some parameters.
The local part goes on from the best of them along derivatives, to each end of the front and into its gaps.
"""

import math
import os
import time
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, pairwise
from typing import Any

import numpy as np
import xarray as xr
from scipy.stats import qmc
from threadpoolctl import threadpool_limits

from legspring.candidates import Bounds, Box, Judge, Trial, bounds_of, box_of
from legspring.checks import LARGEST_SEED, checked_whole, checked_workers, shown
from legspring.constraints import Constraints, named_constraints
from legspring.criteria import GIVEN, Criterion, criteria
from legspring.descent import descended
from legspring.gait import Gait
from legspring.kept import gait_as_json, gait_from_json
from legspring.kernel.walker import Floats
from legspring.mapping import coordinates, empty_map, fill, provenance
from legspring.measures.registry import mapped, measured
from legspring.memory import Memory, opened, recalled
from legspring.parallel import in_threads
from legspring.progress import progress_bar

EVALUATIONS, POPULATION, POINTS = 1000, 48, 15
MOST_EVALUATIONS, MOST_POINTS = 10_000_000, 1000
SAME, NARROW = 1e-6, 1e-3
"""Difference of criteria, by the front's width, that is none; least width, by their values, that is one."""
LOST = 1e9
"""What counts as the criteria of what is no gait."""
CLOSE = 0.25
"""Distance of points, by that of points spread evenly, below which one of them is enough."""
NOTABLE = 0.05
"""Share of its range that a parameter has to change along a front for that to be said."""
Wanted = str | Callable[[Gait], float]


@dataclass(frozen=True)
class Front:
    """Gaits of which none is better than another in all criteria.

    Attributes
    ----------
    box
        The parameters that vary, and their ranges.
    criteria, signs
        What was to be small (1) or large (-1).
    gaits
        The best in the first criterion first.
    values
        ``(N, M)``: their criteria.
    penalties
        ``(N,)``: what each is charged for constraints that it does not keep.
    evaluations, seconds
        Gaits tried, and how long that took.
    """

    box: Box
    criteria: tuple[Criterion, ...]
    signs: Floats
    gaits: tuple[Gait, ...]
    values: Floats
    penalties: Floats
    evaluations: int = 0
    seconds: float = 0.0

    @cached_property
    def places(self) -> Floats:
        """Where the gaits are in the box, ``(N, D)``."""
        return np.array([self.box.place(gait) for gait in self.gaits]).reshape(-1, len(self.box.names))

    @cached_property
    def ends(self) -> tuple[int, ...]:
        """The gait that is best in each criterion."""
        return tuple(int(np.argmin(column)) for column in (self.signs * self.values).T) if self.gaits else ()

    def separation(self) -> list[str]:
        """Say what separates the ends of the front, a line for each pair of criteria."""
        return [self._between(i, j) for i, j in combinations(range(len(self.criteria)), 2)] if self.gaits else []

    def _between(self, i: int, j: int) -> str:
        one, other = self.ends[i], self.ends[j]
        words = f"from the best {self.criteria[i].name} to the best {self.criteria[j].name}"
        if one == other:
            return f"{words}: one gait is the best in both"
        order = np.argsort((self.signs * self.values)[:, i], kind="stable")
        moves = self.places[other] - self.places[one]
        said = []
        for n in np.argsort(-np.abs(moves), kind="stable").tolist():
            if abs(moves[n]) >= NOTABLE:
                begin, end = (self.box.values(self.places[k])[n] for k in (one, other))
                along = np.diff(self.places[order, n])
                steady = np.all(along >= -NOTABLE) if moves[n] > 0.0 else np.all(along <= NOTABLE)
                name, unit = self.box.names[n], self.box.units[n].replace("1", "")
                way = "" if steady else ", not steadily"
                said.append(f"{name} {begin:.4g} -> {end:.4g} {unit}".rstrip() + f" ({100 * moves[n]:+.0f} %{way})")
        still = [name for name, move in zip(self.box.names, moves, strict=True) if abs(move) < NOTABLE]
        families = [self.gaits[k].family for k in (one, other)]
        said += [f"family {families[0]} -> {families[1]}"] if families[0] != families[1] else []
        said += [f"hardly {', '.join(still)}"] if still else []
        return f"{words}: {', '.join(said)}"

    def at_limits(self) -> list[str]:
        """Name the parameters that are at an end of their range in most of the gaits: a wider one would give more."""
        found = []
        for name, column in zip(self.box.names, self.places.T, strict=True):
            for word, there in (("least", column < 1e-6), ("largest", column > 1.0 - 1e-6)):
                if len(column) and np.mean(there) > 0.5:
                    found.append(f"{name} at its {word} value")
        return found

    def to_dataset(self) -> xr.Dataset:
        """Return the front with all measures of its gaits, over ``point``.

        ``objectives`` over objective, ``parameters`` over parameter, ``penalty``, ``family``, and what maps say of
        gaits.
        """
        animal = self.gaits[0].animal if self.gaits else None
        about = {
            "objectives": (("point", "objective"), self.values, {"long_name": "what is traded"}),
            "parameters": (
                ("point", "parameter"),
                np.array([self.box.values(place) for place in self.places]).reshape(self.places.shape),
                {"long_name": "what varies"},
            ),
            "penalty": ("point", self.penalties, {"long_name": "charged for constraints", "units": "1"}),
        }
        coords: dict[str, Any] = {
            "objective": [one.name for one in self.criteria],
            "objective_unit": ("objective", [one.unit for one in self.criteria]),
            "best": ("objective", ["least" if sign > 0.0 else "most" for sign in self.signs]),
            "parameter": list(self.box.names),
            "parameter_unit": ("parameter", list(self.box.units)),
            "least": ("parameter", self.box.low, {"long_name": "least value of the range"}),
            "most": ("parameter", self.box.high, {"long_name": "largest value of the range"}),
        }
        attrs: dict[str, Any] = {"evaluations": self.evaluations, "seconds": self.seconds}
        attrs["separation"] = "\n".join(self.separation())
        if animal is None:
            return xr.Dataset(about, coords, attrs)
        measures = mapped(animal)
        coords |= coordinates(animal, {}) | {"point": ("point", np.arange(len(self.gaits)))}
        dataset = empty_map(measures, ("point",), coords)
        fill(dataset, [((n,), measured(measures, gait)) for n, gait in enumerate(self.gaits)])
        dataset = dataset.assign(about | {"gait": ("point", [gait_as_json(gait) for gait in self.gaits])})
        names = ", ".join(one.name.replace("_", " ") for one in self.criteria)
        return dataset.assign_attrs(provenance(animal) | attrs | {"title": f"{animal.name}: {names}"})


def pareto(
    gaits: Gait | Sequence[Gait],
    over: Mapping[str, tuple[float, float]],
    *,
    minimize: Sequence[Wanted] | Wanted | None = None,
    maximize: Sequence[Wanted] | Wanted | None = None,
    bounds: Bounds | None = None,
    constraints: Constraints | str | None = None,
    evaluations: int = EVALUATIONS,
    refine: bool = True,
    points: int = POINTS,
    seed: int = 0,
    workers: int | None = None,
    store: str | os.PathLike[str] | None = None,
    progress: bool = False,
) -> Front:
    """Find the gaits that are worth having where several things are to be small, or large: the Pareto front.

    Parameters vary within ranges; gaits are followed there from those given, verified and judged. A global search by
    NSGA-II (the extra ``pareto`` of this package) is followed by a local one along derivatives: of each criterion
    alone, and of all together, also into the gaps of the front. See :ref:`numerics-pareto`.

    Parameters
    ----------
    gaits
        The gait to begin with, or several, of different families for instance, which then compete.
    over
        Parameters of the animal, or what gaits were asked for (see `legspring.parameters`), each with the range that
        it may have, in SI units (slope_deg in deg). The given gaits must be within.
    minimize, maximize
        What is to be small, and what large: names of measures (of several numbers, as ``"peak_force"``, the
        largest magnitude counts), ``"stability"`` (largest multiplier but for what is conserved), ``"recovery"``
        (steps), ``"push"`` (largest push survived), ``"basin"`` (share of starts that lead there), ``"roughness"``
        (largest noise of the slope survived, deg), or functions of a gait. Two or more in all.
    bounds
        Criteria with the least and the largest value that a gait may have, as in ``{"friction": (None, 0.8)}``.
    constraints
        What gaits pay for in each criterion, as in `legspring.optimize`: ``"peterson2011"`` or a
        `legspring.constraints.Constraints`.
    evaluations
        Gaits that the global search tries; 0 for no such search.
    refine
        Whether to search locally from what is known.
    points
        About how many gaits there are to be on the front; at most so many.
    seed
        Of the global search. The result depends on it, and not on the number of workers.
    workers
        Threads; by default one a core.
    store
        Directory that keeps what was computed, so that a search which was stopped goes on where it was.
    progress
        Whether to show progress bars.

    Raises
    ------
    ValueError
        For unknown names, ranges that are none or do not hold the gaits, or fewer than two criteria.
    ImportError
        If pymoo is missing.

    Examples
    --------
    >>> import legspring as ls
    >>> gait = ls.find_gaits(ls.cockroach(), slope_deg=45, heading=0.15)[0]
    >>> ranges = {"B.stiffness": (1.2, 1.8)}
    >>> front = ls.pareto(gait, ranges, minimize=["stability", "peak_force"], evaluations=0, points=3)
    >>> len(front.gaits) >= 3, bool(front.values[0, 0] < front.values[-1, 0])
    (True, True)
    """
    given = (gaits,) if isinstance(gaits, Gait) else tuple(gaits)
    if not given or not all(isinstance(gait, Gait) for gait in given):
        raise ValueError(f"gaits = {shown(gaits)}: must be a gait, or several")
    least, most = (criteria(()) if some is None else criteria(some) for some in (minimize, maximize))
    wanted = (*least, *most)
    if len(wanted) < 2:
        raise ValueError(f"minimize, maximize = {shown([one.name for one in wanted])}: must be two criteria or more")
    if twice := {one.name for one in least} & {one.name for one in most}:
        raise ValueError(f"minimize, maximize = {shown(min(twice))}: must be one or the other")
    rules = None if constraints is None else named_constraints(constraints)
    count = checked_whole("evaluations", evaluations, 0, MOST_EVALUATIONS)
    size, threads = checked_whole("points", points, 2, MOST_POINTS), checked_workers(workers)
    seed = checked_whole("seed", seed, 0, LARGEST_SEED)
    signs = np.array([1.0] * len(least) + [-1.0] * len(most))
    judge = Judge(box_of(given, over), given, wanted, signs, bounds_of(bounds or {}), rules)
    if count:
        check_library()
    begin = time.perf_counter()
    archive = Archive(judge, threads, kept_in(store, judge))
    with threadpool_limits(1):
        first = judge.first()
        archive.trials += first
        if count:
            explore(archive, count, seed, progress)
        best = local(archive, size, progress) if refine else spread(worthwhile(archive), size)
    order = sorted(best, key=lambda trial: trial.values.tolist())
    chosen = tuple(trial.gait for trial in order if trial.gait is not None)
    values = np.array([[one.function(gait) for one in wanted] for gait in chosen]).reshape(-1, len(wanted))
    penalties = np.array([trial.values[0] for trial in order]) - signs[0] * values[:, 0] if chosen else np.zeros(0)
    seconds = time.perf_counter() - begin
    return Front(judge.box, wanted, signs, chosen, values, penalties, archive.evaluations, seconds)


def check_library() -> None:
    """Raise ImportError, with what to do, if pymoo is missing."""
    try:
        import pymoo  # noqa: F401
    except ImportError:
        raise ImportError("pareto: needs pymoo; install it with: pip install 'legspring[pareto]'") from None


def kept_in(store: str | os.PathLike[str] | None, judge: Judge) -> Memory | None:
    """Return what is kept of a search in a directory."""
    if store is not None and any(one.words == GIVEN for one in (*judge.criteria, *(one for one, *_ in judge.bounds))):
        raise ValueError(f"store = {str(store)!r}: must be left out where a criterion is a function")
    about = [gait_as_json(gait) for gait in judge.starts], judge.box, [one.name for one in judge.criteria]
    limits = [(one.name, low, high) for one, low, high in judge.bounds]
    return opened(store, "pareto", *about, limits, judge.signs, judge.constraints)


class Archive:
    """All candidates that were tried so far.

    Parameters
    ----------
    judge
        What judges them.
    workers
        Threads.
    memory
        What was tried before the search was stopped; None to keep nothing.
    """

    def __init__(self, judge: Judge, workers: int, memory: Memory | None) -> None:
        self.judge, self.workers, self.memory = judge, workers, memory
        self.trials: list[Trial] = []
        self.evaluations = 0

    def __call__(self, places: Floats, starts: Sequence[int], tick: Callable[[int], None]) -> list[Trial]:
        """Try some places, each going back to one of the given gaits."""
        tasks, known = list(zip(places, starts, strict=True)), list(self.trials)

        def work() -> list[list[Any]]:
            trials = in_threads(lambda task: self.judge(task[0], task[1], known), tasks, self.workers, tick)
            return [_packed(trial) for trial in trials]

        before = self.evaluations
        kept = recalled(self.memory, work, "generation", before, places, list(starts))
        found = [_unpacked(one, start) for one, start in zip(kept, starts, strict=True)]
        self.trials += [trial for trial in found if trial.gait is not None]
        self.evaluations += len(found)
        return found

    def local(self, name: str, search: Callable[[], Trial | None], start: Trial) -> Trial | None:
        """Return the end of a local search, which may be kept; None if that is no better."""

        def work() -> list[Any]:
            end = search()
            return [] if end is None else _packed(end)

        kept = recalled(self.memory, work, "local", name, start.place, start.values)
        return _unpacked(kept, start.start) if kept else None


def _packed(trial: Trial) -> list[Any]:
    """Return a trial as it is kept."""
    text = "" if trial.gait is None else gait_as_json(trial.gait)
    return [text, trial.place, trial.values, trial.excess]


def _unpacked(kept: Sequence[Any], start: int) -> Trial:
    """Return a trial of which this is kept."""
    text, place, values, excess = kept
    return Trial(place, start, gait_from_json(text), values, excess) if text else Trial(place, start)


def explore(archive: Archive, evaluations: int, seed: int, progress: bool) -> None:
    """Search globally: NSGA-II, in whose last variable is to which of the given gaits a candidate goes back."""
    from pymoo.algorithms.moo.nsga2 import NSGA2
    from pymoo.core.evaluator import Evaluator
    from pymoo.core.problem import Problem
    from pymoo.problems.static import StaticProblem

    judge, first = archive.judge, list(archive.trials)
    size, many = len(judge.box.names), len(judge.starts)
    population = max(4, min(POPULATION, evaluations))
    generations = max(1, round(evaluations / population))
    begin = qmc.Sobol(size + 1, rng=seed).random(2 ** math.ceil(math.log2(population)))[:population]
    for row, trial in zip(begin, first, strict=False):
        row[:size], row[size] = np.clip(trial.place, 0.0, 1.0), (trial.start + 0.5) / many
    problem = Problem(
        n_var=size + 1,
        n_obj=len(judge.criteria),
        n_ieq_constr=1,
        xl=np.zeros(size + 1),
        xu=np.ones(size + 1),
    )
    algorithm = NSGA2(pop_size=population, sampling=begin)
    algorithm.setup(problem, seed=seed, termination=("n_gen", generations), verbose=False)
    with progress_bar("exploring", generations * population, show=progress) as tick:
        while algorithm.has_next():
            asked = algorithm.ask()
            x = asked.get("X")
            starts = np.minimum((x[:, size] * many).astype(int), many - 1).tolist()
            found = archive(x[:, :size], starts, tick)
            values = np.array([t.values if t.keeps else np.full(len(judge.criteria), LOST) for t in found])
            beyond = np.array([[_violation(trial)] for trial in found])
            Evaluator().eval(StaticProblem(problem, F=values, G=beyond), asked)
            algorithm.tell(infills=asked)


def _violation(trial: Trial) -> float:
    """Return by how much a candidate breaks bounds, above 0 if it does at all, or is no gait."""
    if trial.keeps:
        return -1.0
    known = trial.gait is not None and np.all(np.isfinite(trial.values)) and np.all(np.isfinite(trial.excess))
    return float(np.sum(np.maximum(trial.excess, 0.0))) if known else LOST


def local(archive: Archive, points: int, progress: bool) -> list[Trial]:
    """Search locally for the ends of the front, from some points of it, and in its gaps; return it."""
    judge = archive.judge
    smooth = np.array([one.smooth for one in judge.criteria])
    front = worthwhile(archive) or restored(archive)
    if not front or not smooth.any():
        return spread(front, points)
    with progress_bar("refining", points + len(judge.criteria), show=progress) as tick:
        for m in np.flatnonzero(smooth).tolist():
            front = _with(archive, front, min(front, key=lambda trial: float(trial.values[m])), f"end {m}", only=m)
            tick(1)
        front = spread(front, points)
        for n, trial in enumerate(list(front)):
            front = _with(archive, front, trial, f"point {n}")
            tick(1)
        tried: set[tuple[float, ...]] = set()
        while len(judge.criteria) == 2 and smooth.all() and len(front) < points:
            gap = widest_gap(front, tried)
            if gap is None:
                break
            tried.add((*gap[0].values, *gap[1].values))
            for side in gap:
                front = _with(archive, front, side, "gap", target=0.5 * (gap[0].values + gap[1].values))
            front = spread(front, points)
            tick(1)
    return spread(front, points)


def restored(archive: Archive) -> list[Trial]:
    """Search for a gait that keeps all bounds where none does that was tried: from the one that comes closest."""
    some = [one for one in archive.trials if np.all(np.isfinite(one.numbers))]
    start = min(some, key=lambda one: float(np.max(one.excess / archive.judge.sizes)), default=None)
    if start is None:
        return []
    end = archive.local("bounds", lambda: descended(archive.judge, start, start.values, None), start)
    return [] if end is None or not end.keeps else [end]


def worthwhile(archive: Archive) -> list[Trial]:
    """Return the front of what was tried."""
    return undominated([trial for trial in archive.trials if trial.keeps])


def _with(
    archive: Archive,
    front: list[Trial],
    start: Trial,
    name: str,
    only: int | None = None,
    target: Floats | None = None,
) -> list[Trial]:
    """Return a front with what a local search from one of its points ends at."""
    sizes = widths(front)
    weights = sizes if only is None else np.where(np.arange(len(sizes)) == only, sizes, math.inf)
    aim = start.values if target is None else target
    about = f"{name} {aim.tolist()} {weights.tolist()}"
    end = archive.local(about, lambda: descended(archive.judge, start, aim, weights), start)
    return front if end is None else undominated([*front, end])


def widest_gap(front: Sequence[Trial], tried: Container[tuple[float, ...]]) -> tuple[Trial, Trial] | None:
    """Return the neighbours on a front of two criteria that are farthest apart, of those that were not yet tried."""
    ordered, width = sorted(front, key=lambda trial: trial.values.tolist()), widths(front)
    gaps = [pair for pair in pairwise(ordered) if (*pair[0].values, *pair[1].values) not in tried]
    return max(gaps, key=lambda gap: float(np.linalg.norm((gap[1].values - gap[0].values) / width)), default=None)


def widths(front: Sequence[Trial]) -> Floats:
    """Return the width of a front in each criterion, ``(M,)``."""
    values = np.array([trial.values for trial in front])
    return np.maximum(np.ptp(values, axis=0), NARROW * np.maximum(np.max(np.abs(values), axis=0), NARROW))


def undominated(trials: Sequence[Trial]) -> list[Trial]:
    """Return the trials than which no other is better in one criterion and not worse in any; of equal ones one."""
    if not trials:
        return []
    values = np.array([trial.values for trial in trials])
    near = SAME * widths(trials)
    kept: list[int] = []
    for n in np.lexsort(values.T[::-1]).tolist():
        if not any(np.all(values[k] <= values[n] + near) for k in kept):
            kept.append(n)
    # What came first is within a hair of what it let pass: look once more, the other way.
    return [trials[n] for n in kept if not any(_better(values[k], values[n]) for k in kept if k != n)]


def _better(one: Floats, other: Floats) -> bool:
    """Whether some criteria are better in one, and none is worse."""
    return bool(np.all(one <= other) and np.any(one < other))


def spread(front: Sequence[Trial], points: int) -> list[Trial]:
    """Choose so many points of a front: the best in each criterion, then those farthest from the chosen, none close."""
    if not front:
        return []
    values = np.array([trial.values for trial in front])
    scaled = (values - values.min(axis=0)) / widths(front)
    chosen = list(dict.fromkeys(np.argmin(scaled, axis=0).tolist()))[:points]
    while len(chosen) < points:
        apart = np.min(np.linalg.norm(scaled[:, None] - scaled[chosen], axis=2), axis=1)
        if np.max(apart) < CLOSE / points:
            break
        chosen.append(int(np.argmax(apart)))
    return [front[n] for n in sorted(chosen)]
