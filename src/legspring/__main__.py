"""The command, as in ``python -m legspring``."""

from legspring.cli import app

app()
