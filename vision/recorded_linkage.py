"""The linkage of a recording, fitted to corners that are put right by what the fit itself shows.

Rows of a rolling shutter are of different moments, and a camera that shakes moves the whole picture. Neither need be said: what is
left of one fit tells the row time and the shake by which the corners of the next one are moved.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calibration.camera import Camera
from mechanism.description import Neck
from vision.linkage.camera_shake import CameraShake
from vision.linkage.linkage_fit import LinkageFit, fit_linkage
from vision.linkage.observed_corners import Floats
from vision.linkage.shared_fit import LinkageOptions
from vision.shutter import Shutter, at_middle_row
from vision.video import Video

Array = NDArray[np.float64]

SHAKEN_PX = 0.02
"""px: standard deviation of the offset of a marker that stands still, where the camera shakes and the corners were moved back by
that marker: its edges go from pixel to pixel (docs/thresholds.md)"""
SHAKEN_WEIGHT = 100.0
"""how many times as much as frames that counts in a fit: what is left of a shake is in all markers but the base's, for many frames
(docs/thresholds.md)"""
_MAX_ROW_TIMES = 3
"""corrections of a rolling shutter's row time that nobody said: the first is nearly right"""


@dataclass(frozen=True)
class CorrectedFit:
    """A fit, the corners to which it was made, and what they were put right by."""

    fit: LinkageFit
    corners: Array
    """(F, markers, 4, 2), px"""
    shutter: Shutter
    shake: CameraShake | None
    """None where the camera stands"""


@dataclass(frozen=True)
class RecordedLinkage:
    """What a linkage is fitted to."""

    neck: Neck
    camera: Camera
    video: Video
    time: Array
    """(F,), s, as stamped"""
    corners: Array
    """(F, markers, 4, 2), px, NaN where a marker was not found"""
    covariance: Floats | None
    """(F, markers, 8, 8), px^2"""
    shown: NDArray[np.bool_]
    """(F,): which frames show the moments of their stamps; motion is told from one of them to the next"""

    def fitted(self, linkage: LinkageOptions, shutter: Shutter, shake: CameraShake | None = None) -> CorrectedFit:
        """With the row time and the shake that fits show, where neither is known before."""
        done = self._with_row_time(linkage, shutter, shake)
        shown = done.fit.shake
        if shake is None and shown is not None and shown.is_sure:
            return self._with_row_time(linkage, shutter, shown)
        return done

    def _with_row_time(self, linkage: LinkageOptions, shutter: Shutter, shake: CameraShake | None) -> CorrectedFit:
        done = self._once(linkage, shutter, shake)
        for _ in range(_MAX_ROW_TIMES):
            row_time = done.fit.row_time
            if shutter.row_s or row_time is None or not row_time.is_sure:
                break
            done = self._once(linkage, replace(done.shutter, row_s=done.shutter.row_s + row_time.seconds), shake)
        return done

    def _once(self, linkage: LinkageOptions, shutter: Shutter, shake: CameraShake | None) -> CorrectedFit:
        height, shown = self.video.height, self.shown
        if shake is None:
            corners = self.corners.copy()
        else:
            corners = self.corners - shake.shift[:, None, None]
            linkage = replace(linkage, standing_px=SHAKEN_PX, standing_weight=SHAKEN_WEIGHT)
        corners[shown] = at_middle_row(self.time[shown], corners[shown], height, shutter)
        fit = fit_linkage(
            self.neck,
            self.camera,
            corners,
            str(self.video.path),
            covariance=self.covariance,
            time=shutter.middle(self.time, height),
            options=linkage,
            corrected=shake,
        )
        return CorrectedFit(fit, corners, shutter, shake)
