"""A whole video followed marker by marker, its segments one after the other or shared among processes."""

from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context

import numpy as np
from numpy.typing import NDArray

from mechanism.description import Markers
from vision.tracking import Tracker
from vision.video import Segment, Video, frames_of

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Followed:
    """All frames of a video: memory grows by some hundred bytes a frame."""

    time: Array
    """(F,), s, camera clock"""
    corners: Array
    """(F, markers, 4, 2), px, NaN where not found"""
    how: NDArray[np.int8]
    """(F, markers), words of tracking.py"""
    foreign: tuple[int, ...]
    """ids of the dictionary in view that are not on the arm"""


def follow(
    video: Video, markers: Markers, workers: int = 1, progress: Callable[[int], object] = lambda frames: None
) -> Followed:
    """Every frame of `video`; the result does not depend on `workers`. Raises Refused for damage."""
    work = [(video, segment, markers) for segment in video.segments]
    if workers == 1 or len(work) == 1:
        parts = [_segment(one, progress) for one in work]
    else:
        parts = []
        # fresh processes: a fork of one that has threads (OpenCV's, FFmpeg's) may hang
        with ProcessPoolExecutor(min(workers, len(work)), mp_context=get_context("spawn")) as pool:
            for part in pool.map(_segment, work):
                parts.append(part)
                progress(len(part.time))
    return Followed(
        np.concatenate([p.time for p in parts]),
        np.concatenate([p.corners for p in parts]),
        np.concatenate([p.how for p in parts]),
        tuple(sorted({i for p in parts for i in p.foreign})),
    )


def _segment(work: tuple[Video, Segment, Markers], progress: Callable[[int], object] = lambda frames: None) -> Followed:
    video, segment, markers = work
    tracker = Tracker(markers)
    seen = []
    for frame in frames_of(video, segment):
        seen.append(tracker.see(frame))
        progress(1)
    return Followed(
        np.array([s.time for s in seen]),
        np.stack([s.corners for s in seen]),
        np.stack([s.how for s in seen]),
        tuple(sorted({i for s in seen for i in s.foreign})),
    )
