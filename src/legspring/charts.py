"""Curves of gaits as datasets and files, and back; and what of a curve is kept while it is followed."""

import json
import math
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from legspring.checks import shown
from legspring.continuation import Continuation, Request, described
from legspring.curve import Stop, Trace, Tracer
from legspring.files import PathLike, check_output, save_netcdf
from legspring.footing import Ending, Reason
from legspring.kept import gait_as_json, gait_from_json
from legspring.kernel.walker import Floats
from legspring.layout import PLACES
from legspring.measures.registry import BY_NAME
from legspring.model import Animal
from legspring.stretch import Point, Stretch

SECONDS = 2.0
"""How often what there is of a curve is kept."""
PLAIN = ("speed", "heading", "yaw", "yaw_rate")


def to_dataset(curve: Continuation, measures: Sequence[str] = ()) -> xr.Dataset:
    """Return a curve as a dataset (see `legspring.continuation.Continuation.to_dataset`)."""
    places, system = curve.points, curve.gait.system
    p = np.array([stretch.parameters(point.y) for stretch, point in places])
    firsts = [system.place(leg, "phase") for leg in system.animal.first_legs]
    special = np.array([one.gait.point for one in curve.special]).reshape(len(curve.special), p.shape[1])
    known = PLAIN if system.yaws else PLAIN[:2]
    variables: dict[str, Any] = {
        curve.parameter: ("point", curve.values, {"units": curve.unit, "long_name": curve.words}),
        "valid": ("point", curve.valid, {"long_name": "whether it is a gait"}),
        "reason": ("point", np.array(curve.reasons, dtype=object), {"long_name": "why it is none"}),
        "stable": ("point", curve.stable, {"long_name": "whether all multipliers are below 1"}),
        "max_multiplier": ("point", _largest(curve.multipliers), BY_NAME["max_multiplier"].attributes),
        "special_kind": ("special", words(one.kind for one in curve.special), {"long_name": "what is special"}),
        "special_value": ("special", [one.value for one in curve.special], {"units": curve.unit}),
        "special_after": ("special", [one.after for one in curve.special], {"long_name": "number of the point before"}),
        "special_leg": ("special", words(one.leg for one in curve.special), {"long_name": "whose it is"}),
        "special_words": ("special", words(one.words for one in curve.special), {"long_name": "what it means"}),
    }
    for name in known:
        variables[name] = ("point", p[:, PLACES[name]], BY_NAME[name].attributes)
        variables[f"special_{name}"] = ("special", special[:, PLACES[name]], BY_NAME[name].attributes)
    variables["phase"] = (("point", "leg"), p[:, firsts], BY_NAME["phase"].attributes)
    variables["special_phase"] = (("special", "leg"), special[:, firsts], BY_NAME["phase"].attributes)
    for name in measures:
        if name not in BY_NAME:
            raise ValueError(f"measures = {shown(name)}: must be measures of gaits, such as transport_cost")
        one = BY_NAME[name]
        variables[name] = (("point", *one.dimensions), np.array([one.of(gait) for gait in curve.gaits]), one.attributes)
    for name, values in (("half_multipliers", curve.half_multipliers), ("multipliers", curve.multipliers)):
        parts = np.stack([values.real, values.imag], axis=-1)
        variables[name] = (("point", "multiplier", "part"), parts, BY_NAME["multipliers"].attributes)
    coords = {
        "leg": list(system.animal.pairs),
        "single_leg": [leg.name for leg in system.animal.legs],
        "axis": list(system.axes),
        "part": ["real", "imaginary"],
    }
    raw = raw_points([places])
    return xr.Dataset(variables | raw, coords=coords, attrs=_about(curve))


def _largest(values: Any) -> Any:
    return np.max(np.abs(values), axis=1, initial=0.0)


def words(some: Iterable[object]) -> Any:
    """Return texts as an array."""
    return np.array([str(one) for one in some], dtype=object)


