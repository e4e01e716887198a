"""Cables as measurements of the angles: what the motors say of the joints, with the elongation's law fitted along.

l_j(alpha) - l_j(0) + (rd/R) theta_j + x0_j = X_j beta_j + e_j, linearised about angles that are already near; e_j coloured (see
wander.py), so rows are filtered until what is left is white.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import block_diag

from mechanism.arm import Arm
from mechanism.cable_lengths import Z, lengths
from state_estimation.banded import add_to_band
from state_estimation.elongation_error import TAPS, Wander
from state_estimation.motion_prior import PARTS
from state_estimation.spline import SUPPORT, Knots

Array = NDArray[np.float64]

_STRETCH = 1 << 11
"""rows that are made at a time: all of them would be most of memory"""


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

    def part(self, rows: slice | NDArray[np.bool_]) -> "Cables":
        """Some of the rows."""
        return Cables(self.arm, self.time[rows], self.travel[rows], self.X[rows])

    def elongation(self, alpha: Array) -> Array:
        """(41), (K, M), m, at angles (K, N)."""
        return lengths(self.arm, alpha) - lengths(self.arm, np.zeros(self.arm.N)) + self.travel


@dataclass(frozen=True)
class CableEquations:
    """A stretch of whitened rows A_j c - y_j - X_j beta_j of each cable."""

    A: list[sparse.csr_array]
    """each (K, columns): the part of c that these rows rest on"""
    X: Array
    """(M, K, P)"""
    y: Array
    """(M, K)"""
    columns: slice
    """of c"""

    def right(self, y: Array) -> tuple[Array, Array]:
        """Right sides of that part of c, and of beta, where the rows measure y (M, K, ...)."""
        of_c = sum((A.T @ part for A, part in zip(self.A, y, strict=True)), 0.0)
        return np.asarray(of_c), np.concatenate([-X.T @ part for X, part in zip(self.X, y, strict=True)])

    def left(self, c: Array, beta: Array, y: Array) -> Array:
        """What c (n, ...) and beta (M P, ...) leave of y (M, K, ...)."""
        each = zip(self.A, self.X, y, np.split(beta, len(self.X)), strict=True)
        return np.stack([A @ c[self.columns] - part - X @ b for A, X, part, b in each])


@dataclass(frozen=True)
class Products:
    """What rows say of c and beta beside A^T A."""

    mixed: Array
    """A^T X, (n, M P)"""
    own: Array
    """X^T X, (M P, M P)"""
    of_c: Array
    """A^T y, (n,)"""
    of_beta: Array
    """-X^T y, (M P,)"""


def add_rows(band: Array, stretches: Iterable[CableEquations]) -> Products:
    """Adds A^T A to a lower band (w + 1, n), which has room for it."""
    mixed: Array | None = None
    own, of_beta = list[Array](), list[Array]()
    of_c = np.zeros(band.shape[1])
    for rows in stretches:
        m, _, p = rows.X.shape
        mixed = np.zeros((band.shape[1], m * p)) if mixed is None else mixed
        for j, (A, X) in enumerate(zip(rows.A, rows.X, strict=True)):
            add_to_band(band[:, rows.columns], sparse.csr_array(A.T @ A))
            mixed[rows.columns, j * p : (j + 1) * p] += A.T @ X
        own.append(np.asarray(block_diag(*(X.T @ X for X in rows.X))))
        more_c, more_beta = rows.right(rows.y)
        of_c[rows.columns] += more_c
        of_beta.append(more_beta)
    assert mixed is not None
    return Products(mixed, np.sum(own, axis=0), of_c, np.sum(of_beta, axis=0))


def cable_rows(
    cables: Cables, knots: Knots, alpha: Array, mean: Array, wander: list[Wander]
) -> Iterator[CableEquations]:
    """Linearised about angles (K, N); coefficients c are those of alpha - mean, joints side by side at each knot."""
    for begin in range(0, len(cables.time), _STRETCH):
        # later stretches are whitened by what was before them
        some = slice(max(0, begin - TAPS), begin + _STRETCH)
        part = cables.part(some)
        whiten = [_whitener(w, len(part.time), first=begin == 0) for w in wander]
        yield _rows(part, knots, alpha[some], mean, whiten)


def _rows(cables: Cables, knots: Knots, alpha: Array, mean: Array, whiten: list[sparse.csr_array]) -> CableEquations:
    count, wide = len(cables.time), cables.arm.N * PARTS
    first, weights = knots.rows(cables.time)
    span = int(first[-1] - first[0]) + SUPPORT
    columns = ((first - first[0])[:, None] + np.arange(SUPPORT))[:, :, None] * wide + np.arange(wide)
    starts = SUPPORT * wide * np.arange(count + 1)
    slope = -Z(cables.arm, alpha)  # (K, N, M)
    y = np.einsum("tij,ti->tj", slope, alpha - mean) - cables.elongation(alpha)
    A, X, measured = [], [], []
    for j, one in enumerate(whiten):
        values = np.repeat((weights[:, :, None] * slope[:, None, :, j]).reshape(-1), PARTS)
        A.append(one @ sparse.csr_array((values, columns.ravel(), starts), shape=(count, span * wide)))
        X.append(one @ cables.X[:, j])
        measured.append(one @ y[:, j])
    begin = int(first[0]) * wide
    return CableEquations(A, np.stack(X), np.stack(measured), slice(begin, begin + span * wide))


def cable_angles(cables: Cables, alpha: Array, beta: Array, wander: list[Wander]) -> tuple[Array, Array]:
    """Angles (K, N) as the cables alone tell them near `alpha`, and their variances; where M >= N."""
    slope, weights = -Z(cables.arm, alpha), np.array([1 / w.variance for w in wander])
    left = cables.elongation(alpha) - np.einsum("tjp,jp->tj", cables.X, beta)
    covariance = np.linalg.inv(np.einsum("tij,j,tkj->tik", slope, weights, slope))
    step = np.einsum("tik,tkj,j,tj->ti", covariance, slope, weights, left)
    return alpha - step, np.diagonal(covariance, axis1=1, axis2=2)


def _whitener(wander: Wander, count: int, first: bool) -> sparse.csr_array:
    """Of `count` rows all if they are the first, else those that have enough before them."""
    taps, sigma = wander.whitener()
    late = len(taps) - 1
    full = [sparse.eye_array(count - late, count, k=k) * tap for k, tap in enumerate(taps[::-1])]
    body = sparse.csr_array(sum(full[1:], full[0]))
    if not first:
        return body
    # the first rows have too little before them: each is believed as if it were alone, and all of them as one
    head = sparse.eye_array(late, count) / (sigma * np.sqrt(late))
    return sparse.csr_array(sparse.vstack([head, body]))
