"""Robust weights of residuals, and what they and neighbouring pixels that err together do to a covariance.

All for M markers side by side: residuals (M, N), columns of the model (M, P, N).
"""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Single = NDArray[np.float32]

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


def scale_of(residual: Single, used: NDArray[np.bool_]) -> Array:
    """Standard deviation of the bulk of each marker's residuals, (M,)."""
    scale = np.ones(len(residual))
    for k, (r, m) in enumerate(zip(residual[:, ::SOME], used[:, ::SOME], strict=True)):
        size = np.abs(r[m])
        if len(size):
            size.partition(len(size) // 2)
            scale[k] = 1.4826 * size[len(size) // 2]
    return scale + 0.05


def tukey(residual: Single, scale: Array) -> Single:
    """Tukey's weights, (M, N)."""
    z = residual * (1 / (TUKEY * scale[:, None])).astype(np.float32)
    np.multiply(z, z, out=z)
    np.subtract(1, z, out=z)
    np.maximum(z, 0, out=z)
    return np.multiply(z, z, out=z)


def with_neighbours(weight: Single, used: NDArray[np.bool_], x: Single, y: Single) -> Single:
    """Weights (M, N) of pixels at x, y (M, N), px, without those beside many that count for nothing.

    A thing across a marker meets the model's grey by chance in places; where it is seen, its surroundings go too.
    """
    lost = used & (weight == 0)
    many = np.flatnonzero(np.count_nonzero(lost, axis=1) > FEW_LOST * np.count_nonzero(used, axis=1))
    weight = weight.copy() if len(many) else weight
    for k in many:
        column, row = ((z[k] - z[k][used[k]].min()).astype(int) // PATCH for z in (x, y))
        column, row = np.maximum(column, 0), np.maximum(row, 0)  # padding
        shape = (int(row.max()) + 1, int(column.max()) + 1)
        patch = row * shape[1] + column
        seen, gone = (np.bincount(patch, one[k], shape[0] * shape[1]) for one in (used, lost))
        bad = ((gone > MANY * seen) & (gone > 1)).astype(np.uint8).reshape(shape)
        weight[k, cv2.dilate(bad, cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))).ravel()[patch] > 0] = 0
    return weight


def slope_share(residual: Single, scale: Array, used: NDArray[np.bool_]) -> Array:
    """Mean slope of Tukey's influence over the mean weight, (M,): how much stiffer the weights make the fit look than it is."""
    z = np.sqrt(tukey(residual, scale)) * used  # d(r w) / dr is z (5 z - 4) with w = z^2
    weight = np.maximum(np.einsum("mn,mn->m", z, z).astype(float), 1e-9)
    return np.maximum(5 - 4 * z.sum(axis=1, dtype=float) / weight, 0.3)


def block_inflation(
    D: Single, inverse: Array, weight: Single, residual: Single, blocks: Sequence[NDArray[np.intp]]
) -> Array:
    """Variance of the residuals as the first eight parameters feel it, (M,).

    Scores (columns times weight times residual) are summed over `blocks` of the picture, as errors within one go together;
    with their covariance B and the normal matrix's inverse A this is trace(A B) / 8, the sandwich's size.
    """
    half = np.linalg.cholesky(inverse[:, :8, :8] + 1e-15 * np.eye(8))
    Q = np.linalg.solve(half, inverse[:, :8]).astype(np.float32) @ D  # unit information: sum of w Q Q^T is 1
    share = np.einsum("mpn,mpn->mn", Q, Q)
    share *= weight
    Q *= (weight * residual)[:, None]
    size, taken = np.empty(len(D)), np.empty(len(D))
    for k, begins in enumerate(blocks):
        size[k] = np.sum(np.add.reduceat(Q[k], begins, axis=1) ** 2)
        # the fit has taken its part out of every block's score; a block has about two directions of its own
        taken[k] = np.sum(np.add.reduceat(share[k], begins) ** 2) / 2
    return size / np.maximum(8 - taken, 1.0)
