"""A whole video followed marker by marker, its segments one after the other or shared among processes."""

from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechanism.description import Markers
from vision.light_patch import LightPatch
from vision.markers.tracking import BY_EDGES, MarkerTracker, TrackingOptions
from vision.video import Segment, Video, read_segment

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MarkerTracks:
    """All frames of a video, arrays (F, markers, ...) of what `Sighting` has for each.

    Memory grows by 0.1 kB a frame and marker, with covariances by 0.4 kB.
    """

    time: Array
    """(F,), s, camera clock"""
    corners: Array
    covariance: NDArray[np.float32] | None
    how: NDArray[np.int8]
    hidden: NDArray[np.float32]
    clipped: NDArray[np.float32]
    fell_back: NDArray[np.bool_]
    foreign: tuple[int, ...]
    """ids of the dictionary in view that are not on the arm"""
    light: Array | None = None
    """(F,): mean grey level where a switched light is to be seen; None without one"""


def track_video(
    video: Video,
    markers: Markers,
    manner: TrackingOptions = BY_EDGES,
    workers: int = 1,
    progress: Callable[[int], object] = lambda frames: None,
    light: LightPatch | None = None,
) -> MarkerTracks:
    """Every frame of `video`, with the brightness of a `light`; the result does not depend on `workers`.

    Raises Refused for damage.
    """
    work = [(video, segment, markers, manner, light) for segment in video.segments]
    if workers == 1 or len(work) == 1:
        parts = [_segment(one, progress) for one in work]
    else:
        parts = []
        # fresh processes: a fork of one that has threads (OpenCV's, FFmpeg's) may hang
        with ProcessPoolExecutor(min(workers, len(work)), mp_context=get_context("spawn")) as pool:
            for part in pool.map(_segment, work):
                parts.append(part)
                progress(len(part.time))
    arrays = {name: _joined(np.concatenate, [getattr(part, name) for part in parts]) for name in _ARRAYS}
    return MarkerTracks(**arrays, foreign=tuple(sorted({i for part in parts for i in part.foreign})))


def _joined(how: Callable[[list[Any]], Any], values: list[Any]) -> Any:
    return None if values[0] is None else how(values)


_SEEN = ("time", "corners", "covariance", "how", "hidden", "clipped", "fell_back")
_ARRAYS = (*_SEEN, "light")


def _segment(
    work: tuple[Video, Segment, Markers, TrackingOptions, LightPatch | None],
    progress: Callable[[int], object] = lambda frames: None,
) -> MarkerTracks:
    video, segment, markers, manner, light = work
    tracker = MarkerTracker(markers, manner)
    seen, brightness = [], []
    for frame in read_segment(video, segment):
        seen.append(tracker.see(frame))
        if light:
            brightness.append(light.brightness(frame.grey))
        progress(1)
    arrays = {name: _joined(np.stack, [getattr(s, name) for s in seen]) for name in _SEEN}
    arrays["light"] = np.array(brightness) if light else None
    return MarkerTracks(**arrays, foreign=tuple(sorted({i for s in seen for i in s.foreign})))
