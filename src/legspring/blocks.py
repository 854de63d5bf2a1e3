"""What a block of a sweep holds: gaits followed, or searched for, at its points, and all that is said of them."""

import hashlib
import json
import math
import threading
from collections import Counter
from collections.abc import Sequence

import numpy as np
from threadpoolctl import threadpool_limits

from legspring.batches import GAIT, MEASURES, NOT_REACHED, REASONS, Batch, gait_of
from legspring.candidates import Judge, Trial, box_of
from legspring.gait import Gait
from legspring.kernel.walker import Floats
from legspring.mapping import Found, find_on
from legspring.measures.registry import OF_RECOVERIES, Measure
from legspring.netting import Place
from legspring.plans import COUNTS, DOUBLE, NO_FURTHER, NO_GAIT, UNASKABLE, Plan, layout_of
from legspring.spreading import neighbours_of, reached

SAME = 1e-6
"""Difference of parameters of two gaits, by their size, that are one."""
LOCAL = threading.local()
"""What each thread has for itself."""


def block_of(plan: Plan) -> dict[str, np.ndarray]:
    """Return all that is said of the points of a part of a plan, ``(M, branch, ...)``; it depends on nothing else."""
    with threadpool_limits(1):
        points = plan.points
        blank = blank_of(plan, len(points))
        if not plan.gaits:
            search_on(plan, blank)
            return blank
        shape = tuple(plan.sizes.values()) if plan.grid else None
        starts = list[Floats]()
        for number, batch in enumerate(batches_of(plan)):
            follow = follow_to if isinstance(batch, Batch) else follow_alone
            starts.append(follow(plan, batch, points, shape, number, blank))  # type: ignore[arg-type]
            mark_doubles(blank, starts, number)
        blank["found"][:] = np.sum(blank["outcome"] == GAIT, axis=1)
        blank["rejected"][:] = np.sum(blank["outcome"] > GAIT, axis=1)
        return blank


def blank_of(plan: Plan, count: int) -> dict[str, np.ndarray]:
    """Return room for what is said of so many points."""
    layout = layout_of(plan, {})
    first = len(plan.sizes)
    return {
        name: np.full((count, *variable.shape[first:]), variable.fill, dtype=variable.dtype)
        for name, variable in layout.variables.items()
    }


def batches_of(plan: Plan) -> list[Batch | Judge]:
    """Return the gaits that are followed, as this thread has them; each for itself if its conditions are not plain."""
    key = hashlib.sha256(json.dumps([plan.gaits, plan.names, plan.low, plan.high]).encode()).hexdigest()
    known: dict[str, list[Batch | Judge]] = LOCAL.__dict__.setdefault("batches", {})
    if key not in known:
        known.clear()
        gaits = plan.followed
        box = box_of(gaits, dict(zip(plan.names, zip(plan.low, plan.high, strict=True), strict=True)))
        known[key] = [
            Batch(gait, box) if Batch.is_plain(gait, box) else Judge(box, (gait,), (), np.zeros(0)) for gait in gaits
        ]
    return known[key]


def follow_to(
    plan: Plan,
    batch: Batch,
    points: Floats,
    shape: tuple[int, ...] | None,
    number: int,
    out: dict[str, np.ndarray],
) -> Floats:
    """Follow a gait to the points of a block, and write what is said of it there; return its parameters, ``(M, n)``."""
    places = (points - batch.box.low) / (batch.box.high - batch.box.low)
    found = reached(batch, places, shape)
    out["outcome"][:, number] = NOT_REACHED
    rows, starts = np.flatnonzero(found.there), np.full((len(points), len(batch.problem.base)), np.nan)
    if not len(rows):
        return starts
    seen = batch.measured(places[rows], found.rows(rows))
    outcome = seen.outcomes.copy()
    out["outcome"][rows, number] = outcome
    good = outcome == GAIT
    out["family"][rows[good], number] = plan.families.index(batch.gait.family)
    for one in plan.about:
        if one.name in MEASURES:
            out[one.name][rows[good], number] = seen[one.name][good]
    for one in plan.freed:
        if one.name in batch.problem.unknowns:
            out[one.name][rows[good], number] = seen.p[good, batch.problem.places[one.name]]
    values = seen.multipliers[good]
    out["multipliers"][rows[good], number, : values.shape[1]] = np.stack([values.real, values.imag], axis=-1)
    others = [one for one in plan.about if one.name not in MEASURES]
    for row in np.flatnonzero(good).tolist() if others or plan.impulses else []:
        tell_more(plan, others, gait_of(batch, places[rows[row]], seen.p[row]), int(rows[row]), number, out)
    starts[rows] = seen.p
    return starts


