"""OpenCV's own calibration of the same views, as a second opinion: it knows plain least squares and flat boards only."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from calibration import lens
from calibration.corner_detection import BoardView

_FAR = 1.0
"""sigmas of ours: both saw the same corners, so that noise is common and only the treatment of bad ones differs"""


@dataclass(frozen=True)
class CrossCheck:
    """What OpenCV makes of the same views with the same free parameters."""

    parameters: np.ndarray  # order of lens.NAMES, shape (9,)
    rms_px: float
    differences: np.ndarray  # ours less OpenCV's over sigma of ours; zero where fixed, shape (9,)

    def note(self, flat: bool) -> str | None:
        """A sentence where both disagree though both believe in a flat board."""
        worst = int(np.argmax(np.abs(self.differences)))
        if not flat or abs(self.differences[worst]) <= _FAR:
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
    """OpenCV beside `parameters` with `sigma`, shape (9,); None where OpenCV finds nothing."""
    flags = 0 if "k3" in free else cv2.CALIB_FIX_K3
    flags |= 0 if "p1" in free else cv2.CALIB_ZERO_TANGENT_DIST
    try:
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
    theirs = np.array([K[0, 0], K[1, 1], K[0, 2], K[1, 2], *np.ravel(distortion)[:5]])
    if not np.all(np.isfinite(theirs)):
        return None
    estimated = np.array([name in free for name in lens.PARAMETER_NAMES]) & (sigma > 0)
    differences = np.where(estimated, (parameters - theirs) / np.where(estimated, sigma, 1.0), 0.0)
    return CrossCheck(theirs, float(rms), differences)
