"""Right-hand side of the equations of motion and of their variational equations (Eqs. 2.1-2.6)."""

import math

from legspring.kernel.jit import formula, jit
from legspring.kernel.length import length, length_partials, length_rates
from legspring.kernel.walker import (
    DOWN,
    FOOT_X,
    FOOT_Y,
    GRAVITY,
    GRIP_X,
    GRIP_Y,
    GYRATION,
    LAW,
    PUSH_X,
    PUSH_Y,
    SPRING,
    VARIED,
    VX,
    VY,
    YAW,
    YAW_RATE,
    Floats,
    X,
    Y,
)

Pair = tuple[float, float]
Triple = tuple[float, float, float]
Factors = tuple[float, float, float, float, float, float, float, float]


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
def rates(s: float, y: Floats, stance: Floats, contacts: Floats, body: Floats, clock: Floats, out: Floats) -> None:
    """Write the time derivative of the state ``y`` at time s into ``out``, but for the derivatives' columns."""
    lean, phase = turn(y), (math.sin(math.pi * s), math.cos(math.pi * s))
    ax = clock[PUSH_X] + clock[PUSH_X + 1] * s
    ay = clock[PUSH_Y] + clock[PUSH_Y + 1] * s - body[GRAVITY, 0]
    moment = 0.0
    for i in range(contacts.shape[0]):
        if contacts[i, DOWN] != 0.0:
            rx, ry, hx, hy, r, gap = spring(y, stance, i, lean, phase)
            pull = stance[i, SPRING, 0] * gap / r
            ax += pull * rx
            ay += pull * ry
            moment += pull * (hx * ry - hy * rx)
    out[X, 0] = y[VX, 0]
    out[Y, 0] = y[VY, 0]
    out[VX, 0] = ax
    out[VY, 0] = ay
    if y.shape[0] == 6:
        out[YAW, 0] = y[YAW_RATE, 0]
        out[YAW_RATE, 0] = body[GYRATION, 0] * moment


@formula
def spring(
    y: Floats, stance: Floats, i: int, lean: Pair, phase: Pair
) -> tuple[float, float, float, float, float, float]:
    """Leg i as a vector from hip to foot (x, y), its hip (x, y), its length |r|, and its gap |r| - l."""
    hx, hy = hip(stance[i, GRIP_X, 0], stance[i, GRIP_Y, 0], lean)
    rx = stance[i, FOOT_X, 0] - y[X, 0] - hx
    ry = stance[i, FOOT_Y, 0] - y[Y, 0] - hy
    r = math.sqrt(rx * rx + ry * ry)
    free = length(stance[i, LAW, 0], stance[i, LAW + 1, 0], stance[i, LAW + 2, 0], phase[0], phase[1])
    return rx, ry, hx, hy, r, r - free


@jit
def tangent_rates(s: float, y: Floats, stance: Floats, contacts: Floats, body: Floats, out: Floats) -> None:
    """Write the time derivatives of the derivatives in ``y`` into ``out`` (variational equations)."""
    rows, width = y.shape
    lean, phase = turn(y), (math.sin(math.pi * s), math.cos(math.pi * s))
    for d in range(1, width):
        out[X, d] = y[VX, d]
        out[Y, d] = y[VY, d]
        out[VX, d] = 0.0
        out[VY, d] = -body[GRAVITY, d]
    if rows == 6:
        for d in range(1, width):
            out[YAW, d] = y[YAW_RATE, d]
            out[YAW_RATE, d] = 0.0
    moment = 0.0
    for i in range(contacts.shape[0]):
        if contacts[i, DOWN] != 0.0:
            moment += add_tangents(y, stance, i, out, lean, phase, contacts[i, VARIED] != 0.0)
    if rows == 6:
        for d in range(1, width):
            out[YAW_RATE, d] = body[GYRATION, 0] * out[YAW_RATE, d] + body[GYRATION, d] * moment


