"""What a stride costs: here, with its derivatives, and with SciPy and heyoka at the same error."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from statistics import median
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks import numpy_walker
from benchmarks.figures import Figure, together
from benchmarks.subjects import Subject, point_masses, rigid_bodies
from legspring.flow import flow, flows
from legspring.kernel.walker import EVALUATIONS, OK
from legspring.layout import ACCURACY
from tests.oracle import heyoka_walker, scipy_walker
from tests.oracle.problem import Problem

Floats = NDArray[np.float64]
Simulate = Callable[[Problem, float], Any]

TARGETS = {
    ("point mass", False): (25.0, 8.0),
    ("rigid body", False): (45.0, 8.0),
    ("point mass", True): (75.0, 25.0),
    ("rigid body", True): (150.0, 25.0),
}
"""Most time a stride, us, without and with derivatives: must, aim."""
AGAINST_SCIPY = 800.0, 3000.0
SCIPY_TOLERANCES = tuple(float(f"{10.0**-exponent:.3g}") for exponent in np.arange(8.0, 13.1, 0.5))
HEYOKA_TOLERANCES = 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 0.0


@dataclass(frozen=True)
class Rival:
    """Another program that simulates a stride, for a problem and a tolerance."""

    name: str
    simulate: Simulate
    tolerances: tuple[float, ...]
    must: float | None = None
    aim: float | None = None


def scipy_scalar(problem: Problem, rtol: float) -> Floats:
    """Return the end of a stride with SciPy, the right-hand side in plain Python floats."""
    return scipy_walker.simulate(problem, rtol=rtol, atol=1e-2 * rtol).state


def scipy_numpy(problem: Problem, rtol: float) -> Floats:
    """Return it with SciPy, the legs as NumPy arrays."""
    return numpy_walker.simulate(problem, rtol=rtol, atol=1e-2 * rtol)


def heyoka(problem: Problem, tol: float) -> Floats:
    """Return it with heyoka, compiled, driven from Python from event to event."""
    return heyoka_walker.simulate(problem, tol=tol).state


RIVALS = (
    Rival("SciPy, plain Python", scipy_scalar, SCIPY_TOLERANCES, *AGAINST_SCIPY),
    Rival("SciPy, NumPy arrays", scipy_numpy, SCIPY_TOLERANCES, *AGAINST_SCIPY),
    Rival("heyoka", heyoka, HEYOKA_TOLERANCES),
)


def compiled_loop(subject: Subject, derivatives: int, repeats: int) -> Callable[[], None]:
    """Return a call that simulates 16 times so many strides, with so many derivatives, as a sweep does."""
    system, points = subject.system, np.tile(subject.points(), (repeats, 1))
    names = subject.names(derivatives)

    def loop() -> None:
        if np.any(flows(system, points, steps=2, along=names).status != OK):
            raise ArithmeticError(f"{subject.name} could not be simulated")

    return loop


def repeated(work: Callable[[], object], times: int) -> Callable[[], None]:
    """Return a call that does something so many times."""

    def loop() -> None:
        for _ in range(times):
            work()

    return loop


def stride_times(subjects: list[Subject], rounds: int, repeats: int) -> dict[str, list[float]]:
    """Time a stride of each subject in each way, us."""
    times: dict[str, list[float]] = {}
    for subject in subjects:
        works = {
            "loop": (compiled_loop(subject, 0, repeats), 16 * repeats),
            "four": (compiled_loop(subject, 4, repeats), 16 * repeats),
            "derivatives": (compiled_loop(subject, 8, repeats), 16 * repeats),
            "flow": (repeated(partial(flow, subject.system, subject.p, steps=2), 5 * repeats), 5 * repeats),
            "step": (repeated(partial(flow, subject.system, subject.p), 5 * repeats), 5 * repeats),
        }
        taken = together({name: work for name, (work, _) in works.items()}, rounds)
        for name, (_, count) in works.items():
            times.setdefault(name, []).append(1e6 * taken[name] / count)
    return times


def evaluations(subject: Subject) -> float:
    """Right-hand sides evaluated in a stride."""
    return float(flow(subject.system, subject.p, steps=2).walker.clock[EVALUATIONS])


def our_end(subject: Subject) -> Floats:
    """State at the end of the stride, SI."""
    return flow(subject.system, subject.p, steps=2).state[:, 0]


def true_end(subject: Subject) -> Any:
    """State at the end of the stride, by Taylor series in extended precision."""
    return heyoka_walker.simulate(subject.problem(), real=np.longdouble).state


def error(state: Any, truth: Any, problem: Problem) -> float:
    """Largest error of a state: lengths by the longest leg's, speeds by v_des, yaw by 1 rad and 1 rad a step."""
    length = max(problem.length)
    size = np.array([length, length, problem.v_des, problem.v_des, 1.0, 1.0 / problem.t_des])
    n = len(state)
    return float(np.max(np.abs((state - truth[:n]) / size[:n])))


