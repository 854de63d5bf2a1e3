"""What commands write: files, each whatever becomes of the others."""

import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from legspring.cli.program import patience
from legspring.messages import one_line

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from legspring.model import Animal

EXAMPLE_SLOPE, EXAMPLE_HEADING = 45.0, 0.15
TELLING = ("mean_speed", "max_multiplier", "transport_cost")
"""Of the gaits that are drawn beside presets, deg and rad."""


def save(*outputs: tuple[Path | None, Callable[[Path], object]]) -> None:
    """Write files, those that are wanted; one that fails keeps none of the others from being written."""
    # What has been printed is not to wait for them.
    sys.stdout.flush()
    errors = []
    for path, write in outputs:
        try:
            if path is not None:
                write(path)
        except Exception as error:
            errors.append(error)
    if len(errors) == 1:
        raise errors[0]
    if errors:
        raise ExceptionGroup("several outputs", errors)


def draws(name: str, *subjects: Any) -> Callable[[Path], object]:
    """Return what draws subjects into a file, by one of the functions of `legspring.figures`."""

    def write(path: Path) -> None:
        from legspring import figures

        figures.save_figure(getattr(figures, name)(*subjects), path)

    return write


def films(*subjects: Any, **options: Any) -> Callable[[Path], object]:
    """Return what makes a moving picture of subjects into a file."""

    def write(path: Path) -> None:
        from legspring.figures import animate

        film = animate(*subjects, **options)
        film.save(path, progress=sys.stderr.isatty())
        print(f"{path}: {film.seconds:.3g} s, {film.pace}", file=sys.stderr)

    return write


def draws_preset(animal: "Animal") -> Callable[[Path], object]:
    """Return what draws an animal, with the most stable of its gaits there."""

    def write(path: Path) -> None:
        with patience("drawing"):
            from legspring.asking import open_phases
            from legspring.solve import search_gaits

        low, high = animal.speed_law.domain_deg
        slope_deg = low if low == high else 0.0 if animal.sagittal else EXAMPLE_SLOPE
        # With one phase to choose, the heading is left to the gait.
        heading = EXAMPLE_HEADING if len(open_phases(animal)) > 1 else None
        found = search_gaits(animal, slope_deg=slope_deg, heading=heading).gaits
        stable_first = sorted(found, key=lambda gait: abs(gait.multipliers[0]))
        draws("draw_animal", animal, stable_first[0] if found else None)(path)
        print(path, file=sys.stderr)

    return write


def atlas_figures(maps: "xr.Dataset", directory: Path) -> Iterator[tuple[Path, Callable[[Path], object]]]:
    """Yield the thesis's figures of an atlas, and what draws those that it gives, and says which it does not.

    Of a map over something else: its most telling measures.
    """
    from legspring.figures import draw_atlas, save_figure
    from legspring.peterson2011.figures import chapter4

    def write(draw: "Callable[[xr.Dataset], Figure]", path: Path) -> None:
        try:
            drawn = draw(maps)
        except ValueError as error:
            print(one_line(f"left out {path.name}: {error}"), file=sys.stderr)
        else:
            save_figure(drawn, path)
            print(path)

    over = [str(dim) for dim in maps["family"].dims][:-1]
    if over != ["slope_deg", "heading"]:
        x, y = over[0], over[1] if len(over) > 1 else None
        for name in TELLING:
            yield directory / f"{name}.png", partial(write, partial(draw_atlas, name=name, x=x, y=y))
        return
    for figure in chapter4.FIGURES:
        yield directory / f"{figure.stem}.png", partial(write, figure.draw)


def save_dataset(dataset: "xr.Dataset", path: Path) -> None:
    """Save a dataset in the form that the file's ending says."""
    from legspring.files import SAVERS

    SAVERS[path.suffix.lower()](dataset, path)
