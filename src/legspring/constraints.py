"""What an optimised gait must keep to, as data, and the one penalty that is made of it."""

import math
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from pkgutil import resolve_name
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from legspring.checks import checked_choice
from legspring.kernel.walker import Floats


class Constraint(StrEnum):
    """What there may be a limit of; the number is that of `Constraints`, which makes words of it."""

    FIXED_POINT = "there is a gait"
    FIXED_POINT_BESIDE = "there is a fixed point at {:g} times the heading, too"
    PHASE_LATEST = "the phase is at most {:g} deg"
    PHASE_EARLIEST = "the phase is at least {:g} deg"
    ANGLE_TOUCHDOWN = "length and force-free length part clearly at touch-down"
    ANGLE_LIFTOFF = "length and force-free length meet clearly at lift-off"
    ACTUATION_LEAST = "the actuation is at least {:g} l0"
    ACTUATION_MOST = "the actuation is at most {:g} l0"


LIMITS = (
    Constraint.ACTUATION_LEAST,
    Constraint.ACTUATION_MOST,
    Constraint.PHASE_LATEST,
    Constraint.PHASE_EARLIEST,
    Constraint.ANGLE_TOUCHDOWN,
    Constraint.ANGLE_LIFTOFF,
)
"""Constraints that concern each pair of legs, in the order in which arrays have them."""
SOFT = [2, 4, 5]
"""Places of those that a search may pass at a price; the others are bounds."""


class Price(NamedTuple):
    """What it costs not to keep to a limit: so much at once, and so much for each unit beyond it."""

    jump: float
    rate: float
    unit: float = 1.0


