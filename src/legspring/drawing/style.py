"""What all figures have in common: sizes for print, colours that the colour-blind can tell apart, files."""

import os
import textwrap
from collections.abc import Callable
from functools import wraps
from io import BytesIO
from typing import Any, ParamSpec

import matplotlib as mpl
import numpy as np
from matplotlib.colors import Colormap, ListedColormap
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from legspring.files import check_output, whole_file

P = ParamSpec("P")

COLUMN, PAGE = 3.46, 7.09
"""Widths of a column and of a page in print: 88 and 180 mm, in inches."""
SUFFIXES = (".png", ".pdf", ".svg")
SCREEN = 150
"""Dots per inch in a notebook."""

SMALL = 7
UNITS = {
    "degrees": "deg",
    "m g": r"$m\,g$",
    "m v_des": r"$m\,v_\mathrm{des}$",
    "t_des": r"$t_\mathrm{des}$",
    "l0": r"$l_0$",
}
STYLE: Any = {
    "font.size": 8,
    "axes.titlesize": 8,
    "axes.labelsize": 8,
    "figure.titlesize": 8,
    "figure.labelsize": 8,
    "legend.fontsize": SMALL,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "hatch.linewidth": 0.4,
    "lines.linewidth": 1.0,
    "lines.markersize": 3.5,
    "legend.frameon": False,
    "pdf.fonttype": 42,  # text stays text
    "savefig.dpi": 300,
    "text.usetex": False,  # whether there is LaTeX or not
}

# Okabe and Ito's palette, without the yellow that white paper swallows.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
BEYOND = "#D55E00"
"""Colour of values above a range; it occurs nowhere inside."""
GRAY = "0.45"
MARKERS = "sv^oDPX*<>"
"""Markers of families, in the animal's order: for the cockroach's A, FB, MB and B those of the thesis."""


def sequential() -> Colormap:
    """Return the colours of quantities of one sign."""
    return mpl.colormaps["viridis"].with_extremes(over=BEYOND, under="white")


def diverging(low: float = -1.0, high: float = 1.0) -> Colormap:
    """Return the colours of quantities of both signs; zero is pale, wherever it lies between the ends."""
    shades = 0.5 + 0.5 * np.linspace(low, high, 256) / max(-low, high)
    return ListedColormap(mpl.colormaps["RdBu_r"](shades)).with_extremes(over="#33000d", under="#021a33")


def styled(draw: Callable[P, Figure]) -> Callable[P, Figure]:
    """Give a function that draws a figure the common style, and leave everybody else's alone."""

    @wraps(draw)
    def drawn(*args: P.args, **kwargs: P.kwargs) -> Figure:
        with mpl.rc_context(STYLE):
            figure = draw(*args, **kwargs)
        # Ticks are made when the figure is shown, long after the context's end.
        for axes in figure.axes:
            axes.tick_params(labelsize=SMALL, width=0.6, length=2.5)
            axes.tick_params(which="minor", width=0.4, length=1.5)
        # Laid out here, and not again for each file.
        if (engine := figure.get_layout_engine()) is not None:
            engine.execute(figure)
            figure.set_layout_engine(None)
        return figure

    return drawn


class ShownFigure(Figure):
    """A figure that notebooks show by themselves."""

    def _repr_png_(self) -> bytes:
        """Return the picture that a notebook asks for."""
        return picture(self, "png", dpi=SCREEN)


def picture(figure: Figure, kind: str, **options: Any) -> bytes:
    """Return what is in the file of a figure."""
    stream = BytesIO()
    with mpl.rc_context(STYLE):
        figure.savefig(stream, format=kind, **options)
    return stream.getvalue()


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure of the given size in inches, whose parts keep out of each other's way."""
    return ShownFigure(figsize=(width, height), layout=ConstrainedLayoutEngine(w_pad=0.06))


def save_figure(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Save a figure for print; the whole file appears, or nothing.

    Parameters
    ----------
    figure
        The figure.
    path
        Its ending says the format: .png (300 dots per inch), .pdf or .svg.

    Raises
    ------
    ValueError
        If the ending is another.
    OSError
        If the file cannot be written.
    """
    check_output(path, SUFFIXES)
    suffix = os.path.splitext(path)[1][1:].lower()
    # By way of memory: on a full disk its writers fail in ways that say nothing of it.
    drawn = picture(figure, suffix)
    with whole_file(path) as file:
        file.write_bytes(drawn)


def units(name: str) -> str:
    """Return units as they are set in a figure."""
    return UNITS.get(name, name)


def label(attributes: dict[str, Any], fallback: str = "") -> str:
    """Return an axis's label from a variable's long name and units, in lines short enough for an axis."""
    words, unit = attributes.get("long_name", fallback), units(attributes.get("units", "1"))
    lines = textwrap.wrap(str(words), 36)
    return "\n".join(lines) + (f" ({unit})" if unit not in ("", "1") else "")
