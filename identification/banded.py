"""Symmetric positive banded matrices: factor, solve, and the band of the inverse."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import cho_solve_banded, cholesky_banded

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Factor:
    """Cholesky factor of a matrix (n, n)."""

    lower: Array
    """its lower band, (w + 1, n)"""

    def solve(self, right: Array) -> Array:
        """(n,) or (n, k)."""
        return np.asarray(cho_solve_banded((self.lower, True), right, check_finite=False))

    @property
    def log_determinant(self) -> float:
        """Of the matrix."""
        return float(2 * np.sum(np.log(self.lower[0])))


def factor(band: Array) -> Factor:
    """Of the matrix whose lower band (w + 1, n) is given. Raises numpy.linalg.LinAlgError where the matrix is not positive."""
    return Factor(np.asarray(cholesky_banded(band, lower=True, check_finite=False)))


def add_to_band(band: Array, matrix: sparse.csr_array) -> None:
    """Adds a symmetric sparse matrix (n, n), whose entries lie within it, to the lower band (w + 1, n)."""
    entries = matrix.tocoo()
    below = entries.row >= entries.col
    i, j = entries.row[below], entries.col[below]
    np.add.at(band, (i - j, j), entries.data[below])


def inverse_windows(found: Factor, block: int, first: NDArray[np.intp], wide: int, parts: int = 1) -> Array:
    """Parts of the inverse, rows and columns first[t] ... first[t] + wide - 1, shape (T, wide, wide), without the whole of it;
    with `parts` summed over as many neighbours in rows and columns, shape (T, wide / parts, wide / parts).

    `block` must be at least the band's width and wide - 1. Takahashi's recursion in blocks of the Cholesky factor, from the last
    one back: sums of squares only, so that rounding cannot make a variance negative. Cost is linear in the matrix's size.
    """
    width, n = len(found.lower) - 1, found.lower.shape[1]
    count = -(-n // block)
    padded = np.zeros((width + 1, count * block))
    padded[:, :n] = found.lower
    padded[0, n:] = 1.0
    own, below = _blocks(padded, block)
    root = np.linalg.inv(own)
    diagonal = np.swapaxes(root, 1, 2) @ root
    gain = below @ root[:-1]
    beside = np.empty_like(gain)  # rows of block k + 1, columns of block k
    for k in range(count - 2, -1, -1):
        beside[k] = -diagonal[k + 1] @ gain[k]
        diagonal[k] -= gain[k].T @ beside[k]
    pair = np.zeros((count, 2 * block, 2 * block))
    pair[:, :block, :block] = diagonal
    pair[:-1, block:, block:] = diagonal[1:]
    pair[:-1, block:, :block] = beside
    pair[:-1, :block, block:] = np.swapaxes(beside, 1, 2)
    k = first // block
    inside = (first - k * block)[:, None] + np.arange(0, wide, parts)
    out = np.zeros((len(first), inside.shape[1], inside.shape[1]))
    for a in range(parts):
        for b in range(parts):
            out += pair[k[:, None, None], inside[:, :, None] + a, inside[:, None, :] + b]
    return out


def _blocks(lower: Array, block: int) -> tuple[Array, Array]:
    """A lower triangle's blocks on the diagonal (count, block, block) and those below them (count - 1, block, block)."""
    n = lower.shape[1]
    count = n // block
    own, below = np.zeros((count, block, block)), np.zeros((count, block, block))
    j = np.arange(n)
    for lag, column in enumerate(lower):
        i = j + lag
        same = (i // block) == (j // block)
        c, a, b = j // block, i % block, j % block
        own[c[same], a[same], b[same]] = column[same]
        beyond = ~same & (i < n)
        below[c[beyond], a[beyond], b[beyond]] = column[beyond]
    return own, below[: count - 1]
