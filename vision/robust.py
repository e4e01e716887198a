"""Robust weights of residuals, and what they and neighbouring pixels that err together do to a covariance.

All for M markers side by side: residuals (M, N), columns of the model (M, P, N).
"""

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TUKEY = 5.0
"""scales, from which on a residual counts for nothing"""
EFFICIENT = 0.925
"""mean weight of normal noise"""
PATCH = 4
"""px: side of the squares in which lost pixels are counted"""
MANY, FEW_LOST = 0.3, 0.01
"""share of a patch's pixels that takes it and its neighbours out; share of a marker's pixels below which nobody looks"""
SOME = 3
"""every how manieth residual the scale is taken from"""


def scale_of(residual: Array, used: NDArray[np.bool_]) -> Array:
    """Standard deviation of the bulk of each marker's residuals, (M,)."""
    return (
        np.array(
            [1.4826 * np.median(np.abs(r[m][::SOME])) if m.any() else 1.0 for r, m in zip(residual, used, strict=True)]
        )
        + 0.05
    )


def tukey(residual: Array, scale: Array) -> Array:
    """Tukey's weights, (M, N)."""
    return np.maximum(1 - (residual / (TUKEY * scale[:, None])) ** 2, 0) ** 2


def with_neighbours(weight: Array, used: NDArray[np.bool_], x: Array, y: Array) -> Array:
    """Weights (M, N) of pixels at x, y (M, N), px, without those beside many that count for nothing.

    A thing across a marker meets the model's grey by chance in places; where it is seen, its surroundings go too.
    """
    lost = used & (weight == 0)
    weight = weight.copy()
    for k in np.flatnonzero(lost.sum(axis=1) > FEW_LOST * used.sum(axis=1)):
        column, row = ((z[k] - z[k][used[k]].min()).astype(int) // PATCH for z in (x, y))
        column, row = np.maximum(column, 0), np.maximum(row, 0)  # padding
        shape = (int(row.max()) + 1, int(column.max()) + 1)
        patch = row * shape[1] + column
        seen, gone = (np.bincount(patch, one[k], shape[0] * shape[1]) for one in (used, lost))
        bad = ((gone > MANY * seen) & (gone > 1)).astype(np.uint8).reshape(shape)
        weight[k, cv2.dilate(bad, cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))).ravel()[patch] > 0] = 0
    return weight


def slope_share(residual: Array, scale: Array, used: NDArray[np.bool_]) -> Array:
    """Mean slope of Tukey's influence over the mean weight, (M,): how much stiffer the weights make the fit look than it is."""
    z = np.maximum(1 - (residual / (TUKEY * scale[:, None])) ** 2, 0) * used
    slope = z * (5 * z - 4)  # d(r w) / dr with w = z^2
    return np.maximum(slope.sum(axis=1) / np.maximum((z * z).sum(axis=1), 1e-9), 0.3)


def block_inflation(
    D: NDArray[np.float32], inverse: Array, pull: Array, weight: Array, block: NDArray[np.intp], blocks: int
) -> Array:
    """Variance of the residuals as the first eight parameters feel it, (M,).

    Scores (columns times pull = weight times residual) are summed over blocks of the picture, as errors within one go
    together; with their covariance B and the normal matrix's inverse A this is trace(A B) / 8, the sandwich's size.
    """
    m = len(pull)
    half = np.linalg.cholesky(inverse[:, :8, :8] + 1e-15 * np.eye(8))
    Q = np.linalg.solve(half, inverse[:, :8]) @ D  # unit information: sum of w Q Q^T is 1
    index = (block + blocks * np.arange(m)[:, None]).ravel()
    score = Q * pull[:, None]
    share = weight * np.einsum("mpn,mpn->mn", Q, Q)

    def summed(values: Array) -> Array:
        return np.bincount(index, values.ravel(), m * blocks).astype(float).reshape(m, blocks)

    size = np.sum([summed(score[:, k]) ** 2 for k in range(8)], axis=(0, 2))
    # the fit has taken its part out of every block's score; a block has about two directions of its own
    taken = (summed(share) ** 2).sum(axis=1) / 2
    return size / np.maximum(8 - taken, 1.0)
