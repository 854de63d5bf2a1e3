"""The command `legspring`.

Slow imports stay inside the commands, so that ``legspring --help`` answers at once.
"""

# Commands join the app in the order in which the help names them.
from legspring.cli import curves, explore, gaits, maps, robust
from legspring.cli.options import parse_grid
from legspring.cli.outputs import save
from legspring.cli.program import app

__all__ = ["app", "curves", "explore", "gaits", "maps", "parse_grid", "robust", "save"]
