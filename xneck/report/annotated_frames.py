"""Annotated frames as the page shows them: cut to the region in which the arm moves, as data URIs."""

import base64
from dataclasses import dataclass

import cv2
import numpy as np

from vision.arm_region import arm_region
from xneck.recording.camera_stages import VideoResult
from xneck.recording.drawn_video import DrawnVideo
from xneck.report.number_text import with_sigma

MAX_SIDE_PX = 900
"""longer side of a cut"""
_JPEG_QUALITY = 85


@dataclass(frozen=True)
class FrameCut:
    """One cut frame; the angles stand beside it in words, as those drawn into the frame are cut away or too small."""

    index: int
    time: float
    """s, camera clock"""
    angles: tuple[str, ...]
    uri: str


def frame_cuts(video: VideoResult, drawn: DrawnVideo) -> list[FrameCut]:
    """The annotated frames of a video, all cut to the same region."""
    cuts = []
    angles = video.extraction.angles
    for frame in drawn.frames:
        height, width = frame.picture.shape[:2]
        left, top, right, bottom = arm_region(video.extraction.corners, width, height)
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
