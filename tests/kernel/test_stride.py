"""The hybrid flow against reference numbers and against the oracle."""

import csv
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("heyoka")

from legspring.kernel.measure import largest_force, leg_work
from legspring.kernel.run import run, touchdown_states
from legspring.kernel.walker import OK, new_walker
from legspring.setting import ACCURACY, TIGHT
from tests.kernel.bridge import (
    NO_PUSH,
    Walk,
    attempt,
    error_scale,
    jets,
    point_mass,
    rigid_body,
    scale,
    sequence,
    simulate,
)
from tests.oracle import heyoka_walker
from tests.oracle.problem import LEGS, Array, Event, Problem, Run, cockroach_problem, random_problem

REFERENCE = Path(__file__).parent.parent / "reference"
STRIDES = list(csv.DictReader((REFERENCE / "strides.csv").open()))
EVENTS = list(csv.DictReader((REFERENCE / "events.csv").open()))

# Away from grazing: rate of the gap at a lift-off, in longest legs per step duration, and the time between a lift-off
# and anything else that happens, in step durations.
STEEP, APART = 0.05, 1e-3


def is_clear(problem: Problem, run: Run) -> bool:
    """Whether no lift-off is nearly tangential, nor close to another event or to the end of its leg's window."""
    clock = np.array([0.0, 0.02, 1.0, 1.02, 2.0, 2.02, 3.0])
    times = np.sort([*clock, *(event.t / problem.t_des for event in run.liftoffs)])
    steep = run.min_gap_rate * problem.t_des > STEEP * max(problem.length)
    return bool(steep and np.min(np.diff(times)) > APART)


PROBLEMS = [make(seed) for make in (point_mass, rigid_body) for seed in range(160)]
RUNS = [heyoka_walker.simulate(problem, 1.5) for problem in PROBLEMS]
CLEAR = [(problem, run) for problem, run in zip(PROBLEMS, RUNS, strict=True) if is_clear(problem, run)]


def state_error(walk: Walk, run: Run) -> float:
    """Largest error of the states at the ends of steps."""
    states = np.array([walk.state(float(step)) for step in range(len(run.states))])
    return float(np.max(np.abs(states - run.states) / scale(walk.problem, run)))