def follow_alone(
    plan: Plan,
    judge: Judge,
    points: Floats,
    shape: tuple[int, ...] | None,
    number: int,
    out: dict[str, np.ndarray],
) -> Floats:
    """Do the same for a gait whose conditions are not the same everywhere: one point after the other."""
    places = (points - judge.box.low) / (judge.box.high - judge.box.low)
    around, known = neighbours_of(places, shape), dict[int, Trial]()
    start = judge.first()[0]
    seed = int(np.argmin(np.max(np.abs(places - start.place), axis=1)))
    ways = [(start, seed)]
    while ways:
        trial, row = ways.pop(0)
        if row in known:
            continue
        gait = judge.followed(trial, places[row], strict=True)
        if gait is None:
            continue
        known[row] = Trial(places[row], 0, gait)
        ways += [(known[row], other) for other in around[row] if other not in known]
    out["outcome"][:, number] = NOT_REACHED
    for row, trial in known.items():
        assert trial.gait is not None
        wrong = trial.gait.invalid()
        out["outcome"][row, number] = GAIT if wrong is None else 1 + REASONS.index(wrong[0])
        if wrong is None:
            tell(plan, trial.gait, row, number, out)
    starts = np.full((len(points), len(judge.starts[0].point)), np.nan)
    for row, trial in known.items():
        assert trial.gait is not None
        starts[row] = trial.gait.point
    return starts


def tell(plan: Plan, gait: Gait, row: int, number: int, out: dict[str, np.ndarray]) -> None:
    """Write what is said of a gait."""
    out["family"][row, number] = plan.families.index(gait.family)
    for one in plan.freed:
        out[one.name][row, number] = gait.freed.get(one.name, math.nan)
    tell_more(plan, plan.about, gait, row, number, out)
    values = gait.multipliers
    out["multipliers"][row, number, : len(values)] = np.stack([values.real, values.imag], axis=-1)


def tell_more(
    plan: Plan, measures: Sequence[Measure], gait: Gait, row: int, number: int, out: dict[str, np.ndarray]
) -> None:
    """Write some measures of a gait, and how it recovers."""
    for one in measures:
        out[one.name][row, number] = one.of(gait)
    if plan.impulses and "energy" not in gait.conserved:
        steps = gait.recovery_steps(plan.impulses)
        for one in OF_RECOVERIES:
            out[one.name][row, number] = one.of(steps)


def mark_doubles(out: dict[str, np.ndarray], starts: Sequence[Floats], number: int) -> None:
    """Say where a gait is the same as one of a smaller number, and take back what is said of it.

    ``starts`` has the parameters of each gait at each point, ``(M, n)``, nan where there is none.
    """
    for other in range(number):
        if starts[other].shape != starts[number].shape:
            continue
        with np.errstate(invalid="ignore"):
            off, size = np.abs(starts[number] - starts[other]), np.abs(starts[number]) + np.abs(starts[other])
        # What is infinite is so in both.
        alike = np.all((off <= SAME * size + SAME) | np.isinf(size), axis=1) & (out["outcome"][:, number] == GAIT)
        rows = np.flatnonzero(alike & (out["outcome"][:, other] == GAIT))
        for name, array in out.items():
            if name not in COUNTS:
                array[rows, number] = DOUBLE if name == "outcome" else -1 if name == "family" else np.nan


def search_on(plan: Plan, out: dict[str, np.ndarray]) -> None:
    """Search for all gaits at the points of a plan, and write what is said of them."""
    row = 0
    for grid in plan.grids:
        found = find_on(grid, method=plan.method, starts=plan.starts, workers=1)
        for place in grid.places:
            if place in found.gaits:
                tell_all(plan, found, place, row, out)
            else:
                out["outcome"][row], out["found"][row], out["rejected"][row] = UNASKABLE, 0, 0
            row += 1


def tell_all(plan: Plan, found: Found, place: Place, row: int, out: dict[str, np.ndarray]) -> None:
    """Write what is said of a place at which gaits were searched for."""
    gaits, rejections = found.gaits[place], found.rejections[place]
    if "alone" in out:
        out["alone"][row] = found.alone.get(place, 0)
    out["outcome"][row], out["found"][row], out["rejected"][row] = NO_FURTHER, len(gaits), len(rejections)
    if not gaits:
        reasons = Counter(rejection.reason for rejection in rejections).most_common(1)
        out["outcome"][row, 0] = 1 + REASONS.index(reasons[0][0]) if reasons else NO_GAIT
    for number, gait in enumerate(gaits[: plan.branches]):
        out["outcome"][row, number] = GAIT
        tell(plan, gait, row, number, out)
        if "sheet" in out:
            out["sheet"][row, number] = found.sheets.get((place, number), -1)
