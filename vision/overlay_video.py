"""Videos with what was found drawn over every frame: the whole picture, and the arm alone in small."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from io import BytesIO
from pathlib import Path

import av
import av.container
import cv2
import numpy as np
from numpy.typing import NDArray

from calibration.camera import Camera
from mechanism.description import Neck
from vision.arm_region import arm_region
from vision.extract import Extraction
from vision.overlay import Picture, draw_linkage, draw_overlay
from vision.video import Frame, Video, read_segments
from xneck_foundation.authorship import MARK
from xneck_foundation.whole_file import whole_file

MAX_BYTES = 1_500_000
"""of the small video, however long the recording: a page holds it whole"""
MAX_SIDE_PX = 480
"""longer side of the small video"""
MAX_FRAMES_PER_S, MAX_FRAMES = 15.0, 900
"""of the small video; longer recordings have fewer frames a second"""
_KEY_FRAME_DISTANCE = 15
"""frames of the small video from one key frame to the next, which is what a browser decodes to show one between"""
_TICKS_PER_S = 90_000
_REPRODUCIBLE = {"fflags": "+bitexact"}
"""options of the file's writer, without which Matroska draws a random number for each file"""
_ENCODER_THREADS = 4
"""by default x264 takes as many as there are cores, and its bytes depend on them"""

TimedPicture = tuple[float, Picture]
"""s, and a BGR picture"""


@dataclass(frozen=True)
class SmallOverlay:
    """A video of the arm alone, with markers and linkage drawn over it, that is small enough to stand in a page."""

    mp4: bytes
    """H.264, at most MAX_BYTES; it begins at 0 s and every frame has the time that it has in the recording"""
    width: int
    height: int
    frames: NDArray[np.int64]
    """numbers, in the recording, of the frames that it has, (K,)"""


def write_overlay(
    video: Video,
    out: str | Path,
    neck: Neck,
    camera: Camera,
    extraction: Extraction,
    progress: Callable[[int], object] = lambda frames: None,
) -> None:
    """Write the whole video with its overlay as H.264, every frame at the time stamp it has."""
    width, height = camera.width // 2 * 2, camera.height // 2 * 2

    def drawn() -> Iterator[TimedPicture]:
        for frame in read_segments(video):
            yield frame.time, draw_overlay(frame.grey, frame.index, neck, camera, extraction)[:height, :width]
            progress(1)

    with whole_file(out) as part, av.open(str(part), "w", options=_REPRODUCIBLE) as container:
        _encode(container, drawn(), (width, height), {"crf": "23", "preset": "veryfast"}, _ENCODER_THREADS)


def small_overlay(frames: Iterable[Frame], neck: Neck, camera: Camera, extraction: Extraction) -> SmallOverlay:
    """The small video of all `frames` of a recording, as they are read, cut to the region in which the arm moves."""
    times = extraction.angles.time
    shown = _shown_frames(times)
    left, top, right, bottom = arm_region(extraction.corners, camera.width, camera.height)
    scale = min(1.0, MAX_SIDE_PX / max(right - left, bottom - top))
    width, height = (max(int(scale * side) // 2 * 2, 2) for side in (right - left, bottom - top))
    wanted = set(shown.tolist())

    def drawn() -> Iterator[TimedPicture]:
        for frame in frames:
            if frame.index in wanted:
                whole = draw_linkage(frame.grey, frame.index, neck, camera, extraction)
                cut = cv2.resize(whole[top:bottom, left:right], (width, height), interpolation=cv2.INTER_AREA)
                yield float(times[frame.index] - times[0]), cut

    duration_s = float(times[shown[-1]] - times[0]) + 1 / MAX_FRAMES_PER_S
    rate = round(0.9 * 8 * MAX_BYTES / duration_s)  # bits a second, less what the container itself takes
    options = {
        "crf": "30",
        "preset": "veryfast",
        "maxrate": str(rate),
        "bufsize": str(rate),
        "g": str(_KEY_FRAME_DISTANCE),
        "bf": "0",  # a frame that is shown before it is decoded would shift the beginning
    }
    out = BytesIO()
    with av.open(out, "w", format="mp4", options=_REPRODUCIBLE) as container:
        _encode(container, drawn(), (width, height), options, threads=1)
    return SmallOverlay(out.getvalue(), width, height, shown)


def _shown_frames(times: NDArray[np.float64]) -> NDArray[np.int64]:
    """Numbers of the frames that the small video of frames at `times` (F,), s, has: the first one, and others far enough apart."""
    apart_s = max(1 / MAX_FRAMES_PER_S, float(times[-1] - times[0]) / MAX_FRAMES)
    due = np.floor((times - times[0]) / apart_s + 1e-6)
    return np.unique(due, return_index=True)[1].astype(np.int64)


def _encode(
    container: av.container.OutputContainer,
    pictures: Iterable[TimedPicture],
    size: tuple[int, int],
    options: Mapping[str, str],
    threads: int,
) -> None:
    """H.264 of pictures of one even size (width, height)."""
    container.metadata["comment"] = MARK
    stream = container.add_stream("libx264", rate=30, options=dict(options))
    stream.width, stream.height = size
    stream.pix_fmt = "yuv420p"
    stream.codec_context.thread_count = threads
    stream.codec_context.time_base = Fraction(1, _TICKS_PER_S)
    for time, drawn in pictures:
        picture = av.VideoFrame.from_ndarray(np.ascontiguousarray(drawn), format="bgr24")
        picture.pts = round(time * _TICKS_PER_S)
        picture.time_base = Fraction(1, _TICKS_PER_S)
        container.mux(stream.encode(picture))
    container.mux(stream.encode(None))
