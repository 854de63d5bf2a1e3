"""Right-hand side of the equations of motion and of their variational equations (Eqs. 2.1-2.6)."""

import math
from typing import NamedTuple

import numpy as np

from legspring.kernel.jit import formula, jit
from legspring.kernel.length import Law, Pair, law, length, length_rates, phase_at
from legspring.kernel.walker import (
    ALL_PLAIN,
    ARM_X,
    ARM_Y,
    DAMPER,
    DOWN,
    FOOT_X,
    FOOT_Y,
    FORCE,
    GRAVITY,
    GRAVITY_X,
    GRIP_X,
    GRIP_Y,
    GYRATION,
    HEIGHT,
    LAW,
    LEVEL,
    PUSH_X,
    PUSH_Y,
    SPRING,
    VX,
    VY,
    WATCHED,
    YAW,
    YAW_RATE,
    Floats,
    X,
    Y,
)

Triple = tuple[float, float, float]
Index = int | np.uint64

ONE, TWO, THREE = np.uint64(1), np.uint64(2), np.uint64(3)
"""Numbers without a sign. An index with one may count from the end, which rules out vector instructions."""


@formula
def turn(y: Floats) -> Pair:
    """Cosine and sine of the yaw."""
    if y.shape[0] == 4:
        return 1.0, 0.0
    return math.cos(y[YAW, 0]), math.sin(y[YAW, 0])


@formula
def hip(x: float, y: float, lean: Pair) -> Pair:
    """Turn a hip's offset in the body by the yaw, given its cosine and sine."""
    return lean[0] * x - lean[1] * y, lean[1] * x + lean[0] * y


@formula
def rates(
    s: float,
    phase: Pair,
    y: Floats,
    stance: Floats,
    contacts: Floats,
    body: Floats,
    clock: Floats,
    struts: Floats,
    out: Floats,
) -> None:
    """Write the accelerations in the state ``y`` at time s into ``out``, but for the derivatives' columns.

    ``phase`` is that of the time; what `tangent_rates` needs of the legs goes into ``struts``.
    """
    lean = turn(y)
    ax = clock[PUSH_X] + clock[PUSH_X + 1] * s - body[GRAVITY_X, 0]
    ay = clock[PUSH_Y] + clock[PUSH_Y + 1] * s - body[GRAVITY, 0]
    moment = 0.0
    if clock[ALL_PLAIN] != 0.0:
        for i in range(contacts.shape[0]):
            if contacts[i, DOWN] != 0.0:
                rx, ry, hx, hy, r, gap = spring(y, stance, i, lean, phase)
                # Quicker than a division by r, which would have to wait for the root.
                inverse = r * (1.0 / (rx * rx + ry * ry))
                pull = stance[i, SPRING, 0] * gap * inverse
                ax += pull * rx
                ay += pull * ry
                moment += pull * (hx * ry - hy * rx)
                if y.shape[1] > 1:
                    leg = struts[i]
                    leg[0], leg[1], leg[2], leg[3], leg[4] = rx * inverse, ry * inverse, hx, hy, gap
                    leg[5], leg[6] = pull, stance[i, SPRING, 0] - pull
    else:
        fx, fy, moment = any_forces(s, y, stance, contacts, lean, phase)
        ax += fx
        ay += fy
    out[VX, 0] = ax
    out[VY, 0] = ay
    if y.shape[0] == 6:
        out[YAW_RATE, 0] = body[GYRATION, 0] * moment


@formula
def reach(y: Floats, stance: Floats, i: int, lean: Pair) -> tuple[float, float, float, float, float]:
    """Leg i as a vector from hip to foot (x, y), its hip (x, y), and its length |r|."""
    hx, hy = hip(stance[i, GRIP_X, 0], stance[i, GRIP_Y, 0], lean)
    rx = stance[i, FOOT_X, 0] - y[X, 0] - hx
    ry = stance[i, FOOT_Y, 0] - y[Y, 0] - hy
    return rx, ry, hx, hy, math.sqrt(rx * rx + ry * ry)