@dataclass(frozen=True)
class Constraints:
    """What an optimised gait must keep to, and what is added to the objective where it does not.

    See :ref:`model-constraints`.

    Attributes
    ----------
    actuation
        Smallest and largest actuation of a pair, in units of its nominal length, from 0 to below 1.
    phase
        Earliest and latest phase, rad.
    angle
        Smallest angle between the curves of a leg's length and its force-free length against time, at touch-down and at
        lift-off, deg with rates in m/s.
    beside
        How much further there must be a fixed point as well: this share of the heading, and at least so much, rad.
    digits
        Counts how far a search stayed from a fixed point: digits + log10 of its sum of squared residuals, from 0 up.
    prices
        For each `Constraint`; what is counted in its units is, in this order of `LIMITS`, units of nominal length, rad
        and deg. Late phases and small angles are at their price in the search as well and must have no jump; the other
        limits of a pair are never passed. A gait whose objective reaches the jump of having none is not worth having.

    Raises
    ------
    ValueError
        For a range that is none, or a price that is missing or negative.
    """

    actuation: tuple[float, float]
    phase: tuple[float, float]
    angle: float
    beside: tuple[float, float]
    digits: float
    prices: dict[Constraint, Price]

    def __post_init__(self) -> None:
        """Refuse what is no range, and no price."""
        least, most = self.actuation
        if not 0.0 <= least < most < 1.0:
            raise ValueError(f"actuation = {self.actuation}: must be two rising numbers from 0 to below 1")
        if not -math.inf < self.phase[0] < self.phase[1] < math.inf:
            raise ValueError(f"phase = {self.phase}: must be two rising angles in rad")
        if not math.isfinite(self.angle) or not math.isfinite(self.digits):
            raise ValueError(f"angle, digits = {self.angle}, {self.digits}: must be finite numbers")
        if not (min(self.beside) >= 0.0 and self.beside[0] <= 0.05 and self.beside[1] <= 0.05):
            raise ValueError(f"beside = {self.beside}: must be a share and an angle from 0 to 0.05")
        if set(self.prices) != set(Constraint):
            raise ValueError("prices: must be one for each constraint")
        for constraint, (jump, rate, unit) in self.prices.items():
            if not (0.0 <= jump < math.inf and 0.0 <= rate < math.inf and 0.0 < unit < math.inf):
                raise ValueError(f"price of {constraint.name}: must be of numbers from 0 up, with a unit above 0")
            if jump and constraint in LIMITS and LIMITS.index(constraint) in SOFT:
                raise ValueError(f"price of {constraint.name}: must have no jump")

    @property
    def no_gait(self) -> float:
        """What it costs at least that there is no gait: one with a larger objective is not worth having."""
        return self.prices[Constraint.FIXED_POINT].jump

    def words(self, constraint: Constraint) -> str:
        """Say what a constraint is about."""
        early, late = map(math.degrees, self.phase)
        numbers: dict[Constraint, float] = dict(zip(LIMITS, (*self.actuation, late, early), strict=False))
        numbers[Constraint.FIXED_POINT_BESIDE] = 1.0 + self.beside[0]
        return constraint.format(numbers.get(constraint))

    def heading_beside(self, heading: float) -> float:
        """Return the slightly larger heading at which there must be a fixed point, too."""
        share, least = self.beside
        far = abs(heading) * share >= least
        return (1.0 + share) * heading if far else heading + math.copysign(least, heading)

    def missing(self, constraint: Constraint, squares: float) -> float:
        """Price a missing fixed point, by the sum of squared residuals at which the search for it ended."""
        jump, rate, unit = self.prices[constraint]
        return jump + rate * max(self.digits + math.log10(squares), 0.0) / unit if squares > 0.0 else jump

    def excess(self, actuation: ArrayLike, phase: ArrayLike, angles: Floats, *, signed: bool) -> Floats:
        """Return by how much limits are passed, negative where they are not, ``(..., P, 6)`` in the order of `LIMITS`.

        Parameters
        ----------
        actuation, phase
            ``(..., P)``; units of nominal lengths, rad.
        angles
            ``(..., P, 2)``: at touch-down and lift-off, deg; negative where a leg begins or ends with the wrong sign.
        signed
            Whether angles of the wrong sign are further beyond the limit than none, which is smooth, as a search along
            slopes needs it. Otherwise their magnitude counts, as between two curves: the penalty of a gait.
        """
        u, phi = np.asarray(actuation), np.asarray(phase)
        (least, most), (early, late) = self.actuation, self.phase
        excess = np.empty((*np.broadcast(u, phi).shape, len(LIMITS)))
        excess[..., 0], excess[..., 1], excess[..., 2], excess[..., 3] = least - u, u - most, phi - late, early - phi
        excess[..., 4:] = self.angle - (angles if signed else np.abs(angles))
        return excess

    def penalties(self, excess: Floats) -> Floats:
        """Return what limits add to the objective, by how much they are passed; 0 where that is not known."""
        jump, rates = self._numbers
        return np.where(excess > 0.0, jump + rates * excess, 0.0)

    def soft(self, excess: Floats) -> Floats:
        """Return what the soft limits of one candidate cost, ``(3 P,)``, negative where they are kept: phases first."""
        cost = self.rates * excess
        return np.concatenate([cost[:, SOFT[0]], cost[:, SOFT[1:]].ravel()])

    @cached_property
    def _numbers(self) -> tuple[Floats, Floats]:
        """Jumps and rates in the order of `LIMITS`."""
        jump, rate, unit = np.array([self.prices[constraint] for constraint in LIMITS]).T
        return jump, rate / unit

    @property
    def rates(self) -> Floats:
        """What each unit of nominal length, rad and deg beyond a limit costs, in the order of `LIMITS`."""
        return self._numbers[1]


CONSTRAINTS = {"peterson2011": "legspring.peterson2011.constraints:TABLE_3_1"}
"""Constraints that have a name, and where they are."""


def named_constraints(constraints: Constraints | str) -> Constraints:
    """Return constraints, which may be given by their name; raise ValueError if there are none of that name."""
    if isinstance(constraints, Constraints):
        return constraints
    checked_choice("constraints", constraints, CONSTRAINTS)
    found: Constraints = resolve_name(CONSTRAINTS[constraints])
    return found
