"""The report: one HTML file with everything in it, readable without a network."""

import os
import platform
import struct
from base64 import b64encode
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from importlib.metadata import version
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup

import legspring
from legspring.figures import Film
from legspring.files import PathLike, check_output, whole_file
from legspring.peterson2011.claims import Outcome, Results, Verdict
from legspring.peterson2011.claims.criteria import MEANINGS, Criteria
from legspring.peterson2011.tables import Cell, Table

PACKAGES = ("numpy", "scipy", "numba", "xarray", "matplotlib")
WIDE = 1500
"""Width in pixels from which on a figure takes the whole width of the page: wider than a column in print."""

CHAPTERS = {
    2: (
        "The model",
        "A body in a plane that is inclined by the slope, on six massless springy legs. Each leg changes its "
        "force-free length by the clock; it is put down by the clock and lifts off when its force is zero "
        "again.",
    ),
    3: (
        "Gaits and their measures",
        "A gait is a fixed point of the map from one step to the next, mirrored. Its stability is measured by "
        "eigenvalues of that map, its robustness by the steps it needs to recover from a sideways push, its "
        "cost by the work of the legs per weight and distance.",
    ),
    4: (
        "Fixed actuation",
        "The length of each leg varies by half of its nominal length. Every gait over slope and heading was "
        "looked for, from many starts and from all neighbours; the figures show the branch that the thesis "
        "shows.",
    ),
    5: (
        "Optimised actuation",
        "The amplitudes of the three pairs of legs are chosen to make the gait of each family as stable, or "
        "as cheap, as can be, within the limits of the thesis's Table 3.1.",
    ),
    6: (
        "Forces, computed and measured",
        "The peak forces of the gaits of chapters 4 and 5 beside those that were measured on animals.",
    ),
}
"""Title and subject of the chapters."""

BADGES = {
    Outcome.HOLDS: "holds",
    Outcome.PARTLY: "partly",
    Outcome.FAILS: "fails",
    Outcome.UNDECIDED: "open",
    Outcome.OPEN: "open",
}
"""Class of each verdict in the style sheet."""


@dataclass(frozen=True)
class Picture:
    """A figure: its PNG file, with a PDF file of the same name beside it, and what it shows."""

    path: Path
    caption: str


@dataclass(frozen=True)
class Section:
    """Something found beyond the thesis: a heading, paragraphs, and what illustrates them."""

    heading: str
    paragraphs: Sequence[str]
    figures: Sequence[Picture] = ()
    tables: Sequence[Table] = ()


@dataclass(frozen=True)
class Moving:
    """A moving picture: its chapter, and what it shows."""

    chapter: int
    film: Film
    caption: str

    @property
    def player(self) -> Markup:
        """The player, as part of a page."""
        return Markup(self.film.player())


@dataclass(frozen=True)
class File:
    """A file to download, and what it holds."""

    path: Path
    text: str


def write_report(
    path: PathLike,
    *,
    results: Results,
    verdicts: Sequence[Verdict],
    figures: Mapping[str, Picture],
    tables: Mapping[str, Table],
    timings: Mapping[int, float],
    cells: Mapping[int, Path] | None = None,
    twins: Mapping[str, Picture] | None = None,
    notes: Mapping[int, Sequence[str]] | None = None,
    coverage: Table | None = None,
    films: Sequence[Moving] = (),
    beyond: Sequence[Section] = (),
    data: Sequence[File] = (),
) -> None:
    """Write the report on the thesis as one HTML file.

    Parameters
    ----------
    path
        The file; it appears whole, or not at all. PDF files and data are linked to relative to it.
    results
        What was computed; the report tells where it comes from.
    verdicts
        On the thesis's claims, of `legspring.peterson2011.claims.judge`.
    figures, tables
        By the thesis's numbers, such as ``"4.2"``.
    timings
        Seconds that the results of each chapter took.
    cells
        Files with the cells that each claim was judged by, by its number.
    twins
        What is shown beside some figures: the same by the thesis's own search.
    notes
        What to know before reading a chapter: paragraphs.
    coverage
        What the thesis has, and where it is.
    films
        Moving pictures, which are shown with their chapters.
    beyond
        What was found beyond the thesis.
    data
        Files to download.

    Raises
    ------
    ValueError
        If the file's ending is not .html, or a figure or table belongs to no chapter.
    OSError
        If a file cannot be read or written.
    """
    check_output(path, (".html",))
    for number in (*figures, *tables):
        if _chapter(number) not in CHAPTERS:
            raise ValueError(f"number = {number!r}: must start with a chapter, one of {', '.join(map(str, CHAPTERS))}")
    page = _environment(Path(path).parent).get_template("report.html.jinja")
    text = page.render(
        chapters=[
            _chapter_parts(number, verdicts, figures, tables, films, timings, notes or {}) for number in CHAPTERS
        ],
        verdicts=verdicts,
        counts=Counter(verdict.verdict for verdict in verdicts),
        badges=BADGES,
        cells=cells or {},
        twins=twins or {},
        criteria=criteria_table(),
        coverage=coverage,
        beyond=beyond,
        data=data,
        provenance=provenance(results),
        versions=versions(),
        total=sum(timings.values()),
    )
    with whole_file(path) as file:
        file.write_text(text, encoding="utf-8")