def _about(curve: Continuation) -> dict[str, Any]:
    gait = curve.gait
    return {
        "title": f"Gaits of {gait.animal.name} along {curve.words or curve.parameter}",
        "animal": gait.animal.name,
        "family": gait.family,
        "followed": curve.parameter,
        "source": f"legspring {version('legspring')}",
        "references": gait.animal.source,
        "history": f"{datetime.now(UTC):%Y-%m-%d %H:%M:%S} UTC: computed",
        "request": request_as_json(curve.request),
        "ending": ending_as_json(curve.ending),
        "beginning": ending_as_json(curve.beginning),
        "finished": 1,
    }


def ending_as_json(ending: Ending | None) -> str:
    """Return why a curve ends."""
    return json.dumps(None if ending is None else [ending.reason, ending.value, ending.leg, ending.words])


def ending_from(text: str) -> Ending | None:
    """Return why a curve ends."""
    kept = json.loads(text)
    return None if kept is None else Ending(Reason(kept[0]), *kept[1:])


def request_as_json(request: Request) -> str:
    """Return what is followed: the gait, and along what."""
    subject: Any = request.parameter
    if isinstance(subject, Animal):
        subject = {"animal": subject.model_dump(mode="json")}
    elif not isinstance(subject, str):
        subject = {"values": dict(subject)} if hasattr(subject, "keys") else {"names": list(subject)}
    about: dict[str, Any] = {"parameter": subject, "to": request.to, "within": request.within, "most": request.most}
    about["longest"] = request.longest
    return json.dumps(about | {"gait": json.loads(gait_as_json(request.gait))})


def request_from_json(text: str) -> Request:
    """Return what is followed."""
    kept = json.loads(text)
    subject = kept["parameter"]
    if isinstance(subject, dict):
        ((kind, inside),) = subject.items()
        subject = Animal.model_validate(inside) if kind == "animal" else inside
    within = None if kept["within"] is None else (kept["within"][0], kept["within"][1])
    return Request(gait_from_json(json.dumps(kept["gait"])), subject, kept["to"], within, kept["most"], kept["longest"])


# Points as they are -----------------------------------------------------------------------------------------


def raw_points(ways: Sequence[Sequence[tuple[Stretch, Point]]]) -> dict[str, Any]:
    """Return points as variables: which way, in which region of the route, unknowns and place, and tangent."""
    rows = [(way, stretch, point) for way, some in enumerate(ways) for stretch, point in some]
    known = {"long_name": "unknowns and place, in the problem's units"}
    regions: list[Stretch] = []
    for _, stretch, _ in rows:
        if not regions or regions[-1] is not stretch:
            regions.append(stretch)
    numbers = [next(n for n, one in enumerate(regions) if one is stretch) for _, stretch, _ in rows]
    return {
        "y": (("point", "coordinate"), np.array([point.y for _, _, point in rows]), known),
        "tangent": (("point", "coordinate"), np.array([point.tangent for _, _, point in rows])),
        "way": ("point", np.array([way for way, _, _ in rows])),
        "stretch": ("point", np.array(numbers)),
        "region": (("part_of_route", "end"), np.array([one.region for one in regions])),
    }


def stretches_of(dataset: xr.Dataset, stretch_in: Callable[[tuple[float, float]], Stretch], way: int) -> list[Stretch]:
    """Return the parts of a curve that went one way, each made for its region of the route."""
    found: dict[int, Stretch] = {}
    rows = np.flatnonzero(dataset["way"].values == way)
    for row in rows:
        number = int(dataset["stretch"].values[row])
        low, high = dataset["region"].values[number].tolist()
        stretch = found.setdefault(number, stretch_in((low, high)))
        y, tangent = dataset["y"].values[row], dataset["tangent"].values[row]
        look = stretch.look(y)
        if look is None:
            raise ValueError(f"point {row}: must be one from which a step can be simulated")
        stretch.points.append(Point(y, tangent, look))
    return list(found.values())


def load_curve(path: PathLike) -> Continuation:
    """Return a curve that was saved.

    Raises
    ------
    OSError, ValueError
        If the file cannot be read, or holds no finished curve.
    """
    with xr.open_dataset(path) as dataset:
        return curve_from(dataset.load(), path)


