"""Reduced-order models of legged locomotion: planar bodies on springy legs.

Everything that the outside may rely on is here; names are loaded when they are first used, so that importing the
package costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from legspring.atlases import atlas as atlas
    from legspring.basins import basin as basin
    from legspring.boundaries import boundary as boundary
    from legspring.boundary_charts import load_boundary as load_boundary
    from legspring.charts import load_curve as load_curve
    from legspring.drawing.film import animate as animate
    from legspring.flow import IntegrationError as IntegrationError
    from legspring.following import follow as follow
    from legspring.following import follow_connected as follow_connected
    from legspring.fronts import pareto as pareto
    from legspring.gait import Gait as Gait
    from legspring.model import Animal as Animal
    from legspring.model import ModelError as ModelError
    from legspring.model import cockroach as cockroach
    from legspring.model import load_animal as load_animal
    from legspring.model import presets as presets
    from legspring.optima import optimal_atlas as optimal_atlas
    from legspring.optimisation import optimize as optimize
    from legspring.optimisation import trade_off as trade_off
    from legspring.pushing import pushes as pushes
    from legspring.roughness import rough as rough
    from legspring.simulation import simulate as simulate
    from legspring.solve import find_gaits as find_gaits
    from legspring.solve import search_gaits as search_gaits
    from legspring.stores import open_sweep as open_sweep
    from legspring.sweeping import sweep as sweep
    from legspring.variance import sobol_indices as sobol_indices
    from legspring.varied import parameters as parameters

_HOMES = {
    "Animal": "model",
    "Gait": "gait",
    "IntegrationError": "flow",
    "ModelError": "model",
    "animate": "drawing.film",
    "atlas": "atlases",
    "basin": "basins",
    "boundary": "boundaries",
    "cockroach": "model",
    "find_gaits": "solve",
    "follow": "following",
    "follow_connected": "following",
    "load_animal": "model",
    "load_boundary": "boundary_charts",
    "load_curve": "charts",
    "optimal_atlas": "optima",
    "open_sweep": "stores",
    "parameters": "varied",
    "optimize": "optimisation",
    "pareto": "fronts",
    "presets": "model",
    "pushes": "pushing",
    "rough": "roughness",
    "search_gaits": "solve",
    "simulate": "simulation",
    "sobol_indices": "variance",
    "sweep": "sweeping",
    "trade_off": "optimisation",
}

__all__ = [*_HOMES, "__version__"]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
