"""The program's frame: its app, and how its commands fail."""

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Annotated, Any, NoReturn

import typer
from typer.core import TyperGroup

import legspring
from legspring.messages import one_line

BAD_INPUT, NO_GAIT, INTERRUPTED = 2, 1, 130
"""Exit statuses other than 0."""


class Commands(TyperGroup):
    """Commands of which every error is one line on the error stream."""

    def main(self, args: Sequence[str] | None = None, *rest: Any, **options: Any) -> NoReturn:
        """Run a command and exit; without any arguments, show the help."""
        given = sys.argv[1:] if args is None else args
        options["standalone_mode"] = False
        try:
            status = super().main(args if given else ["--help"], *rest, **options)
        except (typer.TyperException, OSError, ValueError, ArithmeticError, ExceptionGroup) as error:
            fail(words(error))
        if status == INTERRUPTED:
            fail("interrupted", INTERRUPTED)
        sys.exit(status)


def words(error: Exception) -> str:
    """Say what an error is about."""
    match error:
        case ExceptionGroup():
            return "; ".join(words(part) for part in error.exceptions)
        case typer.TyperException():
            return error.format_message()
        case OSError(filename=str(name), strerror=str(reason)):
            return f"{name}: {reason}"
        case OSError(strerror=str(reason)):
            return reason
        case OSError() | ValueError() | ArithmeticError():
            return str(error)
    return f"{type(error).__name__}: {error}"


def fail(message: str, status: int = BAD_INPUT) -> NoReturn:
    """Exit with one line on the error stream."""
    say(message)
    sys.exit(status)


def say(message: str) -> None:
    """Print a line on the error stream."""
    print(one_line(f"legspring: {message}"), file=sys.stderr)


@contextmanager
def patience(words: str) -> Iterator[None]:
    """Tell somebody who looks at a terminal what is going on."""
    if not sys.stderr.isatty():
        yield
        return
    from rich.console import Console

    with Console(stderr=True, markup=False, emoji=False).status(f"{words} ..."):
        yield


app = typer.Typer(
    cls=Commands,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def show_version(wanted: bool) -> None:
    """Print the version and exit."""
    if wanted:
        print(f"legspring {legspring.__version__}")
        raise typer.Exit


@app.callback()
def describe(
    version: Annotated[
        bool, typer.Option("--version", callback=show_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    """Reduced-order models of legged locomotion: gaits of planar bodies on springy legs.

    Slopes are in degrees and headings in radians, as in the field. The first run compiles for about half a minute.
    """
