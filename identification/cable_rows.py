"""Cables as measurements of the angles: what the motors say of the joints, with the elongation's law fitted along.

l_j(alpha) - l_j(0) + (rd/R) theta_j + x0_j = X_j beta_j + e_j, linearised about angles that are already near; e_j coloured (see
force_law.py), so rows are filtered until what is left is white.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from identification.force_law import Wander
from identification.mixture import PARTS
from identification.spline import SUPPORT, Knots
from mechanism.arm import Arm
from mechanism.cable_lengths import Z, lengths

Array = NDArray[np.float64]


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

    def elongation(self, alpha: Array) -> Array:
        """(41), (K, M), m, at angles (K, N)."""
        return lengths(self.arm, alpha) - lengths(self.arm, np.zeros(self.arm.N)) + self.travel


@dataclass(frozen=True)
class Rows:
    """Normal equations of the cables' rows for coefficients c and regressors' factors beta: of |A c - y - X beta|^2."""

    normal: sparse.csr_array
    right: Array
    mixed: Array
    own: Array
    own_right: Array


def cable_rows(cables: Cables, knots: Knots, alpha: Array, mean: Array, wander: list[Wander]) -> Rows:
    """Rows linearised about angles (K, N); coefficients are those of alpha - mean, joints side by side at each knot."""
    n_joints, m = cables.arm.N, cables.arm.M
    count, p = len(cables.time), cables.X.shape[2]
    wide = n_joints * PARTS
    size = knots.count * wide
    first, weights = knots.rows(cables.time)
    columns = ((first[:, None] + np.arange(SUPPORT))[:, :, None] * wide + np.arange(wide)).reshape(count, -1)
    starts = columns.shape[1] * np.arange(count + 1)
    slope = -Z(cables.arm, alpha)  # (K, N, M)
    y = np.einsum("tij,ti->tj", slope, alpha - mean) - cables.elongation(alpha)
    normal: sparse.csr_array = sparse.csr_array((size, size))
    right, mixed = np.zeros(size), np.zeros((size, m * p))
    own, own_right = np.zeros((m * p, m * p)), np.zeros(m * p)
    step = float(cables.time[1] - cables.time[0])
    for j in range(m):
        values = np.repeat((weights[:, :, None] * slope[:, None, :, j]).reshape(-1), PARTS)
        whiten = _whitener(wander[j], step, count)
        A = whiten @ sparse.csr_array((values, columns.ravel(), starts), shape=(count, size))
        yw, Xw = whiten @ y[:, j], whiten @ cables.X[:, j]
        part = slice(j * p, (j + 1) * p)
        normal = normal + A.T @ A
        right += A.T @ yw
        mixed[:, part] = A.T @ Xw
        own[part, part] = Xw.T @ Xw
        own_right[part] = -Xw.T @ yw
    return Rows(normal, right, mixed, own, own_right)


def cable_angles(cables: Cables, alpha: Array, beta: Array, wander: list[Wander]) -> tuple[Array, Array]:
    """Angles (K, N) as the cables alone tell them near `alpha`, and their variances; where M >= N."""
    slope, weights = -Z(cables.arm, alpha), np.array([1 / (2 * w.fast**2 + w.slow**2) for w in wander])
    left = cables.elongation(alpha) - np.einsum("tjp,jp->tj", cables.X, beta)
    covariance = np.linalg.inv(np.einsum("tij,j,tkj->tik", slope, weights, slope))
    step = np.einsum("tik,tkj,j,tj->ti", covariance, slope, weights, left)
    return alpha - step, np.diagonal(covariance, axis1=1, axis2=2)


def disagreement(cables: Cables, alpha: Array, beta: Array, used: NDArray[np.bool_]) -> Array:
    """What more than N cables contradict each other in, however the arm stands, as each one's share, (M,), m RMS.

    used: (M,). A cable's error is taken to grow with what its elongation varies.
    """
    explained = np.einsum("tjp,jp->tj", cables.X, beta)
    size = explained.std(axis=0)
    left = (cables.elongation(alpha) - explained)[:, used]
    # combinations of cables that no angle moves
    blind = np.linalg.svd(Z(cables.arm, alpha)[:, :, used])[2][:, cables.arm.N :, :]
    each = np.einsum("tqj,tj->tq", blind, left) / np.sqrt(np.einsum("tqj,j->tq", blind**2, size[used] ** 2))
    return size * np.sqrt(np.mean(each**2))


def _whitener(wander: Wander, step: float, count: int) -> sparse.csr_array:
    taps, sigma = wander.whitener(step)
    late = len(taps) - 1
    full = [sparse.eye_array(count - late, count, k=k) * tap for k, tap in enumerate(taps[::-1])]
    body = sum(full[1:], full[0])
    # the first rows have too little before them: each is believed as if it were alone, and all of them as one
    head = sparse.eye_array(late, count) / (sigma * np.sqrt(late))
    return sparse.csr_array(sparse.vstack([head, body]))
