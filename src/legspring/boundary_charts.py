"""Boundaries as datasets and files, and back."""

from datetime import UTC, datetime
from importlib.metadata import version
from typing import Any

import numpy as np
import xarray as xr

from legspring.charts import ending_as_json, ending_from, raw_points, stretches_of, words
from legspring.files import PathLike
from legspring.kernel.walker import Floats
from legspring.lines import Line
from legspring.planes import Boundary, Corner, Plane, swapped
from legspring.stretch import Look, Point


def boundary_dataset(found: Boundary) -> xr.Dataset:
    """Return a boundary as a dataset (see `legspring.planes.Boundary.to_dataset`)."""
    first, second = found.parameters
    some = found.special
    corners = np.array([one.y for one in some]).reshape(len(some), len(found.points[0][1].y))
    values = np.array([one.values for one in some]).reshape(len(some), 2)
    variables: dict[str, Any] = {
        first: ("point", found.values[:, 0], {"units": found.units[0]}),
        second: ("point", found.values[:, 1], {"units": found.units[1]}),
        "special_kind": ("special", words(one.kind for one in some), {"long_name": "what is special"}),
        f"special_{first}": ("special", values[:, 0], {"units": found.units[0]}),
        f"special_{second}": ("special", values[:, 1], {"units": found.units[1]}),
        "special_leg": ("special", words(one.leg for one in some), {"long_name": "whose it is"}),
        "special_words": ("special", words(one.words for one in some), {"long_name": "what it means"}),
        "special_after": ("special", [one.after for one in some], {"long_name": "number of the point before"}),
        "special_y": (("special", "coordinate"), corners, {"long_name": "unknowns and place"}),
    }
    gait = found.plane.gait
    about = {
        "title": f"{found.kind} of {gait.animal.name} in {first} and {second}",
        "boundary": f"{found.kind} ({found.leg})" if found.leg else found.kind,
        "parameters": [first, second],
        "animal": gait.animal.name,
        "family": gait.family,
        "source": f"legspring {version('legspring')}",
        "references": gait.animal.source,
        "history": f"{datetime.now(UTC):%Y-%m-%d %H:%M:%S} UTC: computed",
        "plane": found.plane.as_json(),
        "kind": found.kind,
        "leg": found.leg,
        "ending": ending_as_json(found.ending),
        "beginning": ending_as_json(found.beginning),
        "finished": 1,
    }
    return xr.Dataset(variables | raw_points([found.points]), attrs=about)


class Known(Line):
    """A part of a boundary that is known: nothing has to be special for it to be looked at."""

    def look(self, y: Floats) -> Look | None:
        """Look at all conditions but the one that was special."""
        return self.without(y)


def load_boundary(path: PathLike) -> Boundary:
    """Return a boundary that was saved.

    Raises
    ------
    OSError, ValueError
        If the file cannot be read, or holds no finished boundary.
    """
    with xr.open_dataset(path) as dataset:
        return boundary_from(dataset.load(), path)


def boundary_from(dataset: xr.Dataset, path: PathLike) -> Boundary:
    """Return the boundary that a dataset is of."""
    about = dataset.attrs
    if "plane" not in about or not about.get("finished"):
        raise ValueError(f"{path}: must hold a boundary that was followed to its end")
    plane = Plane.from_json(about["plane"])

    def line(region: tuple[float, float]) -> Line:
        return Known(plane.route, region, target=plane.target)

    stretches = stretches_of(dataset, line, 0)
    points = [(one, point) for one in stretches for point in one.points]
    values = np.array([[plane.first(one, point.y), plane.route.place(point.y)] for one, point in points])
    ending = ending_from(about["ending"])
    assert ending is not None
    found = Boundary(
        about["kind"],
        about["leg"],
        (plane.p1, plane.p2),
        plane.units,
        values,
        tuple(_corners(dataset, plane, points)),
        ending,
        ending_from(about["beginning"]),
        plane,
        tuple(points),
    )
    return found if list(about["parameters"]) == [plane.p1, plane.p2] else swapped(found)


def _corners(dataset: xr.Dataset, plane: Plane, points: list[tuple[Any, Point]]) -> list[Corner]:
    found = []
    for row in range(dataset.sizes["special"]):
        kind, leg, text, after = (dataset[f"special_{name}"].values[row] for name in ("kind", "leg", "words", "after"))
        y, line = dataset["special_y"].values[row], points[int(after)][0]
        values = plane.first(line, y), plane.route.place(y)
        found.append(Corner(str(kind), values, str(leg), str(text), int(after), y, plane.gait_of(line, y)))
    return found
