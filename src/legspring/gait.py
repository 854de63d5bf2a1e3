"""A gait: a fixed point of the map of a step, or of a stride, with the evidence that it is one."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from legspring.flow import SEEN, Flow, IntegrationError, flow
from legspring.kernel.walker import Floats
from legspring.layout import TIGHT, System
from legspring.measures.cost import weighed, work_of_legs
from legspring.measures.energy import total_energy
from legspring.measures.footfalls import phase_lag, touchdowns
from legspring.measures.forces import needed_friction, net_force, peak_force, peak_magnitude
from legspring.measures.registry import MEASURES
from legspring.measures.robustness import Recovery, recover, recovery_steps
from legspring.measures.sensitivity import Origin
from legspring.measures.stability import eigenvalues, largest_magnitude
from legspring.model import Animal
from legspring.repetition import departure, largest_departure
from legspring.returnmap import complete_map, reduced_map

if TYPE_CHECKING:
    import xarray as xr

    from legspring.drawing.film import Film
    from legspring.drawing.stage import Shot

IDLE = 1e-3
"""Peak force, in units of m g, below which a leg does nothing."""


GRAZING = 0.01
"""Rate at lift-off, in units of v_des, below which a leg grazes."""


LEAST_ISOLATION = 1e-8
"""Singular value below which what is left of the conditions, about 1e-13, says nothing about an unknown."""
NOWHERE = 1e-6
"""Progress of a step, by the path that its speed would take, below which there is none."""


class Invalid(StrEnum):
    """Why a solution of a gait's conditions is no gait."""

    NOT_SIMULATED = "the stride cannot be simulated"
    NO_LIFTOFF = "a leg does not lift off before its next touch-down"
    WRONG_SIGN = "a leg pulls that should push, or pushes that should pull"
    COLLAPSED = "a leg has no length: its foot passes through its hip"
    IDLE = "a leg bears less than a thousandth of the weight"
    OLD_LEGS = "the legs down at the start are not those that the step before leaves down"
    DEPARTS = "the motion does not repeat itself"
    NOT_ISOLATED = "nothing fixes it: it is one of many, as close together as one likes"
    NO_ANIMAL = "no animal has what is free as it would have to be"
    UNCONFIRMED = "it is no solution when looked at more closely"


