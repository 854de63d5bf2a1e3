"""Stability of a fixed point of a return map, from its Jacobian."""

import numpy as np
from numpy.typing import NDArray


def multipliers(step_jacobian: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Floquet multipliers of a stride, largest first, from the Jacobian of the mirrored one-step map.

    A stride is two steps that mirror each other, so that they are the squares of its eigenvalues.

    Parameters
    ----------
    step_jacobian
        ``(n, n)``, of `legspring.returnmap.complete_map`.

    Returns
    -------
    ndarray
        ``(n,)``, dimensionless.
    """
    squares = np.linalg.eigvals(step_jacobian).astype(complex) ** 2
    return squares[np.argsort(-np.abs(squares), kind="stable")]


def largest_magnitude(jacobian: NDArray[np.float64]) -> float:
    """Largest magnitude of an eigenvalue; below 1 a fixed point is stable."""
    return float(np.max(np.abs(np.linalg.eigvals(jacobian))))
