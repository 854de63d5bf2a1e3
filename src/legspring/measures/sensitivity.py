"""How a gait and its measures change with what they depend on."""

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from legspring.checks import shown
from legspring.kernel.walker import Floats
from legspring.layout import BODY, LEG, PLACES, START, System
from legspring.measures.registry import BY_NAME, MEASURES

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

    from legspring.model import Animal

STEP = 2e-3
"""First step of the differences of measures, in units of the parameter's scale."""
LEVELS = 3
TRIES = 4
"""Steps that are tried, each a quarter of the one before, until the gait is found on both sides."""
ENDS = "what the animal keeps, as its energy, it keeps for this value only: there is no such gait beside"
ODD = "steps mirror one another no more: derivatives are differences of gaits, and those of free phases are missing"
DOUBLE = 1e-6
"""Distance of two multipliers below which neither has a derivative."""
TARGET_UNITS = {"mean_speed": "m/s", "energy": "J", "apex_height": "m", "lateral_drift": "m/s"}
EVIDENCE = ("residual", "drift")
"""Numbers that say how well a gait is known, and nothing about it."""
SCALARS = tuple(one for one in MEASURES if one.unit and not one.dimensions and one.name not in EVIDENCE)


class Origin(Protocol):
    """What a gait is a solution of."""

    @property
    def free(self) -> tuple[str, ...]:
        """Parameters that were let go."""

    @property
    def given(self) -> Mapping[str, float | str]:
        """What was asked for."""

    def rates(self, gait: Any, names: Sequence[str]) -> Floats:
        """Return the derivatives of all of a gait's parameters by some of them, ``(D, n)``."""

    def moved(self, gait: Any, name: str, amount: float) -> Any:
        """Return the gait where a parameter has changed by so much; None if it is not found."""

    def lasts(self, gait: Any, name: str, amount: float) -> bool:
        """Whether there is such an animal, and it keeps what this one keeps."""


class Solved(Protocol):
    """What has to be known of a gait for it to be differentiated."""

    @property
    def animal(self) -> "Animal":
        """Whose gait it is."""

    @property
    def family(self) -> str:
        """Which pairs of legs push."""

    @property
    def slope_deg(self) -> float:
        """Slope."""

    @property
    def system(self) -> System:
        """The animal on its slope."""

    @property
    def point(self) -> Floats:
        """All parameters."""

    @property
    def first_legs(self) -> tuple[int, ...]:
        """The leg of each pair that is put down first."""

    @property
    def multipliers(self) -> "NDArray[np.complex128]":
        """Floquet multipliers."""

    @property
    def origin(self) -> Origin | None:
        """What it is a solution of."""


def sensitivity(gait: "Solved", parameters: Sequence[str]) -> "xr.Dataset":
    """Return the derivatives of a gait and its measures (see `Gait.sensitivity`)."""
    import xarray as xr

    if gait.origin is None:
        raise ValueError("gait: must be one that a search has found, which says what was given and what was free")
    names = [checked(gait, name) for name in parameters]
    rates, notes = gait.origin.rates(gait, names), [note_on(gait, name) for name in names]
    rates[[note == ENDS for note in notes]] = math.nan
    exact = unknowns(gait, rates)
    columns = [differences(gait, name) for name in names]
    measures = {one: np.array([column[one] for column in columns]) for one in columns[0]} if columns else {}
    for row, name in enumerate(names):
        if breaks_symmetry(gait, name):
            for one, values in exact.items():
                # What a step of the mirrored problem says holds for both legs of a pair, and not for one.
                values[row] = measures[one][row] if one in measures else math.nan if asked_of(gait)[1] else 0.0
    variables: dict[str, Any] = {}
    for name, values in (measures | exact).items():
        about = BY_NAME[name]
        dims = ("multiplier", "part") if name == "multipliers" else about.dimensions
        words = {"long_name": f"derivative of: {about.words}", "units": f"{about.unit} per unit of the parameter"}
        variables[name] = (("parameter", *dims), values, words)
    system = gait.system
    return xr.Dataset(
        variables,
        coords={
            "parameter": list(names),
            "value": ("parameter", [value_of(gait, name) for name in names], {"long_name": "value of the parameter"}),
            "unit": ("parameter", [unit_of(name) for name in names], {"long_name": "unit of the parameter"}),
            "note": ("parameter", notes, {"long_name": "what holds there"}),
            "leg": list(gait.animal.pairs),
            "axis": list(system.axes),
            "part": ["real", "imaginary"],
        },
        attrs={"animal": gait.animal.name, "family": gait.family, "slope_deg": gait.slope_deg},
    )


def note_on(gait: "Solved", name: str) -> str:
    """Say what is special about derivatives by a parameter, if there is something."""
    assert gait.origin is not None
    side = side_of(gait.system, name)
    step = 1e-6 * scale_of(gait.system, name, value_of(gait, name))
    if not all(gait.origin.lasts(gait, name, sign * step) for sign in ((side,) if side else (1.0, -1.0))):
        return ENDS
    return gait.system.one_sided(name) or (ODD if breaks_symmetry(gait, name) else "")


def breaks_symmetry(gait: "Solved", name: str) -> bool:
    """Whether steps that mirror one another do so no more where a parameter varies: that of one leg of a pair."""
    return gait.system.mirrored and gait.animal.is_one_of_two(name.rpartition(".")[0])