def _chapter(number: str) -> int:
    """Chapter of a figure or table."""
    first = number.partition(".")[0]
    return int(first) if first.isdecimal() else 0


def _chapter_parts(
    chapter: int,
    verdicts: Sequence[Verdict],
    figures: Mapping[str, Picture],
    tables: Mapping[str, Table],
    films: Sequence[Moving],
    timings: Mapping[int, float],
    notes: Mapping[int, Sequence[str]],
) -> dict[str, Any]:
    """Collect what the report says about a chapter."""
    title, subject = CHAPTERS[chapter]
    return {
        "number": chapter,
        "title": title,
        "subject": subject,
        "notes": notes.get(chapter, ()),
        "verdicts": [verdict for verdict in verdicts if verdict.chapter == chapter],
        "films": [moving for moving in films if moving.chapter == chapter],
        "figures": {number: picture for number, picture in figures.items() if _chapter(number) == chapter},
        "tables": {number: table for number, table in tables.items() if _chapter(number) == chapter},
        "seconds": timings.get(chapter),
    }


def _environment(directory: Path) -> jinja2.Environment:
    """Prepare the template: it escapes all text, and an undefined name in it is an error."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("legspring.peterson2011", "."),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )

    def link(target: Path) -> str:
        return Path(os.path.relpath(target, directory)).as_posix()

    environment.filters |= {"inline": inline, "size": size, "link": link, "duration": duration}
    environment.tests["wide"] = lambda picture: size(picture.path)[0] > WIDE
    environment.tests["file"] = Path.is_file
    # Of the thesis, and not of ours about it.
    environment.tests["printed"] = lambda number: number.replace(".", "").isdecimal()
    return environment


def inline(path: Path) -> Markup:
    """Return a PNG file as a data URL, in which there is nothing to be escaped."""
    return Markup("data:image/png;base64,") + Markup(b64encode(path.read_bytes()).decode("ascii"))


def size(path: Path) -> tuple[int, int]:
    """Return width and height of a PNG file in pixels, which its header tells."""
    head = path.read_bytes()[:24]
    if head[:8] != b"\x89PNG\r\n\x1a\n" or len(head) < 24:
        raise ValueError(f"{path}: must be a PNG file")
    width, height = struct.unpack(">II", head[16:24])
    return width, height


def duration(seconds: float) -> str:
    """Return a time as people say it."""
    if seconds < 0.1:
        return "less than 0.1 s"
    if seconds < 90.0:
        return f"{seconds:.1f} s" if seconds < 10.0 else f"{seconds:.0f} s"
    return f"{seconds / 60.0:.1f} min"


def criteria_table() -> Table:
    """Return what the thesis's words are taken to mean."""
    rows: list[tuple[Cell, ...]] = []
    for each in fields(Criteria):
        values = (float(getattr(criteria, each.name)) for criteria in MEANINGS.values())
        rows.append((str(each.metadata["words"]), *values))
    caption = "What words are taken to mean: the thesis gives no numbers, and these are ours."
    return Table("", caption, ("criterion", *MEANINGS), tuple(rows))


def provenance(results: Results) -> Table:
    """Return where each dataset comes from."""
    datasets = {
        "gaits": results.atlas,
        "optimised": results.optima,
        "optimised by Nelder-Mead": results.nelder_mead,
    }
    names = ("source", "history", "search", "method", "map")
    cells = ((label, *(str(data.attrs.get(name, "")) for name in names)) for label, data in datasets.items())
    return Table("", "Datasets", ("dataset", *names), tuple(cells))


def versions() -> Table:
    """Return the versions of what computed the results."""
    own = (("legspring", legspring.__version__), ("Python", platform.python_version()))
    return Table("", "Versions", ("package", "version"), (*own, *((name, version(name)) for name in PACKAGES)))
