"""The actuation that makes gaits most stable or most efficient.

The method looks all over the range of actuations for gaits (`scan`), polishes the best of them, constraints as
constraints (`legspring.programme.Programme`), and takes the least actuation among those that are as good (`settle`):
the minimum is often not unique. Other methods are looked up by their names (`METHODS`).
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import fields
from pkgutil import resolve_name
from typing import Any, NamedTuple, get_args

import numpy as np
from scipy.spatial import cKDTree
from scipy.stats import qmc
from threadpoolctl import threadpool_limits

from legspring.actuated import Map, pair_lengths
from legspring.checks import LARGEST_SEED, checked_angle, checked_choice, checked_whole, shown
from legspring.constraints import Constraints, named_constraints
from legspring.direct import direct, is_programmable, tried
from legspring.fronts import pareto
from legspring.gait import Gait
from legspring.kernel import newton
from legspring.kernel.walker import Floats
from legspring.layout import slope_for
from legspring.model import Animal
from legspring.objective import Candidate, Goal, Objective, Score
from legspring.optimum import TIE, Method, Optimum, best_of
from legspring.problem import NARROW
from legspring.programme import ITERATIONS, LATEST_OF_ALL, Programme
from legspring.solve import ROUGH_GOAL
from legspring.starts import ROUGH_ACCURACY

METHODS: dict[Method, tuple[str, str]] = {
    "default": ("legspring.optimisation:search", "legspring.exchange:search"),
    "nelder-mead": ("legspring.peterson2011.search:search", "legspring.peterson2011.search:search_map"),
}
"""Who searches for the best of one cell, and of a map."""

NODES = 256
"""Actuations at which a search looks for gaits; a power of two."""
NEIGHBOURS = 3
"""Actuations to which each solution is continued."""
STARTS_AT_NODE = 1
"""Starts at each actuation."""
START_PHASE = math.pi / 2
"""Their phases are within this much of 0, rad."""
MOST_AT_NODE = 3
"""Solutions kept at each actuation."""
POLISHED = 24
"""Gaits that are polished."""
FEW_NODES, FEW_POLISHED = 32, 2
"""The same in each of the places around."""
NEAR_PLACES = ((5.0, 0.0), (-5.0, 0.0), (15.0, 0.0), (-15.0, 0.0), (0.0, 0.05), (0.0, -0.05))
FAR_PLACES = ((-30.0, 0.0), (30.0, 0.0), (-45.0, 0.0))
"""How far away these are: slope (deg), heading (rad); the far ones are for when nothing else was found."""
FEWEST_STOPS, STOP_EVERY = 4, math.radians(3.0)
"""On the way from one place to another optima are looked for so often, or every so much of the slope."""
APART = 0.35
"""Difference of phases between starts of polishing, rad."""
ALIKE = 0.1
"""Difference of actuations, in units of nominal lengths, below which two candidates may be alike."""
FIRST_ITERATIONS = 8
"""Iterations after which only the best of some searches goes on."""
MOST_POINTS = 1000
"""Gaits of a trade-off."""
GAIN = 1e-4
"""Gain for which it is worth starting a search again from where it ended."""


class End(NamedTuple):
    """Where a search ended, and why."""

    score: Score
    reason: str

    @property
    def candidate(self) -> Candidate:
        """What to start from again."""
        assert self.score.unknowns is not None
        return Candidate(self.score.actuation, self.score.unknowns, self.score.beside)

    @property
    def effort(self) -> float:
        """Sum of squared actuations, in units of nominal lengths."""
        return float(np.sum(self.score.actuation**2))


def optimize(
    animal: Animal,
    *,
    heading: float | None = None,
    slope: float | None = None,
    slope_deg: float | None = None,
    family: str | None = None,
    objective: Goal = "stability",
    map: Map = "complete",
    method: Method = "default",
    seed: int = 0,
    constraints: Constraints | str = "peterson2011",
) -> Optimum | None:
    """Find the actuation of each pair of legs that makes a gait most stable, or most efficient.

    The actuation and the gait keep constraints, the soft ones at a price. Among actuations that are as good (to 1e-3),
    the smallest is taken.

    See :ref:`model-optimal`.

    Parameters
    ----------
    animal
        The animal; some of its legs must have an actuation.
    heading
        rad, within +-1.47, as there must be a fixed point at a slightly larger one; to be left out where gaits have
        headings of their own.
    slope, slope_deg
        Either of them; rad or degrees (see `legspring.find_gaits`).
    family
        Which pairs of legs push; by default the best family, and among those as good the cheaper.
    objective
        ``"stability"``: the least largest eigenvalue magnitude; ``"efficiency"``: the least transport cost.
    map
        Whose eigenvalues: ``"complete"``, the Floquet multipliers, or ``"reduced"``, the thesis's.
    method
        ``"default"``, or ``"nelder-mead"``: the thesis's method, started from the best gait of a coarse search. The
        default is a nonlinear programme for point masses on three pairs of legs as the thesis has them; other animals
        are searched by trial (``legspring.direct``), which is slower.
    seed
        Of the actuations at which the search looks for gaits; the result must not depend on it.
    constraints
        By default those of the thesis's Table 3.1, `legspring.peterson2011.constraints.TABLE_3_1`: an actuation within
        0.2 and 0.9 of the nominal lengths, for instance. Others are a `legspring.constraints.Constraints`, such as
        ``dataclasses.replace(TABLE_3_1, actuation=(0.1, 0.6))``.

    Returns
    -------
    Optimum or None
        A gait that also says what was reached, why the search stopped and which constraints bind; None if no gait
        was found that is worth more than none (in the thesis's constraints, a penalised objective of 2).

    Raises
    ------
    ValueError
        For an angle out of range, an unknown family, objective, map, method or constraints, or an animal whose gaits
        have other unknowns.

    Examples
    --------
    >>> import legspring as ls
    >>> best = ls.optimize(ls.cockroach(), slope_deg=45, heading=0.15, family="B", objective="efficiency")
    >>> round(best.transport_cost, 4), best.method
    (0.7071, 'default')
    """
    angle, seed = slope_for(animal, slope, slope_deg), checked_whole("seed", seed, 0, LARGEST_SEED)
    checked_choice("method", method, METHODS)
    look = resolve_name(METHODS[method][0])
    if not is_programmable(animal):
        if method != "default":
            raise ValueError(f"method = {shown(method)}: must be default for {animal.name!r}")
        found = [
            tried(direct(animal, angle, label, heading, objective, map, constraints), seed)
            for label in (animal.families if family is None else [family])
        ]
        return best_of([optimum for optimum in found if optimum is not None])
    heading = heading_of(heading)
    # Matrices are tiny: threads would only get in each other's way, and round differently.
    with threadpool_limits(1):
        found = [
            look(Objective(animal, angle, heading, label, objective, map, constraints=constraints), seed)
            for label in (animal.families if family is None else [family])
        ]
    return best_of([optimum for optimum in found if optimum is not None])


def heading_of(heading: float | None) -> float:
    """Return a heading; raise ValueError if it is missing, or none."""
    if heading is None:
        raise ValueError("heading is missing: must be an angle in rad, within +-pi/2")
    return checked_angle("heading", heading, math.pi / 2)


def search(objective: Objective, seed: int) -> Optimum | None:
    """Search one family in one cell."""
    candidates = scan(objective, seed)
    ends = explore(objective, spread_out(rank(objective, candidates), POLISHED))
    if not ends or not is_as_good_as_can_be(objective, ends[0]):
        ends += from_around(objective, NEAR_PLACES, seed)
    if not ends:
        ends += from_around(objective, FAR_PLACES, seed)
    ends.sort(key=lambda end: end.score.total)
    return settle(objective, ends, candidates)


def from_around(objective: Objective, places: Sequence[tuple[float, float]], seed: int) -> list[End]:
    """Search from the optima of places around: gaits that are rare here may be found there, and followed from there."""
    system, heading = objective.actuated.system, objective.actuated.heading
    animal, slope = system.animal, system.slope
    ends: list[End] = []
    for change_deg, turn in places:
        try:
            animal.desired_speed(slope + math.radians(change_deg))
            origin = objective.at(slope + math.radians(change_deg), heading + turn)
        except ValueError:  # there is no such slope, or heading
            continue
        near = explore(origin, spread_out(rank(origin, scan(origin, seed, FEW_NODES)), FEW_POLISHED))
        ends += approached(objective, origin, near[0].candidate) if near else []
        objective.evaluations += origin.evaluations
    return ends


def approached(objective: Objective, origin: Objective, candidate: Candidate) -> list[End]:
    """Search from an optimum of another place by way of what lies in between; return the ends, the best first."""
    start, target = (np.array([o.actuated.system.slope, o.actuated.heading]) for o in (origin, objective))
    count = max(FEWEST_STOPS, round(abs(float(target[0] - start[0])) / STOP_EVERY))
    for share in (np.arange(count) + 1.0) / count:
        halt = objective if share == 1.0 else objective.at(*(start + share * (target - start)).tolist())
        end = polish(halt, candidate, iterations=FIRST_ITERATIONS)
        if end is None:
            return []
        candidate = end.candidate
    return explore(objective, [candidate])


def trade_off(
    animal: Animal,
    *,
    heading: float | None = None,
    family: str,
    slope: float | None = None,
    slope_deg: float | None = None,
    map: Map = "complete",
    points: int = 9,
    seed: int = 0,
    constraints: Constraints | str = "peterson2011",
) -> list[Gait]:
    """Find gaits from the most stable to the cheapest one of a family: the Pareto front of both objectives.

    Parameters
    ----------
    animal, heading, family, slope, slope_deg, map, seed, constraints
        See `optimize`.
    points
        About how many gaits, from 2; those in between cost least within bounds of the eigenvalue.

    Returns
    -------
    list of Gait
        The most stable first; empty if there is none.

    Raises
    ------
    ValueError
        As `optimize` does, and for too few points.
    """
    points = checked_whole("points", points, 2, MOST_POINTS)
    angle = slope_for(animal, slope, slope_deg)
    here: dict[str, Any] = {"heading": heading, "family": family, "slope": angle, "map": map, "seed": seed}
    best = [optimize(animal, **here, objective=goal, constraints=constraints) for goal in get_args(Goal)]
    ends = [optimum for optimum in best if optimum is not None]
    if len(ends) < 2:
        return []
    rules, programmable = named_constraints(constraints), is_programmable(animal)
    gaits: Sequence[Gait] = ends
    if programmable:
        objective = Objective(animal, angle, heading_of(heading), family, "efficiency", map, constraints=rules)
        stable, cheap = (objective.candidate(end) for end in ends)
        with threadpool_limits(1):
            found = [objective.gait(score) for score in front(objective, stable, cheap, points)]
        gaits = [gait for gait in found if gait is not None]
    ranges = {
        f"{pair}.actuation": (rules.actuation[0] * length, rules.actuation[1] * length)
        for pair, length, amount in zip(animal.pairs, pair_lengths(animal), animal.actuation, strict=True)
        if amount > 0.0
    }
    traded = ("reduced_eigenvalue" if map == "reduced" else "stability", "transport_cost")
    whole = pareto(
        gaits, ranges, minimize=traded, constraints=rules, evaluations=0, refine=not programmable, points=points
    )
    return list(whole.gaits)


def scan(objective: Objective, seed: int = 0, nodes: int = NODES) -> list[Candidate]:
    """Look for solutions of a gait's conditions at actuations all over their range.

    What is found at one actuation is continued to those around it, until nothing new turns up.
    """
    actuated, (least, most) = objective.actuated, objective.constraints.actuation
    problem, sobol = (
        actuated.problem,
        qmc.Sobol(len(actuated.lengths) + STARTS_AT_NODE * actuated.problem.size, rng=seed),
    )
    points = sobol.random(nodes)
    grid = least + (most - least) * points[:, : len(actuated.lengths)]
    slow, fast = NARROW["speed"]
    low = np.array([slow, *np.full(len(actuated.lengths), -START_PHASE)])
    high = np.array([fast, *np.full(len(actuated.lengths), START_PHASE)])
    starts = low + (high - low) * points[:, len(actuated.lengths) :].reshape(-1, problem.size)
    near = cKDTree(grid).query(grid, NEIGHBOURS + 1)[1][:, 1:]
    found: list[list[Floats]] = [[] for _ in grid]
    where = np.repeat(np.arange(nodes), STARTS_AT_NODE)
    while len(where):
        solved = actuated.solve(grid[where], starts, ROUGH_ACCURACY, ROUGH_GOAL)
        fresh = []
        for node, z, ending in zip(where.tolist(), solved.z, solved.endings, strict=True):
            sensible = ending == newton.CONVERGED and bool(np.all(np.abs(z[1:]) < LATEST_OF_ALL))
            if sensible and len(found[node]) < MOST_AT_NODE and not is_among(z, found[node]):
                found[node].append(z)
                fresh.append((node, z))
        tasks = [(n, z) for node, z in fresh for n in near[node].tolist() if len(found[n]) < MOST_AT_NODE]
        where, starts = np.array([n for n, _ in tasks], dtype=int), np.array([z for _, z in tasks])
    return [Candidate(grid[node], z) for node, solutions in enumerate(found) for z in solutions]


def is_among(z: Floats, others: Iterable[Floats]) -> bool:
    """Whether unknowns are, roughly, among others."""
    return any(float(np.max(np.abs(z - other))) < 1e-4 for other in others)


def rank(objective: Objective, candidates: Sequence[Candidate], most: float = np.inf) -> list[Candidate]:
    """Sort candidates by the objective (but for the gaits beside); leave out those that are no gaits, or too bad."""
    if not candidates:
        return []
    totals = objective.totals(np.array([candidate.point for candidate in candidates]))
    order = np.argsort(totals, kind="stable")
    return [candidates[n] for n in order if totals[n] < min(most, 1e3)]


def spread_out(candidates: Iterable[Candidate], count: int) -> list[Candidate]:
    """Choose the first candidates whose phases differ: those that minima are apart by."""
    chosen: list[Floats] = []
    out = []
    for candidate in candidates:
        phases = candidate.unknowns[1:]
        if all(np.max(np.abs(phases - other)) > APART for other in chosen):
            chosen.append(phases)
            out.append(candidate)
        if len(out) == count:
            break
    return out


def polish(
    objective: Objective, start: Candidate, most: float | None = None, iterations: int = ITERATIONS
) -> End | None:
    """Minimise the objective, or, given what is good enough, the actuation; None if the search ends at no gait."""
    programme = Programme(objective)
    before = objective(*start)
    x, reason = programme.minimise(programme.start(start.actuation, start.unknowns, before.beside), most, iterations)
    objective.evaluations += programme.evaluations
    score = objective(x[programme.u], x[programme.z], x[programme.beside])
    if most is None:
        # The programme asks for a little more than the objective does, and may stop at a kink.
        score = min(score, before, key=lambda score: score.total)
    return End(score, reason) if score.total < objective.constraints.no_gait else None


def explore(objective: Objective, starts: Iterable[Candidate]) -> list[End]:
    """Polish some gaits, the best of them well, until one is as good as can be; return the ends, the best first."""
    ends: list[End] = []
    for start in starts:
        end = polish(objective, start, iterations=FIRST_ITERATIONS)
        if end is not None:
            ends.append(end)
            if is_as_good_as_can_be(objective, end):
                break
    ends.sort(key=lambda end: end.score.total)
    # A search that starts again sees the way with other eyes.
    while ends and not is_as_good_as_can_be(objective, ends[0]):
        end = polish(objective, ends[0].candidate)
        if end is None or end.score.total > ends[0].score.total - GAIN:
            break
        ends.insert(0, end)
    return ends


def is_as_good_as_can_be(objective: Objective, end: End) -> bool:
    """Whether nothing could be better by as much as counts."""
    return end.score.total < objective.floor + 0.6 * TIE


def settle(objective: Objective, ends: Sequence[End], candidates: Sequence[Candidate] = ()) -> Optimum | None:
    """Take the least actuation among those as good as the best, and make it a gait; None if there is nothing."""
    if not ends:
        return None
    starts = [*ties_of(objective, ends), *ties(objective, candidates, ends[0])]
    return finished(objective, lessen(objective, ends[0], ends[0], starts), "default")


def as_good(objective: Objective, best: End) -> float:
    """Return the objective of gaits that are as good as the best one: greater by what does not count."""
    return (objective.floor if is_as_good_as_can_be(objective, best) else best.score.total) + TIE


def ties_of(objective: Objective, ends: Sequence[End]) -> list[Candidate]:
    """Return the ends that are as good as the first one, and unlike one another."""
    chosen: list[Candidate] = []
    for end in ends:
        good = end.score.total <= as_good(objective, ends[0])
        if good and not any(are_alike(end.candidate, other) for other in chosen):
            chosen.append(end.candidate)
    return chosen


def are_alike(one: Candidate, other: Candidate) -> bool:
    """Whether searches from two candidates will probably end at the same place."""
    actuations, phases = np.abs(one.actuation - other.actuation), np.abs(one.unknowns[1:] - other.unknowns[1:])
    return bool(np.max(actuations) < ALIKE and np.max(phases) < APART)


def ties(objective: Objective, candidates: Sequence[Candidate], best: End) -> list[Candidate]:
    """Choose a few candidates that are as good as the best end, the least actuated first."""
    good = rank(objective, candidates, as_good(objective, best))
    return spread_out(sorted(good, key=lambda candidate: float(np.sum(candidate.actuation**2))), 3)


def lessen(objective: Objective, end: End, best: End, starts: Iterable[Candidate]) -> End:
    """Look for a smaller actuation than that of an end, from some starts, among gaits as good as the best."""
    most = as_good(objective, best)
    for start in starts:
        other = polish(objective, start, most - 0.05 * TIE)
        if other is not None and other.score.total <= most and other.effort < end.effort:
            end = End(other.score, best.reason)
    return end


def front(objective: Objective, stable: Candidate, cheap: Candidate, points: int) -> list[Score]:
    """Trade stability for efficiency between the best gaits for either: least cost within bounds of the eigenvalue.

    Parameters
    ----------
    objective
        That of efficiency.
    stable, cheap
        The most stable gait, and the cheapest one.
    points
        How many bounds, between the eigenvalues of these two.

    Returns
    -------
    list of Score
        The most stable first; the two ends alone if the cheapest gait is the most stable one as well; nothing if one
        of the ends is no gait.
    """
    ends = [objective.approached(objective(*one)) for one in (stable, cheap)]
    if any(end.unknowns is None for end in ends):
        return []
    low, high = (objective.eigenvalue(end) for end in ends)
    found = [ends[1]]
    for limit in np.linspace(high, low, points)[1:-1] if high > low + TIE else []:
        programme = Programme(objective, float(limit))
        tried = []
        for start in (found[0], ends[0]):
            assert start.unknowns is not None
            x, _ = programme.minimise(programme.start(start.actuation, start.unknowns, start.beside))
            score = objective(x[programme.u], x[programme.z], x[programme.beside])
            if score.total < objective.constraints.no_gait and objective.eigenvalue(score) < limit + TIE:
                tried.append(score)
        found = [*sorted(tried, key=lambda score: score.total)[:1], *found]
    return [ends[0], *found]


def finished(objective: Objective, end: End, method: Method) -> Optimum | None:
    """Make the end of a search a gait, refined and verified; None if it is none, or not worth having."""
    score = end.score
    gait = objective.gait(score) if score.total < objective.constraints.no_gait else None
    if gait is None:
        return None
    return Optimum(
        **{field.name: getattr(gait, field.name) for field in fields(Gait)},
        objective=objective.goal,
        map=objective.of,
        method=method,
        value=score.value,
        penalised=score.total,
        ending=end.reason,
        active=objective.active(score),
        evaluations=objective.evaluations,
    )
