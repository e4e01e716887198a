"""Annotated frames as the page shows them: cut to the region in which the arm moves, as data URIs."""

import base64
from dataclasses import dataclass

import cv2
import numpy as np

from xneck.recording.camera_stages import VideoResult
from xneck.report.number_text import with_sigma

MAX_SIDE_PX = 900
"""longer side of a cut"""
_MARGIN = 0.12
"""margin around the markers, as a share of the longer side of their region"""
_JPEG_QUALITY = 85
_MIN_SIDE_PX = 16
"""a region that is narrower is not cut out"""


@dataclass(frozen=True)
class FrameCut:
    """One cut frame; the angles stand beside it in words, as those drawn into the frame are cut away or too small."""

    index: int
    time: float
    """s, camera clock"""
    angles: tuple[str, ...]
    uri: str


def frame_cuts(video: VideoResult) -> list[FrameCut]:
    """The annotated frames of a video, all cut to the same region."""
    cuts = []
    angles = video.extraction.angles
    for frame in video.annotated_frames:
        height, width = frame.picture.shape[:2]
        left, top, right, bottom = _arm_region(video.extraction.corners, width, height)
        cut = np.ascontiguousarray(frame.picture[top:bottom, left:right])
        scale = MAX_SIDE_PX / max(cut.shape)
        if scale < 1:
            cut = cv2.resize(cut, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        encoded, jpeg = cv2.imencode(".jpg", cut, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])
        assert encoded
        pairs = zip(np.degrees(angles.alpha[frame.index]), np.degrees(angles.sigma[frame.index]), strict=True)
        lines = [
            f"alpha {i + 1}: " + ("not seen" if np.isnan(a) else f"{with_sigma(a, s)} deg")
            for i, (a, s) in enumerate(pairs)
        ]
        uri = "data:image/jpeg;base64," + base64.b64encode(jpeg.tobytes()).decode("ascii")
        cuts.append(FrameCut(frame.index, float(angles.time[frame.index]), tuple(lines), uri))
    return cuts


def _arm_region(corners: np.ndarray, width: int, height: int) -> tuple[int, int, int, int]:
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
