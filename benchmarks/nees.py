"""Normalised estimation error squared: whether a covariance is as large as the errors that it is of."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def nees_per_dimension(e: Array, covariance: Array) -> Array:
    """NEES of errors (K, 3 N): of each derivative with its own block, and of all, (4,); NaN where K = 0."""
    if not len(e):
        return np.full(4, np.nan)
    n = e.shape[1] // 3
    parts = [slice(d * n, (d + 1) * n) for d in range(3)] + [slice(None)]
    return np.array(
        [float(np.mean(e[:, p] * np.linalg.solve(covariance[:, p, p], e[:, p, None])[..., 0])) for p in parts]
    )
