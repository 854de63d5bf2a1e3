"""The largest push that a gait survives, in every direction and at every moment of a stride: `legspring.pushes`."""

import math
import os
import time
from collections.abc import Sequence

import numpy as np
import xarray as xr

from legspring.checks import checked_grid, checked_positive, checked_whole, checked_workers
from legspring.flow import flow
from legspring.gait import Gait
from legspring.kept import gait_as_json
from legspring.kernel.walker import Floats
from legspring.mapping import provenance
from legspring.measures.robustness import LARGEST_IMPULSE, LENGTH, TO_PEAK, check_pushed
from legspring.memory import digest, opened, recalled
from legspring.progress import progress_bar
from legspring.settling import Settling, attractor

DIRECTIONS, MOMENTS, IMPULSES = 24, 16, tuple(0.25 * n for n in range(1, 21))
MOST_DIRECTIONS, MOST_STRIDES = 1000, 200
HALVINGS = 6
"""Halvings of the gap between an impulse that is survived and one that is not."""


def pushes(
    gait: Gait,
    *,
    directions: int | Sequence[float] = DIRECTIONS,
    moments: int | Sequence[float] = MOMENTS,
    impulses: Sequence[float] = IMPULSES,
    duration: float = LENGTH,
    most_strides: int = MOST_STRIDES,
    workers: int | None = None,
    store: str | os.PathLike[str] | None = None,
    progress: bool = False,
) -> xr.Dataset:
    """Find the largest push from which a gait comes back, in every direction and at every moment of a stride.

    A push is a triangle in time, as the thesis has it, whose sideways push is the one in direction 0 at the moment
    1/16. A gait has come back once its motion is where the return map is seen to contract towards it (see `basin`).

    Parameters
    ----------
    gait
        The gait, which must be stable.
    directions
        Angles in which the push acts, rad, 0 to the animal's right (from the side: ahead), pi/2 ahead (up); or how
        many, all around.
    moments
        When a push begins, as parts of the stride from 0 to below 1; or how many.
    impulses
        Sizes that are tried, rising, in units of m v_des; the gap in which the first one is not survived is halved
        six times.
    duration
        Of the push, s.
    most_strides
        Strides after which a gait that has not come back counts as lost.
    workers
        Threads; by default one a core. The result does not depend on it.
    store
        Directory that keeps what was computed, so that one that was stopped goes on where it was.
    progress
        Whether to show a progress bar.

    Returns
    -------
    xarray.Dataset
        Over ``direction`` and ``moment``: ``survived``, the largest impulse up to which all that were tried are
        survived, and ``lost``, the smallest that is not, missing where all are survived; over ``impulse`` as well:
        ``recovery_steps``, missing where the gait does not come back.

    Raises
    ------
    ValueError
        For a gait that is not stable, or keeps what it is given; or values out of range.

    Examples
    --------
    >>> import legspring as ls
    >>> gait = ls.find_gaits(ls.cockroach(), slope_deg=15, heading=0.15)[0]
    >>> found = ls.pushes(gait, directions=4, moments=2, impulses=[0.5])
    >>> found["recovery_steps"].dims
    ('direction', 'moment', 'impulse')
    """
    check_pushed(gait.system)
    angles = _grid("directions", directions, 2.0 * math.pi)
    shares = _grid("moments", moments, 1.0)
    if not all(0.0 <= share < 1.0 for share in shares):
        raise ValueError(f"moments = {shares}: must be parts of a stride, from 0 to below 1")
    sizes = checked_grid("impulses", impulses, LARGEST_IMPULSE)
    if not sizes[0] > 0.0:
        raise ValueError(f"impulses = {sizes[0]:g}, ...: must be above 0")
    lasts = checked_positive("duration", duration)
    most, count = checked_whole("most_strides", most_strides, 1, 1_000_000), checked_workers(workers)
    begin = time.perf_counter()
    trial, memory = Trial(gait, lasts, most, count), opened(store, "pushes", gait_as_json(gait), lasts, most)

    def tried(some: Floats, sizes: Floats) -> Floats:
        return recalled(memory, lambda: trial(some, sizes), digest(some, sizes))

    cells = np.array([(angle, share) for angle in angles for share in shares])
    steps = np.full((len(cells), len(sizes)), np.nan)
    with progress_bar("pushing", len(sizes) + HALVINGS, show=progress) as tick:
        for n, size in enumerate(sizes):
            steps[:, n] = tried(cells, np.full(len(cells), size))
            tick(1)
        survived, lost = bracketed(np.isfinite(steps), np.array(sizes))
        for _ in range(HALVINGS):
            rows = np.flatnonzero(np.isfinite(lost))
            middle = 0.5 * (survived[rows] + lost[rows])
            back = np.isfinite(tried(cells[rows], middle)) if len(rows) else np.zeros(0, dtype=bool)
            survived[rows[back]], lost[rows[~back]] = middle[back], middle[~back]
            tick(1)
    shape, dims = (len(angles), len(shares)), ("direction", "moment")
    units = {"units": "m v_des"}
    return xr.Dataset(
        {
            "survived": (dims, survived.reshape(shape), units | {"long_name": "largest impulse that is survived"}),
            "lost": (dims, lost.reshape(shape), units | {"long_name": "smallest impulse that is not"}),
            "recovery_steps": (
                (*dims, "impulse"),
                steps.reshape(*shape, -1),
                {"units": "1", "long_name": "steps until the gait is back"},
            ),
        },
        {
            "direction": ("direction", list(angles), {"units": "rad", "long_name": "direction of the push"}),
            "moment": ("moment", list(shares), {"units": "1", "long_name": "part of the stride at which it begins"}),
            "impulse": ("impulse", list(sizes), units | {"long_name": "impulse"}),
        },
        provenance(gait.animal)
        | {"title": f"Pushes that {gait!r} survives", "duration": lasts, "seconds": time.perf_counter() - begin},
    )


