"""The best actuation of one family at one slope and heading, as a nonlinear programme.

All at once: actuation u and unknowns z of the gait are varied together, with the conditions of a gait as equations, so
that the search passes folds, where two gaits meet, without noticing. The fixed point at a slightly larger heading,
which must exist, has unknowns and equations of its own. What is to be small is a bound t of the eigenvalues (or cost)
plus what the soft constraints are violated by, each a variable >= 0; with that, all functions are smooth
where the maximum of moduli of eigenvalues is not.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import minimize

from legspring.constraints import SOFT
from legspring.kernel.circle import characteristic, inside
from legspring.kernel.walker import Floats
from legspring.objective import Objective

DIFFERENCE = 1e-6
"""Step of the differences of exact Jacobians."""
ITERATIONS = 20
"""Most iterations; to start again from where they end is quicker than to go on."""
PRECISION = 1e-6
SLOWEST, FASTEST = 0.5, 2.0
"""Initial speed, in units of the desired one."""
LATEST_OF_ALL = 2.5
"""Largest phase to be looked at, rad."""
WORST = 3.0
"""Largest objective, and part of it, to be looked at."""
WORST_ANGLE = -90.0
"""What counts as a leg's angle, deg, where it has none."""
SMALLEST = 5e-4
"""Bound of eigenvalues below which there is no point in going."""
CLEARANCE = 1.002
CORRECTIONS, PRECISE, LONGEST_CORRECTION = 8, 1e-9, 0.3
"""How a search's end is moved onto the equations: most steps, residual to reach, longest step."""
REASONS = {
    0: "converged",
    4: "the constraints leave no way to go",
    8: "no way further down",
    9: "iteration limit reached",
}
"""Why SLSQP stops."""
NEGLIGIBLE = 1e-6
"""Length of a correction along which no slope is worth its price."""
NOWHERE = 1e3
"""Violation of all constraints where there is nothing to evaluate."""


@dataclass
class Point:
    """The functions of the programme at one point, and, once somebody asks, their derivatives by actuation and z.

    Derivatives are differences of the functions, which are made of exact Jacobians themselves; a step of the search
    stays on the gaits but for Newton's correction, so that slopes in other directions do not matter.
    """

    programme: "Programme"
    x: Floats
    left: Floats
    by: Floats
    angles: Floats
    measure: Floats

    @cached_property
    def slopes(self) -> tuple[Floats, Floats]:
        """Derivatives of angles and measure."""
        along = steps_taken(self.left[0], self.by[0])
        angles, measure = self.programme.measure(self.x + DIFFERENCE * along.T)
        rows = np.hstack([angles - self.angles, measure - self.measure]) / DIFFERENCE
        # Next to where there is nothing to evaluate, any slope will do.
        rows[np.isnan(rows)] = 0.0
        by_x = rows.T @ along.T
        return by_x[: len(self.angles)], by_x[len(self.angles) :]


