"""OpenCV's own calibration of the same views, as a second opinion: it knows plain least squares and flat boards only."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from calibration import lens
from calibration.corner_detection import BoardView
from calibration.one_opencv_thread import one_opencv_thread

_MAX_DIFFERENCE_SIGMA = 1.0
"""difference in standard deviations of our estimate above which it is noted: both use the same corners, so noise is common
(docs/thresholds.md)"""


@dataclass(frozen=True)
class CrossCheck:
    """OpenCV's estimate from the same views with the same free parameters."""

    parameters: np.ndarray  # order of lens.PARAMETER_NAMES, shape (9,)
    rms_px: float
    differences: np.ndarray  # ours less OpenCV's over sigma of ours; zero where fixed, shape (9,)

    def note(self, flat: bool) -> str | None:
        """A sentence where the two disagree; `flat` is whether our estimate has a flat board too, else None."""
        worst = int(np.argmax(np.abs(self.differences)))
        if not flat or abs(self.differences[worst]) <= _MAX_DIFFERENCE_SIGMA:
            return None
        return (
            f"OpenCV's own calibration disagrees: {lens.PARAMETER_NAMES[worst]} {self.parameters[worst]:.5g}, "
            f"{abs(self.differences[worst]):.1f} sigma away"
        )


def cross_check(
    views: Sequence[BoardView],
    image_size: tuple[int, int],
    free: Sequence[str],
    parameters: np.ndarray,
    sigma: np.ndarray,
) -> CrossCheck | None:
    """OpenCV's estimate against our `parameters` with standard deviations `sigma`, shape (9,); None where OpenCV fails."""
    flags = 0 if "k3" in free else cv2.CALIB_FIX_K3
    flags |= 0 if "p1" in free else cv2.CALIB_ZERO_TANGENT_DIST
    try:
        with one_opencv_thread():
            rms, K, distortion, *_ = cv2.calibrateCamera(
                [view.object_points.astype(np.float32) for view in views],
                [view.image_points.astype(np.float32).reshape(-1, 1, 2) for view in views],
                image_size,
                np.zeros((3, 3)),
                np.zeros(5),
                flags=flags,
            )
    except cv2.error:
        return None
    opencv = np.array([K[0, 0], K[1, 1], K[0, 2], K[1, 2], *np.ravel(distortion)[:5]])
    if not np.all(np.isfinite(opencv)):
        return None
    estimated = np.array([name in free for name in lens.PARAMETER_NAMES]) & (sigma > 0)
    differences = np.where(estimated, (parameters - opencv) / np.where(estimated, sigma, 1.0), 0.0)
    return CrossCheck(opencv, float(rms), differences)