@formula
def spring(
    y: Floats, stance: Floats, i: int, lean: Pair, phase: Pair
) -> tuple[float, float, float, float, float, float]:
    """Leg i as `reach` gives it, and its gap |r| - l, for the law of the sinusoid."""
    rx, ry, hx, hy, r = reach(y, stance, i, lean)
    free = length(stance[i, LAW, 0], stance[i, LAW + 1, 0], stance[i, LAW + 2, 0], phase[0], phase[1])
    return rx, ry, hx, hy, r, r - free


class Strut(NamedTuple):
    """A moving leg: vector from hip to foot, its length and rate; hip; gap |r| - l, rate of |r|; force per mass."""

    rx: float
    ry: float
    r: float
    vx: float
    vy: float
    hx: float
    hy: float
    gap: float
    rate: float
    force: float


@formula
def strut(y: Floats, stance: Floats, i: int, lean: Pair, free: float) -> Strut:
    """Leg i with everything that its force depends on."""
    rx, ry, hx, hy, r = reach(y, stance, i, lean)
    spin = y[YAW_RATE, 0] if y.shape[0] == 6 else 0.0
    vx, vy = spin * hy - y[VX, 0], -spin * hx - y[VY, 0]
    gap, rate = r - free, (rx * vx + ry * vy) / r
    force = stance[i, SPRING, 0] * gap + stance[i, DAMPER, 0] * rate
    return Strut(rx, ry, r, vx, vy, hx, hy, gap, rate, force)


@formula
def leg_force(
    s: float, y: Floats, stance: Floats, i: int, lean: Pair, phase: Pair
) -> tuple[float, float, float, float, float, float]:
    """Leg i as `reach` gives it, and its force (per mass, > 0 pulling), whatever its law, and with its damper."""
    numbers = law(s, stance, i, phase)
    leg = strut(y, stance, i, lean, numbers[0])
    return leg.rx, leg.ry, leg.hx, leg.hy, leg.r, leg.force


@jit
def any_forces(s: float, y: Floats, stance: Floats, contacts: Floats, lean: Pair, phase: Pair) -> Triple:
    """Sum of the forces (x, y, per mass) and moments of all legs in stance, whatever their laws and dampers."""
    ax = ay = moment = 0.0
    for i in range(contacts.shape[0]):
        if contacts[i, DOWN] != 0.0:
            rx, ry, hx, hy, r, force = leg_force(s, y, stance, i, lean, phase)
            pull = force / r
            ax += pull * rx
            ay += pull * ry
            moment += pull * (hx * ry - hy * rx)
    return ax, ay, moment


@formula
def tangent_rates(
    s: float,
    phase: Pair,
    y: Floats,
    stance: Floats,
    contacts: Floats,
    body: Floats,
    clock: Floats,
    struts: Floats,
    out: Floats,
) -> None:
    """Write the derivatives of the accelerations into ``out`` (variational equations), after `rates`."""
    rows, width = y.shape
    lean = turn(y)
    moment = 0.0
    if clock[ALL_PLAIN] != 0.0:
        if rows == 6:
            plain_tangents(y, stance, contacts, body, struts, lean, phase, out, True)
        else:
            plain_tangents(y, stance, contacts, body, struts, lean, phase, out, False)
        if rows == 6:
            for i in range(contacts.shape[0]):
                if contacts[i, DOWN] != 0.0:
                    leg = struts[i]
                    moment += stance[i, SPRING, 0] * leg[4] * (leg[2] * leg[1] - leg[3] * leg[0])
    else:
        for d in range(1, width):
            out[VX, d], out[VY, d] = -body[GRAVITY_X, d], -body[GRAVITY, d]
            if rows == 6:
                out[YAW_RATE, d] = 0.0
        moment = add_any_tangents(s, y, stance, contacts, out, lean, phase)
    if rows == 6:
        for d in range(1, width):
            out[YAW_RATE, d] = body[GYRATION, 0] * out[YAW_RATE, d] + body[GYRATION, d] * moment


