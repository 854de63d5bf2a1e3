"""What the figures of the report have in common: a number or name, what they are drawn from, and words."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

from matplotlib.figure import Figure

Source = Literal[
    "gait",
    "simulation",
    "system",
    "atlas",
    "families",
    "optima",
    "selected",
    "nelder_mead",
    "nelder_mead_selected",
    "measured",
    "decays",
    "back_pulls",
    "fronts",
    "single_leg",
    "surfaces",
    "limits",
    "survivals",
    "yawing",
    "yaw_forces",
]
"""What a figure is drawn from:

- ``gait``: a `legspring.Gait` at `GAIT`
- ``simulation``: of `legspring.simulate`, with `SIMULATION`
- ``system``: a `legspring.layout.System` of the animal
- ``atlas``: of `legspring.atlas`; branch 0 is the thesis's
- ``families``: of that, the first gait of each family in each cell, over family in place of branch
- ``optima``: gaits with the best actuation, over objective, slope, heading and family
- ``selected``: those of the best family of each cell
- ``nelder_mead``, ``nelder_mead_selected``: the same by the thesis's own search
- ``measured``: `legspring.peterson2011.published.published_forces`
- ``decays``: of `legspring.peterson2011.decay.decays`
- ``back_pulls``: an atlas of the families in which the back legs pull
- ``fronts``: gaits of each family from the most stable to the cheapest, over slope_deg, family and point
- ``single_leg``: of `legspring.peterson2011.single_leg.map_single_legs`
- ``surfaces``: of `legspring.peterson2011.surfaces.lines`
- ``limits``: of `legspring.peterson2011.limits.limits`
- ``survivals``: of `legspring.peterson2011.survival.survivals`
- ``yawing``: an atlas of the cockroach as a rigid body
- ``yaw_forces``: of `legspring.peterson2011.yawing.force_ranges`
"""

FAMILY_WORDS = "A: all legs push; FB: front and back; MB: middle and back; B: back only"

NOT_UNIQUE = "Where several actuations are equally good, ours is the least, and need not be the thesis's."
BY_THESIS = "By the thesis's own search (Nelder-Mead), run again, whose end depends on its start. "


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
    suffix
        What its file's name ends in.
    """

    number: str
    source: Source
    draw: Callable[..., Figure]
    caption: str
    suffix: str = ""

    @property
    def stem(self) -> str:
        """Name of its file, without the ending."""
        name = f"figure_{self.number.replace('.', '_')}" if self.number[0].isdecimal() else self.number
        return name + self.suffix

    @property
    def by_thesis(self) -> "ThesisFigure | None":
        """The same figure of the gaits at which the thesis's own search ends; None if it shows no optimised ones."""
        sources: dict[Source, Source] = {"optima": "nelder_mead", "selected": "nelder_mead_selected"}
        if self.source not in sources:
            return None
        caption = BY_THESIS + self.caption.replace(f" {NOT_UNIQUE}", "")
        return replace(self, source=sources[self.source], caption=caption, suffix="_nelder_mead")
