"""Angles that are none: a number that a tracker writes where it saw nothing, and frames in which it took a marker for turned.

No joint goes from one frame to the next where it has not been before, and back.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

Array = NDArray[np.float64]

MIN_JUMP_RAD = 0.5
"""rad from the frames about it: less is no misread angle, however steady the others are (docs/thresholds.md)"""
JUMP_STEPS = 6.0
"""by so many of the larger steps from frame to frame a misread angle is off the frames about it (docs/thresholds.md)"""
MAX_MISREAD_SHARE = 0.2
"""of a joint's angles: where more jump they are left as they are (docs/thresholds.md)"""
_LARGER_STEPS = 0.9
"""quantile of the steps; what is misread makes two steps, and few"""
_FRAMES_ABOUT = 9
_LEAST_FRAMES = 20
_LEAST_MARKS = 3
_MARKS = (0.0, -1.0)
"""what trackers write where nothing was seen; larger numbers are no radians and are told by that"""


def marks_of_nothing(alpha: Array) -> dict[float, NDArray[np.bool_]]:
    """Frames (F,) in which all angles (F, N), rad, are a mark that nothing was seen, far from where they were; by the mark."""
    known = np.isfinite(alpha).all(axis=1)
    marks = {mark: known & (alpha == mark).all(axis=1) for mark in _MARKS}
    return {
        mark: frames for mark, frames in marks.items() if frames.sum() >= _LEAST_MARKS and _jumps(alpha, frames, mark)
    }


def _jumps(alpha: Array, frames: NDArray[np.bool_], mark: float) -> bool:
    """Whether most frames with a mark are far from the ones before and after them that have none, in some joint."""
    others = np.flatnonzero(np.isfinite(alpha).all(axis=1) & ~frames)
    if len(others) < _LEAST_FRAMES:
        return False
    usual = np.quantile(np.abs(np.diff(alpha[others], axis=0)), _LARGER_STEPS, axis=0)
    places = np.searchsorted(others, np.flatnonzero(frames))
    beside = np.stack([alpha[others[np.clip(places - k, 0, len(others) - 1)]] for k in (1, 0)])
    far = (np.abs(beside - mark) > JUMP_STEPS * usual).any(axis=2).all(axis=0)
    return bool(np.mean(far) > 0.5)


def misread(alpha: Array) -> NDArray[np.bool_]:
    """Which angles (F, N), rad, jump away from the frames about them and back."""
    out = np.zeros(alpha.shape, dtype=bool)
    for j, values in enumerate(alpha.T):
        seen = np.flatnonzero(np.isfinite(values))
        if len(seen) < _LEAST_FRAMES:
            continue
        angles = values[seen]
        usual = float(np.quantile(np.abs(np.diff(angles)), _LARGER_STEPS))
        jumps = np.abs(angles - median_filter(angles, _FRAMES_ABOUT, mode="reflect")) > max(
            MIN_JUMP_RAD, JUMP_STEPS * usual
        )
        if np.mean(jumps) <= MAX_MISREAD_SHARE:
            out[seen[jumps], j] = True
    return out
