"""Gaits and what solves them as JSON, and back: so that what was computed from a gait can go on where it was."""

import json
from dataclasses import replace
from typing import Any

from legspring.gait import Gait
from legspring.layout import System
from legspring.model import Animal
from legspring.problem import GaitProblem
from legspring.solve import Origin

KEPT = (
    *("slope", "heading", "speed", "yaw", "yaw_rate", "turn", "phase", "actuation", "displacement", "remembered"),
    *("family", "branch", "contacts", "symmetric", "strides", "residual", "drift", "isolation"),
)


def gait_as_json(gait: Gait) -> str:
    """Return a gait, its animal, and what it is a solution of."""
    kept: dict[str, Any] = {name: getattr(gait, name) for name in KEPT}
    kept["animal"] = gait.animal.model_dump(mode="json")
    if isinstance(gait.origin, Origin):
        problem, system = gait.origin.problem, gait.origin.problem.system
        kept["problem"] = {
            "animal": system.animal.model_dump(mode="json"),
            "system": {name: getattr(system, name) for name in ("slope", "family", "actuation", "contacts")}
            | {name: getattr(system, name) for name in ("symmetric", "apart", "strides")},
            "free": problem.free,
            "given": dict(problem.given),
        }
    return json.dumps(kept)


def gait_from_json(text: str) -> Gait:
    """Return the gait of which this is the JSON."""
    kept: dict[str, Any] = json.loads(text)
    animal, problem = Animal.model_validate(kept.pop("animal")), kept.pop("problem", None)
    gait = Gait(animal, **{name: _tuple(value) for name, value in kept.items()})
    if problem is None:
        return gait
    about = {name: _tuple(value) for name, value in problem["system"].items()}
    system = System(Animal.model_validate(problem["animal"]), **about)
    return replace(gait, origin=Origin(GaitProblem(system, tuple(problem["free"]), problem["given"])))


def _tuple(value: Any) -> Any:
    """Return lists, which JSON makes of tuples, as such."""
    return tuple(value) if isinstance(value, list) else value
