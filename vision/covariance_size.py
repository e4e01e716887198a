"""The size of a marker's covariance from frame to frame: each frame tells it from the few blocks that the marker covers.

Sizes of one marker are drawn towards their common one by as much as they differ by that chance alone. Blur, light or something
across the marker change them by more, and then little is taken back.
"""

import numpy as np
from numpy.typing import NDArray

from vision.moderated_variance import moderated_variances

Covariance = NDArray[np.float32]

FREEDOM = 8.0
"""degrees of freedom by which a frame tells the size of a marker's covariance: scores in eight directions (docs/thresholds.md)"""


def steady_sizes(covariance: Covariance) -> Covariance:
    """Covariances of corners, (F, markers, 8, 8), NaN where not known, with the size that a marker's frames together tell."""
    size = np.trace(covariance, axis1=2, axis2=3, dtype=float) / 8
    factor = np.ones(size.shape, dtype=np.float32)
    for k, of_marker in enumerate(size.T):
        known = np.isfinite(of_marker) & (of_marker > 0)
        if known.any():
            told = moderated_variances(FREEDOM * of_marker[known], np.full(np.count_nonzero(known), FREEDOM))
            factor[known, k] = told / of_marker[known]
    return covariance * factor[..., None, None]
