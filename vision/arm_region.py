"""The part of the picture in which the arm moves."""

import numpy as np

_MARGIN = 0.12
"""margin around the markers, as a share of the longer side of their region"""
_MIN_SIDE_PX = 16
"""a region that is narrower is not cut out"""


def arm_region(corners: np.ndarray, width: int, height: int) -> tuple[int, int, int, int]:
    """Left, top, right, bottom of all markers in all frames with a margin, px; the whole picture where that is too small.

    corners: (F, markers, 4, 2), px, NaN where not found.
    """
    points = corners[~np.isnan(corners).any(axis=-1)]
    low, high = points.min(axis=0), points.max(axis=0)
    margin = _MARGIN * float(np.max(high - low))
    left, top = np.maximum(np.floor(low - margin), 0).astype(int).tolist()
    right, bottom = np.minimum(np.ceil(high + margin), [width, height]).astype(int).tolist()
    if right - left < _MIN_SIDE_PX or bottom - top < _MIN_SIDE_PX:
        return 0, 0, width, height
    return left, top, right, bottom
