"""Signals as quintic splines on even knots, and a prior of smoothness for their coefficients.

A signal is sum_k c_k B((t - t_k) / step). Its coefficients are an autoregressive process with one pole of order p: sampled from
a process of spectral density q / (w0^2 + w^2)^p (Matern's). With w0 = 0 and p = 4 it is the jerk that wanders as a Wiener
process. A signal at any time rests on six neighbouring coefficients, so every matrix is banded.
"""

from dataclasses import dataclass
from functools import cache
from math import comb, factorial

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

Array = NDArray[np.float64]

DEGREE = 5
SUPPORT = DEGREE + 1
"""coefficients that a signal rests on at any time"""


@dataclass(frozen=True)
class Knots:
    """Even knots from `start` (s), `step` (s) apart, with `count` coefficients."""

    start: float
    step: float
    count: int

    def rows(self, time: Array, derivative: int = 0) -> tuple[NDArray[np.intp], Array]:
        """First coefficient (T,) and weights (T, 6) that give the signal's derivative at `time` (T,) within the knots."""
        at = (time - self.start) / self.step
        first = np.clip(np.floor(at).astype(np.intp), 0, self.count - SUPPORT)
        powers = (at - first)[:, None] ** np.arange(SUPPORT)
        return first, powers @ _pieces(derivative) / self.step**derivative

    def design(self, time: Array, derivative: int = 0) -> sparse.csr_array:
        """The same as a sparse matrix, (T, count)."""
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
class Prior:
    """A signal's spectrum: (1 - a S)^order applied to its coefficients leaves white noise of the standard deviation `drive`.

    S shifts by one knot, a = exp(-corner step). The first `order` coefficients have the standard deviation `spread`.
    """

    order: int
    corner: float
    """w0, rad/s"""
    drive: float
    spread: float

    def band(self, knots: Knots) -> Array:
        """Precision of the coefficients, lower band (order + 1, count) as scipy.linalg.solveh_banded has it."""
        n, p = knots.count, self.order
        angles = np.pi * (2 * np.arange(p) + p + 1) / (2 * p)
        taps = np.real(np.poly(np.exp(self.corner * knots.step * np.exp(1j * angles))))[::-1]
        out = np.zeros((p + 1, n))
        for lag in range(p + 1):
            for k in range(p + 1 - lag):
                # row i of the filter touches c_{i + k} and c_{i + k + lag}
                out[lag, k : k + n - p] += taps[k] * taps[k + lag] / self.drive**2
        out[0, :p] += self.spread**-2
        return out

    def log_determinant(self, knots: Knots) -> float:
        """Of the precision."""
        return -2 * ((knots.count - self.order) * np.log(self.drive) + self.order * np.log(self.spread))
