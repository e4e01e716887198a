"""Annotated frames as the page shows them: cut to where the arm moves, as data URIs."""

import base64
from dataclasses import dataclass

import cv2
import numpy as np

from xneck.recording.pipeline import Result
from xneck.report.wording import with_sigma

LARGEST = 900
"""px: the longer side of a cut"""
_MARGIN = 0.12
_QUALITY = 85


@dataclass(frozen=True)
class Shot:
    """One frame; `angles` in words, since what is written into the picture is cut away or too small."""

    index: int
    time: float
    """s, camera clock"""
    angles: tuple[str, ...]
    uri: str


def shots(result: Result) -> list[Shot]:
    """The result's pictures, all cut alike."""
    if result.extraction is None:
        return []
    out = []
    for index, picture in result.pictures:
        height, width = picture.shape[:2]
        left, top, right, bottom = _where_the_arm_moves(result.extraction.corners, width, height)
        cut = np.ascontiguousarray(picture[top:bottom, left:right])
        scale = LARGEST / max(cut.shape)
        if scale < 1:
            cut = cv2.resize(cut, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        done, packed = cv2.imencode(".jpg", cut, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
        assert done
        pairs = zip(np.degrees(result.angles.alpha[index]), np.degrees(result.angles.sigma[index]), strict=True)
        angles = [
            f"alpha {i + 1}: " + ("not seen" if np.isnan(a) else f"{with_sigma(a, s)} deg")
            for i, (a, s) in enumerate(pairs)
        ]
        uri = "data:image/jpeg;base64," + base64.b64encode(packed.tobytes()).decode("ascii")
        out.append(Shot(index, float(result.angles.time[index]), tuple(angles), uri))
    return out


def _where_the_arm_moves(corners: np.ndarray, width: int, height: int) -> tuple[int, int, int, int]:
    """Left, top, right, bottom of all markers in all frames with a margin, px; the whole picture where that is nothing.

    corners: (F, markers, 4, 2), px, NaN where not found.
    """
    found = corners[~np.isnan(corners).any(axis=-1)]
    low, high = found.min(axis=0), found.max(axis=0)
    margin = _MARGIN * float(np.max(high - low))
    left, top = np.maximum(np.floor(low - margin), 0).astype(int).tolist()
    right, bottom = np.minimum(np.ceil(high + margin), [width, height]).astype(int).tolist()
    if right - left < 16 or bottom - top < 16:
        return 0, 0, width, height
    return left, top, right, bottom
