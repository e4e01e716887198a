"""Cables as measurements of the angles: what the motors say of the joints, with the elongation's law fitted along.

l_j(alpha) - l_j(0) + (rd/R) theta_j + x0_j = X_j beta_j + e_j, linearised about angles that are already near; e_j coloured (see
wander.py), so rows are filtered until what is left is white.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from identification.banded import add_to_band
from identification.mixture import PARTS
from identification.spline import SUPPORT, Knots
from identification.wander import Wander
from mechanism.arm import Arm
from mechanism.cable_lengths import Z, lengths

Array = NDArray[np.float64]

_STRETCH = 1 << 11
"""rows whose products are made at a time: those of all would be the most that there is in memory"""


@dataclass(frozen=True)
class Cables:
    """What all rows at even times share."""

    arm: Arm
    time: Array
    """(K,), s"""
    travel: Array
    """(rd/R) theta + x0, (K, M), m"""
    X: Array
    """(K, M, P)"""

    @property
    def step(self) -> float:
        return float(self.time[1] - self.time[0])

    def elongation(self, alpha: Array) -> Array:
        """(41), (K, M), m, at angles (K, N)."""
        return lengths(self.arm, alpha) - lengths(self.arm, np.zeros(self.arm.N)) + self.travel


@dataclass(frozen=True)
class Rows:
    """Whitened rows A_j c - y_j - X_j beta_j of each cable, and their normal equations for all c and beta."""

    A: list[sparse.csr_array]
    X: list[Array]
    y: list[Array]
    normal: Array
    """lower band, of those for c"""
    mixed: Array
    own: Array

    def right(self, y: list[Array]) -> tuple[Array, Array]:
        """Right sides of c and of beta where the rows measure y, each (K, ...)."""
        of_c = sum((A.T @ part for A, part in zip(self.A, y, strict=True)), 0.0)
        return np.asarray(of_c), np.concatenate([-X.T @ part for X, part in zip(self.X, y, strict=True)])

    def left(self, c: Array, beta: Array, y: list[Array]) -> list[Array]:
        """What c (n, ...) and beta (M P, ...) leave of them."""
        each = np.split(beta, len(self.X))
        return [A @ c - part - X @ b for A, X, part, b in zip(self.A, self.X, y, each, strict=True)]


def cable_rows(cables: Cables, knots: Knots, alpha: Array, mean: Array, wander: list[Wander], width: int) -> Rows:
    """Rows linearised about angles (K, N); coefficients are those of alpha - mean, joints side by side at each knot.

    width: of the band within which their normal equations lie."""
    n_joints, m = cables.arm.N, cables.arm.M
    count, p = len(cables.time), cables.X.shape[2]
    wide = n_joints * PARTS
    size = knots.count * wide
    first, weights = knots.rows(cables.time)
    columns = ((first[:, None] + np.arange(SUPPORT))[:, :, None] * wide + np.arange(wide)).reshape(count, -1)
    starts = columns.shape[1] * np.arange(count + 1)
    slope = -Z(cables.arm, alpha)  # (K, N, M)
    y = np.einsum("tij,ti->tj", slope, alpha - mean) - cables.elongation(alpha)
    normal = np.zeros((width + 1, size))
    mixed, own = np.zeros((size, m * p)), np.zeros((m * p, m * p))
    every, regressors, measured = [], [], []
    for j in range(m):
        values = np.repeat((weights[:, :, None] * slope[:, None, :, j]).reshape(-1), PARTS)
        whiten = _whitener(wander[j], count)
        A = whiten @ sparse.csr_array((values, columns.ravel(), starts), shape=(count, size))
        X = whiten @ cables.X[:, j]
        part = slice(j * p, (j + 1) * p)
        for begin in range(0, count, _STRETCH):
            some = A[begin : begin + _STRETCH]
            add_to_band(normal, sparse.csr_array(some.T @ some))
        mixed[:, part], own[part, part] = A.T @ X, X.T @ X
        every.append(A)
        regressors.append(X)
        measured.append(whiten @ y[:, j])
    return Rows(every, regressors, measured, normal, mixed, own)


def cable_angles(cables: Cables, alpha: Array, beta: Array, wander: list[Wander]) -> tuple[Array, Array]:
    """Angles (K, N) as the cables alone tell them near `alpha`, and their variances; where M >= N."""
    slope, weights = -Z(cables.arm, alpha), np.array([1 / w.variance for w in wander])
    left = cables.elongation(alpha) - np.einsum("tjp,jp->tj", cables.X, beta)
    covariance = np.linalg.inv(np.einsum("tij,j,tkj->tik", slope, weights, slope))
    step = np.einsum("tik,tkj,j,tj->ti", covariance, slope, weights, left)
    return alpha - step, np.diagonal(covariance, axis1=1, axis2=2)


def _whitener(wander: Wander, count: int) -> sparse.csr_array:
    taps, sigma = wander.whitener()
    late = len(taps) - 1
    full = [sparse.eye_array(count - late, count, k=k) * tap for k, tap in enumerate(taps[::-1])]
    body = sum(full[1:], full[0])
    # the first rows have too little before them: each is believed as if it were alone, and all of them as one
    head = sparse.eye_array(late, count) / (sigma * np.sqrt(late))
    return sparse.csr_array(sparse.vstack([head, body]))
