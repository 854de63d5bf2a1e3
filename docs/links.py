"""Check every link within the built pages: that its file is there, and the place in it that it names."""

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

FROM_SCRIPTS = {"", "#"}
"""What a script finds or fills in."""


class Page(HTMLParser):
    """The places and the links of a page."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self.places: set[str] = set()
        self.links: list[str] = []
        self.feed(file.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note a place, or a link."""
        for name, value in attrs:
            if name in ("id", "name") and value:
                self.places.add(value)
            elif name in ("href", "src") and value:
                self.links.append(value)


def broken(folder: Path) -> list[str]:
    """Return the links that lead nowhere, each with its page."""
    # What the theme brings along are templates.
    files = [file for file in sorted(folder.rglob("*.html")) if folder / "_static" not in file.parents]
    pages = {file: Page(file) for file in files}
    found = []
    for file, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc or link in FROM_SCRIPTS:
                continue
            target = (file.parent / unquote(parts.path)).resolve() if parts.path else file
            target = target / "index.html" if target.is_dir() else target
            there = target.exists()
            if there and parts.fragment and target in pages:
                there = unquote(parts.fragment) in pages[target].places
            if not there:
                found.append(f"{file.relative_to(folder)}: {link}")
    return found


def main() -> int:
    """Print the broken links; return whether there are any."""
    folder = Path(sys.argv[1]).resolve()
    lost = broken(folder)
    print("\n".join(lost or [f"All links within {len(list(folder.rglob('*.html')))} pages lead somewhere."]))
    return int(bool(lost))


if __name__ == "__main__":
    sys.exit(main())