class Programme:
    """The nonlinear programme of one objective.

    Variables: actuation u (units of nominal lengths), unknowns z of the gait, unknowns of the one beside, what is to be
    small (eigenvalue or cost), and an amount for each soft constraint, in the units of the objective.

    Parameters
    ----------
    objective
        What is to be small.
    limit
        Bound of the eigenvalue magnitudes where the objective is efficiency; None for none.
    """

    def __init__(self, objective: Objective, limit: float | None = None) -> None:
        self.objective, self.limit = objective, limit
        self.constraints, heading = objective.constraints, objective.actuated.heading
        # A little beyond what is asked for, so that a fold is kept clear of.
        self.headings = heading, heading + CLEARANCE * (objective.beside.heading - heading)
        p = self.pairs = len(objective.actuated.lengths)
        m = 1 + p
        self.u, self.z, self.beside = slice(0, p), slice(p, p + m), slice(p + m, p + 2 * m)
        self.t, self.slack, self.size = p + 2 * m, slice(p + 2 * m + 1, 4 * p + 2 * m + 1), 4 * p + 2 * m + 1
        low, high = np.full(self.size, -np.inf), np.full(self.size, np.inf)
        low[self.u], high[self.u] = self.constraints.actuation
        low[[self.z.start, self.beside.start]] = SLOWEST
        low[self.z.start + 1 : self.z.stop] = self.constraints.phase[0]
        high[[self.z.start, self.beside.start]] = FASTEST
        high[self.z.start + 1 : self.z.stop] = LATEST_OF_ALL
        high[self.t :] = WORST
        low[self.t], low[self.slack] = SMALLEST, 0.0
        self.bounds = np.column_stack([low, high])
        self._at: Floats | None = None
        self._point: Point | None = None
        self.evaluations = 0

    def measure(self, points: Floats) -> tuple[Floats, Floats]:
        """Angles (deg), and costs or characteristic polynomials of the map, at ``(N, P + n)``; nan where undefined."""
        actuated, objective = self.objective.actuated, self.objective
        measures = []
        if objective.goal == "efficiency":
            seen = actuated.measure(points, "cost")
            measures.append(seen.cost[:, None])
        if objective.goal == "stability" or self.limit is not None:
            seen = actuated.measure(points, objective.of)
            measures.append(characteristic(seen.jacobians))
        return seen.angles.reshape(len(points), -1), np.hstack(measures)

    def within(self, measure: Floats, t: float) -> tuple[Floats, Floats, Floats]:
        """Return what must not be negative for the measure to be bounded by t, and its derivatives by both."""
        efficiency = self.objective.goal == "efficiency"
        if efficiency and self.limit is None:
            return t - measure, -np.ones((1, 1)), np.ones(1)
        bound = self.limit if efficiency and self.limit is not None else t
        # The complete map is that of a step, the bound that of a stride.
        radius, rate = (bound, 1.0) if self.objective.of == "reduced" else (math.sqrt(bound), 0.5 / math.sqrt(bound))
        values, by_c, by_radius = inside(measure[1:] if efficiency else measure, radius)
        if not efficiency:
            return values, by_c, by_radius * rate
        by_measure = np.zeros((4, len(measure)))
        by_measure[0, 0], by_measure[1:, 1:] = -1.0, by_c
        return np.append(t - measure[0], values), by_measure, np.array([1.0, 0.0, 0.0, 0.0])

    def point(self, x: Floats) -> Point | None:
        """All functions at a point; None where they cannot be had."""
        if self._at is None or not np.array_equal(x, self._at):
            self._at, self._point = x.copy(), self._evaluate(x)
            self.evaluations += 1
        return self._point

    def _evaluate(self, x: Floats) -> Point | None:
        u, z = x[self.u], x[self.z]
        both = self.objective.actuated.conditions(u, np.array([z, x[self.beside]]), self.headings)
        angles, measure = self.measure(x[None, : self.z.stop])
        if both is None or np.any(np.isnan(measure)):
            return None
        return Point(self, x[: self.z.stop].copy(), *both, np.nan_to_num(angles[0], nan=WORST_ANGLE), measure[0])

    def equations(self, x: Floats) -> Floats:
        """Return what must be zero: conditions of the gait, and of the one beside."""
        point = self.point(x)
        rows = 2 * (1 + self.pairs)
        return np.full(rows, NOWHERE) if point is None else point.left.ravel()

    def equations_by(self, x: Floats) -> Floats:
        """Return the derivatives of the equations."""
        point, p = self.point(x), self.pairs
        by = np.zeros((2 * (1 + p), self.size))
        if point is not None:
            by[: 1 + p, : self.z.stop] = point.by[0]
            by[1 + p :, self.u], by[1 + p :, self.beside] = point.by[1][:, :p], point.by[1][:, p:]
        return by

    def margins(self, x: Floats) -> Floats:
        """Return what must not be negative: room in the soft constraints, and in the bound of what is to be small."""
        point = self.point(x)
        if point is None:
            return np.full(3 * self.pairs + self._bounded, -NOWHERE)
        room = x[self.slack] - self.violations(x, point)
        return np.concatenate([room, self.within(point.measure, x[self.t])[0]])

    def margins_by(self, x: Floats) -> Floats:
        """Return the derivatives of the margins."""
        point, p, n = self.point(x), self.pairs, self.z.stop
        by = np.zeros((3 * p + self._bounded, self.size))
        if point is None:
            return by
        angles_by, measure_by = point.slopes
        _, by_measure, by_t = self.within(point.measure, x[self.t])
        by[: 3 * p, self.slack] = np.eye(3 * p)
        late, *clear = self.constraints.rates[SOFT]
        by[:p, self.z.start + 1 : n] = -late * np.eye(p)
        by[p : 3 * p, :n] = np.tile(clear, p)[:, None] * angles_by
        by[3 * p :, self.t], by[3 * p :, :n] = by_t, by_measure @ measure_by
        return by

    def violations(self, x: Floats, point: Point) -> Floats:
        """Return how much each soft constraint adds to the objective (negative: it is kept): phases, then angles."""
        angles = point.angles.reshape(-1, 2)
        return self.constraints.soft(self.constraints.excess(x[self.u], x[self.z][1:], angles, signed=True))

    @property
    def _bounded(self) -> int:
        """Number of margins that bound the measure."""
        return 3 if self.objective.goal == "stability" else 1 if self.limit is None else 4

    def start(self, actuation: Floats, z: Floats, beside: Floats | None = None) -> Floats:
        """Return variables to start from: a gait or what is near one, and, if known, the one beside."""
        x = np.zeros(self.size)
        x[self.u], x[self.z], x[self.beside] = actuation, z, z if beside is None else beside
        point = self._evaluate(x)
        if point is None:
            x[self.t :] = 1.0
        else:
            x[self.slack] = self.violations(x, point)
            x[self.t] = point.measure[0] if self.objective.goal == "efficiency" else self.bound(point.measure)
        return np.clip(x, self.bounds[:, 0], self.bounds[:, 1])

    def restored(self, x: Floats) -> Floats:
        """Return the point near x that fulfils the equations: at folds, what they are short of decides."""
        x, n = x.copy(), self.beside.stop
        low, high = self.bounds[:n].T
        for _ in range(CORRECTIONS):
            left = self.equations(x)
            if not PRECISE < np.max(np.abs(left)) < NOWHERE:
                break
            by = self.equations_by(x)[:, :n]
            # The least change of what is not at its bound already.
            free = (low < x[:n]) & (x[:n] < high)
            move = -np.linalg.lstsq(by[:, free], left, rcond=None)[0]
            x[:n][free] += move * min(1.0, LONGEST_CORRECTION / np.max(np.abs(move)))
            x[:n] = np.clip(x[:n], low, high)
        return x

    def bound(self, c: Floats) -> float:
        """Largest magnitude of the eigenvalues of a stride, from the characteristic polynomial."""
        radius = float(np.max(np.abs(np.roots([1.0, *c]))))
        return radius if self.objective.of == "reduced" else radius**2

    def minimise(self, x: Floats, most: float | None = None, iterations: int = ITERATIONS) -> tuple[Floats, str]:
        """Minimise what is to be small, or, where it need only be at most so much, the actuation.

        Returns
        -------
        x, message
            Where the search ended, moved onto the equations, and why.
        """
        total = np.zeros(self.size)
        total[self.t :] = 1.0
        constraints = [
            {"type": "eq", "fun": self.equations, "jac": self.equations_by},
            {"type": "ineq", "fun": self.margins, "jac": self.margins_by},
        ]
        if most is not None:
            constraints.append({"type": "ineq", "fun": lambda x: most - total @ x, "jac": lambda x: -total})

        def objective(x: Floats) -> tuple[float, Floats]:
            if most is None:
                return float(total @ x), total
            gradient = np.zeros(self.size)
            gradient[self.u] = 2.0 * x[self.u]
            return float(np.sum(x[self.u] ** 2)), gradient

        found = minimize(
            objective,
            x,
            jac=True,
            method="SLSQP",
            bounds=self.bounds,
            constraints=constraints,
            options={"maxiter": iterations, "ftol": PRECISION},
        )
        return self.restored(found.x), REASONS.get(found.status, str(found.message))


def steps_taken(residual: Floats, jacobian: Floats) -> Floats:
    """Orthonormal directions of all x with J x = -c r, for any c: the null space of J, and Newton's correction."""
    rows = len(residual)
    left, sizes, right = np.linalg.svd(jacobian)
    correction = -right[:rows].T @ ((left.T @ residual) / sizes)
    length = np.linalg.norm(correction)
    along = right[rows:].T
    return along if not length > NEGLIGIBLE else np.column_stack([along, correction / length])