@formula
def tangent(y: Floats, rows: Floats, leg: Floats, lean: Pair, phase: Pair, d: Index, yaws: bool) -> Triple:
    """Differentiate the force (x, y, per mass) of a leg, and its moment, along one direction.

    With r = |r| u, gap = |r| - l and q = gap / |r|, the force is F = k gap u and

        dF = k q dr + (k (1 - q) (u dr) - k dl + gap dk) u,    dr = dfoot - dcom - dhip

    The hip moves with its offset in the body, turned by the yaw, and with the yaw itself. ``rows`` is the leg's stance.
    """
    k, ux, uy, gap, turning = rows[SPRING, 0], leg[0], leg[1], leg[4], 0.0
    hip_x, hip_y = rows[GRIP_X, d], rows[GRIP_Y, d]
    if yaws:
        hip_x, hip_y = hip(hip_x, hip_y, lean)
        hip_x, hip_y = hip_x - y[YAW, d] * leg[3], hip_y + y[YAW, d] * leg[2]
    rx, ry = rows[FOOT_X, d] - y[X, d] - hip_x, rows[FOOT_Y, d] - y[Y, d] - hip_y
    tension = leg[6] * (ux * rx + uy * ry) + gap * rows[SPRING, d]
    tension -= k * length(rows[LAW, d], rows[LAW + 1, d], rows[LAW + 2, d], phase[0], phase[1])
    fx, fy = leg[5] * rx + tension * ux, leg[5] * ry + tension * uy
    if yaws:
        turning = leg[2] * fy - leg[3] * fx + k * gap * (hip_x * uy - hip_y * ux)
    return fx, fy, turning


@formula
def plain_tangents(
    y: Floats,
    stance: Floats,
    contacts: Floats,
    body: Floats,
    struts: Floats,
    lean: Pair,
    phase: Pair,
    out: Floats,
    yaws: bool,
) -> None:
    """Write gravity and the sums of `tangent` over all legs, for four directions at a time: vector instructions.

    The last four may have some in common with those before.
    """
    width = y.shape[1]
    for d in range(1, width, 4):
        four_tangents(y, stance, contacts, body, struts, lean, phase, np.uint64(min(d, width - 4)), out, yaws)


@formula
def four_tangents(
    y: Floats,
    stance: Floats,
    contacts: Floats,
    body: Floats,
    struts: Floats,
    lean: Pair,
    phase: Pair,
    d: Index,
    out: Floats,
    yaws: bool,
) -> None:
    """Do that for four directions, from d on."""
    am = bm = cm = dm = 0.0
    g, f = body[GRAVITY], body[GRAVITY_X]
    ax, bx, cx, dx = -f[d], -f[d + ONE], -f[d + TWO], -f[d + THREE]
    ay, by, cy, dy = -g[d], -g[d + ONE], -g[d + TWO], -g[d + THREE]
    for i in range(contacts.shape[0]):
        if contacts[i, DOWN] != 0.0:
            rows, leg = stance[i], struts[i]
            x, y_, m = tangent(y, rows, leg, lean, phase, d, yaws)
            ax, ay, am = ax + x, ay + y_, am + m
            x, y_, m = tangent(y, rows, leg, lean, phase, d + ONE, yaws)
            bx, by, bm = bx + x, by + y_, bm + m
            x, y_, m = tangent(y, rows, leg, lean, phase, d + TWO, yaws)
            cx, cy, cm = cx + x, cy + y_, cm + m
            x, y_, m = tangent(y, rows, leg, lean, phase, d + THREE, yaws)
            dx, dy, dm = dx + x, dy + y_, dm + m
    out[VX, d], out[VX, d + ONE], out[VX, d + TWO], out[VX, d + THREE] = ax, bx, cx, dx
    out[VY, d], out[VY, d + ONE], out[VY, d + TWO], out[VY, d + THREE] = ay, by, cy, dy
    if yaws:
        out[YAW_RATE, d], out[YAW_RATE, d + ONE] = am, bm
        out[YAW_RATE, d + TWO], out[YAW_RATE, d + THREE] = cm, dm