@formula
def add_tangents(y: Floats, stance: Floats, i: int, out: Floats, lean: Pair, phase: Pair, varied: bool) -> float:
    """Add the derivatives of the force of leg i, and of its moment, in every direction; return the moment.

    With r = |r| u, gap = |r| - l and q = gap / |r|, the force is F = k gap u and

        dF = k (q 1 + (1 - q) u u^T) dr - k u dl + gap u dk,    dr = dfoot - dcom - dhip

    so that each row is a fixed linear combination of the rows of the stance and of the state. The hip moves with
    its offset in the body, turned by the yaw, and with the yaw itself.
    """
    rx, ry, hx, hy, r, gap = spring(y, stance, i, lean, phase)
    ux, uy, q, stiffness = rx / r, ry / r, gap / r, stance[i, SPRING, 0]
    along = stiffness * (1.0 - q)
    kxx, kxy, kyy = stiffness * q + along * ux * ux, along * ux * uy, stiffness * q + along * uy * uy
    law = length_partials(phase[0], phase[1])
    # Factors of the rows of the stance, in their order, and of the yaw.
    row_x = force_row(kxx, kxy, ux, gap, stiffness, lean, law)
    row_y = force_row(kxy, kyy, uy, gap, stiffness, lean, law)
    yaw_x, yaw_y = hy * kxx - hx * kxy, hy * kxy - hx * kyy
    add_row(y, stance, i, out[VX], row_x, yaw_x, varied)
    add_row(y, stance, i, out[VY], row_y, yaw_y, varied)
    if y.shape[0] == 6:
        c, s = lean
        fx, fy = stiffness * gap * ux, stiffness * gap * uy
        row_moment = (
            hx * row_y[0] - hy * row_x[0],
            hx * row_y[1] - hy * row_x[1],
            hx * row_y[2] - hy * row_x[2] + c * fy - s * fx,
            hx * row_y[3] - hy * row_x[3] - s * fy - c * fx,
            hx * row_y[4] - hy * row_x[4],
            hx * row_y[5] - hy * row_x[5],
            hx * row_y[6] - hy * row_x[6],
            hx * row_y[7] - hy * row_x[7],
        )
        add_row(y, stance, i, out[YAW_RATE], row_moment, hx * yaw_y - hy * yaw_x - hx * fx - hy * fy, varied)
    return stiffness * gap * (hx * uy - hy * ux)


@formula
def force_row(kx: float, ky: float, u: float, gap: float, spring: float, lean: Pair, law: Triple) -> Factors:
    """Factors of one component of the force: foot, hip offset (x, y each), stiffness, the law's coefficients."""
    c, s = lean
    free = -spring * u
    return kx, ky, -c * kx - s * ky, s * kx - c * ky, gap * u, free * law[0], free * law[1], free * law[2]


@formula
def add_row(y: Floats, stance: Floats, i: int, out: Floats, f: Factors, yaw: float, varied: bool) -> None:
    """Add to one row of derivatives the given multiples of the stance's rows and of the state's.

    In loops of few arrays each, which the compiler turns into vector instructions.
    """
    rows = stance[i]
    for d in range(1, out.size):
        out[d] += f[0] * (rows[0, d] - y[X, d]) + f[1] * (rows[1, d] - y[Y, d])
    if varied:
        for d in range(1, out.size):
            out[d] += f[2] * rows[2, d] + f[3] * rows[3, d] + f[4] * rows[4, d]
    for d in range(1, out.size):
        out[d] += f[5] * rows[5, d] + f[6] * rows[6, d] + f[7] * rows[7, d]
    if y.shape[0] == 6:
        for d in range(1, out.size):
            out[d] += yaw * y[YAW, d]


@formula
def gap_rates(y: Floats, f: Floats, stance: Floats, i: int, lean: Pair, phase: Pair) -> Triple:
    """Gap |r| - l of leg i and its first two time derivatives, in the state y whose rates are ``f``."""
    rx, ry, hx, hy, r, gap = spring(y, stance, i, lean, phase)
    vx, vy, ax, ay = -y[VX, 0], -y[VY, 0], -f[VX, 0], -f[VY, 0]
    if y.shape[0] == 6:
        spin, spin_rate = y[YAW_RATE, 0], f[YAW_RATE, 0]
        vx, vy = vx + spin * hy, vy - spin * hx
        ax, ay = ax + spin_rate * hy + spin**2 * hx, ay - spin_rate * hx + spin**2 * hy
    rate = (rx * vx + ry * vy) / r
    second = (vx * vx + vy * vy + rx * ax + ry * ay - rate * rate) / r
    free_rate, free_second = length_rates(stance[i, LAW + 1, 0], stance[i, LAW + 2, 0], phase[0], phase[1])
    return gap, rate - free_rate, second - free_second


@jit
def measure_gaps(s: float, y: Floats, f: Floats, stance: Floats, contacts: Floats, gaps: Floats) -> None:
    """Write the gap and its rates for every leg in stance into ``gaps``; ``f`` holds the rates of y."""
    lean, phase = turn(y), (math.sin(math.pi * s), math.cos(math.pi * s))
    for i in range(contacts.shape[0]):
        if contacts[i, DOWN] != 0.0:
            g, v, a = gap_rates(y, f, stance, i, lean, phase)
            gaps[i, 0] = g
            gaps[i, 1] = v
            gaps[i, 2] = a
