"""Frames that hold the angles of the frame before: of a tracker that is slower than its file, or that was stuck for a moment.

Their angles are true of an earlier time than their stamps say. That angles are equal to the last digit is no proof, for an arm at
rest may show just that; but an arm that rests does not set out by a whole step of its motion.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MIN_CATCH_UP = 0.05
"""of the rms step from frame to frame, for each frame that motion goes on in: what ends a run of equal angles where these were
held, up to one whole step (docs/thresholds.md)"""


def held_frames(alpha: Array) -> NDArray[np.bool_]:
    """Which of the frames (F,) hold angles (F, N), rad, of the frame before while the arm moves; NaN where not seen."""
    steps = np.diff(alpha, axis=0)
    size = np.sqrt(np.sum(np.nan_to_num(steps) ** 2, axis=1))
    still = np.r_[False, (size == 0) & ~np.isnan(steps).any(axis=1), False]
    held = np.zeros(len(alpha), dtype=bool)
    moving = size[size > 0]
    if not len(moving) or not still.any():
        return held
    usual = float(np.sqrt(np.mean(moving**2)))
    edges = np.diff(still.astype(int))
    for begin, end in zip(np.flatnonzero(edges > 0), np.flatnonzero(edges < 0), strict=True):
        # steps begin .. end - 1 are nothing: frames begin + 1 .. end hold the angles of frame `begin`
        frames = end - begin + 1
        if end < len(size) and size[end] > min(MIN_CATCH_UP * frames, 1.0) * usual:
            held[begin + 1 : end + 1] = True
    return held
