"""Least squares, linear and nonlinear, with the covariance of what is estimated: the routine that every fit shares."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr
from scipy.optimize import least_squares

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Estimate:
    """Result of a fit: values (p,), covariance (p, p), residuals (n,) and their variance per degree of freedom."""

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

    @property
    def correlation(self) -> Array:
        """Correlations of the estimates, shape (p, p)."""
        return self.covariance / np.outer(self.sigma, self.sigma)


def linear_least_squares(D: Array, y: Array) -> Estimate:
    """Least squares D v = y and its covariance sigma_rho^2 (D^T D)^-1 (64)-(66).

    D: shape (n, p), y: shape (n,), n > p. A column that the others determine gets infinite
    variance, and the value of the shortest v.
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


def nonlinear(
    residuals: Callable[[Array], Array],
    start: Array,
    known_sigma: bool = False,
    jacobian: Callable[[Array], Array] | None = None,
    scale: Array | float | str = 1.0,
    loss: str = "linear",
) -> Estimate:
    """Gauss-Newton type least squares from `start`, shape (p,).

    residuals: (p,) -> (n,), already divided by their standard deviation where `known_sigma`; then the covariance is not
    scaled with the residuals' variance. `scale` (its x_scale) and `loss` as in scipy.optimize.least_squares.
    """
    # Levenberg-Marquardt by QR: several times faster on tall problems than the trust region's SVD, which robust losses need
    method = "lm" if loss == "linear" else "trf"
    derivative: dict[str, Any] = {"jac": jacobian} if jacobian else {}
    solution = least_squares(residuals, start, x_scale=scale, loss=loss, method=method, **derivative)  # type: ignore[arg-type]
    J, value, residuals_after = np.asarray(solution.jac), solution.x, solution.fun
    _, inverse, condition, dead, base = _solve(J, residuals_after, np.linalg.norm(J, axis=0))
    variance = float(residuals_after @ residuals_after / max(len(residuals_after) - len(value), 1))
    covariance = inverse * (1.0 if known_sigma else variance)
    covariance[dead, dead] = np.inf
    return Estimate(
        value=value,
        covariance=covariance,
        residuals=residuals_after,
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
    # a direction that the data do not reach leaves every parameter that takes part in it undetermined
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
