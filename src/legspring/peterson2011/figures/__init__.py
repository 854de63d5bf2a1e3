"""The figures of D. E. Peterson's thesis (2011), drawn from our own data in its colour ranges.

`FIGURES` has them all by number: what each is drawn from, the function that draws it, and a caption.
"""

from collections.abc import Mapping

from legspring.peterson2011.figures import chapter2, chapter3, chapter4, chapter5, chapter6
from legspring.peterson2011.figures.chapter2 import GAIT, SIMULATION
from legspring.peterson2011.figures.registry import Source, ThesisFigure

FIGURES: Mapping[str, ThesisFigure] = {
    figure.number: figure
    for chapter in (chapter2, chapter3, chapter4, chapter5, chapter6)
    for figure in chapter.FIGURES
}

__all__ = ["FIGURES", "GAIT", "SIMULATION", "Source", "ThesisFigure"]
