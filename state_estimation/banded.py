"""Symmetric positive definite banded matrices: Cholesky factor, solution, and windows of the inverse."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import cholesky_banded, get_lapack_funcs

Array = NDArray[np.float64]

_BLOCKS_AT_ONCE = 256
"""blocks whose inverses are held in memory together"""
(_solve_triangular,) = get_lapack_funcs(("tbtrs",), dtype=np.float64)


@dataclass(frozen=True)
class BandedCholesky:
    """Cholesky factor of a banded matrix (n, n) of bandwidth w."""

    lower: Array
    """lower band of the factor, (w + 1, n)"""

    def solve(self, right: Array) -> Array:
        """The matrix's inverse times `right`, (n,) or (n, k)."""
        return self.solve_second_half(self.solve_first_half(right))

    def solve_first_half(self, right: Array) -> Array:
        """The factor's inverse times `right`: the products of two of these are those of `solve`, for half of its time."""
        return self._solved(right, "N")

    def solve_second_half(self, half: Array) -> Array:
        """What `solve` gives, from the first half of it."""
        return self._solved(half, "T")

    def _solved(self, right: Array, transposed: str) -> Array:
        if not right.size:
            # the library writes beyond arrays that have no columns
            return right.copy()
        columns, _ = _solve_triangular(self.lower, right.reshape(len(right), -1), uplo="L", trans=transposed)
        return np.asarray(columns).reshape(right.shape)

    @property
    def log_determinant(self) -> float:
        """Logarithm of the matrix's determinant."""
        return float(2 * np.sum(np.log(self.lower[0])))


def banded_cholesky(band: Array) -> BandedCholesky:
    """Factor of the matrix whose lower band is `band` (w + 1, n).

    Raises numpy.linalg.LinAlgError where the matrix is not positive definite.
    """
    return BandedCholesky(np.asarray(cholesky_banded(band, lower=True, check_finite=False)))


def add_to_band(band: Array, matrix: sparse.csr_array, parts: int = 1) -> None:
    """Adds a symmetric sparse matrix (n, n), whose entries lie within the band, to the lower band (w + 1, n parts).

    Every row and column of the matrix stands for `parts` neighbours in the band.
    """
    matrix.sum_duplicates()
    entries = matrix.tocoo()
    below = entries.row >= entries.col
    lag, column = (entries.row - entries.col)[below], entries.col[below]
    own = np.zeros((int(lag.max(initial=0)) + 1, band.shape[1] // parts))
    own[lag, column] = entries.data[below]
    for a in range(parts):
        for b in range(parts):
            # above the diagonal stand the entries of the other triangle
            first = 0 if a >= b else 1
            rows = slice(parts * first + a - b, parts * (len(own) - 1) + a - b + 1, parts)
            band[rows, b::parts] += own[first:]


def inverse_windows(
    cholesky: BandedCholesky, block: int, first: NDArray[np.intp], width: int, parts: int = 1
) -> Iterator[tuple[slice, Array]]:
    """Square windows on the diagonal of the inverse: rows and columns first[t] ... first[t] + width - 1, `first` not falling.

    The whole inverse is never made. Yields slices of `first`, never empty, and the windows of their entries, (T, width, width),
    from the last slice back; with `parts`, that many neighbours in rows and columns are summed, (T, width / parts, width / parts).
    `block` must be at least the bandwidth and at least width - 1.

    This is Takahashi's recursion in blocks of the Cholesky factor. It adds squares only, so rounding cannot make a variance
    negative. Time is linear in the matrix's size and memory does not grow with it.
    """
    count = -(-cholesky.lower.shape[1] // block)
    next_diagonal = np.zeros((block, block))
    for low in reversed(range(0, count, _BLOCKS_AT_ONCE)):
        high = min(low + _BLOCKS_AT_ONCE, count)
        on_diagonal, below = _blocks(cholesky.lower, block, low, high)
        root = np.linalg.inv(on_diagonal)
        diagonal = np.swapaxes(root, 1, 2) @ root
        gain = below @ root
        beside = np.empty_like(gain)  # rows of block k + 1, columns of block k
        beyond = next_diagonal
        for k in reversed(range(high - low)):
            beside[k] = -next_diagonal @ gain[k]
            diagonal[k] -= gain[k].T @ beside[k]
            next_diagonal = diagonal[k]
        pair = np.zeros((high - low, 2 * block, 2 * block))
        pair[:, :block, :block] = diagonal
        pair[:, block:, block:] = np.concatenate([diagonal[1:], beyond[None]])
        pair[:, block:, :block] = beside
        pair[:, :block, block:] = np.swapaxes(beside, 1, 2)
        rows = slice(*np.searchsorted(first, (low * block, high * block)).tolist())
        if rows.start == rows.stop:
            continue
        distinct, place = np.unique(first[rows], return_inverse=True)
        k = distinct // block
        inside = (distinct - k * block)[:, None] + np.arange(0, width, parts)
        k = (k - low)[:, None, None]
        windows = np.zeros((len(inside), inside.shape[1], inside.shape[1]))
        for a in range(parts):
            for b in range(parts):
                windows += pair[k, inside[:, :, None] + a, inside[:, None, :] + b]
        yield rows, windows[place]


def _blocks(lower: Array, block: int, low: int, high: int) -> tuple[Array, Array]:
    """Blocks `low` to `high` of a lower triangle on the diagonal, and those below them, (count, block, block) each.

    Beyond the triangle's end the diagonal is filled with ones.
    """
    width, begin, end = len(lower) - 1, low * block, high * block
    n, count = lower.shape[1], high - low
    band = np.zeros((width + 1, count * block))
    band[0] = 1.0
    inside = lower[:, begin : min(end, n)]
    band[:, : inside.shape[1]] = inside
    on_diagonal, below = np.zeros((count, block, block)), np.zeros((count, block, block))
    j = np.arange(count * block)
    for lag, column in enumerate(band):
        i = j + lag
        same = (i // block) == (j // block)
        c, a, b = j // block, i % block, j % block
        on_diagonal[c[same], a[same], b[same]] = column[same]
        below[c[~same], a[~same], b[~same]] = column[~same]
    return on_diagonal, below
