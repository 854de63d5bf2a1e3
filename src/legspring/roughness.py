"""Rough ground and bad luck: how long a gait goes on where every step is a little different: `legspring.rough`."""

import math
import os
import time
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.stats import chi2, norm

from legspring.checks import (
    LARGEST_SEED,
    checked_choice,
    checked_grid,
    checked_number,
    checked_whole,
    checked_workers,
    shown,
)
from legspring.gait import Gait
from legspring.kept import gait_as_json
from legspring.kernel.settle import FAILS, FALLS, RUNS_AWAY, STOPS
from legspring.kernel.walker import Floats, Ints, new_tape
from legspring.kernel.wander import (
    GOES_ON,
    N_OF_LEG,
    OF_HEIGHT,
    OF_LEGS,
    OF_SLOPE,
    OF_STIFFNESS,
    TURNS_BACK,
    wander,
)
from legspring.layout import System
from legspring.mapping import provenance
from legspring.memory import opened, recalled
from legspring.parallel import in_threads
from legspring.progress import progress_bar

KINDS = {
    "slope_deg": "deg",
    "height": "m",
    "stiffness": "1",
    "phase": "rad",
    "late": "1",
    "miss": "1",
}
"""What may change from step to step, and the unit of how much."""
FATES = {
    GOES_ON: "goes on",
    FALLS: "falls",
    FAILS: "cannot be simulated",
    STOPS: "stops",
    RUNS_AWAY: "runs away",
    TURNS_BACK: "turns back",
}
DISTRIBUTIONS = ("normal", "uniform")
RUNS, STRIDES, MOST_RUNS, MOST_STEPS = 1000, 100, 1_000_000, 100_000_000
CONFIDENCE = 0.95
LEAST_SHARE = 0.5
"""Share of the runs that has to go on for a roughness to be survived."""
PORTIONS = 16
"""In which runs are done at least, and kept."""
AT_ONCE = 2_000_000
"""Numbers of what changes that are held at once by a thread."""
LARGEST = {"slope_deg": 90.0, "stiffness": 10.0, "phase": 10.0, "late": 0.9, "miss": 1.0, "height": 1e3}


class Roughness(NamedTuple):
    """What changes from step to step, and how.

    Attributes
    ----------
    amounts
        Standard deviations, and for ``"miss"`` the probability, by kind.
    distribution, correlation
        Of each kind; from one step to the next.
    """

    amounts: dict[str, float]
    distribution: str
    correlation: float

    def drawn(self, rng: np.random.Generator, steps: int, legs: int, scale: float) -> Floats:
        """Draw what changes in each step of a run, ``(S, 3 + 3 L)``."""
        count = OF_LEGS + N_OF_LEG * legs
        # All numbers are drawn whatever is asked for, so that one seed means one piece of luck.
        normal, luck = rng.standard_normal((steps, count)), rng.random((steps, legs))
        if self.correlation:
            rest = np.sqrt(1.0 - self.correlation**2)
            for step in range(1, steps):
                normal[step] = self.correlation * normal[step - 1] + rest * normal[step]
        if self.distribution == "uniform":
            normal = np.sqrt(3.0) * (2.0 * norm.cdf(normal) - 1.0)
        amounts, changes = {name: scale * amount for name, amount in self.amounts.items()}, np.zeros((steps, count))
        changes[:, OF_SLOPE] = np.radians(amounts.get("slope_deg", 0.0)) * normal[:, OF_SLOPE]
        changes[:, OF_HEIGHT] = amounts.get("height", 0.0) * normal[:, OF_HEIGHT]
        changes[:, OF_STIFFNESS] = amounts.get("stiffness", 0.0) * normal[:, OF_STIFFNESS]
        own = normal[:, OF_LEGS:].reshape(steps, legs, N_OF_LEG)
        per_leg = changes[:, OF_LEGS:].reshape(steps, legs, N_OF_LEG)
        per_leg[..., 0] = amounts.get("phase", 0.0) * own[..., 0]
        per_leg[..., 1] = np.minimum(amounts.get("late", 0.0) * np.abs(own[..., 1]), LARGEST["late"])
        per_leg[..., 2] = luck < amounts.get("miss", 0.0)
        return changes


