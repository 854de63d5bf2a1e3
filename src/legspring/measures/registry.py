"""What is said of a gait, each thing once: JSON, maps and `Gait.missing` are made from here.

A test compares docs/reference/gait.md with it.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from legspring.kernel.walker import Floats
    from legspring.model import Animal


class Measurable(Protocol):
    """What a gait tells of itself for its measures to know whether it has them."""

    @property
    def animal(self) -> "Animal":
        """Whose gait it is."""

    @property
    def gets_on(self) -> bool:
        """Whether a step gets anywhere."""

    @property
    def grazing(self) -> float:
        """Smallest rate at which a leg passes through zero force; nan where none does."""

    @property
    def phase_lag(self) -> "Floats":
        """Touch-down of each leg; nan for one that is not put down."""

    @property
    def straight(self) -> bool:
        """Whether the step before was straight ahead at the desired speed."""

    @property
    def apex_height(self) -> float:
        """Largest height in flight; nan where there is none."""

    @property
    def friction(self) -> float:
        """Coefficient of friction needed; nan where none would do."""


def always(_: "Animal") -> bool:
    """Say that maps of any animal have it."""
    return True


def never(_: "Animal") -> bool:
    """Say that no map has it as a variable: it is a coordinate, or not an array of one shape for all gaits."""
    return False


def yaws(animal: "Animal") -> bool:
    """Say that maps have it where the body yaws; elsewhere it says nothing about the gait."""
    return animal.body.yaw == "free"


def from_the_side(animal: "Animal") -> bool:
    """Say that maps of animals seen from the side have it."""
    return animal.sagittal


def from_above(animal: "Animal") -> bool:
    """Say that maps of animals seen from above have it."""
    return not animal.sagittal


def nothing(_: Measurable) -> None:
    """Say that every gait has it."""


@dataclass(frozen=True)
class Measure:
    """Something that is said of a gait.

    Attributes
    ----------
    name
        In JSON and in maps.
    unit
        "1" for a number without one, "" for what is no number.
    words
        What it is.
    dimensions
        Of its value; ``leg`` stands for pairs of legs, ``single_leg`` for each leg.
    function
        The gait's value; by default its attribute of this name.
    missing
        Why a gait has no such number, which then is nan; None if it has.
    mapped
        Whether maps of an animal have it as a variable.
    """

    name: str
    unit: str
    words: str
    dimensions: tuple[str, ...] = ()
    function: Callable[[Any], Any] | None = None
    missing: Callable[[Measurable], str | None] = nothing
    mapped: Callable[["Animal"], bool] = always

    def of(self, gait: Any) -> Any:
        """Return the value of a gait (of its `recovery_steps`, for `OF_RECOVERIES`)."""
        return getattr(gait, self.name) if self.function is None else self.function(gait)

    @property
    def attributes(self) -> dict[str, str]:
        """What a variable of a dataset says about itself."""
        return {"long_name": self.words} | ({"units": self.unit} if self.unit else {})


def _nowhere(gait: Measurable) -> str | None:
    return None if gait.gets_on else "the gait stays where it is: there is no distance to go by"


def _not_rebuilt(gait: Measurable) -> str | None:
    if not gait.animal.tuned:
        return "the animal has no desired speed by which to rebuild the old feet"
    return None if gait.straight else "old feet are not where a step straight ahead would have left them"


def _from_the_side(gait: Measurable) -> str | None:
    return "the animal is seen from the side" if gait.animal.sagittal else None


def _no_flight(gait: Measurable) -> str | None:
    if not gait.animal.sagittal:
        return "the animal is not seen from the side"
    return "no flight begins in a step" if gait.apex_height != gait.apex_height else None


def _lifted_by_the_clock(gait: Measurable) -> str | None:
    return "the clock lifts all legs" if gait.grazing != gait.grazing else None


def _not_put_down(gait: Measurable) -> str | None:
    lags = zip(gait.animal.legs, gait.phase_lag, strict=True)
    names = [leg.name for leg, lag in lags if lag != lag]
    return f"not put down in a stride: {', '.join(names)}" if names else None


def _slips(gait: Measurable) -> str | None:
    if gait.friction == gait.friction:
        return None
    return "a leg pulls at the ground" if gait.animal.sagittal else "nothing presses feet onto a wall"


MEASURES = (
    Measure("family", "", "pairs of legs that push"),
    Measure("branch", "", "branch, by the phase of the hindmost legs", mapped=never),
    Measure("slope_deg", "degrees", "slope", mapped=never),
    Measure("heading", "rad", "initial heading", mapped=never),
    Measure("speed", "m/s", "initial speed of a step"),
    Measure("mean_speed", "m/s", "mean speed of progress"),
    Measure(
        "lateral_drift",
        "m/s",
        "mean speed sideways, of a step or, unmirrored, a stride",
        missing=_from_the_side,
        mapped=from_above,
    ),
    Measure("step_duration", "s", "duration of a step"),
    Measure("phase", "rad", "phase of the actuation", ("leg",)),
    Measure("actuation", "m", "magnitude of the actuation", ("leg",)),
    Measure("freed", "", "what was let go beside phases: the values found", mapped=never),
    Measure("displacement", "m", "displacement over the step before", ("axis",), mapped=never),
    Measure("contacts", "", "legs put down before that are down as a step begins", ("contact",), mapped=never),
    Measure("memory", "", "what is remembered of their feet", ("coordinate",), mapped=never),
    Measure("mirrored", "", "whether the next step is the image of a step", mapped=never),
    Measure("yaw", "rad", "yaw at the start of a step", mapped=yaws),
    Measure("yaw_rate", "rad/s", "yaw rate at the start of a step", mapped=yaws),
    Measure("liftoff", "t_des", "time from touch-down to lift-off", ("leg",)),
    Measure("events", "", "touch-downs and lift-offs of a stride, in their order", ("event",), mapped=never),
    Measure("residual", "1", "largest scaled condition left"),
    Measure("drift", "1", "largest change of the unknowns with the accuracy"),
    Measure(
        "grazing",
        "m/s",
        "smallest rate at which a leg passes through zero force at lift-off",
        missing=_lifted_by_the_clock,
    ),
    Measure(
        "reduced_eigenvalue", "1", "largest eigenvalue magnitude of the reduced map (thesis)", missing=_not_rebuilt
    ),
    Measure("multipliers", "1", "Floquet multipliers of a stride (complete map)", ("multiplier",), mapped=never),
    Measure("conserved", "", "what no step changes", ("multiplier",), mapped=never),
    Measure("missing", "", "measures that the gait does not have, and why", mapped=never),
    Measure("transport_cost", "1", "transport cost (Eqs. 3.5, 3.6)", missing=_nowhere),
    Measure("work", "1", "work of each leg", ("single_leg", "sign"), missing=_nowhere, mapped=never),
    Measure("peak_force", "m g", "peak force of a leg on the body", ("leg", "axis")),
    Measure("friction", "1", "coefficient of friction that feet need", missing=_slips),
    Measure("yaw_amplitude", "rad", "largest yaw to either side", mapped=yaws),
    Measure("peak_moment", "N m", "largest moment of all legs about the centre of mass", mapped=yaws),
    Measure("net_force_max", "m g", "largest sum of the forces of all legs", ("axis",), lambda gait: gait.net_force[0]),
    Measure(
        "net_force_min", "m g", "smallest sum of the forces of all legs", ("axis",), lambda gait: gait.net_force[1]
    ),
    Measure(
        "max_multiplier",
        "1",
        "largest magnitude of a Floquet multiplier of a stride (complete map)",
        function=lambda gait: abs(gait.multipliers[0]),
    ),
    Measure("duty_factor", "1", "share of a stride in which the leg is in stance", ("single_leg",)),
    Measure(
        "phase_lag",
        "1",
        "touch-down after that of the first leg, as a share of a stride",
        ("single_leg",),
        missing=_not_put_down,
    ),
    Measure("stride_frequency", "Hz", "strides in a second"),
    Measure("stride_length", "m", "progress of a stride"),
    Measure("froude_number", "1", "Froude number v^2 / (g L), L the mean force-free leg length"),
    Measure("energy", "J", "total energy at the start of a step"),
    Measure("apex_height", "m", "largest height above the ground in flight", missing=_no_flight, mapped=from_the_side),
    Measure(
        "half_multipliers", "1", "multipliers of the step that mirrors itself, unsquared", ("multiplier",), mapped=never
    ),
)
"""What is said of a gait, in the order of JSON."""

OF_RECOVERIES = (
    Measure(
        "recovery_steps",
        "1",
        "steps to recover from an impulse",
        ("impulse",),
        lambda steps: steps,
    ),
    Measure(
        "recovered",
        "1",
        "whether the gait came back after an impulse (0 or 1)",
        ("impulse",),
        lambda steps: [float(one == one) for one in steps],
    ),
)
"""What a map says of a gait's recoveries from several impulses."""

OF_OPTIMA = (
    Measure("value", "1", "what is minimised, without penalties"),
    Measure("penalised", "1", "what is minimised, with the penalties of Table 3.1"),
    Measure("ending", "", "why the search stopped"),
    Measure("active", "", "constraints that bind", function=lambda optimum: "; ".join(optimum.active)),
)
"""What a map says of an optimised gait in addition."""

BY_NAME = {measure.name: measure for measure in MEASURES}


def mapped(animal: "Animal") -> tuple[Measure, ...]:
    """Return what maps of an animal's gaits have as variables."""
    return tuple(measure for measure in MEASURES if measure.mapped(animal))


def measured(measures: Iterable[Measure], gait: Any) -> dict[str, Any]:
    """Return values by name, of a gait (of its `recovery_steps`, for `OF_RECOVERIES`)."""
    return {measure.name: measure.of(gait) for measure in measures}
