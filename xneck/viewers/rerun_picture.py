"""The video in Rerun, with markers and linkage as they were found drawn over every frame."""

from pathlib import Path
from typing import Any

import numpy as np

from calibration.camera import Camera
from mechanism.description import Neck
from vision.extract import Extraction
from vision.overlay import MARKER, linkage, pose_of
from xneck.viewers.playable import playable

VIDEO = "video"
_WIDTH = 1.5
"""in the viewer's points, whatever the zoom"""


def write_picture(rr: Any, stream: Any, video: Path, neck: Neck, camera: Camera, found: Extraction, at: Any) -> None:
    """Pictures and lines of all frames at the times `at`, an index of the recording."""
    asset = rr.AssetVideo(contents=playable(video), media_type="video/mp4")
    stream.log(VIDEO, asset, static=True)
    stamps = np.sort(asset.read_frame_timestamps_nanos())
    stream.send_columns(VIDEO, indexes=[at], columns=rr.VideoFrameReference.columns_nanos(stamps))
    markers, lines = [], []
    for index, alpha in enumerate(found.angles.alpha):
        markers.append([_closed(c) for c in found.corners[index] if not np.isnan(c).any()])
        known = not np.isnan(alpha).any()
        lines.append(linkage(neck, camera, pose_of(found, index), alpha) if known else [])
    colours = [_rgb(one) for one in next(([c for _, c in drawn] for drawn in lines if drawn), [])]
    _strips(rr, stream, f"{VIDEO}/markers", markers, [_rgb(MARKER)], at)
    _strips(rr, stream, f"{VIDEO}/linkage", [[points for points, _ in drawn] for drawn in lines], colours, at)


def _strips(rr: Any, stream: Any, entity: str, frames: list[list[np.ndarray]], colours: list[Any], at: Any) -> None:
    """Lines (K, 2), px, of every frame, as many as there are."""
    look = rr.LineStrips2D.from_fields(colors=colours, radii=rr.Radius.ui_points(_WIDTH))
    stream.log(entity, look, static=True)
    flat = [points for drawn in frames for points in drawn]
    columns = rr.LineStrips2D.columns(strips=flat).partition([len(drawn) for drawn in frames])
    stream.send_columns(entity, indexes=[at], columns=columns)


def _closed(corners: np.ndarray) -> np.ndarray:
    return np.concatenate([corners, corners[:1]])


def _rgb(bgr: tuple[int, int, int]) -> tuple[int, int, int]:
    return bgr[2], bgr[1], bgr[0]
