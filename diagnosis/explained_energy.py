"""How much of a residual its conditions explain, and how much they would by chance: residuals follow each other for seconds.

Columns Q (orthonormal) take the energy |Q' r|^2 from a residual r. Were r unrelated to them but as correlated in time as it is,
with autocovariance G, that energy would be a sum of chi squares with the eigenvalues of Q' G Q as weights: one scaled chi square
has its mean and its variance (Satterthwaite).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.fft import irfft, rfft
from numpy.typing import NDArray
from scipy.stats import chi2

Array = NDArray[np.float64]
Index = NDArray[np.intp]

_MAX_LAG_PART = 10
"""the autocovariance reaches as far as this part of the longest recording, its 10th; what lasts longer is drift
(docs/thresholds.md)"""
_MIN_LAGS = 8
_COLUMN_TOLERANCE = 1e-6
"""of the largest singular value: columns below are copies of others"""


@dataclass(frozen=True)
class Energy:
    """What columns take of a residual, and what they would take by chance."""

    taken: float
    expected: float
    """by chance"""
    log_p: float
    """log of the probability that chance takes as much"""
    scale: float
    """of the chi square by which chance takes energy with one column"""


@dataclass(frozen=True)
class Autocovariance:
    """Of a residual in recordings on even grids with gaps."""

    grid_rows: tuple[Index, ...]
    """of each recording, the rows' places on its grid, (S,)"""
    lags: Array
    """autocovariance at lags of 0, 1, ... rows"""

    def spread(self, columns: Sequence[Array]) -> Array:
        """Q' G Q of columns Q (S, K) of each recording."""
        K = columns[0].shape[1]
        out = np.zeros((K, K))
        for rows, Q in zip(self.grid_rows, columns, strict=True):
            length = int(rows[-1]) + 1
            grid = np.zeros((length, K))
            grid[rows] = Q
            size = 2 ** int(np.ceil(np.log2(length + len(self.lags))))
            kernel = np.zeros(size)
            kernel[: len(self.lags)] = self.lags
            kernel[-len(self.lags) + 1 :] = self.lags[:0:-1]
            smooth = irfft(rfft(grid, size, axis=0) * rfft(kernel)[:, None], size, axis=0)[:length]
            out += grid.T @ smooth
        return (out + out.T) / 2


def autocovariance(residual: Sequence[Array], grid_rows: Sequence[Index]) -> Autocovariance:
    """Of residuals (S,) on grid rows; Parzen's window, so that no combination of rows comes out with less than no variance."""
    count = sum(len(r) for r in residual)
    longest = max(int(rows[-1]) + 1 for rows in grid_rows)
    m = min(max(_MIN_LAGS, longest // _MAX_LAG_PART), longest)
    lags = np.zeros(m)
    for r, rows in zip(residual, grid_rows, strict=True):
        grid = np.zeros(int(rows[-1]) + 1)
        grid[rows] = r
        size = 2 ** int(np.ceil(np.log2(len(grid) + m)))
        products = irfft(np.abs(rfft(grid, size)) ** 2, size)
        lags[: min(m, len(grid))] += products[: min(m, len(grid))] / count
    u = np.arange(m) / m
    return Autocovariance(tuple(grid_rows), lags * np.where(u <= 0.5, 1 - 6 * u**2 * (1 - u), 2 * (1 - u) ** 3))


def explained_energy(
    residual: Sequence[Array], columns: Sequence[Array], basis: Array, covariance: Autocovariance
) -> Energy:
    """Of columns (S, K) of each recording, in a residual (S,), beyond a basis: orthonormal columns, rows of all recordings."""
    X, r = np.concatenate(columns), np.concatenate(residual)
    Q = orthonormal(X - basis @ (basis.T @ X))
    if not Q.shape[1]:
        return Energy(0.0, 0.0, 0.0, 0.0)
    ends = np.cumsum([len(c) for c in columns])[:-1]
    B = covariance.spread(np.split(Q, ends))
    mean, square = float(np.trace(B)), float(np.sum(B**2))
    taken = float(np.sum((Q.T @ r) ** 2))
    if mean <= 0:
        return Energy(taken, 0.0, 0.0, 0.0)
    log_p = float(chi2.logsf(taken * mean / square, mean**2 / square))
    # beyond the reach of its series the tail falls as exp(-x/2)
    return Energy(taken, mean, log_p if np.isfinite(log_p) else -taken * mean / square / 2, square / mean)


def energy_taken(residual: Array, columns: Array, basis: Array) -> float:
    """What `explained_energy` says that columns (S, K) take of a residual (S,), alone."""
    Q = orthonormal(columns - basis @ (basis.T @ columns))
    return float(np.sum((Q.T @ residual) ** 2))


def orthonormal(columns: Array) -> Array:
    """A basis (n, q) of what columns (n, K) span."""
    U, size, _ = np.linalg.svd(columns, full_matrices=False)
    return U[:, size > max(_COLUMN_TOLERANCE * size.max(initial=0.0), 1e-12)]
