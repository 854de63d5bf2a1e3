"""Whether the atlas of the thesis's grid is complete: a search from very many random starts in every cell and family.

python benchmarks/audit.py > audit.json        some ten minutes on two cores

The starts are uniform over all phases and a wide range of speeds, and use nothing that the package's own search
relies on: no bound on the phases, no neighbouring cells. A gait's hit rate is the part of the starts in its cell and
family that lead to it. A gait with a hit rate of 3/n or more turns up in n starts with a probability of 95 % at least.
"""

import argparse
import json
import sys
import time
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from legspring.asking import tuned
from legspring.gait import Gait
from legspring.kernel.newton import CONVERGED
from legspring.kernel.walker import Floats
from legspring.mapping import HEADINGS, SLOPES_DEG, find_all
from legspring.model import cockroach
from legspring.problem import GaitProblem
from legspring.progress import progress_bar
from legspring.solve import ROUGH_GOAL, search_gaits, solve, sort
from legspring.starts import ROUGH_ACCURACY

Place = tuple[int, ...]

STARTS = 4000
SEED = 20110301
SPEEDS = 0.6, 1.8
"""Initial speeds to start from, in units of the desired one."""
CHUNK = 200
SAME_ZERO, SAME_GAIT = 1e-4, 1e-6
"""Differences (speeds in units of v_des, phases in rad) below which two solutions are one: rough, and fine."""


def unknowns(gait: Gait) -> Floats:
    """Return a gait as a solution: speed in units of v_des, phases."""
    return np.array([gait.speed / gait.system.desired_speed, *gait.phase])


def difference(a: Floats, b: Floats) -> float:
    """Largest difference of two solutions, the phases' modulo 2 pi."""
    gap = a - b
    gap[1:] = (gap[1:] + np.pi) % (2.0 * np.pi) - np.pi
    return float(np.max(np.abs(gap)))


@dataclass
class Cell:
    """One family at one point of the grid: what random starts led to, and how often."""

    place: Place
    problem: GaitProblem
    zeros: list[Floats] = field(default_factory=list)
    hits: list[int] = field(default_factory=list)
    gaits: list[Gait | None] = field(default_factory=list)
    rejected: Counter[str] = field(default_factory=Counter)
    starts: int = 0
    steps: int = 0

    def search(self, starts: Floats) -> None:
        """Search from each start by itself."""
        found = solve(self.problem, starts, ROUGH_ACCURACY, ROUGH_GOAL)
        for solution in found.z[found.endings == CONVERGED]:
            self.count(solution)
        self.starts += len(starts)
        self.steps += found.steps

    def count(self, z: Floats) -> None:
        """Note a solution."""
        for number, known in enumerate(self.zeros):
            if difference(z, known) < SAME_ZERO:
                self.hits[number] += 1
                return
        self.zeros.append(z)
        self.hits.append(1)

    def sort(self) -> None:
        """Tell gaits from solutions that are none."""
        for z in self.zeros:
            gaits, rejections = sort(self.problem, z[None])
            self.gaits.append(gaits[0] if gaits else None)
            self.rejected.update(str(rejection.reason) for rejection in rejections)
            if not gaits and not rejections:
                self.rejected["no solution to the last digits"] += 1


def is_among(gait: Gait, others: Sequence[Gait]) -> bool:
    """Whether the same gait, of the same family, is among others of its cell."""
    return any(
        gait.family == other.family and difference(unknowns(gait), unknowns(other)) < SAME_GAIT for other in others
    )


def random_starts(count: int, seed: Sequence[int]) -> Floats:
    """Starts over all phases: ``(count, 4)``."""
    rng = np.random.default_rng(list(seed))
    return np.column_stack([rng.uniform(*SPEEDS, count), rng.uniform(-np.pi, np.pi, (count, 3))])