@formula
def change(
    y: Floats, stance: Floats, i: int, d: int, lean: Pair, leg: Strut, numbers: Law
) -> tuple[float, float, float, float, float]:
    """Differentiate leg i along one direction: vector from hip to foot (x, y), hip (x, y), force.

    With r = |r| u, the gap g = |r| - l and the force k g + c |r|', the derivative of the rate |r|' = u r' is
    u dr' + du r', du = (dr - u (u dr)) / |r|.
    """
    ux, uy, spin, yaw, spin_d = leg.rx / leg.r, leg.ry / leg.r, 0.0, 0.0, 0.0
    if y.shape[0] == 6:
        spin, yaw, spin_d = y[YAW_RATE, 0], y[YAW, d], y[YAW_RATE, d]
    hx, hy = hip(stance[i, GRIP_X, d], stance[i, GRIP_Y, d], lean)
    hx, hy = hx - yaw * leg.hy, hy + yaw * leg.hx
    rx, ry = stance[i, FOOT_X, d] - y[X, d] - hx, stance[i, FOOT_Y, d] - y[Y, d] - hy
    vx, vy = spin_d * leg.hy + spin * hy - y[VX, d], -spin_d * leg.hx - spin * hx - y[VY, d]
    gap = along = ux * rx + uy * ry
    rate = ux * vx + uy * vy + ((rx - along * ux) * leg.vx + (ry - along * uy) * leg.vy) / leg.r
    gap -= numbers[3] * stance[i, LAW, d] + numbers[4] * stance[i, LAW + 1, d]
    gap -= numbers[5] * stance[i, LAW + 2, d] + numbers[6] * stance[i, LAW + 3, d]
    force = stance[i, SPRING, 0] * gap + leg.gap * stance[i, SPRING, d]
    force += stance[i, DAMPER, 0] * rate + leg.rate * stance[i, DAMPER, d]
    return rx, ry, hx, hy, force


@jit
def force_changes(s: float, y: Floats, stance: Floats, i: int, out: Floats) -> None:
    """Write the derivatives of the force (per mass) of leg i at time s into ``out``."""
    lean, phase = turn(y), phase_at(s)
    numbers = law(s, stance, i, phase)
    leg = strut(y, stance, i, lean, numbers[0])
    for d in range(1, out.size):
        out[d] = change(y, stance, i, d, lean, leg, numbers)[4]


@jit
def add_any_tangents(
    s: float, y: Floats, stance: Floats, contacts: Floats, out: Floats, lean: Pair, phase: Pair
) -> float:
    """Add what `tangent` gives for all legs in stance, whatever their laws and dampers; return their moment."""
    moment = 0.0
    for i in range(contacts.shape[0]):
        if contacts[i, DOWN] == 0.0:
            continue
        numbers = law(s, stance, i, phase)
        leg = strut(y, stance, i, lean, numbers[0])
        ux, uy = leg.rx / leg.r, leg.ry / leg.r
        fx, fy = leg.force * ux, leg.force * uy
        for d in range(1, y.shape[1]):
            rx, ry, hx, hy, force = change(y, stance, i, d, lean, leg, numbers)
            along = ux * rx + uy * ry
            fx_d = force * ux + leg.force * (rx - along * ux) / leg.r
            fy_d = force * uy + leg.force * (ry - along * uy) / leg.r
            out[VX, d] += fx_d
            out[VY, d] += fy_d
            if y.shape[0] == 6:
                out[YAW_RATE, d] += hx * fy + leg.hx * fy_d - hy * fx - leg.hy * fx_d
        moment += leg.hx * fy - leg.hy * fx
    return moment


