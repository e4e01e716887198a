"""Cables as measurements of the joint angles, with the regressors of their elongation as nuisances.

l_j(alpha) - l_j(0) + (rd/R) theta_j + x0_j = X_j beta_j + e_j, linearised about angles that are near already. The error e_j is
coloured (see elongation_error_spectrum), so the rows are filtered until their errors are white.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import block_diag

from mechanism.arm import Arm
from mechanism.cable_lengths import Z, lengths
from state_estimation.banded import add_to_band
from state_estimation.elongation_error_spectrum import TAPS, ErrorSpectrum
from state_estimation.elongation_law import ElongationLaw
from state_estimation.elongation_regressors import CUTOFF_HZ
from state_estimation.motion_prior import PARTS
from state_estimation.smoother import BANDWIDTH
from state_estimation.spline import SUPPORT, Knots

Array = NDArray[np.float64]

CABLE_HZ = 2 * CUTOFF_HZ
"""Hz: rate of the cables' equations; the regressors hold nothing faster than CUTOFF_HZ"""
_ROWS_AT_ONCE = 1 << 11
"""rows that are made together: those of a whole recording would fill the memory"""


@dataclass(frozen=True)
class CableMeasurements:
    """What motors tell at even times, before it is linearised."""

    law: ElongationLaw
    time: Array
    """(K,), s"""
    travel: Array
    """(rd/R) theta + x0, (K, M), m"""
    X: Array
    """the law's regressors of each cable's elongation, (K, M, P), and what they were divided by, (M, P)"""
    size: Array

    @property
    def arm(self) -> Arm:
        """The law's."""
        return self.law.arm

    def part(self, rows: slice | NDArray[np.bool_]) -> "CableMeasurements":
        """Some of the rows."""
        return replace(self, time=self.time[rows], travel=self.travel[rows], X=self.X[rows])

    def with_law(self, law: ElongationLaw) -> "CableMeasurements":
        """The same with the regressors of another law."""
        X, size = law.sampled(self.time)
        return replace(self, law=law, X=X, size=size)

    def factors(self, beta: Array) -> Array:
        """Factors (M, P) of the regressors in their units, for beta (M P,) of X."""
        return beta.reshape(self.size.shape) / self.size

    def elongation(self, alpha: Array) -> Array:
        """(41), (K, M), m, at angles (K, N)."""
        return lengths(self.arm, alpha) - lengths(self.arm, np.zeros(self.arm.N)) + self.travel

    def linearisation_error(self, near: Array, alpha: Array) -> float:
        """By how much lengths linearised about angles `near` (K, N) err at angles alpha (K, N): RMS of the worst cable, m."""
        change = lengths(self.arm, alpha) - lengths(self.arm, near)
        linear = -np.einsum("tij,ti->tj", Z(self.arm, near), alpha - near)
        return float(np.max(np.sqrt(np.mean((change - linear) ** 2, axis=0))))


@dataclass(frozen=True)
class CableEquations:
    """Whitened rows A_j c - y_j - X_j beta_j of each cable over some of the times."""

    A: list[sparse.csr_array]
    """of each cable, (K, number of knots times N): it multiplies the sums of the parts' coefficients that these rows rest on"""
    X: Array
    """(M, K, P)"""
    y: Array
    """(M, K)"""
    columns: slice
    """of all coefficients c, those that these rows rest on"""

    def right_sides(self, y: Array) -> tuple[Array, Array]:
        """Right sides of the normal equations, of c[columns] and of beta, where the rows measure y (M, K, ...)."""
        A_y = np.asarray(sum((A.T @ part for A, part in zip(self.A, y, strict=True)), 0.0))
        return np.repeat(A_y, PARTS, axis=0), np.concatenate([-X.T @ part for X, part in zip(self.X, y, strict=True)])

    def residuals(self, c: Array, beta: Array, y: Array) -> Array:
        """A c - y - X beta of each cable, (M, K, ...), for c (n, ...), beta (M P, ...) and measurements y (M, K, ...)."""
        cables = zip(self.A, self.X, y, np.split(beta, len(self.X)), strict=True)
        of_knots = c[self.columns]
        angles = of_knots.reshape(-1, PARTS, *of_knots.shape[1:]).sum(axis=1)
        return np.stack([A @ angles - part - X @ b for A, X, part, b in cables])


@dataclass(frozen=True)
class NormalProducts:
    """Blocks of the rows' normal equations for (c, beta), beside A^T A."""

    A_X: Array
    """A^T X, (n, M P)"""
    X_X: Array
    """X^T X, (M P, M P)"""
    A_y: Array
    """A^T y, (n,)"""
    X_y: Array
    """-X^T y, (M P,)"""