def search_everywhere(count: int, seed: int, workers: int) -> list[Cell]:
    """Search from so many random starts in every cell and family."""
    animal = cockroach()
    cells = []
    for family, row, column in product(animal.families, range(len(SLOPES_DEG)), range(len(HEADINGS))):
        problem = tuned(animal, float(np.radians(SLOPES_DEG[row])), HEADINGS[column], family)
        cells.append(Cell((row, column), problem))

    def work(number: int) -> None:
        starts = random_starts(count, (seed, number))
        for first in range(0, count, CHUNK):
            cells[number].search(starts[first : first + CHUNK])
            tick(1)
        cells[number].sort()

    chunks = len(cells) * -(-count // CHUNK)
    with progress_bar("random starts", chunks, show=True) as tick, ThreadPoolExecutor(workers) as pool:
        list(pool.map(work, range(len(cells))))
    return cells


def about(place: Place, gait: Gait) -> dict[str, Any]:
    """Describe a gait."""
    return {
        "slope_deg": SLOPES_DEG[place[0]],
        "heading": HEADINGS[place[1]],
        "family": gait.family,
        "speed": round(gait.speed, 8),
        "phase_deg": [round(float(angle), 4) for angle in np.degrees(gait.phase)],
    }


def random_search(known: dict[Place, tuple[Gait, ...]], args: argparse.Namespace) -> dict[str, Any]:
    """Compare what random starts find with what the atlas has."""
    begin = time.perf_counter()
    cells = search_everywhere(args.starts, args.seed, args.workers)
    wall = time.perf_counter() - begin
    found: dict[Place, list[Gait]] = {place: [] for place in known}
    hits: list[tuple[float, dict[str, Any]]] = []
    rejected: Counter[str] = Counter()
    for cell in cells:
        rejected.update(cell.rejected)
        for gait, count in zip(cell.gaits, cell.hits, strict=True):
            if gait is not None:
                found[cell.place].append(gait)
                hits.append((count / cell.starts, about(cell.place, gait)))
    rates = np.array([rate for rate, _ in hits])
    return {
        "starts_per_cell_and_family": args.starts,
        "seed": args.seed,
        "starts": sum(cell.starts for cell in cells),
        "steps": sum(cell.steps for cell in cells),
        "wall_s": round(wall, 1),
        "workers": args.workers,
        "gaits": len(rates),
        "known": sum(map(len, known.values())),
        "not_in_atlas": [
            about(place, gait) for place in known for gait in found[place] if not is_among(gait, known[place])
        ],
        "not_found": [
            about(place, gait) for place in known for gait in known[place] if not is_among(gait, found[place])
        ],
        "solutions_rejected": dict(rejected),
        "hit_rate": {
            "smallest": rates.min(),
            "5 %": np.quantile(rates, 0.05),
            "median": np.median(rates),
            "detectable": 3.0 / args.starts,
        },
        "rarest": [{"hit_rate": rate} | gait for rate, gait in sorted(hits, key=lambda hit: hit[0])[:10]],
    }


def single_cells(known: dict[Place, tuple[Gait, ...]]) -> dict[str, Any]:
    """Compare what a search finds in each cell by itself with what the atlas has."""
    animal = cockroach()
    differing = []
    begin = time.perf_counter()
    with progress_bar("single cells", len(known), show=True) as tick:
        for place, gaits in known.items():
            slope_deg, heading = SLOPES_DEG[place[0]], HEADINGS[place[1]]
            found = search_gaits(animal, slope_deg=slope_deg, heading=heading).gaits
            missed = [about(place, gait) for gait in gaits if not is_among(gait, found)]
            extra = [about(place, gait) for gait in found if not is_among(gait, gaits)]
            if missed or extra:
                differing.append({"missed": missed, "not_in_atlas": extra})
            tick(1)
    return {
        "cells": len(known),
        "as_in_atlas": len(known) - len(differing),
        "differing": differing,
        "wall_s": round(time.perf_counter() - begin, 1),
    }


def main() -> None:
    """Run the audit and print its summary."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--starts", type=int, default=STARTS, help="random starts for each cell and family")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--workers", type=int, default=2)
    args = parser.parse_args()
    known, effort = find_all(cockroach(), SLOPES_DEG, HEADINGS)
    result = {
        "atlas": effort | {"gaits": sum(map(len, known.values()))},
        "single_cells": single_cells(known),
        "random_search": random_search(known, args),
    }
    json.dump(result, sys.stdout, indent=2)
    print()


if __name__ == "__main__":
    main()