def curve_from(dataset: xr.Dataset, path: PathLike) -> Continuation:
    """Return the curve that a dataset is of."""
    if "request" not in dataset.attrs or not dataset.attrs.get("finished"):
        raise ValueError(f"{path}: must hold a curve of gaits that was followed to its end")
    request = request_from_json(dataset.attrs["request"])
    stretches = stretches_of(dataset, partial(Stretch, request.route), 0)
    ending = ending_from(dataset.attrs["ending"])
    assert ending is not None
    return described(request, Trace(stretches, Stop.EDGE), ending_from(dataset.attrs["beginning"]), ending)


@dataclass
class Shelf:
    """Keeps what there is of a curve in a file, or nowhere.

    Attributes
    ----------
    path
        The file; None: nothing is kept.
    request
        What is followed, as JSON.
    stretch
        Makes a part of such a curve, in a region of the route.
    """

    path: PathLike | None
    request: str
    stretch: Callable[[tuple[float, float]], Stretch]
    _ways: list[Trace] = field(default_factory=list)
    _begun: list[Stretch] = field(default_factory=list)
    _step: float = math.nan
    _last: float = field(default_factory=time.monotonic)
    _tracer: Tracer | None = None

    def begin(self) -> tuple[xr.Dataset | None, list[Trace]]:
        """Return what was finished, if it is; else the ways that were, and remember what there is of the next one.

        Raises
        ------
        ValueError
            If the file holds something else.
        """
        if self.path is None:
            return None, []
        check_output(self.path, (".nc",))
        if not Path(self.path).exists():
            return None, []
        with xr.open_dataset(self.path) as dataset:
            kept = dataset.load()
        if json.loads(kept.attrs.get("request", "null")) != json.loads(self.request):
            raise ValueError(f"store = {shown(str(self.path))}: must be a new file, or one of the same curve")
        if kept.attrs["finished"]:
            return kept, []
        stops = json.loads(kept.attrs["stops"])
        for way, (stop, words) in enumerate(stops):
            self._ways.append(Trace(stretches_of(kept, self.stretch, way), Stop(stop), words))
        self._begun, self._step = stretches_of(kept, self.stretch, len(stops)), float(kept.attrs["step"])
        return None, list(self._ways)

    def resume(self, tracer: Tracer) -> list[Stretch]:
        """Return what there is already of the next way, to go on from."""
        self._tracer, begun, self._begun = tracer, self._begun, []
        if begun:
            tracer.step = self._step
        return begun

    def note(self, stretches: list[Stretch]) -> None:
        """Keep what there is of a way, now and then."""
        if self.path is not None and time.monotonic() - self._last > SECONDS:
            self._keep([*self._ways, Trace(stretches, Stop.ENOUGH)], len(self._ways))

    def finish(self, traces: Sequence[Trace]) -> None:
        """Keep what there is after a way."""
        self._ways = list(traces)
        if self.path is not None and time.monotonic() - self._last > SECONDS:
            self._keep(self._ways, len(traces))

    def _keep(self, traces: list[Trace], finished: int) -> None:
        assert self._tracer is not None and self.path is not None
        ways = [[(one, point) for one in trace.stretches for point in one.points] for trace in traces]
        stops = [[trace.stop, trace.words] for trace in traces[:finished]]
        about = {"request": self.request, "finished": 0, "step": self._tracer.step, "stops": json.dumps(stops)}
        save_netcdf(xr.Dataset(raw_points(ways), attrs=about), self.path)
        self._last = time.monotonic()

    def traced(self, ways: Sequence[float], tracer: Callable[[], Tracer], z: Floats, kept: list[Trace]) -> list[Trace]:
        """Trace all ways, but for what is there already."""
        traces = list(kept)
        for way in ways[len(kept) :]:
            one = tracer()
            traces.append(one.trace(z, way, self.resume(one)))
            self.finish(traces)
        return traces