def cable_measurements(law: ElongationLaw, time: Array, theta: Array) -> CableMeasurements:
    """Of motor angles (K, M), rad, at even times (K,), s."""
    X, size = law.sampled(time)
    return CableMeasurements(law, time, law.arm.drum * theta + law.arm.x0, X, size)


def rows_reach(step: float) -> int:
    """Knots, `step` (s) apart, over which whitened rows couple coefficients."""
    return max(BANDWIDTH, SUPPORT - 1 + int(np.ceil(TAPS / CABLE_HZ / step)))


def add_rows(band: Array, equations: Iterable[CableEquations]) -> NormalProducts:
    """Adds A^T A of all equations to a lower band (w + 1, n), which has room for it, and returns the other products."""
    A_X: Array | None = None
    X_X, X_y = list[Array](), list[Array]()
    A_y = np.zeros(band.shape[1])
    for rows in equations:
        m, _, p = rows.X.shape
        A_X = np.zeros((band.shape[1], m * p)) if A_X is None else A_X
        for j, (A, X) in enumerate(zip(rows.A, rows.X, strict=True)):
            A_X[rows.columns, j * p : (j + 1) * p] += np.repeat(A.T @ X, PARTS, axis=0)
        all_rows = sparse.vstack(rows.A, format="csr")
        add_to_band(band[:, rows.columns], sparse.csr_array(all_rows.T @ all_rows), PARTS)
        X_X.append(np.asarray(block_diag(*(X.T @ X for X in rows.X))))
        part_A_y, part_X_y = rows.right_sides(rows.y)
        A_y[rows.columns] += part_A_y
        X_y.append(part_X_y)
    assert A_X is not None
    return NormalProducts(A_X, np.sum(X_X, axis=0), A_y, np.sum(X_y, axis=0))


def cable_rows(
    cables: CableMeasurements, knots: Knots, alpha: Array, mean: Array, spectra: list[ErrorSpectrum]
) -> Iterator[CableEquations]:
    """Whitened equations linearised about angles (K, N), some rows at a time.

    Their coefficients c are those of alpha - mean, joints side by side at each knot; `spectra` are of the cables' errors.
    """
    for begin in range(0, len(cables.time), _ROWS_AT_ONCE):
        # all but the first rows are whitened by the rows before them
        rows = slice(max(0, begin - TAPS), begin + _ROWS_AT_ONCE)
        part = cables.part(rows)
        whiteners = [_whitener(s, len(part.time), first=begin == 0) for s in spectra]
        yield _whitened_rows(part, knots, alpha[rows], mean, whiteners)


def _whitened_rows(
    cables: CableMeasurements, knots: Knots, alpha: Array, mean: Array, whiteners: list[sparse.csr_array]
) -> CableEquations:
    count, joints = len(cables.time), cables.arm.N
    first, weights = knots.rows(cables.time)
    span = int(first[-1] - first[0]) + SUPPORT
    columns = ((first - first[0])[:, None] + np.arange(SUPPORT))[:, :, None] * joints + np.arange(joints)
    starts = SUPPORT * joints * np.arange(count + 1)
    slope = -Z(cables.arm, alpha)  # (K, N, M)
    y = np.einsum("tij,ti->tj", slope, alpha - mean) - cables.elongation(alpha)
    A, X, measured = [], [], []
    for j, whitener in enumerate(whiteners):
        values = (weights[:, :, None] * slope[:, None, :, j]).reshape(-1)
        A.append(whitener @ sparse.csr_array((values, columns.ravel(), starts), shape=(count, span * joints)))
        X.append(whitener @ cables.X[:, j])
        measured.append(whitener @ y[:, j])
    per_knot = joints * PARTS
    begin = int(first[0]) * per_knot
    return CableEquations(A, np.stack(X), np.stack(measured), slice(begin, begin + span * per_knot))


def _whitener(spectrum: ErrorSpectrum, count: int, first: bool) -> sparse.csr_array:
    """Matrix that whitens `count` rows: (count, count) for the first of a recording, else without those that only precede."""
    taps, sigma = spectrum.whitener()
    order = len(taps) - 1
    repeated = np.repeat(taps[::-1, None], count, axis=1)
    body = sparse.csr_array(sparse.dia_array((repeated, np.arange(order + 1)), shape=(count - order, count)))
    if not first:
        return body
    # the first rows have too few before them: all of them together weigh as much as one
    head = sparse.eye_array(order, count) / (sigma * np.sqrt(order))
    return sparse.csr_array(sparse.vstack([head, body]))
