"""Stability of a fixed point of a return map, from its Jacobian."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray


def multipliers(step_jacobian: NDArray[np.float64], mirrored: bool = True) -> NDArray[np.complex128]:
    """Floquet multipliers of a stride, largest first, from the Jacobian of the one-step map.

    Where steps mirror each other a stride is two of them: multipliers are the squares of the eigenvalues.

    Parameters
    ----------
    step_jacobian
        ``(n, n)``, of `legspring.returnmap.complete_map`.
    mirrored
        Whether steps mirror each other; else a stride is one step.

    Returns
    -------
    ndarray
        ``(n,)``, dimensionless.
    """
    return eigenvalues(step_jacobian) ** (2 if mirrored else 1)


def eigenvalues(jacobian: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Eigenvalues of a Jacobian, ``(n,)``, largest first."""
    values = np.linalg.eigvals(jacobian).astype(complex)
    return values[np.argsort(-np.abs(values), kind="stable")]


def without(values: NDArray[np.complex128], kept: Iterable[float]) -> NDArray[np.complex128]:
    """Return multipliers without those, one each, that are what they are because something is conserved."""
    for value in kept:
        values = np.delete(values, int(np.argmin(np.abs(values - value))))
    return values


def largest_magnitude(jacobian: NDArray[np.float64]) -> float:
    """Largest magnitude of an eigenvalue; below 1 a fixed point is stable."""
    return float(np.max(np.abs(np.linalg.eigvals(jacobian))))
