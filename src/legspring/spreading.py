"""How a gait is followed to all places of a block: far ones first, then those between, then around corners."""

from collections.abc import Sequence
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from legspring.batches import Batch, Solved
from legspring.kernel.walker import Floats

NEIGHBOURS = 2
"""Points around one that it is reached from, for each dimension and side."""
MOST_SEEDS = 27
"""Places of a block, beside the nearest, to which a gait is followed straight if they are not reached otherwise."""


def reached(batch: Batch, places: Floats, shape: tuple[int, ...] | None) -> Solved:
    """Follow a gait to all places of a block that can be reached, many at once.

    From a first place to some that are far apart, from these to those in between, and so on; last from neighbour to
    neighbour, around what cannot be reached straight.
    """
    count = len(places)
    known = batch.nowhere(count)
    for seed in seeds_of(places, batch.here):
        if known.there[seed]:
            continue
        first = batch.first(places[seed])
        if not first.there[0]:
            continue
        known.put(np.array([seed]), first)
        for rows in levels_of(places, shape, seed):
            todo = rows[~known.there[rows]]
            if len(todo):
                begun = np.flatnonzero(known.there)
                near = begun[np.asarray(cKDTree(places[begun]).query(places[todo])[1])]
                across = across_from(near, todo, shape, known) if shape is not None else near
                known.put(todo, batch.advanced(known.rows(near), places[near], places[todo], known.rows(across)))
        spread_out(batch, places, neighbours_of(places, shape), known)
    return known


def seeds_of(places: Floats, here: Floats) -> list[int]:
    """Return places to which a gait is followed straight: the nearest one, and those at corners, edges and middle."""
    low, high = places.min(axis=0), places.max(axis=0)
    shares = [spot for spot in product((0.0, 0.5, 1.0), repeat=places.shape[1])][:MOST_SEEDS]
    aims = [here, *(low + np.array(spot) * (high - low) for spot in shares)]
    width = np.where(high > low, high - low, 1.0)
    return list(dict.fromkeys(int(np.argmin(np.max(np.abs(places - aim) / width, axis=1))) for aim in aims))


def levels_of(places: Floats, shape: tuple[int, ...] | None, seed: int) -> list[NDArray[np.intp]]:
    """Return places in groups, each of which lies between those of the groups before; without the seed."""
    count = len(places)
    if shape is None:
        others = np.random.default_rng(0).permutation(np.delete(np.arange(count), seed))
        ends = [4**n for n in range(1, 16) if 4**n < count]
        return np.split(others, ends)
    index = np.array(np.unravel_index(np.arange(count), shape))
    off, found, taken = index - index[:, seed, None], list[NDArray[np.intp]](), np.arange(count) == seed
    for power in range(max(shape).bit_length(), -1, -1):
        rows = np.flatnonzero(np.all(off % 2**power == 0, axis=0) & ~taken)
        taken[rows] = True
        found.append(rows)
    return found


def across_from(
    near: NDArray[np.intp], todo: NDArray[np.intp], shape: tuple[int, ...], known: Solved
) -> NDArray[np.intp]:
    """Return the places of a grid that are as far from some, on the other side, as others are; or these again.

    The latter where there is no such place, or where nothing is known of it.
    """
    far = 2 * np.array(np.unravel_index(todo, shape)) - np.array(np.unravel_index(near, shape))
    inside = np.all((far >= 0) & (far < np.array(shape)[:, None]), axis=0)
    found = np.where(inside, np.ravel_multi_index(tuple(far), shape, mode="clip"), near)
    return np.where(known.there[found], found, near)


def spread_out(batch: Batch, places: Floats, around: Sequence[Sequence[int]], known: Solved) -> None:
    """Go on from all that is known to the places beside, each from one after the other, until no way is untried."""
    ways: dict[int, list[int]] = {}

    def offer(fresh: NDArray[np.intp]) -> None:
        for one in fresh.tolist():
            for other in around[one]:
                if not known.there[other]:
                    ways.setdefault(other, []).append(one)

    offer(np.flatnonzero(known.there))
    while ways:
        there = np.array(sorted(ways))
        here = np.array([ways[one].pop(0) for one in there.tolist()])
        found = batch.advanced(known.rows(here), places[here], places[there])
        known.put(there, found)
        offer(there[found.there])
        ways = {one: rest for one, rest in ways.items() if rest and not known.there[one]}


def neighbours_of(places: Floats, shape: tuple[int, ...] | None) -> list[list[int]]:
    """Return the places next to each place: on a grid those beside it, else the nearest."""
    count = len(places)
    if shape is None:
        near = min(count, 1 + 2 * NEIGHBOURS * places.shape[1])
        index = cKDTree(places).query(places, near)[1].reshape(count, near)
        around: list[list[int]] = [[] for _ in range(count)]
        for one, others in enumerate(index.tolist()):
            for other in others:
                if other != one:
                    around[one].append(other)
                    around[other].append(one)
        return [list(dict.fromkeys(some)) for some in around]
    numbers, found = np.arange(count).reshape(shape), [list[int]() for _ in range(count)]
    for axis in range(len(shape)):
        low, high = (np.moveaxis(numbers, axis, 0)[part].ravel() for part in (slice(None, -1), slice(1, None)))
        for one, other in zip(low.tolist(), high.tolist(), strict=True):
            found[one].append(other)
            found[other].append(one)
    return found
