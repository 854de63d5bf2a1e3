"""The command that opens the explorer."""

from typing import Annotated

import typer

from legspring.cli.options import Heading, Slope, integer
from legspring.cli.program import app, patience


# Hidden until it is whole.
@app.command(hidden=True)
def explore(
    animal: Annotated[
        str, typer.Argument(metavar="[ANIMAL]", help="A preset, or a file in TOML.", show_default=False)
    ] = "cockroach",
    slope: Slope = None,
    heading: Heading = None,
    port: Annotated[int, typer.Option(parser=integer, metavar="NUMBER", help="0: any that is free.")] = 0,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Only say the address.")] = False,
) -> None:
    """See an animal run in the browser, change it, and watch what happens.

    Example: legspring explore cockroach --slope 45 --heading 0.15
    """
    from legspring.model import load_animal

    creature = load_animal(animal)
    if not 0 <= port <= 65535:
        raise ValueError(f"--port = {port}: must be a number from 0 to 65535")
    try:
        with patience("loading"):
            from legspring.explorer.serving import explored
    except ImportError:
        raise ValueError("explore: needs Panel; install it with: pip install 'legspring[explore]'") from None
    explored(creature, {"slope_deg": slope, "heading": heading}, port, not no_browser)
