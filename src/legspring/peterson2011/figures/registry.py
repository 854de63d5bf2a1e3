"""What the figures of the report have in common: a number or name, what they are drawn from, and words."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from matplotlib.figure import Figure

Source = Literal[
    "gait",
    "simulation",
    "system",
    "atlas",
    "optima",
    "selected",
    "measured",
    "decays",
    "back_pulls",
    "fronts",
    "yawing",
    "yaw_forces",
]
"""What a figure is drawn from:

- ``gait``: a `legspring.Gait` at `GAIT`
- ``simulation``: of `legspring.simulate`, with `SIMULATION`
- ``system``: a `legspring.layout.System` of the animal
- ``atlas``: of `legspring.atlas`; branch 0 is the thesis's
- ``optima``: gaits with the best actuation, over objective, slope, heading and family
- ``selected``: those of the best family of each cell
- ``measured``: `legspring.peterson2011.published.published_forces`
- ``decays``: of `legspring.peterson2011.decay.decays`
- ``back_pulls``: an atlas of the families in which the back legs pull
- ``fronts``: gaits of each family from the most stable to the cheapest, over slope_deg, family and point
- ``yawing``: an atlas of the cockroach as a rigid body
- ``yaw_forces``: of `legspring.peterson2011.yawing.force_ranges`
"""

FAMILY_WORDS = "A: all legs push; FB: front and back; MB: middle and back; B: back only"


@dataclass(frozen=True)
class ThesisFigure:
    """One of the thesis's figures, drawn from our own data in its colour ranges, or of those beyond it.

    Attributes
    ----------
    number
        As in the thesis; beyond it a name, such as beyond_decays.
    source
        The data that `draw` takes.
    draw
        Returns the figure.
    caption
        What it shows, and what to notice or to beware of.
    """

    number: str
    source: Source
    draw: Callable[..., Figure]
    caption: str

    @property
    def stem(self) -> str:
        """Name of its file, without the ending."""
        return f"figure_{self.number.replace('.', '_')}" if self.number[0].isdecimal() else self.number
