"""Whether a motion repeats itself: the evidence that a solution of a gait's conditions is a gait.

The conditions of a gait are a few equations, and some of what they leave out is assumed: what is conserved, which feet
are down, where they are. Here nothing is assumed. Two strides are simulated, with other steps of the integrator than
the conditions were solved with, and all that makes up the state is compared at the start of each step with what it was
at the start of the first one.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from legspring.flow import Flow, IntegrationError, flow
from legspring.kernel.walker import Floats
from legspring.layout import System
from legspring.measures.energy import kinetic_and_spring

STRIDES = 2
ACCURACY = 3e-13
"""Relative accuracy of the simulation: another one than that of the conditions."""
CLOSE = 1e-8
"""Largest departure where small ones do not grow; in units of the speed, rad, the longest leg or the kinetic energy."""
FARTHEST = 1e-3
"""Largest departure, however fast small ones grow: further off, nothing is known."""


class Moment(NamedTuple):
    """The start of a step, in SI units: what comes back if the motion repeats itself.

    Which legs are down, and which of them are put down right then. Loads are how far legs that are down are from
    lifting off at zero force, m; infinite for those that have just been put down, or that the clock lifts.
    """

    velocity: Floats
    yaw: float
    yaw_rate: float
    down: NDArray[np.bool_]
    lands: NDArray[np.bool_]
    loads: Floats
    feet: Floats
    height: float
    depths: Floats
    energy: float


class Departure(NamedTuple):
    """By how much something did not come back; scaled as `CLOSE` is, infinite for what is not a matter of degree."""

    amount: float
    what: str


def departure(system: System, p: Floats, growth: float = 1.0) -> Departure | None:
    """Follow a motion for two strides; say what does not come back, if there is something.

    Parameters
    ----------
    system, p
        The motion: an animal on its slope, and all parameters with the start.
    growth
        By how much a small departure may grow in a stride: the largest magnitude of a multiplier.

    Returns
    -------
    Departure or None
        None if everything comes back to within 1e-8 max(1, growth^2), and within 1e-3 at the most.
    """
    allowed = largest_departure(growth)
    first = moment(flow(system, p, steps=0))
    for step in range(system.period, STRIDES * system.cycle + 1, system.period):
        try:
            now = moment(flow(system, p, steps=step, accuracy=ACCURACY))
        except IntegrationError as error:
            return Departure(math.inf, f"in step {step} it {error}")
        if system.mirrored and step % 2:
            now = mirrored(system, now)
        for found in departures(system, first, now):
            if not found.amount <= allowed:
                return Departure(found.amount, f"after {step} step{'s' if step > 1 else ''} {found.what}")
    return None


def largest_departure(growth: float) -> float:
    """Return how far a motion in which small departures grow so fast in a stride may be off after two."""
    return min(CLOSE * max(1.0, growth**STRIDES), FARTHEST) if math.isfinite(growth) else FARTHEST


def departures(system: System, first: Moment, now: Moment) -> Iterator[Departure]:
    """Compare everything, one after the other; the contacts first, as the rest depends on them."""
    names = np.array([leg.name for leg in system.animal.legs])
    speed, length = math.hypot(*first.velocity), max(leg.length for leg in system.animal.legs)
    for words, here, there in (("is down", now, first), ("is up", first, now)):
        for leg in np.flatnonzero(here.down & ~there.down):
            # A leg that is just about to lift off, or has just done so, makes no difference.
            yield Departure(here.loads[leg] / length, f"{names[leg]} {words}, which was not so at the start")
    for leg in np.flatnonzero(now.lands & first.down & ~first.lands):
        yield Departure(math.inf, f"{names[leg]} is put down, which was down already at the start")
    (vx, vy), (ux, uy) = now.velocity, first.velocity
    off = float(np.max(np.abs(now.velocity - first.velocity))) / speed
    yield Departure(off, f"the velocity is ({vx:.6g}, {vy:.6g}) m/s, and not ({ux:.6g}, {uy:.6g})")
    turned = math.remainder(now.yaw - first.yaw, 2.0 * math.pi)
    yield Departure(abs(turned), f"the yaw is off by {turned:.3g} rad")
    spin = now.yaw_rate - first.yaw_rate
    yield Departure(abs(spin) * length / speed, f"the yaw rate is off by {spin:.3g} rad/s")
    both = now.down & first.down
    for name, depth in zip(names[both], now.depths[both], strict=True):
        yield Departure(abs(depth) / length, f"the foot of {name} is {abs(depth):.3g} m off the ground")
    yield Departure(abs(now.height - first.height) / length, f"the height is off by {now.height - first.height:.3g} m")
    for name, gap in zip(names[both], (now.feet - first.feet)[both], strict=True):
        yield Departure(float(np.max(np.abs(gap))) / length, f"the foot of {name} is {np.hypot(*gap):.3g} m off")
    if "energy" in system.conserved:
        off = abs(now.energy - first.energy) / first.energy
        yield Departure(off, f"the kinetic and spring energy is off by a share of {off:.3g}")


def moment(run: Flow) -> Moment:
    """Look at the end of a simulation."""
    system, legs = run.system, run.contacts()
    state, body = np.pad(run.state[:, 0], (0, 6 - system.rows)), system.animal.body
    loads = np.where(legs.leaves, np.abs(legs.gaps), math.inf)
    # Where nothing stands on a ground, there are no heights.
    depths, height = np.nan_to_num(legs.feet[:, 1] - legs.ground), float(np.nan_to_num(-legs.ground[0]))
    # Where energy is conserved, and so compared, a gap is a spring's stretch.
    energy = kinetic_and_spring(body, state, legs.stiffness, legs.gaps, legs.down)
    turn = float(state[4]), float(state[5])
    return Moment(state[2:4], *turn, legs.down, legs.lands, loads, legs.feet, height, depths, energy)


def mirrored(system: System, m: Moment) -> Moment:
    """Return the mirror image of a moment, each leg in the place of the other one of its pair.

    From the side, an image would run backwards: there steps have to be alike.
    """
    legs, side = list(system.animal.partners), -1.0 if system.flips else 1.0
    flip = np.array([side, 1.0])
    return m._replace(
        velocity=m.velocity * flip,
        yaw=side * m.yaw,
        yaw_rate=side * m.yaw_rate,
        down=m.down[legs],
        lands=m.lands[legs],
        loads=m.loads[legs],
        feet=m.feet[legs] * flip,
        depths=m.depths[legs],
    )
