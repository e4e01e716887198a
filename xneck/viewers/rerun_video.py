"""The video in Rerun, with markers and linkage drawn over every frame. Needs PyAV and OpenCV."""

from pathlib import Path
from typing import Any

import numpy as np

from mechanism.description import Neck
from vision.overlay import MARKER_COLOUR, frame_pose, linkage_lines
from xneck.recording.camera_stages import VideoResult
from xneck.viewers.rerun_layout import VIDEO_ENTITY
from xneck.viewers.viewer_video import viewer_video

_LINE_WIDTH = 1.5
"""in the viewer's points, whatever the zoom"""


def write_video(rr: Any, stream: Any, video: Path, neck: Neck, result: VideoResult, index: Any) -> None:
    """Writes the video and the lines over it; `index` is Rerun's column with the time of each frame."""
    asset = rr.AssetVideo(contents=viewer_video(video), media_type="video/mp4")
    stream.log(VIDEO_ENTITY, asset, static=True)
    stamps = np.sort(asset.read_frame_timestamps_nanos())
    stream.send_columns(VIDEO_ENTITY, indexes=[index], columns=rr.VideoFrameReference.columns_nanos(stamps))
    extraction = result.extraction
    markers, linkages = [], []
    for frame, alpha in enumerate(extraction.angles.alpha):
        markers.append([_closed(c) for c in extraction.corners[frame] if not np.isnan(c).any()])
        complete = not np.isnan(alpha).any()
        pose = frame_pose(extraction, frame)
        linkages.append(linkage_lines(neck, result.camera, pose, alpha) if complete else [])
    colours = next(([_rgb(colour) for _, colour in linkage] for linkage in linkages if linkage), [])
    strips = [[points for points, _ in linkage] for linkage in linkages]
    _write_strips(rr, stream, f"{VIDEO_ENTITY}/markers", markers, [_rgb(MARKER_COLOUR)], index)
    _write_strips(rr, stream, f"{VIDEO_ENTITY}/linkage", strips, colours, index)


def _write_strips(
    rr: Any, stream: Any, entity: str, frames: list[list[np.ndarray]], colours: list[Any], index: Any
) -> None:
    """Writes the lines of every frame, each (K, 2), px."""
    appearance = rr.LineStrips2D.from_fields(colors=colours, radii=rr.Radius.ui_points(_LINE_WIDTH))
    stream.log(entity, appearance, static=True)
    strips = [points for frame in frames for points in frame]
    columns = rr.LineStrips2D.columns(strips=strips).partition([len(frame) for frame in frames])
    stream.send_columns(entity, indexes=[index], columns=columns)


def _closed(corners: np.ndarray) -> np.ndarray:
    return np.concatenate([corners, corners[:1]])


def _rgb(bgr: tuple[int, int, int]) -> tuple[int, int, int]:
    return bgr[2], bgr[1], bgr[0]