@dataclass(frozen=True, repr=False)
class Gait:
    """A periodic way of running: steps are all alike, or each mirrors the one before.

    See :ref:`model-gaits`.

    Attributes
    ----------
    animal
        Whose gait it is.
    slope, heading
        rad; the heading at the start of a step whose first tripod is the one that touches down at time 0.
    family
        Which pairs of legs push, by the animal's label.
    branch
        Number among all gaits of the same animal, slope and heading, by the phase of the hindmost legs, most
        negative first, or by heading, if gaits have their own; -1 where it is not known.
    speed
        At the start of a step, m/s.
    phase, actuation
        Of each pair of legs: rad, m (magnitudes).
    yaw, yaw_rate
        At the start of a step, rad and rad/s; zero where the yaw is held.
    residual
        Largest of the conditions left, scaled by v_des, 1 rad, v_des, v_des t_des.
    displacement
        Displacement of the centre of mass over the step before (x, y), m, of an animal that is not tuned to its desired
        speed; None for that of the desired speed, or where feet are remembered one by one.
    turn
        Change of yaw over the step before, rad, where steps do not mirror one another and feet are not remembered one
        by one; else None.
    contacts, remembered
        Legs that were put down before a step begins and are down then, and what is remembered of them (see `memory`);
        None where the step before says it.
    symmetric
        Whether steps mirror one another, if the animal is such that they may.
    strides
        After how many strides it repeats itself; what is said of its stride is then said of these.
    origin
        What it is a solution of; None for one that nobody has searched for.
    drift
        Largest change of the unknowns (speed in units of v_des, phases in rad) from an integration at an accuracy of
        1e-10 to one at 1e-12.
    isolation
        Smallest singular value of the Jacobian of the conditions: how clearly they tell
        this gait from those next to it.
    """

    animal: Animal = field(repr=False)
    slope: float
    heading: float
    family: str
    speed: float
    phase: tuple[float, ...]
    actuation: tuple[float, ...]
    residual: float
    drift: float = math.nan
    isolation: float = math.nan
    branch: int = -1
    yaw: float = 0.0
    yaw_rate: float = 0.0
    displacement: tuple[float, float] | None = None
    turn: float | None = None
    contacts: tuple[str, ...] | None = None
    remembered: tuple[float, ...] = ()
    symmetric: bool = True
    strides: int = 1
    origin: Origin | None = field(default=None, repr=False, compare=False)

    def __repr__(self) -> str:
        """Say in a line which gait this is."""
        place = f"slope_deg={self.slope_deg:g}, heading={self.heading:.4g}, speed={self.speed:.4g}"
        kind = type(self).__name__
        return f"{kind}({self.animal.name!r}, family={self.family!r}, branch={self.branch}, {place})"

    @cached_property
    def system(self) -> System:
        """The animal on its slope, with this gait's legs."""
        # The legs of a pair may differ in the animal's own actuation.
        own = self.actuation == self.animal.actuation
        actuation = None if own else self.actuation
        return System(
            self.animal, self.slope, self.family, actuation, self.contacts, self.symmetric, strides=self.strides
        )

    @property
    def slope_deg(self) -> float:
        """Slope in degrees."""
        return round(math.degrees(self.slope), 12)

    @cached_property
    def point(self) -> Floats:
        """All parameters, the start of a step among them (see `legspring.layout`)."""
        return self.system.point(
            self.phase,
            speed=self.speed,
            heading=self.heading,
            displacement=self.displacement,
            yaw=self.yaw,
            yaw_rate=self.yaw_rate,
            turn=self.turn if self.turn is not None or self.system.flips else 0.0,
            memory=self.remembered,
        )

    @cached_property
    def stride(self) -> Flow:
        """One stride as it was simulated, or the strides after which it repeats itself."""
        return flow(self.system, self.point, steps=self.system.cycle, record=True, accuracy=TIGHT)

    @property
    def memory(self) -> dict[str, float]:
        """What is remembered of feet that are down as a step begins, by name; empty where the step before says it.

        Of legs that go by the clock, displacement and turn of the body since they were put down, m and rad; of others,
        place of the foot seen from the centre of mass, m, and time since touch-down, in the animal's step durations.

        See :ref:`model-memory`.
        """
        names = (name for name in self.system.memory if "." in name)
        return dict(zip(names, self.remembered, strict=True))

    @property
    def freed(self) -> dict[str, float]:
        """What was let go by ``free`` and is not among the phases, by name: the values found, SI units."""
        free = () if self.origin is None else self.origin.free
        return {name: float(self.point[self.system.place_of(name)]) for name in free if not name.endswith(".phase")}

    @property
    def first_legs(self) -> tuple[int, ...]:
        """For each pair, its leg that touches down first."""
        return self.animal.first_legs

    @cached_property
    def liftoff(self) -> Floats:
        """Time from touch-down to lift-off of each pair of legs, in step durations; nan if there is none."""
        return self._stances[list(self.first_legs), 0] / self.step_duration

    @cached_property
    def _stances(self) -> Floats:
        """Time (s) from touch-down to lift-off of each leg, and the rate of its gap then, ``(L, 2)``; nan if none.

        What lifts off before it is put down was put down in the stride before.
        """
        events, end = self.stride.events, float(self.stride.times[-1])
        lags, found = touchdowns(self.stride), np.full((len(self.animal.legs), 2), math.nan)
        for time, leg, lifts, rate in zip(events.time, events.leg, events.lifts, events.rate, strict=True):
            if lifts and 0.0 < time <= end:
                lasts = (time - lags[leg]) % end or end
                if not found[leg, 0] <= lasts:
                    found[leg] = lasts, rate
        return found

    @property
    def events(self) -> tuple[str, ...]:
        """Sequence of touch-downs and lift-offs in a stride, as in ``("BR lift-off", "MR lift-off", ...)``."""
        names, events = [leg.name for leg in self.animal.legs], self.stride.events
        what = zip(events.leg.tolist(), events.lifts.tolist(), strict=True)
        return tuple(f"{names[leg]} {'lift-off' if lifts else 'touch-down'}" for leg, lifts in what)

    @property
    def grazing(self) -> float:
        """Smallest rate at which a leg passes through zero force at lift-off, m/s; small: derivatives are doubtful.

        Nan where the clock lifts all legs.

        See :ref:`model-grazing`.
        """
        events = self.stride.events
        by_force = np.array([leg.stance is None for leg in self.animal.legs])[events.leg]
        rates = np.abs(events.rate[events.lifts & by_force])
        return float(rates.min()) if len(rates) else math.nan

    @property
    def grazes(self) -> bool:
        """Whether a leg leaves so slowly (below 1 % of v_des) that derivatives, and so stability, are doubtful."""
        return self.grazing < GRAZING * self.system.desired_speed

    def invalid(self) -> tuple[Invalid, str] | None:
        """Say why this solution is no gait, and which leg is to blame (or more of the reason); None if it is one.

        See :ref:`model-believed`.
        """
        try:
            run = self.stride
        except IntegrationError as error:
            return Invalid.NOT_SIMULATED, str(error)
        for leg in turned_over(run):
            return Invalid.COLLAPSED, self.animal.legs[leg].name
        for leg in self.first_legs if self.system.mirrored else range(len(self.animal.legs)):
            name, (time, rate) = self.animal.legs[leg].name, self._stances[leg]
            if math.isnan(time):
                return Invalid.NO_LIFTOFF, name
            if rate * self.system.side[leg] > 0.0 and self.animal.legs[leg].stance is None:
                return Invalid.WRONG_SIGN, name
            if peak_magnitude(run, leg) < IDLE:
                return Invalid.IDLE, name
        for leg, old in enumerate(self.animal.legs):
            alike = self.first_legs[self.system.pair[leg]] if self.system.mirrored else leg
            left_down = self._stances[alike, 0] > (2.0 - old.offset) * self.system.step_duration
            if old.touchdown == "clock" and old.offset > 0.0 and left_down != bool(run.down_at_start[leg]):
                return Invalid.OLD_LEGS, old.name
        largest = float(np.max(np.abs(self.multipliers)))
        found = departure(self.system, self.point, largest)
        if found is not None:
            return Invalid.DEPARTS, found.what
        begin, end = run.states[[0, -1], 2:4]
        if not np.max(np.abs(end - begin)) <= largest_departure(largest) * self.speed:
            return Invalid.DEPARTS, "as it was simulated once more: what departs grows faster than can be told"
        if self.isolation < LEAST_ISOLATION:
            return Invalid.NOT_ISOLATED, f"its conditions have a singular value of {self.isolation:.1g}"
        return None

    @cached_property
    def reduced_eigenvalue(self) -> float:
        """Largest eigenvalue magnitude of the thesis's one-stride map of speed and heading.

        Nan for an animal that is not tuned to its desired speed, by which that map rebuilds the old feet, and where old
        feet are elsewhere.

        See :ref:`model-reduced`.
        """
        if not (self.animal.tuned and self.straight):
            return math.nan
        return largest_magnitude(reduced_map(self.system, self.point, accuracy=TIGHT)[1])

    @cached_property
    def multipliers(self) -> NDArray[np.complex128]:
        """Floquet multipliers of a stride (of a step where steps are all alike), of the complete map, largest first.

        What is `conserved` shows as a multiplier of 1.

        See :ref:`model-multipliers`.
        """
        return self.half_multipliers ** (2 if self.system.mirrored else 1)

    @cached_property
    def half_multipliers(self) -> NDArray[np.complex128]:
        """Multipliers of the step that the next one mirrors, half of a stride, in the order of `multipliers`.

        Those of a stride are their squares, of which 1 may be two things: +1, a fold or a crossing of families (passive
        ones: gaits that are tuned have other folds), or what is conserved; -1, where steps to the left and to the right
        begin to differ, or the direction where no direction is special. Where steps are all alike, they are
        `multipliers`.

        See :ref:`model-half`.
        """
        return eigenvalues(complete_map(self.system, self.point, accuracy=TIGHT)[1])

    @property
    def conserved(self) -> tuple[str, ...]:
        """What no step changes, and so has a multiplier of 1 (see `legspring.layout.System.conserved`).

        See :ref:`model-conserved`.
        """
        return self.system.conserved

    @cached_property
    def work(self) -> Floats:
        """Positive and negative work of each leg over a step, per m g and distance: ``(L, 2)``; nan at no distance.

        See :ref:`model-work`.
        """
        share = self.system.step_length / self.distance if self.gets_on else math.nan
        return work_of_legs(self.stride, steps=self.system.period) * share

    @cached_property
    def distance(self) -> float:
        """How far a step gets, m: straight ahead where steps mirror one another, else whatever way."""
        steps = self.system.period
        x, y = self.stride.states[steps, :2] / steps
        return float(abs(y) if self.system.flips else math.hypot(x, y))

    @property
    def gets_on(self) -> bool:
        """Whether a step gets anywhere: further than a millionth of how far its speed would take it."""
        return self.distance > NOWHERE * self.speed * self.step_duration

    @property
    def step_duration(self) -> float:
        """Duration of a step, s; the mean of a stride's where they differ."""
        return float(self.stride.times[-1]) / self.system.cycle

    @property
    def mean_speed(self) -> float:
        """Mean speed of progress, m/s."""
        return self.distance / self.step_duration

    @cached_property
    def _seen(self) -> dict[str, float]:
        """What is observed at the end of a period."""
        run = flow(self.system, self.point, steps=self.system.period, everything=True, accuracy=TIGHT)
        return dict(zip(SEEN, run.seen[: len(SEEN), 0].tolist(), strict=True))

    @property
    def lateral_drift(self) -> float:
        """Mean speed to the right, m/s: of a step if the next one mirrors it, else of a stride; nan from the side."""
        return math.nan if self.animal.sagittal else self._seen["x"] / self._seen["duration"]

    @property
    def apex_height(self) -> float:
        """Largest height of the centre of mass above the ground in flight, m; nan where none begins in a step.

        See :ref:`model-side`.
        """
        return self._seen["apex_height"]

    @property
    def mirrored(self) -> bool:
        """Whether the next step is the image of a step: as seen from above, with left and right exchanged."""
        return self.system.mirrored

    @property
    def straight(self) -> bool:
        """Whether the step before was straight ahead at the desired speed, as the thesis has it."""
        return self.contacts is None and self.displacement is None and self.system.flips

    @property
    def stride_frequency(self) -> float:
        """Strides in a second, Hz; a stride is two steps, or one where steps are all alike."""
        return 1.0 / (self.system.steps_per_stride * self.step_duration)

    @property
    def stride_length(self) -> float:
        """Progress of a stride, m: `mean_speed` by `stride_frequency`; but for rounding, zero for hopping in place."""
        return self.system.steps_per_stride * self.distance

    @property
    def froude_number(self) -> float:
        """Froude number v^2 / (g L) of the mean speed v (Alexander and Jayes 1983), dimensionless.

        L stands for the height of the hip in standing, and is the mean force-free length of the legs without actuation:
        from the side, that of a leg upright. Seen from above, where there is no height, it is that of their projections
        onto the ground. Gravity is the whole of it, whatever the slope.

        See :ref:`model-froude`.
        """
        length = float(np.mean([leg.length for leg in self.animal.legs]))
        return self.mean_speed**2 / (self.animal.gravity * length)

    @property
    def duty_factor(self) -> Floats:
        """Share of a stride in which each leg is in stance: ``(L,)``, in the order of the animal's legs.

        See :ref:`model-footfalls`.
        """
        return self.stride.duty_factor

    @property
    def phase_lag(self) -> Floats:
        """Touch-down of each leg after that of the animal's first leg, as a share of a stride: ``(L,)``, below 1.

        In the order of the animal's legs; of a leg that is put down more than once, the first time counts. Nan for one
        that is not put down.

        See :ref:`model-footfalls`.
        """
        return phase_lag(self.stride)

    @property
    def energy(self) -> float:
        """Total energy at the start of a step, J: that of motion and turning, of the springs and of the height.

        m v^2 / 2 + I w^2 / 2 + k gap^2 / 2 of each leg in stance, and m g by the height of the centre of mass above the
        ground, from the side. From above, height counts from the start of the step, and so is zero.

        See :ref:`model-energy`.
        """
        return total_energy(self.stride)

    @property
    def transport_cost(self) -> float:
        """Transport cost: work by weight and distance (Eq. 3.6); nan for a gait that gets nowhere.

        Positive and negative work count by the animal's ``work_weights`` (b1 and b2 of Eq. 3.5).

        See :ref:`model-cost`.
        """
        return float(weighed(self.work, self.animal.work_weights))

    @property
    def missing(self) -> dict[str, str]:
        """Measures that this gait does not have, which are nan, each with the reason."""
        reasons = {measure.name: measure.missing(self) for measure in MEASURES}
        return {name: reason for name, reason in reasons.items() if reason is not None}

    @cached_property
    def peak_force(self) -> Floats:
        """Peak force along x and y, with its sign, of each pair's leg that touches down first: ``(P, 2)``.

        Lateral and fore-aft, or horizontal and vertical in a side view; in units of m g.

        See :ref:`model-peak-forces`.
        """
        return np.array([peak_force(self.stride, leg) for leg in self.first_legs])

    @cached_property
    def net_force(self) -> tuple[Floats, Floats]:
        """Largest and smallest sum of the legs' forces (x, y) during a step, in units of m g."""
        return net_force(self.stride, steps=self.system.period)

    @cached_property
    def friction(self) -> float:
        """Coefficient of friction that feet need not to slip; nan where none would do.

        From the side, of each foot: its force has the direction of its leg. From above, of all feet together: the
        largest force along the slope by the weight that presses them onto it, m g cos(slope).

        See :ref:`model-friction`.
        """
        return needed_friction(self.stride)

    @property
    def yaw_amplitude(self) -> float:
        """Largest yaw to either side, rad, among the samples of `simulate`; 0 where the yaw is held."""
        return self._turning[0]

    @property
    def peak_moment(self) -> float:
        """Largest moment of all legs about the centre of mass, either way, N m, among the samples of `simulate`.

        Where the yaw is held, it is what holding takes.
        """
        return self._turning[1]

    @cached_property
    def _turning(self) -> tuple[float, float]:
        from legspring.simulation import turning

        return turning(self.stride)

    def sensitivity(self, *parameters: str) -> "xr.Dataset":
        """Return how the gait, its multipliers and its measures change with some parameters.

        See :ref:`numerics-sensitivity`.

        Parameters
        ----------
        *parameters
            Names, as in ``"slope_deg"``, ``"F.stiffness"`` or ``"mass"`` (see `legspring.parameters`), or of what the
            gait was asked for, as ``"energy"``.

        Returns
        -------
        xarray.Dataset
            Over ``parameter`` (with coordinates ``value`` and ``unit``): derivatives of the unknowns of the gait
            (``speed``, ``heading``, ``phase``, ..., exact), of ``multipliers``, over multiplier and part (real and
            imaginary), and of every measure that is one number, per unit of the parameter. What a gait does not have,
            or does not have nearby, is missing, as are derivatives of multipliers that are double. Where a parameter
            can only grow, or has a kink, derivatives are those of one side, which ``note`` says.

        Raises
        ------
        ValueError
            For a name that is none, or of something that the gait has found.

        Examples
        --------
        >>> import legspring as ls
        >>> gait = ls.find_gaits(ls.cockroach(), slope_deg=45, heading=0.15)[0]
        >>> round(gait.sensitivity("slope_deg").speed.item(), 5)
        -0.00113
        """
        from legspring.measures.sensitivity import sensitivity

        return sensitivity(self, parameters)

    def recover(self, impulse: float) -> Recovery:
        """Push the gait sideways, or fore-aft in a side view, and see whether it comes back.

        See :ref:`model-recovery`.

        Parameters
        ----------
        impulse
            In units of m v_des, > 0 to the right, or forward.

        Raises
        ------
        ValueError
            If the impulse is out of range, or the animal's legs do no work, so that it keeps what it is given.
        """
        return recover(self.system, self.point, impulse)

    def recovery_steps(self, impulses: Sequence[float]) -> Floats:
        """Return how many steps it takes to recover from each of some impulses (see `recover`); nan if it does not."""
        return recovery_steps(self.system, self.point, impulses)

    def simulate(self, strides: float = 2) -> "xr.Dataset":
        """Simulate the gait (see `legspring.simulate`)."""
        from legspring.simulation import simulation

        return simulation(self.system, self.point, strides)

    def shot(self, strides: float | None = None) -> "Shot":
        """Return what a film shows of the gait, out of the midst of it: by default two strides.

        A stride before, whose feet and track are seen, and one after: the camera's way is a mean over a stride.
        """
        from legspring.drawing.stage import Shot

        stride, shown = 1.0 / self.stride_frequency, strides or 2.0
        place = "" if self.animal.sagittal else f"slope {self.slope_deg:g} deg, heading {self.heading:.3g} rad, "
        number = f", branch {self.branch}" if self.branch >= 0 else ""
        about = f", family {self.family}{number}\n{place}{self.mean_speed:.3g} m/s"
        return Shot(self.simulate(math.ceil(shown - 1e-9) + 2), stride, (1.0 + shown) * stride, about, repeats=True)

    def animate(self, strides: float = 2, slow: float | None = None) -> "Film":
        """Make a moving picture of the gait (see `legspring.animate`), which notebooks show."""
        from legspring.drawing.film import animate

        return animate(self, strides=strides, slow=slow)


def turned_over(run: Flow) -> list[int]:
    """Return the legs that point the other way from one step of the integrator to the next."""
    seen = run.samples(run.tape.time[: run.tape.counts[0] + 1])
    across = np.sum(seen.legs[1:] * seen.legs[:-1], axis=-1)
    return [int(leg) for leg in np.flatnonzero(np.any((across < 0.0) & seen.down[1:] & seen.down[:-1], axis=0))]
