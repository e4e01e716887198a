"""Symmetric positive banded matrices: factor, solve, and the band of the inverse."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import cho_solve_banded, cholesky_banded

Array = NDArray[np.float64]

_STRETCH = 256
"""blocks whose inverses are made at a time"""


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


def inverse_windows(
    found: Factor, block: int, first: NDArray[np.intp], wide: int, parts: int = 1
) -> Iterator[tuple[slice, Array]]:
    """Parts of the inverse without the whole of it: rows and columns first[t] ... first[t] + wide - 1, `first` not falling.

    A stretch at a time from the last back, as a slice of `first` and its parts (T, wide, wide); with `parts` summed over as many
    neighbours in rows and columns, (T, wide / parts, wide / parts). `block` must be at least the band's width and wide - 1.
    Takahashi's recursion in blocks of the Cholesky factor: sums of squares only, so that rounding cannot make a variance negative.
    Time is linear in the matrix's size, memory does not grow with it.
    """
    count = -(-found.lower.shape[1] // block)
    after = np.zeros((block, block))
    for low in reversed(range(0, count, _STRETCH)):
        high = min(low + _STRETCH, count)
        own, below = _blocks(found.lower, block, low, high)
        root = np.linalg.inv(own)
        diagonal = np.swapaxes(root, 1, 2) @ root
        gain = below @ root
        beside = np.empty_like(gain)  # rows of block k + 1, columns of block k
        beyond = after
        for k in reversed(range(high - low)):
            beside[k] = -after @ gain[k]
            diagonal[k] -= gain[k].T @ beside[k]
            after = diagonal[k]
        pair = np.zeros((high - low, 2 * block, 2 * block))
        pair[:, :block, :block] = diagonal
        pair[:, block:, block:] = np.concatenate([diagonal[1:], beyond[None]])
        pair[:, block:, :block] = beside
        pair[:, :block, block:] = np.swapaxes(beside, 1, 2)
        here = slice(*np.searchsorted(first, (low * block, high * block)).tolist())
        k = first[here] // block
        inside = (first[here] - k * block)[:, None] + np.arange(0, wide, parts)
        k = (k - low)[:, None, None]
        out = np.zeros((len(inside), inside.shape[1], inside.shape[1]))
        for a in range(parts):
            for b in range(parts):
                out += pair[k, inside[:, :, None] + a, inside[:, None, :] + b]
        yield here, out


def _blocks(lower: Array, block: int, low: int, high: int) -> tuple[Array, Array]:
    """Of a lower triangle's blocks `low` to `high` those on the diagonal and those below them, (count, block, block) each.

    Beyond the triangle's end there are ones.
    """
    width, begin, end = len(lower) - 1, low * block, high * block
    n, count = lower.shape[1], high - low
    band = np.zeros((width + 1, count * block))
    band[0] = 1.0
    there = lower[:, begin : min(end, n)]
    band[:, : there.shape[1]] = there
    own, below = np.zeros((count, block, block)), np.zeros((count, block, block))
    j = np.arange(count * block)
    for lag, column in enumerate(band):
        i = j + lag
        same = (i // block) == (j // block)
        c, a, b = j // block, i % block, j % block
        own[c[same], a[same], b[same]] = column[same]
        below[c[~same], a[~same], b[~same]] = column[~same]
    return own, below