def matched(rival: Rival, problems: list[Problem], truths: list[Any], goal: float) -> tuple[float, float]:
    """Return the loosest tolerance at which a rival's median error is as small as ours, and that error.

    If there is none: the one with the smallest error.
    """
    errors = {}
    for tolerance in rival.tolerances:
        found = [
            error(rival.simulate(problem, tolerance), truth, problem)
            for problem, truth in zip(problems, truths, strict=True)
        ]
        errors[tolerance] = median(found)
        if errors[tolerance] <= goal:
            return tolerance, errors[tolerance]
    return min(errors.items(), key=lambda entry: entry[1])


def stride_figures(kind: str, times: dict[str, list[float]], subjects: list[Subject]) -> list[Figure]:
    """Figures of our own."""
    detail = {
        "strides": len(subjects),
        "worst_us": {name: max(values) for name, values in times.items()},
        "evaluations": median(map(evaluations, subjects)),
        "us_each": {s.name: time for s, time in zip(subjects, times["loop"], strict=True)},
    }
    figures = []
    for way, derivatives, about in (
        ("loop", False, "stride"),
        ("derivatives", True, "stride with eight derivatives"),
    ):
        must, aim = TARGETS[kind, derivatives]
        name = f"{about}, {kind}"
        figures.append(Figure(name, median(times[way]), "us", must, aim, detail={} if derivatives else detail))
        figures.append(Figure(f"{name}, the slowest", max(times[way]), "us"))
    figures.append(Figure(f"stride with four derivatives, {kind}", median(times["four"]), "us"))
    figures.append(Figure(f"stride, {kind}, one call of flow", median(times["flow"]), "us"))
    figures.append(Figure(f"step, {kind}, one call of flow", median(times["step"]), "us", aim=30.0))
    for way, about in (("loop", "no derivatives"), ("four", "four derivatives")):
        name = f"strides a second and core, {kind}, {about}"
        goal = 50_000.0 if way == "loop" else None
        figures.append(Figure(name, 1e6 / median(times[way]), "", aim=goal, more_is_better=True))
    return figures


def rival_figures(kind: str, subjects: list[Subject], rounds: int, repeats: int) -> list[Figure]:
    """Figures of the others, and how many times faster we are: both timed in turn, at the same median error."""
    problems, truths = [s.problem() for s in subjects], [true_end(s) for s in subjects]
    ours = median(
        error(our_end(subject), truth, problem)
        for subject, problem, truth in zip(subjects, problems, truths, strict=True)
    )
    figures = [Figure(f"error of a stride, {kind}", ours, "", detail={"accuracy": ACCURACY})]
    for rival in RIVALS:
        tolerance, theirs = matched(rival, problems, truths, ours)
        ratios, times = [], []
        for subject, problem in zip(subjects, problems, strict=True):
            works: dict[str, Callable[[], object]] = {
                "ours": compiled_loop(subject, 0, repeats),
                "theirs": partial(rival.simulate, problem, tolerance),
            }
            taken = together(works, rounds)
            ratios.append(16 * repeats * taken["theirs"] / taken["ours"])
            times.append(1e6 * taken["theirs"])
        detail = {
            "tolerance": tolerance,
            "median_error": theirs,
            "our_median_error": ours,
            "least": min(ratios),
            "most": max(ratios),
        }
        figures.append(Figure(f"stride, {kind}, {rival.name}", median(times), "us"))
        name = f"times faster than {rival.name}, {kind}"
        figures.append(Figure(name, median(ratios), "", rival.must, rival.aim, more_is_better=True, detail=detail))
    return figures


def measure(quick: bool) -> list[Figure]:
    """Measure everything about strides."""
    figures = []
    for kind, subjects in (("point mass", point_masses()), ("rigid body", rigid_bodies())):
        chosen = subjects[::6] if quick else subjects
        rounds, repeats = (5, 10) if quick else (15, 25)
        figures += stride_figures(kind, stride_times(chosen, rounds, repeats), chosen)
        figures += rival_figures(kind, chosen, 3 if quick else 5, repeats)
    return figures
