"""The markers of a whole video, its segments worked on one after the other or shared among processes."""

from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechanism.printed_markers import Markers
from vision.light_patch import LightPatch
from vision.markers.tracking import BY_EDGES, MarkerTracker, TrackingOptions
from vision.video import Segment, Video, read_segment
from xneck_foundation.one_blas_thread import one_blas_thread

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MarkerTracks:
    """All frames of a video: arrays (F, markers, ...) of the fields of `TrackedFrame`.

    Memory grows by 0.1 kB a frame and marker, with covariances by 0.4 kB.
    """

    time: Array
    """(F,), s, camera clock"""
    corners: Array
    covariance: NDArray[np.float32] | None
    status: NDArray[np.int8]
    hidden: NDArray[np.float32]
    clipped: NDArray[np.float32]
    fell_back: NDArray[np.bool_]
    foreign_ids: tuple[int, ...]
    """ids of the dictionary in view that are not on the arm"""
    light: Array | None = None
    """(F,): mean grey level of the rectangle in which a switched light is seen; None without a light"""


@dataclass(frozen=True)
class _SegmentTask:
    """What a process needs to track a segment."""

    video: Video
    segment: Segment
    markers: Markers
    options: TrackingOptions
    light: LightPatch | None


_FRAME_FIELDS = ("time", "corners", "covariance", "status", "hidden", "clipped", "fell_back")
_FIELDS = (*_FRAME_FIELDS, "light")


def track_video(
    video: Video,
    markers: Markers,
    options: TrackingOptions = BY_EDGES,
    workers: int = 1,
    progress: Callable[[int], object] = lambda frames: None,
    light: LightPatch | None = None,
) -> MarkerTracks:
    """The markers in every frame of `video`, and the brightness of a `light`; the result does not depend on `workers`.

    `progress` is called with each number of frames done. Raises Refused for a damaged video.
    """
    tasks = [_SegmentTask(video, segment, markers, options, light) for segment in video.segments]
    if workers == 1 or len(tasks) == 1:
        parts = [_track_segment(task, progress) for task in tasks]
    else:
        parts = []
        # fresh processes: a fork of one that has threads (OpenCV's, FFmpeg's) may hang
        with ProcessPoolExecutor(min(workers, len(tasks)), mp_context=get_context("spawn")) as pool:
            for part in pool.map(_track_segment, tasks):
                parts.append(part)
                progress(len(part.time))
    arrays = {name: _joined(np.concatenate, [getattr(part, name) for part in parts]) for name in _FIELDS}
    return MarkerTracks(**arrays, foreign_ids=tuple(sorted({i for part in parts for i in part.foreign_ids})))


@one_blas_thread
def _track_segment(task: _SegmentTask, progress: Callable[[int], object] = lambda frames: None) -> MarkerTracks:
    tracker = MarkerTracker(task.markers, task.options)
    tracked, brightness = [], []
    for frame in read_segment(task.video, task.segment):
        tracked.append(tracker.track(frame))
        if task.light:
            brightness.append(task.light.brightness(frame.grey))
        progress(1)
    arrays = {name: _joined(np.stack, [getattr(t, name) for t in tracked]) for name in _FRAME_FIELDS}
    arrays["light"] = np.array(brightness) if task.light else None
    return MarkerTracks(**arrays, foreign_ids=tuple(sorted({i for t in tracked for i in t.foreign_ids})))


def _joined(join: Callable[[list[Any]], Any], values: list[Any]) -> Any:
    """The values joined to one array; None where they are None."""
    return None if values[0] is None else join(values)
