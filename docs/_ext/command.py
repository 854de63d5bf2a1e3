"""The directive ``command``: runs a command line of legspring when the pages are built, and shows what it prints.

A command that fails makes the build fail. Its files are written to a folder that all commands of a build share, from
which the option ``picture`` shows one. ``status`` is the exit status that is expected.
"""

import hashlib
import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import Directive, directives
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective


def run(line: str, status: int, folder: Path) -> str:
    """Run one command line in a folder; return what it prints."""
    program, *arguments = shlex.split(line)
    if program != "legspring":
        raise ValueError(f"{line}: must be a command line of legspring")
    environment = os.environ | {"COLUMNS": "100", "NO_COLOR": "1", "TERM": "dumb"}
    done = subprocess.run(
        [sys.executable, "-m", "legspring", *arguments],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    if done.returncode != status:
        raise ValueError(f"{line}: ended with status {done.returncode}, not {status}: {done.stdout[-300:]}")
    return done.stdout


class Command(SphinxDirective):
    """A command line and what it prints."""

    has_content = True
    option_spec: ClassVar[dict[str, Any]] = {
        "status": directives.nonnegative_int,
        "picture": directives.unchanged,
        "alt": directives.unchanged,
        "lines": directives.nonnegative_int,
        "silent": directives.flag,
    }

    def run(self) -> list[nodes.Node]:
        """Run the lines, each of which is one command."""
        if self.env.docname in self.config.pages_not_run:
            text = "\n".join(f"$ {line}" for line in self.content)
            return [nodes.literal_block(text, text, language="text", classes=["command"])]
        folder = Path(self.env.app.outdir).parent / "commands"
        folder.mkdir(parents=True, exist_ok=True)
        shown = []
        for line in self.content:
            try:
                printed = self.printed(line, folder)
            except ValueError as error:
                raise self.error(str(error)) from error
            kept = printed.rstrip().splitlines()
            most = self.options.get("lines", len(kept))
            kept = [*kept[:most], "..."] if len(kept) > most else kept
            shown.append("\n".join([f"$ {line}", *([] if "silent" in self.options else kept)]))
        text = "\n".join(shown)
        block = nodes.literal_block(text, text, language="text", classes=["command"])
        return [block, *self.picture(folder)]

    def printed(self, line: str, folder: Path) -> str:
        """Return what a command prints, from an earlier build if nothing has changed since."""
        from legspring.files import code_stamp

        files = sorted((*folder.glob("*.toml"), *folder.glob("*.py")))
        key = [code_stamp(), line, *(file.read_text() for file in files)]
        cache = folder / f".{hashlib.sha256(chr(0).join(key).encode()).hexdigest()[:24]}.txt"
        if not cache.exists():
            cache.write_text(run(line, self.options.get("status", 0), folder))
        return cache.read_text()

    def picture(self, folder: Path) -> list[nodes.Node]:
        """Return the picture that the command has drawn."""
        if "picture" not in self.options:
            return []
        drawn = folder / self.options["picture"]
        if not drawn.is_file():
            raise self.error(f"{drawn.name}: was not drawn")
        target = Path(self.env.srcdir) / "_made" / drawn.name
        target.parent.mkdir(exist_ok=True)
        if not target.exists() or target.read_bytes() != drawn.read_bytes():
            shutil.copy2(drawn, target)
        if "alt" not in self.options:
            raise self.error("alt: must say what the picture shows")
        return [nodes.image(uri=f"/_made/{drawn.name}", alt=self.options["alt"])]


class Given(Directive):
    """The directive ``given``: a file for the commands that follow, shown as it is."""

    required_arguments = 1
    has_content = True

    def run(self) -> list[nodes.Node]:
        """Write the file."""
        folder = Path(self.state.document.settings.env.app.outdir).parent / "commands"
        folder.mkdir(parents=True, exist_ok=True)
        text = "\n".join(self.content)
        name = self.arguments[0]
        file = folder / name
        if not file.exists() or file.read_text() != f"{text}\n":
            file.write_text(f"{text}\n")
        block = nodes.literal_block(text, text, language=file.suffix.removeprefix("."))
        caption = nodes.caption("", name)
        return [nodes.container("", caption, block, literal_block=True, classes=["literal-block-wrapper"])]


def setup(app: Sphinx) -> dict[str, Any]:
    """Add the directives."""
    app.add_config_value("pages_not_run", [], "env")
    app.add_directive("command", Command)
    app.add_directive("given", Given)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