@formula
def stretch_rates(
    y: Floats, f: Floats, lean: Pair, rx: float, ry: float, hx: float, hy: float, r: float
) -> tuple[float, float]:
    """First two time derivatives of the length of a leg, as `reach` gives it, in the state y whose rates are ``f``."""
    vx, vy, ax, ay = -y[VX, 0], -y[VY, 0], -f[VX, 0], -f[VY, 0]
    if y.shape[0] == 6:
        spin, spin_rate = y[YAW_RATE, 0], f[YAW_RATE, 0]
        vx, vy = vx + spin * hy, vy - spin * hx
        ax, ay = ax + spin_rate * hy + spin**2 * hx, ay - spin_rate * hx + spin**2 * hy
    rate = (rx * vx + ry * vy) / r
    return rate, (vx * vx + vy * vy + rx * ax + ry * ay - rate * rate) / r


@formula
def gap_rates(y: Floats, f: Floats, stance: Floats, i: int, lean: Pair, phase: Pair) -> Triple:
    """Gap |r| - l of leg i and its first two time derivatives, in the state y whose rates are ``f``."""
    rx, ry, hx, hy, r, gap = spring(y, stance, i, lean, phase)
    rate, second = stretch_rates(y, f, lean, rx, ry, hx, hy, r)
    free_rate, free_second = length_rates(stance[i, LAW + 1, 0], stance[i, LAW + 2, 0], phase[0], phase[1])
    return gap, rate - free_rate, second - free_second


@jit
def any_gap_rates(s: float, y: Floats, f: Floats, stance: Floats, i: int, lean: Pair, phase: Pair) -> Triple:
    """Gap of leg i with any law and damper, and its first two time derivatives.

    With a damper the gap is the force by the stiffness; its second derivative would take one more of the state: nan.
    """
    rx, ry, hx, hy, r = reach(y, stance, i, lean)
    rate, second = stretch_rates(y, f, lean, rx, ry, hx, hy, r)
    numbers = law(s, stance, i, phase)
    if stance[i, DAMPER, 0] == 0.0:
        return r - numbers[0], rate - numbers[1], second - numbers[2]
    damper = stance[i, DAMPER, 0] / stance[i, SPRING, 0]
    return r - numbers[0] + damper * rate, rate - numbers[1] + damper * second, math.nan


@formula
def height_rates(y: Floats, f: Floats, contacts: Floats, i: int, lean: Pair) -> Triple:
    """Height above the ground of the foot of leg i, held ready, and its first two time derivatives."""
    x, height = hip(contacts[i, ARM_X], contacts[i, ARM_Y], lean)
    rate = second = 0.0
    if y.shape[0] == 6:
        spin = y[YAW_RATE, 0]
        rate, second = spin * x, f[YAW_RATE, 0] * x - spin**2 * height
    return y[Y, 0] + height - contacts[i, LEVEL], y[VY, 0] + rate, f[VY, 0] + second


@jit
def measure_gaps(s: float, y: Floats, f: Floats, stance: Floats, contacts: Floats, clock: Floats, gaps: Floats) -> None:
    """Write the gap and its rates for every leg whose gap is watched into ``gaps``; ``f`` holds the rates of y."""
    lean, phase = turn(y), phase_at(s)
    if clock[ALL_PLAIN] != 0.0:
        for i in range(contacts.shape[0]):
            if contacts[i, WATCHED] == FORCE:
                gaps[i, 0], gaps[i, 1], gaps[i, 2] = gap_rates(y, f, stance, i, lean, phase)
    else:
        for i in range(contacts.shape[0]):
            if contacts[i, WATCHED] == FORCE:
                gaps[i, 0], gaps[i, 1], gaps[i, 2] = any_gap_rates(s, y, f, stance, i, lean, phase)
    for i in range(contacts.shape[0]):
        if contacts[i, WATCHED] == HEIGHT:
            gaps[i, 0], gaps[i, 1], gaps[i, 2] = height_rates(y, f, contacts, i, lean)