def _grid(name: str, values: int | Sequence[float], whole: float) -> tuple[float, ...]:
    """Return values, or so many that divide a whole evenly."""
    if isinstance(values, int) and not isinstance(values, bool):
        count = checked_whole(name, values, 1, MOST_DIRECTIONS)
        return tuple((whole * np.arange(count) / count).tolist())
    return checked_grid(name, values, whole)


def bracketed(back: np.ndarray, sizes: Floats) -> tuple[Floats, Floats]:
    """Return the impulses before and at the first that is not survived, of each row; nan where all are."""
    first = np.where(back.all(axis=1), len(sizes), np.argmin(back, axis=1))
    padded = np.concatenate([[0.0], sizes, [np.nan]])
    return padded[first], padded[first + 1]


class Trial:
    """Pushes a gait, and sees whether it comes back.

    Parameters
    ----------
    gait
        The gait.
    duration
        Of pushes, s.
    most, workers
        Most strides; threads.
    """

    def __init__(self, gait: Gait, duration: float, most: int, workers: int) -> None:
        self.system, self.point = gait.system, gait.point
        known = attractor(gait.system, gait.point)
        if not known.within:
            size = float(np.max(np.abs(known.multipliers)))
            raise ValueError(f"gait: must be stable, to come back; its largest multiplier is {size:.4g}")
        self.settling = Settling(gait.system, [known], most, workers)
        t_des, cycle = gait.system.step_duration, gait.system.cycle
        ends = flow(gait.system, gait.point, steps=cycle).step_ends
        # In step durations, where steps end at touch-downs a mere unit of time.
        self.stride = float(ends[-1]) if gait.system.event_driven else float(cycle)
        self.times = np.array([0.0, TO_PEAK / LENGTH, 1.0]) * duration / t_des
        self.peak = 2.0 * gait.system.desired_speed / duration * t_des**2
        self.period = self.stride * gait.system.period / cycle

    def __call__(self, cells: Floats, impulses: Floats) -> Floats:
        """Return how many steps it takes to come back, at each direction and moment; nan where it does not."""
        knots = np.zeros((len(cells), 3, 3))
        knots[:, :, 0] = cells[:, 1, None] * self.stride + self.times
        knots[:, 1, 1], knots[:, 1, 2] = impulses * self.peak * np.array([np.cos(cells[:, 0]), np.sin(cells[:, 0])])
        steps = np.full(len(cells), np.nan)
        # Nothing is back before the push is over: what is pushed late in a stride is judged later.
        first = np.ceil(knots[:, -1, 0] / self.period - 1e-9).astype(int)
        for one in np.unique(first).tolist():
            rows = np.flatnonzero(first == one)
            fates, taken = self.settling(np.repeat(self.point[None], len(rows), axis=0), knots[rows], max(1, one))
            steps[rows] = np.where(fates == 0, taken, np.nan)
        return steps
