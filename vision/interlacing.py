"""Pictures in which even and odd rows show two moments, told from the markers in motion; the stream's own flag is often missing.

An interlaced camera exposes the even rows, and half a frame later the odd ones. Woven into one picture, odd rows are ahead of
even ones by half of what a marker moves from frame to frame, and turn round as the marker does. Nothing else does that: a rolling
shutter shears a picture and leaves each row between its neighbours; noise and compression do not know which way a marker moves.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

MIN_SHARE = 0.05
"""shift of odd rows against even ones over a marker's motion from frame to frame, from which on pictures are interlaced: half if
they are (docs/thresholds.md)"""
MAX_SHARE_SIGMA = 0.01
"""standard deviation of that share, above which the motion tells nothing (docs/thresholds.md)"""
MAX_MOTION_PX = 4.0
"""px from frame to frame: of faster markers the rows are too far apart to be compared (docs/thresholds.md)"""
_MARGIN_PX = 4
_MIN_SIDE_PX = 8


def row_shift(grey: NDArray[np.uint8], corners: Array) -> Array:
    """How far odd rows are right of even ones around markers (K, 4, 2), (K,), px; NaN where there is no marker."""
    return np.array([_row_shift(grey, of) if np.isfinite(of).all() else np.nan for of in corners])


def _row_shift(grey: NDArray[np.uint8], corners: Array) -> float:
    """Of one marker: each row against the mean of its neighbours, by their slope from left to right."""
    height, width = grey.shape
    x0, y0 = np.maximum(np.floor(corners.min(axis=0)).astype(int) - _MARGIN_PX, 1).tolist()
    x1, y1 = np.minimum(np.ceil(corners.max(axis=0)).astype(int) + _MARGIN_PX, (width - 1, height - 1)).tolist()
    if x1 - x0 < _MIN_SIDE_PX or y1 - y0 < _MIN_SIDE_PX:
        return np.nan
    rows = grey[y0 - 1 : y1 + 1, x0 - 1 : x1 + 1].astype(np.float32)
    beside = (rows[:-2] + rows[2:]) / 2
    slope = (beside[:, 2:] - beside[:, :-2]) / 2
    off = (rows[1:-1] - beside)[:, 1:-1]
    # a row that shows what is to the right of it in its neighbours is shifted to the left
    along = np.sum(off * slope, axis=1)
    is_odd = np.arange(y0, y1) % 2 == 1
    power = float(np.sum(slope**2))
    return float(along[~is_odd].sum() - along[is_odd].sum()) / power if power > 0 else np.nan


def share_of_motion(time: Array, corners: Array, shift: NDArray[np.floating]) -> tuple[float, float]:
    """Shift of odd rows against even ones over the markers' motion from frame to frame, and its standard deviation.

    time: (F,), s; corners: (F, markers, 4, 2), px; shift: (F, markers), px, of `row_shift`. Both are NaN where nothing moves.
    """
    if len(time) < 3:
        return np.nan, np.nan
    x = corners[..., 0].mean(axis=2)
    motion = np.full(x.shape, np.nan)
    motion[1:-1] = (x[2:] - x[:-2]) / (time[2:] - time[:-2])[:, None] * np.median(np.diff(time))
    use = np.isfinite(motion) & np.isfinite(shift) & (np.abs(motion) < MAX_MOTION_PX)
    moved, shifted = motion[use], np.clip(shift[use], -MAX_MOTION_PX, MAX_MOTION_PX)
    power = float(np.sum(moved**2))
    if not power:
        return np.nan, np.nan
    share = float(np.sum(moved * shifted)) / power
    return share, float(np.sqrt(np.mean((shifted - share * moved) ** 2) / power))


def refuse_interlaced(path: Path, time: Array, corners: Array, shift: NDArray[np.floating]) -> None:
    """Raises Refused where odd rows show another moment than even ones; arguments as of `share_of_motion`."""
    share, sigma = share_of_motion(time, corners, shift)
    if not (sigma < MAX_SHARE_SIGMA and abs(share) > MIN_SHARE):
        return
    raise Refused(
        path,
        f"is interlaced: odd rows of its pictures show markers {100 * abs(share):.0f} % of a frame's motion away from where even "
        "rows do",
        f"give every field a picture of its own: ffmpeg -i {path.name} -vf bwdif=mode=send_field -crf 16 OUT.mp4",
    )
