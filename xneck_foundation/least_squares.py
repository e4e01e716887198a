"""Linear least squares with the covariance of the estimate and its base parameters."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Estimate:
    """Estimated values (p,), covariance (p, p), residuals (n,) and their variance per degree of freedom."""

    value: Array
    covariance: Array
    residuals: Array
    variance: float
    condition: float
    """condition number of the Jacobian with its columns scaled to one"""
    base: tuple[int, ...]
    """indices of linearly independent columns by QR with pivoting (Gautier 1991): the base parameters, the best determined first"""

    @property
    def sigma(self) -> Array:
        """Standard deviations, shape (p,)."""
        return np.sqrt(np.diag(self.covariance))


def linear_least_squares(D: Array, y: Array) -> Estimate:
    """Least squares D v = y and its covariance sigma_rho^2 (D^T D)^-1 (64)-(66).

    D: shape (n, p), y: shape (n,), n > p. Parameters that the data do not determine get infinite variance, and the values of the
    shortest v.
    """
    scale = np.linalg.norm(D, axis=0)
    value, inverse, condition, dead, base = _solve(D, y, scale)
    residuals = y - D @ value
    variance = float(residuals @ residuals / max(len(y) - len(value) + dead.sum(), 1))
    covariance = variance * inverse
    covariance[dead, dead] = np.inf
    return Estimate(
        value=value,
        covariance=covariance,
        residuals=residuals,
        variance=variance,
        condition=condition,
        base=base,
    )


def _solve(D: Array, y: Array, scale: Array) -> tuple[Array, Array, float, NDArray[np.bool_], tuple[int, ...]]:
    """Scaled least squares by QR and SVD: value, (D^T D)^-1, condition number, undetermined columns, base columns."""
    live = scale > 0
    safe = np.where(live, scale, 1.0)
    q, r = np.linalg.qr(D / safe)
    u, s, vt = np.linalg.svd(r)
    keep = s > s[0] * max(D.shape) * np.finfo(float).eps if len(s) and s[0] > 0 else np.zeros(len(s), dtype=bool)
    # a direction in the null space leaves every parameter that takes part in it undetermined
    dead = ~live | (np.sum(vt[~keep] ** 2, axis=0) > 1e-12)
    weights = np.where(keep, 1 / np.where(keep, s, 1.0), 0.0)
    value = (vt.T * weights) @ (u.T @ (q.T @ y)) / safe
    inverse = (vt.T * weights**2) @ vt / np.outer(safe, safe)
    condition = float(s[0] / s[-1]) if len(s) and s[-1] > 0 else float("inf")
    # the stubs forget the order that pivoting returns
    _, pivoted, order = qr(r, mode="economic", pivoting=True)  # pyright: ignore[reportAssignmentType]
    pivots = np.abs(np.diag(pivoted))
    rank = int(np.sum(pivots > pivots[0] * max(D.shape) * np.finfo(float).eps)) if len(pivots) and pivots[0] > 0 else 0
    return value, inverse, condition, dead, tuple(int(i) for i in order[:rank])
