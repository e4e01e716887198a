"""Signals as quintic splines on even knots, and a smoothness prior for their coefficients.

A signal is sum_k c_k B((t - t_k) / step). The prior takes its coefficients for samples of a process with spectral density
q / (w0^2 + w^2)^p (Matern's), which is autoregressive with one pole of order p; with w0 = 0 and p = 4 the jerk is a Wiener
process. A signal at any time depends on six neighbouring coefficients, so every matrix is banded.
"""

from dataclasses import dataclass, replace
from functools import cache
from math import comb, factorial

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

Array = NDArray[np.float64]

DEGREE = 5
SUPPORT = DEGREE + 1
"""coefficients that a signal depends on at any time"""
CARRIED = 0.2
"""oscillations from knot to knot that a spline carries: of faster ones it lets less than half of the power through
(docs/thresholds.md)"""


@dataclass(frozen=True)
class Knots:
    """Even knots from `start` (s), `step` (s) apart, with `count` coefficients."""

    start: float
    step: float
    count: int

    def rows(self, time: Array, derivative: int = 0) -> tuple[NDArray[np.intp], Array]:
        """First coefficient (T,) and weights (T, 6) that give the signal's derivative at `time` (T,) within the knots."""
        position = (time - self.start) / self.step
        first = np.clip(np.floor(position).astype(np.intp), 0, self.count - SUPPORT)
        powers = (position - first)[:, None] ** np.arange(SUPPORT)
        return first, powers @ _pieces(derivative) / self.step**derivative

    def design(self, time: Array, derivative: int = 0) -> sparse.csr_array:
        """The weights of `rows` as a sparse matrix, (T, count)."""
        first, weights = self.rows(time, derivative)
        columns = first[:, None] + np.arange(SUPPORT)
        starts = SUPPORT * np.arange(len(time) + 1)
        return sparse.csr_array((weights.ravel(), columns.ravel(), starts), shape=(len(time), self.count))


def knots_over(first: float, last: float, step: float) -> Knots:
    """Knots that carry a signal from `first` to `last`, s."""
    return Knots(first, step, max(1, int(np.ceil((last - first) / step))) + DEGREE)


@cache
def _pieces(derivative: int) -> Array:
    """Basis functions on one interval as polynomials of u in [0, 1): coefficient of u^a (row) in the k-th function (column)."""
    out = np.zeros((SUPPORT, SUPPORT))
    for k in range(SUPPORT):
        # the k-th of six is the bump at u + 5 - k, a sum of truncated powers
        shifts = DEGREE - k
        for j in range(shifts + 1):
            weight = (-1) ** j * comb(SUPPORT, j) / factorial(DEGREE)
            for a in range(SUPPORT):
                out[a, k] += weight * comb(DEGREE, a) * float(shifts - j) ** (DEGREE - a)
    for _ in range(derivative):
        out = np.vstack([np.arange(1, SUPPORT)[:, None] * out[1:], np.zeros(SUPPORT)])
    return out


@dataclass(frozen=True)
class SplinePrior:
    """An autoregressive prior: the filter of order p applied to the coefficients leaves white noise."""

    order: int
    """p"""
    corner: float
    """w0, rad/s"""
    innovation_sigma: float
    """standard deviation of the white noise, in the signal's unit"""
    initial_sigma: float
    """standard deviation of the first p coefficients, in the signal's unit"""

    def band(self, knots: Knots) -> Array:
        """Precision of the coefficients, lower band (order + 1, count) in the layout of scipy.linalg.solveh_banded."""
        n, p = knots.count, self.order
        # between p columns at either end all columns are one, so a filter as short as this one shows all of them
        short = min(n, 2 * p + 1)
        rows = np.zeros((short - p, short + 1))
        rows[:, : p + 1] = self._taps(knots)
        # one entry more in a row of the table than in one of the filter: each begins one later
        rows = rows.ravel()[: (short - p) * short].reshape(short - p, short)
        products = np.zeros((short + p, short))
        products[:short] = rows.T @ rows / self.innovation_sigma**2
        columns = np.arange(short)
        ends = products[columns + np.arange(p + 1)[:, None], columns]
        band = np.empty((p + 1, n))
        band[:, : short - p] = ends[:, : short - p]
        band[:, short - p : n - p] = ends[:, short - p - 1, None]
        band[:, n - p :] = ends[:, short - p :]
        band[0, :p] += self.initial_sigma**-2
        return band

    def innovations(self, knots: Knots, c: Array) -> Array:
        """The innovations, of variance one by this prior, of coefficients c (count, ...): (count - order, ...)."""
        rows = knots.count - self.order
        filtered = np.sum([tap * c[k : k + rows] for k, tap in enumerate(self._taps(knots))], axis=0)
        return np.asarray(filtered / self.innovation_sigma, dtype=np.float64)

    def innovations_transposed(self, knots: Knots, values: Array) -> Array:
        """The transpose of the linear map `innovations` applied to `values` (count - order, ...): (count, ...)."""
        out = np.zeros((knots.count, *values.shape[1:]))
        for k, tap in enumerate(self._taps(knots)):
            out[k : k + len(values)] += tap * values
        return out / self.innovation_sigma

    def scaled(self, factor: float) -> "SplinePrior":
        """Of a signal that is `factor` times as large."""
        return replace(self, innovation_sigma=factor * self.innovation_sigma, initial_sigma=factor * self.initial_sigma)

    def _taps(self, knots: Knots) -> Array:
        """Filter (order + 1,), oldest coefficient first, that leaves the innovations of the coefficients."""
        p = self.order
        angles = np.pi * (2 * np.arange(p // 2) + p + 1) / (2 * p)
        poles = np.exp(self.corner * knots.step * np.exp(1j * angles))
        # newest first: of each pole with its conjugate, and of the one in the middle where their number is odd
        taps = np.array([1.0, -np.exp(-self.corner * knots.step)] if p % 2 else [1.0])
        for twice_real, power in zip(2 * np.real(poles), np.abs(poles) ** 2, strict=True):
            taps = np.convolve(taps, [1.0, -twice_real, power])
        return taps[::-1]

    def log_determinant(self, knots: Knots) -> float:
        """Logarithm of the determinant of the coefficients' precision."""
        free = knots.count - self.order
        return -2 * (free * np.log(self.innovation_sigma) + self.order * np.log(self.initial_sigma))