def checked(gait: "Solved", name: str) -> str:
    """Return the name of something that a gait may depend on."""
    if not isinstance(name, str):
        raise ValueError(f"parameter = {shown(name)}: must be a name")
    given, free = asked_of(gait)
    if name in given:
        return name
    system = gait.system
    direction = system.direction(name)
    if name in system.state:
        raise ValueError(f"parameter = {shown(name)}: must be no coordinate of the start, which the gait has found")
    if any(np.any(direction[system.direction(other) != 0.0]) for other in free):
        raise ValueError(f"parameter = {shown(name)}: must be no parameter that was free, as are {', '.join(free)}")
    return name


def asked_of(gait: "Solved") -> tuple[dict[str, float], tuple[str, ...]]:
    """Return what a gait was asked for as a number, and what was free."""
    problem = getattr(gait.origin, "problem", None)
    given = {name: value for name, value in problem.given.items() if not isinstance(value, str)} if problem else {}
    return given, problem.free if problem else ()


def value_of(gait: "Solved", name: str) -> float:
    """Return the value of a parameter, in its unit."""
    given, _ = asked_of(gait)
    if name in given:
        return float(given[name])
    if name == "slope_deg":
        return gait.slope_deg
    return float(gait.point[gait.system.place_of(name)])


def unit_of(name: str) -> str:
    """Return the unit of a parameter."""
    if name == "slope_deg":
        return "deg"
    return TARGET_UNITS.get(name) or (START | BODY | LEG)[name.rpartition(".")[2]][0]


def scale_of(system: System, name: str, value: float) -> float:
    """Return a change of a parameter that makes a difference: its value, or what is large of its kind."""
    quantity = name.rpartition(".")[2]
    longest, mass = max(leg.length for leg in system.animal.legs), system.animal.body.mass
    sizes = {"slope_deg": 30.0, "slope": 0.5, "hip_x": longest, "hip_y": longest, "actuation": longest}
    sizes |= {"damping": mass / system.step_duration, "lateral_drift": system.desired_speed}
    sizes |= dict.fromkeys(("angle", "phase", "heading", "yaw", "offset", "stance"), 1.0)
    return sizes.get(quantity) or abs(value) or 1.0


def unknowns(gait: "Solved", rates: Floats) -> dict[str, Floats]:
    """Return the exact derivatives of what a start consists of, from those of all parameters."""
    places, system = gait.system, gait.system
    found = {name: rates[:, PLACES[name]] for name in ("speed", "heading")}
    if system.yaws:
        found |= {name: rates[:, PLACES[name]] for name in ("yaw", "yaw_rate")}
    found["phase"] = rates[:, [places.place(leg, "phase") for leg in gait.first_legs]]
    return found


def differences(gait: "Solved", name: str) -> dict[str, Any]:
    """Return derivatives of multipliers and measures by a parameter: extrapolated differences of gaits found anew."""
    assert gait.origin is not None
    side = side_of(gait.system, name)
    step = STEP * scale_of(gait.system, name, value_of(gait, name))
    for _ in range(TRIES):
        amounts = [step / 2**level for level in range(LEVELS + (1 if side else 0))]
        signs = (side,) if side else (1.0, -1.0)
        gaits = {sign * h: gait.origin.moved(gait, name, sign * h) for h in amounts for sign in signs}
        known = {amount: described(gait, one) for amount, one in gaits.items() if one is not None}
        if len(known) == len(gaits):
            here = described(gait, gait)
            return {key: extrapolated({a: d[key] for a, d in known.items()}, here[key], side) for key in here}
        step *= 0.25
    return {key: np.full_like(value, math.nan) for key, value in described(gait, gait).items()}


def side_of(system: System, name: str) -> float:
    """Return 1 or -1 where a parameter can only grow, or shrink; 0 where it can do both."""
    if system.one_sided(name) is None:
        return 0.0
    return -1.0 if name.endswith("stance") else 1.0


def extrapolated(values: dict[float, Any], here: Any, side: float) -> Any:
    """Return the derivative at 0 of what has some values around it (Richardson)."""
    sizes = sorted({abs(amount) for amount in values}, reverse=True)
    if side:
        rows = [(values[side * h] - here) / (side * h) for h in sizes]
        powers = [2**order for order in range(1, len(sizes))]
    else:
        rows = [(values[h] - values[-h]) / (2.0 * h) for h in sizes]
        powers = [4**order for order in range(1, len(sizes))]
    for power in powers:
        rows = [fine + (fine - rough) / (power - 1) for rough, fine in pairwise(rows)]
    return rows[0]


def described(reference: "Solved", gait: "Solved") -> dict[str, Any]:
    """Return the measures of a gait, and its multipliers, ``(n, 2)``, in the order of those of another one."""
    from scipy.optimize import linear_sum_assignment

    measures = {one.name: np.asarray(float(one.of(gait))) for one in SCALARS if one.name not in ("slope_deg",)}
    wanted, found = reference.multipliers, gait.multipliers
    ordered = np.full((len(wanted), 2), math.nan)
    if len(found) == len(wanted):
        rows, columns = linear_sum_assignment(np.abs(wanted[:, None] - found[None, :]))
        ordered[rows, 0], ordered[rows, 1] = found[columns].real, found[columns].imag
        apart = np.abs(wanted[:, None] - wanted[None, :]) + np.diag(np.full(len(wanted), math.inf))
        ordered[np.min(apart, axis=1) < DOUBLE] = math.nan
    if math.isnan(ordered[0, 0]):
        measures["max_multiplier"] = np.asarray(math.nan)
    return measures | {"multipliers": ordered}
