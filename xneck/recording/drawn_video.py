"""A recording's video with what was found drawn over it: a few frames, and the whole in small. Needs OpenCV and PyAV."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mechanism.description import Neck
from vision.overlay import draw_overlay
from vision.overlay_video import SmallOverlay, small_overlay
from vision.video import Frame, describe_video, read_segments
from xneck.recording.camera_stages import VideoResult
from xneck_foundation.whole_file import whole_file

SPREAD_FRAMES = 4
"""frames of the report that are spread over the video"""


@dataclass(frozen=True)
class AnnotatedFrame:
    """A frame with its markers, its linkage and its angles drawn over it."""

    index: int
    picture: NDArray[np.uint8]
    """(height, width, 3), BGR"""


@dataclass(frozen=True)
class DrawnVideo:
    """What the report shows of a video."""

    frames: tuple[AnnotatedFrame, ...]
    """spread over the video, and the one in which the arm is bent most"""
    overlay: SmallOverlay

    def write_file(self, file: Path) -> None:
        """The small video, as a file of its own."""
        with whole_file(file) as part:
            part.write_bytes(self.overlay.mp4)


def draw_video(file: Path, neck: Neck, video: VideoResult) -> DrawnVideo:
    """What the report shows of the video in `file`, which is read once more. Raises Refused where it was changed meanwhile."""
    camera, extraction = video.camera, video.extraction
    angles = extraction.angles
    bent_most = int(np.nanargmax(np.nan_to_num(np.abs(angles.alpha)).sum(axis=1)))
    wanted = {*np.linspace(0, len(angles.time) - 1, SPREAD_FRAMES, dtype=int).tolist(), bent_most}
    annotated = []

    def frames() -> Iterator[Frame]:
        for frame in read_segments(describe_video(file)):
            if frame.index in wanted:
                picture = draw_overlay(frame.grey, frame.index, neck, camera, extraction)
                annotated.append(AnnotatedFrame(frame.index, picture))
            yield frame

    overlay = small_overlay(frames(), neck, camera, extraction)
    return DrawnVideo(tuple(annotated), overlay)
