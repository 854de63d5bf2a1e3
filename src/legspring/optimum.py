"""A gait whose actuation is the best there is."""

from collections.abc import Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Literal

import numpy as np

from legspring.actuated import Map, pair_lengths
from legspring.gait import Gait
from legspring.objective import Goal

Method = Literal["default", "nelder-mead"]
TIE = 1e-3
"""Difference of objectives that does not count."""


@dataclass(frozen=True, repr=False)
class Optimum(Gait):
    """A gait whose actuation is the best there is.

    Attributes
    ----------
    objective, map, method
        What was minimised, the map whose eigenvalues count for stability, and how.
    value, penalised
        The objective without and with the penalties for constraints that are not kept.
    ending
        Why the search stopped.
    active
        The constraints that bind.
    evaluations
        How often the objective was evaluated.
    """

    objective: Goal = "stability"
    map: Map = "complete"
    method: Method = "default"
    value: float = np.nan
    penalised: float = np.nan
    ending: str = ""
    active: tuple[str, ...] = ()
    evaluations: int = 0


def best_of(optima: Sequence[Optimum]) -> Optimum | None:
    """Choose among families: the best; among those as good, the cheaper; among those as cheap, the less actuated."""
    rest = list(optima)
    for key in (attrgetter("penalised"), attrgetter("transport_cost")):
        least = min(map(key, rest), default=0.0)
        rest = [optimum for optimum in rest if key(optimum) <= least + TIE]
    return min(rest, key=lambda o: float(np.sum((o.actuation / pair_lengths(o.animal)) ** 2)), default=None)
