"""A picture whose scale comes and goes, as that of a lens does whose focus breathes.

Markers that stand still tell it twice: the scale moves them from and to the optical axis, and makes them larger and smaller. A
tripod that shakes does only the first, a shadow on a marker only the second. So both must agree before it is believed, and a scale
that changes once is left to the camera's motion.
"""

import numpy as np
from numpy.typing import NDArray

from calibration.camera import Camera
from vision.linkage.standing_markers import standing_markers

Array = NDArray[np.float64]

WINDOW_S = 0.5
"""s over which the scale is averaged before it is judged, as a codec errs for as long (docs/thresholds.md)"""
MIN_WINDOWS = 6
"""windows below which nothing comes and goes (docs/thresholds.md)"""
MIN_RMS = 2e-4
"""rms of the scale, below which it is left alone (docs/thresholds.md)"""
STANDING_SHARE = 0.1
"""of its side, by which a picture that breathes may move a marker that stands still (docs/thresholds.md)"""
MIN_CORRELATION = 0.8
"""of the scale by place with that by size (docs/thresholds.md)"""
SIZE_OVER_PLACE = (0.5, 1.5)
"""slope of the scale by size over that by place (docs/thresholds.md)"""


def beating_scale(time: Array, corners: Array, camera: Camera) -> Array | None:
    """Scale of the picture in each frame over its mean, (F,); None where it does not come and go, or nothing that stands tells it.

    time: (F,), s; corners: (F, markers, 4, 2), px, NaN where not found.
    """
    standing = standing_markers(corners[..., 0] + 1j * corners[..., 1], STANDING_SHARE)
    seen = np.isfinite(corners[:, standing]).all(axis=(1, 2, 3))
    if not standing.any() or np.count_nonzero(seen) < MIN_WINDOWS:
        return None
    still = corners[seen][:, standing]
    usual = still.mean(axis=0)
    inside, usual_inside = (x - x.mean(axis=-2, keepdims=True) for x in (still, usual))
    from_axis = usual - camera.K[:2, 2]
    by_place = np.sum(from_axis * (still - usual), axis=(1, 2, 3)) / np.sum(from_axis**2)
    by_size = np.sum(usual_inside * (inside - usual_inside), axis=(1, 2, 3)) / np.sum(usual_inside**2)
    window = np.floor((time[seen] - time[seen][0]) / WINDOW_S).astype(int)
    place, size = (_window_means(x, window) for x in (by_place, by_size))
    if len(place) < MIN_WINDOWS or not _agree(place - place.mean(), size - size.mean()) or not _comes_and_goes(place):
        return None
    return 1 + np.interp(time, time[seen], by_place)


def at_usual_scale(corners: Array, scale: Array, camera: Camera) -> Array:
    """Corners (F, markers, 4, 2), px, as they were at scale one; scale: (F,)."""
    axis = camera.K[:2, 2]
    return axis + (corners - axis) / scale[:, None, None, None]


def scale_warning(scale: Array | None) -> list[str]:
    """A sentence on a scale that comes and goes."""
    if scale is None:
        return []
    return [
        f"the picture's scale comes and goes by {100 * float(np.std(scale)):.2f} % rms, {100 * float(np.ptp(scale)):.2f} % in all: "
        "a focus that breathes; corrected by the markers that stand still; lock the focus"
    ]


def _window_means(values: Array, window: NDArray[np.intp]) -> Array:
    """Means of the values (F,) of each window that has any."""
    count = np.bincount(window)
    return np.bincount(window, values)[count > 0] / count[count > 0]


def _agree(place: Array, size: Array) -> bool:
    """Whether scales by place and by size, (windows,), without their means, are one scale."""
    if np.sqrt(np.mean(place**2)) < MIN_RMS:
        return False
    slope = float(place @ size / (place @ place))
    return SIZE_OVER_PLACE[0] < slope < SIZE_OVER_PLACE[1] and np.corrcoef(place, size)[0, 1] > MIN_CORRELATION


def _comes_and_goes(place: Array) -> bool:
    """Whether a scale (windows,) goes from one half of its range to the other more than once, by half of the range each time."""
    low, high = np.quantile(place, [0.0, 1.0])
    side = np.where(place < low + (high - low) / 4, -1, np.where(place > high - (high - low) / 4, 1, 0))
    sides = side[side != 0]
    return int(np.count_nonzero(np.diff(sides))) >= 2
