"""Symmetric positive banded matrices: factor, solve, and the band of the inverse."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import cho_solve_banded, cholesky_banded

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Factor:
    """Cholesky factor of a matrix (n, n) given by its lower band (w + 1, n)."""

    band: Array
    lower: Array

    def solve(self, right: Array) -> Array:
        """(n,) or (n, k)."""
        return np.asarray(cho_solve_banded((self.lower, True), right, check_finite=False))

    @property
    def log_determinant(self) -> float:
        """Of the matrix."""
        return float(2 * np.sum(np.log(self.lower[0])))


def factor(band: Array) -> Factor:
    """Raises numpy.linalg.LinAlgError where the matrix is not positive."""
    return Factor(band, np.asarray(cholesky_banded(band, lower=True, check_finite=False)))


def band_of(matrix: sparse.csr_array | sparse.coo_array, width: int) -> Array:
    """Lower band (width + 1, n) of a symmetric sparse matrix whose entries lie within it."""
    entries = matrix.tocoo()
    below = entries.row >= entries.col
    i, j, v = entries.row[below], entries.col[below], entries.data[below]
    out = np.zeros((width + 1, matrix.shape[0]))
    np.add.at(out, (i - j, j), v)
    return out


def inverse_windows(band: Array, block: int, first: NDArray[np.intp], wide: int) -> Array:
    """Parts of the inverse, rows and columns first[t] ... first[t] + wide - 1, shape (T, wide, wide), without the whole of it.

    `block` must be at least the band's width and wide - 1. Block-tridiagonal elimination forwards, then backwards for the inverse's
    diagonal and next blocks (Takahashi's recursion); cost is linear in the matrix's size.
    """
    width, n = band.shape[0] - 1, band.shape[1]
    count = -(-n // block)
    padded = np.zeros((width + 1, count * block))
    padded[:, :n] = band
    padded[0, n:] = 1.0
    own, below = _blocks(padded, block)
    gain = np.empty((count, block, block))
    reduced = np.empty((count, block, block))
    reduced[0] = np.linalg.inv(own[0])
    for k in range(1, count):
        gain[k] = below[k - 1] @ reduced[k - 1]
        reduced[k] = np.linalg.inv(own[k] - gain[k] @ below[k - 1].T)
    diagonal = np.empty_like(own)
    beside = np.empty((max(count - 1, 0), block, block))
    diagonal[-1] = reduced[-1]
    for k in range(count - 2, -1, -1):
        beside[k] = -diagonal[k + 1] @ gain[k + 1]  # rows of k + 1, columns of k
        diagonal[k] = reduced[k] - gain[k + 1].T @ beside[k]
    pair = np.zeros((count, 2 * block, 2 * block))
    pair[:, :block, :block] = diagonal
    pair[:-1, block:, block:] = diagonal[1:]
    pair[:-1, block:, :block] = beside
    pair[:-1, :block, block:] = np.swapaxes(beside, 1, 2)
    k = first // block
    inside = (first - k * block)[:, None] + np.arange(wide)
    return pair[k[:, None, None], inside[:, :, None], inside[:, None, :]]


def _blocks(band: Array, block: int) -> tuple[Array, Array]:
    """Diagonal blocks (count, block, block) and those below them (count - 1, block, block)."""
    width, n = band.shape[0] - 1, band.shape[1]
    count = n // block
    own, below = np.zeros((count, block, block)), np.zeros((count, block, block))
    j = np.arange(n)
    for lag in range(width + 1):
        i = j + lag
        same = (i // block) == (j // block)
        c, a, b = j // block, i % block, j % block
        own[c[same], a[same], b[same]] = band[lag, same]
        own[c[same], b[same], a[same]] = band[lag, same]
        next_one = ~same & (i < n)
        below[c[next_one], a[next_one], b[next_one]] = band[lag, next_one]
    return own, below[: count - 1]
