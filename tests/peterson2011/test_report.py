"""The report: complete, self-contained, and safe with any text."""

import struct
import zlib
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path

import pytest
import xarray as xr

from legspring import Animal, load_animal, simulate
from legspring.figures import animate
from legspring.peterson2011.claims import CLAIMS, Outcome, Part, Results, Verdict
from legspring.peterson2011.coverage import ENTRIES, coverage_table
from legspring.peterson2011.report import File, Moving, Picture, Section, duration, size, write_report
from legspring.peterson2011.tables import Table

FIGURES = ("2.2", "4.1", "4.2", "5.10", "6.3")
VOID = {"meta", "img", "br", "link", "hr", "input"}


class Page(HTMLParser):
    """Elements, text and links of a page; fails where tags do not match."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str]]] = []
        self.open: list[str] = []
        self.text = ""
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, {name: value or "" for name, value in attrs}))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data

    def all(self, tag: str, name: str) -> list[str]:
        """Return an attribute of all elements of a kind that have it."""
        return [attributes[name] for kind, attributes in self.elements if kind == tag and name in attributes]


def png(path: Path, width: int = 2, height: int = 1) -> Path:
    """Write a white picture."""

    def chunk(kind: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    rows = zlib.compress(height * (b"\0" + width * b"\xff"))
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + header + chunk(b"IDAT", rows) + chunk(b"IEND", b""))
    return path


def verdicts() -> list[Verdict]:
    """Return one verdict for each claim, of all kinds."""
    outcomes = list(Outcome)
    judged = []
    for claim in CLAIMS:
        outcome = outcomes[claim.number % len(outcomes)]
        part = Part(f"quantity {claim.number:03}", "little", "at most 5", f"{claim.number} deg", outcome)
        why = "" if outcome == Outcome.HOLDS else f"reason {claim.number}"
        judged.append(Verdict(claim.number, claim.chapter, claim.text, outcome, part.sentence, why, (part,)))
    return judged


@pytest.fixture
def results(roach: Animal) -> Results:
    """Datasets without a single gait: the report reads no more than where they come from."""
    about = xr.Dataset(attrs={"parameters": roach.model_dump_json(), "source": "legspring <test>", "method": "default"})
    return Results(about, about, about, about, about, about)


@pytest.fixture
def write(tmp_path: Path, results: Results) -> Callable[..., str]:
    """Return a function that writes a report and returns its text."""
    folder = tmp_path / "figures"
    folder.mkdir()
    pictures = {}
    for number in FIGURES:
        path = png(folder / f"figure_{number.replace('.', '_')}.png", 2000 if number == "4.1" else 2)
        path.with_suffix(".pdf").touch()
        pictures[number] = Picture(path, f"Caption of {number}.")
    tables = {"6.1": Table("6.1", "Forces.", ("slope_deg", "model"), (("0", "1.00"),))}

    def written(**changes: object) -> str:
        what: dict[str, object] = {
            "results": results,
            "verdicts": verdicts(),
            "figures": pictures,
            "tables": tables,
            "timings": {4: 12.0, 5: 600.0},
        }
        write_report(tmp_path / "report.html", **what | changes)  # type: ignore[arg-type]
        return (tmp_path / "report.html").read_text(encoding="utf-8")

    return written


def test_everything_is_in_it(write: Callable[..., str]) -> None:
    page = Page(write())
    ids = {attributes["id"] for _, attributes in page.elements if "id" in attributes}
    assert {f"claim-{number}" for number in range(1, len(CLAIMS) + 1)} <= ids
    assert {f"figure-{number}" for number in FIGURES} <= ids
    assert {f"chapter-{number}" for number in range(2, 7)} <= ids
    for verdict in verdicts():
        # Once in the summary and once in the chapter.
        assert page.text.count(verdict.claim) == 2
        assert page.text.count(f"quantity {verdict.number:03}") == 1
        assert verdict.decisive.sentence in page.text
        assert verdict.why in page.text
    assert "Table 6.1" in page.text
    assert "10.0 min" in page.text
    assert "5 hold" in page.text
    assert "share that 'most' asks for" in page.text


def test_notes_tables_and_coverage(write: Callable[..., str]) -> None:
    tables = {number: Table(number, f"About {number}.", ("a",), (("1",),)) for number in ("6.1", "6.differences")}
    names = ("residual", "gaits", "least", "fixed", "printed", "clear", "stability", "efficiency")
    coverage = coverage_table(verdicts(), dict.fromkeys(names, 1))
    page = Page(write(tables=tables, notes={5: ["First note.", "Second note."]}, coverage=coverage))
    assert "First note." in page.text and "Second note." in page.text
    # What is not the thesis's has none of its numbers.
    assert "Table 6.1" in page.text and "Table 6.differences" not in page.text and "About 6.differences." in page.text
    assert "coverage" in {attributes.get("id") for _, attributes in page.elements}
    assert all(all(row) for row in coverage.rows), "no row is empty"
    named = {number for entry in ENTRIES for number in entry.claims}
    assert named == set(range(1, len(CLAIMS) + 1)), "every claim is about some part"


def test_links_lead_somewhere(write: Callable[..., str], tmp_path: Path) -> None:
    data = tmp_path / "data"
    data.mkdir()
    (data / "atlas.nc").touch()
    page = Page(write(data=[File(data / "atlas.nc", "all gaits")]))
    ids = {attributes["id"] for _, attributes in page.elements if "id" in attributes}
    links = page.all("a", "href")
    assert "data/atlas.nc" in links
    assert "figures/figure_4_2.pdf" in links
    for link in links:
        assert link[1:] in ids if link.startswith("#") else (tmp_path / link).is_file()


def test_it_needs_no_network(write: Callable[..., str]) -> None:
    text = write()
    page = Page(text)
    sources = page.all("img", "src")
    assert len(sources) == len(FIGURES)
    assert all(source.startswith("data:image/png;base64,") for source in sources)
    assert "//" not in "".join(page.all("a", "href"))
    assert not {"link", "script", "iframe"} & {tag for tag, _ in page.elements}
    assert "url(" not in text
    assert "@import" not in text


def test_pictures_have_words_and_sizes(write: Callable[..., str]) -> None:
    page = Page(write())
    assert page.all("img", "alt") == [f"Figure {number}: Caption of {number}." for number in FIGURES]
    assert page.all("img", "width") == ["2", "2000", "2", "2", "2"]
    assert page.all("figure", "class") == ["wide"]


def test_text_is_escaped(write: Callable[..., str], tmp_path: Path) -> None:
    nasty = '<script>alert("x & y")</script>'
    picture = Picture(png(tmp_path / "a.png"), nasty)
    table = Table("", nasty, (nasty,), ((nasty,),))
    judged = [
        Verdict(
            1, 4, nasty, Outcome.FAILS, nasty, nasty, (Part(nasty, nasty, nasty, nasty, Outcome.FAILS, nasty),), nasty
        )
    ]
    text = write(verdicts=judged, figures={"4.1": picture}, beyond=[Section(nasty, [nasty], [picture], [table])])
    assert "<script" not in text
    assert Page(text).text.count(nasty) >= 10


def test_beyond_the_thesis(write: Callable[..., str]) -> None:
    assert "Beyond the thesis" not in write()
    page = Page(write(beyond=[Section("A second branch", ["It is there.", "And stable."])]))
    assert "#beyond" in page.all("a", "href")
    assert "A second branch" in page.text
    assert "And stable." in page.text


def test_where_the_results_come_from(write: Callable[..., str]) -> None:
    page = Page(write())
    assert "legspring <test>" in page.text
    assert "numba" in page.text


def test_figures_without_pdf_have_no_link(write: Callable[..., str], tmp_path: Path) -> None:
    page = Page(write(figures={"4.1": Picture(png(tmp_path / "b.png"), "Alone.")}))
    assert not [link for link in page.all("a", "href") if link.endswith(".pdf")]


@pytest.mark.parametrize("number", ["7.1", "x", "", "A.1"])
def test_figures_belong_to_chapters(write: Callable[..., str], tmp_path: Path, number: str) -> None:
    with pytest.raises(ValueError, match="must start with a chapter, one of 2, 3, 4, 5, 6"):
        write(figures={number: Picture(png(tmp_path / "b.png"), "Lost.")})


def test_films_are_shown_with_their_chapter(write: Callable[..., str]) -> None:
    run = simulate(load_animal("lateral_leg_spring"), speed=0.5, heading=0.1, strides=1)
    film = animate(run, width=160)
    text = write(films=[Moving(3, film, "It moves <so>.")])
    chapter = text[text.index('id="chapter-3"') : text.index('id="chapter-4"')]
    assert "In motion" in chapter and "It moves &lt;so&gt;." in chapter
    assert chapter.count("data:image/png;base64,") == len(film) + 1
    assert "In motion" not in text.replace(chapter, "")
    assert "In motion" not in write()


def test_other_files(tmp_path: Path, results: Results) -> None:
    (tmp_path / "a.png").write_text("no picture")
    with pytest.raises(ValueError, match=r"a\.png: must be a PNG file"):
        size(tmp_path / "a.png")
    with pytest.raises(ValueError, match=r"must end in \.html"):
        write_report(tmp_path / "a.txt", results=results, verdicts=[], figures={}, tables={}, timings={})


@pytest.mark.parametrize(
    ("seconds", "words"), [(0.01, "less than 0.1 s"), (5.04, "5.0 s"), (61.0, "61 s"), (600.0, "10.0 min")]
)
def test_durations(seconds: float, words: str) -> None:
    assert duration(seconds) == words
