"""Robust weights of residuals, and the covariance under these weights where errors of neighbouring pixels are correlated.

All functions work on M markers side by side: residuals (M, N), derivatives of the model (M, P, N).
"""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Single = NDArray[np.float32]

TUKEY_SCALES = 5.0
"""residual scales from which on a residual has no weight (docs/thresholds.md)"""
MEAN_NORMAL_WEIGHT = 0.925
"""mean of Tukey's weights for normal noise"""
PATCH_PX = 4
"""px: side of the patches in which pixels without weight are counted"""
MAX_OUTLIER_SHARE, MIN_OUTLIER_SHARE = 0.3, 0.01
"""share of a patch's pixels without weight that takes weight from it and its neighbours; share of a marker's pixels without
weight below which patches are not counted (docs/thresholds.md)"""
SCALE_STRIDE = 3
"""the scale is taken from every so many-th residual"""
_LEAST_SHARE = 1e-12
"""of the largest variance of a combination of numbers: less is rounding"""


def residual_scale(residual: Single, used: NDArray[np.bool_]) -> Array:
    """Standard deviation of each marker's residuals from their median size, (M,)."""
    scale = np.ones(len(residual))
    for k, (r, m) in enumerate(zip(residual[:, ::SCALE_STRIDE], used[:, ::SCALE_STRIDE], strict=True)):
        size = np.abs(r[m])
        if len(size):
            size.partition(len(size) // 2)
            scale[k] = 1.4826 * size[len(size) // 2]
    return scale + 0.05


def tukey_weights(residual: Single, scale: Array) -> Single:
    """Tukey's weights, (M, N)."""
    z = residual * (1 / (TUKEY_SCALES * scale[:, None])).astype(np.float32)
    np.multiply(z, z, out=z)
    np.subtract(1, z, out=z)
    np.maximum(z, 0, out=z)
    return np.multiply(z, z, out=z)


def drop_outlier_neighbours(weight: Single, used: NDArray[np.bool_], x: Single, y: Single) -> Single:
    """Weights (M, N) of pixels at x, y (M, N), px, set to zero beside many pixels that have none.

    In places a thing across a marker has the model's grey by chance, so that its surroundings lose their weight too.
    """
    outlier = used & (weight == 0)
    affected = np.flatnonzero(np.count_nonzero(outlier, axis=1) > MIN_OUTLIER_SHARE * np.count_nonzero(used, axis=1))
    weight = weight.copy() if len(affected) else weight
    for k in affected:
        column, row = ((z[k] - z[k][used[k]].min()).astype(int) // PATCH_PX for z in (x, y))
        column, row = np.maximum(column, 0), np.maximum(row, 0)  # padding
        shape = (int(row.max()) + 1, int(column.max()) + 1)
        patch = row * shape[1] + column
        counts, outliers = (np.bincount(patch, mask[k], shape[0] * shape[1]) for mask in (used, outlier))
        bad = ((outliers > MAX_OUTLIER_SHARE * counts) & (outliers > 1)).astype(np.uint8).reshape(shape)
        weight[k, cv2.dilate(bad, cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))).ravel()[patch] > 0] = 0
    return weight


def influence_slope(residual: Single, scale: Array, used: NDArray[np.bool_]) -> Array:
    """Mean slope of Tukey's influence function over the mean weight, (M,): below 1, as the weights overstate the information."""
    z = np.sqrt(tukey_weights(residual, scale)) * used  # d(r w) / dr is z (5 z - 4) with w = z^2
    weight = np.maximum(np.einsum("mn,mn->m", z, z).astype(float), 1e-9)
    return np.maximum(5 - 4 * z.sum(axis=1, dtype=float) / weight, 0.3)


def block_variance(
    D: Single, inverse: Array, weight: Single, residual: Single, blocks: Sequence[NDArray[np.intp]]
) -> Array:
    """Variance of the residuals in the directions of the first eight parameters, (M,).

    Scores (derivatives times weight times residual) are summed over `blocks` of the picture, since errors within a block are
    correlated; with their covariance B and the normal matrix's inverse A this is trace(A B) / 8, the size of the sandwich.
    """
    variance, axes = np.linalg.eigh(inverse[:, :8, :8])
    # of a marker of few pixels rounding may take what little there is of a direction below zero
    variance = np.maximum(variance, _LEAST_SHARE * variance[:, -1:])
    half = np.swapaxes(axes / np.sqrt(variance)[:, None], 1, 2)
    Q = (half @ inverse[:, :8]).astype(np.float32) @ D  # unit information: sum of w Q Q^T is 1
    share = np.einsum("mpn,mpn->mn", Q, Q)
    share *= weight
    Q *= (weight * residual)[:, None]
    size, leverage = np.empty(len(D)), np.empty(len(D))
    for k, begins in enumerate(blocks):
        size[k] = np.sum(np.add.reduceat(Q[k], begins, axis=1) ** 2)
        # the fit has reduced every block's score by the block's leverage; a block has about two directions of its own
        leverage[k] = np.sum(np.add.reduceat(share[k], begins) ** 2) / 2
    return size / np.maximum(8 - leverage, 1.0)