def rough(
    gait: Gait,
    roughness: Mapping[str, float],
    *,
    runs: int = RUNS,
    strides: int = STRIDES,
    scales: Sequence[float] = (1.0,),
    distribution: str = "normal",
    correlation: float = 0.0,
    seed: int = 0,
    workers: int | None = None,
    store: str | os.PathLike[str] | None = None,
    progress: bool = False,
) -> xr.Dataset:
    """Let a gait run over rough ground, and with bad luck, many times; see how long it goes on.

    See :ref:`numerics-rough`.

    Parameters
    ----------
    gait
        The gait, which each run starts with.
    roughness
        What changes from step to step, and by how much, as standard deviations: ``"slope_deg"``, the slope that pulls
        (the animal's clock does not know); ``"height"`` of the ground (m, from the side); ``"stiffness"``, the
        logarithm of that of the legs that stand on it; ``"phase"`` of each leg (rad); ``"late"``, how much later each
        leg of the clock comes down (step durations, of a normal distribution's magnitude); and ``"miss"``, the
        probability with which a leg of the clock finds no ground.
    runs, strides
        How many runs, of how many strides.
    scales
        Multiples of the roughness, rising; all have the same luck.
    distribution
        ``"normal"`` or ``"uniform"``, of the same standard deviation.
    correlation
        Of what changes from one step to the next, from 0 to below 1.
    seed
        Of the luck: one seed, one result, whatever the number of workers.
    workers
        Threads; by default one a core.
    store
        Directory that keeps what was computed, so that one that was stopped goes on where it was.
    progress
        Whether to show a progress bar.

    Returns
    -------
    xarray.Dataset
        Over ``scale`` and ``run``: ``steps`` gone, and ``fate``; over ``scale`` and ``step``: ``survival``, the share
        of the runs that goes on after a step, with its confidence interval (Wilson), and mean and standard deviation of
        speed and heading of those; over ``scale``: ``expected_steps`` to failure, all steps by the number of failures,
        with its confidence interval (of a constant hazard; missing, but for its lower end, where nothing failed).
        Attribute ``largest_scale``: the largest scale up to which half of the runs go on at all that were tried.

    Raises
    ------
    ValueError
        For an unknown kind of roughness, one that the animal does not know, or numbers out of range.

    Examples
    --------
    >>> import legspring as ls
    >>> gait = ls.find_gaits(ls.cockroach(), slope_deg=15, heading=0.15)[0]
    >>> found = ls.rough(gait, {"slope_deg": 5.0}, runs=20, strides=10)
    >>> float(found["survival"][0, -1])
    1.0
    """
    system = gait.system
    amounts = checked_roughness(system, roughness)
    checked_choice("distribution", distribution, DISTRIBUTIONS)
    correlated = checked_number("correlation", correlation, "from 0 to below 1", 1.0)
    if not 0.0 <= correlated < 1.0:
        raise ValueError(f"correlation = {correlated:g}: must be from 0 to below 1")
    kind = Roughness(amounts, distribution, correlated)
    sizes = checked_grid("scales", scales, 1e6)
    if sizes[0] < 0.0:
        raise ValueError(f"scales = {sizes[0]:g}, ...: must not be negative")
    count, length = checked_whole("runs", runs, 1, MOST_RUNS), checked_whole("strides", strides, 1, 100_000)
    luck, threads = checked_whole("seed", seed, 0, LARGEST_SEED), checked_workers(workers)
    begin, steps = time.perf_counter(), length * system.cycle
    numbers = OF_LEGS + N_OF_LEG * len(system.animal.legs)
    if count * steps * len(sizes) > MOST_STEPS:
        raise ValueError(f"runs = {count}, strides = {length}: must be of {MOST_STEPS:,} steps in all, at most")
    parts, legs = [], len(system.animal.legs)
    memory = opened(store, "rough", gait_as_json(gait), amounts, distribution, correlated, luck)
    with progress_bar("running", count * len(sizes), show=progress) as tick:
        for size in sizes:

            def work(rows: range, size: float = size) -> tuple[Floats, Ints, Ints]:
                def run() -> tuple[Floats, Ints, Ints]:
                    luck_of = (np.random.default_rng([luck, row]) for row in rows)
                    return run_all(gait, np.array([kind.drawn(rng, steps, legs, size) for rng in luck_of]))

                found = recalled(memory, run, size, rows.start, rows.stop, steps)
                tick(len(rows))
                return found

            width = max(1, min(-(-count // PORTIONS), AT_ONCE // (steps * numbers)))
            chunks = [range(n, min(n + width, count)) for n in range(0, count, width)]
            done = in_threads(work, chunks, threads)
            parts.append(tuple(np.concatenate(some) for some in zip(*done, strict=True)))
    seen, fates, taken = (np.array(some) for some in zip(*parts, strict=True))
    words = [f"{name} {amount:g} {KINDS[name]}".removesuffix(" 1") for name, amount in amounts.items()]
    about = {
        "title": f"Runs of {gait!r} over rough ground",
        "roughness": ", ".join(words),
        "distribution": distribution,
        "correlation": correlated,
        "seed": luck,
        "seconds": time.perf_counter() - begin,
    }
    return as_dataset(system, sizes, seen, fates, taken).assign_attrs(provenance(gait.animal) | about)


def checked_roughness(system: System, roughness: Mapping[str, float]) -> dict[str, float]:
    """Return what changes, checked."""
    if not isinstance(roughness, Mapping) or not roughness:
        raise ValueError(f"roughness = {shown(roughness)}: must name one or more of {', '.join(KINDS)}, with numbers")
    found = {}
    by_clock = any(leg.touchdown == "clock" for leg in system.animal.legs)
    for name, amount in roughness.items():
        checked_choice("roughness", name, tuple(KINDS))
        number = checked_number(f"roughness[{name!r}]", amount, f"from 0 to {LARGEST[name]:g}", LARGEST[name])
        if number < 0.0:
            raise ValueError(f"roughness[{name!r}] = {number:g}: must be from 0 to {LARGEST[name]:g}")
        if name == "height" and not (system.animal.sagittal and system.event_driven):
            raise ValueError("roughness: 'height' must be left out, but for animals that come down to the ground")
        if name in ("late", "miss") and not by_clock:
            raise ValueError(f"roughness: {name!r} must be left out where no leg goes by the clock")
        found[name] = number
    return found


def run_all(gait: Gait, changes: Floats) -> tuple[Floats, Ints, Ints]:
    """Run from a gait with given changes in each step; return what was seen, fates and steps gone."""
    system, p, count = gait.system, gait.point, len(changes)
    walker = system.walker(0, np.zeros((0, 3)))
    seen = np.full((count, changes.shape[1], 2), np.nan)
    fates, steps = np.zeros(count, np.int64), np.zeros(count, np.int64)
    pace = system.desired_speed * system.step_duration
    even = np.zeros((len(system.animal.legs), 2))
    tape, scale = new_tape(0, 0, walker), system.error_scale()
    wander(walker, tape, p[None].copy(), changes, pace, scale, even, seen, fates, steps)
    return seen, fates, steps


def as_dataset(system: System, scales: Sequence[float], seen: Floats, fates: Ints, steps: Ints) -> xr.Dataset:
    """Return what was seen of runs, as a dataset."""
    failed, number = fates != GOES_ON, np.arange(1, seen.shape[2] + 1)
    # A run that fails in a step does not go on after it.
    going = (steps[:, :, None] > number) | ~failed[:, :, None]
    share, (low, high) = going.mean(axis=1), wilson(going.sum(axis=1), going.shape[1])
    mean, spread = spread_of(system, seen, going)
    expected, least, most = hazard(steps.sum(axis=1).astype(float), failed.sum(axis=1))
    over, one = ("scale", "step"), {"units": "1"}
    flags = {"flag_values": list(FATES), "flag_meanings": "; ".join(FATES.values())}
    words = "what became of each run; " + ", ".join(f"{n}: {word}" for n, word in FATES.items())
    return xr.Dataset(
        {
            "steps": (("scale", "run"), steps.astype(np.int32), one | {"long_name": "steps gone"}),
            "fate": (("scale", "run"), fates.astype(np.int16), {"long_name": words} | flags),
            "survival": (over, share, one | {"long_name": "share of the runs that goes on"}),
            "survival_low": (over, low, one | {"long_name": "lower end of its 95 % confidence interval"}),
            "survival_high": (over, high, one | {"long_name": "upper end of its 95 % confidence interval"}),
            "mean_speed": (over, mean[..., 0], {"units": "m/s", "long_name": "mean of the speeds of runs that go on"}),
            "speed_spread": (over, spread[..., 0], {"units": "m/s", "long_name": "standard deviation of these"}),
            "mean_heading": (over, mean[..., 1], {"units": "rad", "long_name": "mean of their headings"}),
            "heading_spread": (over, spread[..., 1], {"units": "rad", "long_name": "standard deviation of these"}),
            "expected_steps": ("scale", expected, one | {"long_name": "steps to failure, expected"}),
            "expected_steps_low": ("scale", least, one | {"long_name": "lower end of its 95 % interval"}),
            "expected_steps_high": ("scale", most, one | {"long_name": "upper end of its 95 % interval"}),
        },
        {
            "scale": ("scale", list(scales), one | {"long_name": "multiple of the roughness"}),
            "step": ("step", number, one | {"long_name": "step"}),
        },
        {"largest_scale": largest_survived(scales, share[:, -1])},
    )


def spread_of(system: System, seen: Floats, going: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Return mean and standard deviation of speed and heading of the runs that go on, ``(C, S, 2)``; nan of none."""
    number = np.arange(1, seen.shape[2] + 1)
    sides = np.where(number % 2, -1.0, 1.0) if system.flips else np.ones(len(number))
    values = np.where(
        going[..., None], seen * np.stack([np.full(len(number), system.desired_speed), sides], axis=-1), 0.0
    )
    count = going.sum(axis=1)[..., None]
    with np.errstate(invalid="ignore"):
        mean = values.sum(axis=1) / count
        off = np.where(going[..., None], values - mean[:, None], 0.0)
        return mean, np.sqrt((off**2).sum(axis=1) / count)


def largest_survived(scales: Sequence[float], shares: Floats) -> float:
    """Return the largest scale up to which half of the runs go on at all that were tried; nan if at none."""
    failing = np.flatnonzero(shares < LEAST_SHARE)
    survived = scales[: failing[0]] if len(failing) else scales
    return float(survived[-1]) if len(survived) else math.nan


def wilson(successes: NDArray[np.int64], count: int) -> tuple[Floats, Floats]:
    """Return the confidence interval of a share, by Wilson's score."""
    z = float(norm.ppf(0.5 + 0.5 * CONFIDENCE))
    share = successes / count
    centre = (share + z**2 / (2 * count)) / (1.0 + z**2 / count)
    half = z / (1.0 + z**2 / count) * np.sqrt(share * (1.0 - share) / count + z**2 / (4.0 * count**2))
    return np.maximum(centre - half, 0.0), np.minimum(centre + half, 1.0)


def hazard(exposure: Floats, failures: NDArray[np.int64]) -> tuple[Floats, Floats, Floats]:
    """Return the expected time to failure and its confidence interval, where the hazard is constant."""
    tail = 0.5 * (1.0 - CONFIDENCE)
    expected = np.where(failures > 0, exposure / np.maximum(failures, 1), np.nan)
    least = 2.0 * exposure / chi2.ppf(1.0 - tail, 2 * failures + 2)
    most = np.where(failures > 0, 2.0 * exposure / chi2.ppf(tail, np.maximum(2 * failures, 1)), np.nan)
    return expected, least, most
