"""The markers of a whole video, its segments worked on one after the other or shared among processes."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechanism.printed_markers import Markers
from vision.light_patch import LightPatch
from vision.markers.tracking import BY_EDGES, MarkerTracker, TrackedFrame, TrackingOptions
from vision.video import Segment, Video, read_segment
from xneck_foundation.one_blas_thread import one_blas_thread
from xneck_foundation.worker_processes import worker_processes

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
    row_shift: NDArray[np.float32]
    prints: Array
    """(n, 4), one row for each print of a marker in a frame that shows the marker more than once: time (s), index of the marker,
    x and y of the print's middle (px)"""
    foreign_ids: tuple[int, ...]
    """ids of the dictionary in view that are not on the arm"""
    light: Array | None = None
    """(F,): mean grey level of the rectangle in which a switched light is seen; None without a light"""

    def without(self, left_out: NDArray[np.bool_], status: int) -> "MarkerTracks":
        """The tracks without the corners of these markers in these frames, (F, markers), which get this status."""
        if not left_out.any():
            return self
        covariance = self.covariance
        if covariance is not None:
            covariance = np.where(left_out[..., None, None], np.float32(np.nan), covariance)
        return replace(
            self,
            corners=np.where(left_out[..., None, None], np.nan, self.corners),
            covariance=covariance,
            status=np.where(left_out, np.int8(status), self.status),
        )


@dataclass(frozen=True)
class _SegmentTask:
    """What a process needs to track a segment."""

    video: Video
    segment: Segment
    markers: Markers
    options: TrackingOptions
    light: LightPatch | None


_FRAME_FIELDS = ("time", "corners", "covariance", "status", "hidden", "clipped", "fell_back", "row_shift")
_FIELDS = (*_FRAME_FIELDS, "prints", "light")


def track_video(
    video: Video,
    markers: Markers,
    options: TrackingOptions = BY_EDGES,
    workers: int = 1,
    progress: Callable[[int], object] = lambda frames: None,
    light: LightPatch | None = None,
    tracked: Mapping[Segment, MarkerTracks] = MappingProxyType({}),
) -> MarkerTracks:
    """The markers in every frame of `video`, and the brightness of a `light`; the result does not depend on `workers`.

    `tracked` holds the tracks of segments that were tracked before, by the same options: these are not read again.
    `progress` is called with each number of frames done. Raises Refused for a damaged video.
    """
    done = {segment: tracked[segment] for segment in video.segments if segment in tracked}
    progress(sum(len(part.time) for part in done.values()))
    rest = [segment for segment in video.segments if segment not in done]
    done |= zip(rest, _track_segments(video, rest, markers, options, workers, progress, light), strict=True)
    return joined_tracks([done.pop(segment) for segment in video.segments])


def _track_segments(
    video: Video,
    segments: Sequence[Segment],
    markers: Markers,
    options: TrackingOptions,
    workers: int,
    progress: Callable[[int], object],
    light: LightPatch | None,
) -> list[MarkerTracks]:
    """The tracks of each segment."""
    tasks = [_SegmentTask(video, segment, markers, options, light) for segment in segments]
    if workers == 1 or len(tasks) < 2:
        return [_track_segment(task, progress) for task in tasks]
    parts = []
    with worker_processes(min(workers, len(tasks))) as pool:
        for part in pool.map(_track_segment, tasks):
            parts.append(part)
            progress(len(part.time))
    return parts


def joined_tracks(parts: list[MarkerTracks]) -> MarkerTracks:
    """Tracks of frames that follow each other, as one; the list is given up."""
    foreign_ids = tuple(sorted({i for part in parts for i in part.foreign_ids}))
    # field by field, each given up in the parts as it is joined: not all of it is there twice
    fields = [vars(part).copy() for part in parts]
    parts.clear()
    arrays = {name: _joined(np.concatenate, [of_part.pop(name) for of_part in fields]) for name in _FIELDS}
    return MarkerTracks(**arrays, foreign_ids=foreign_ids)


@one_blas_thread
def _track_segment(task: _SegmentTask, progress: Callable[[int], object] = lambda frames: None) -> MarkerTracks:
    tracker = MarkerTracker(task.markers, task.options)
    tracked, brightness = [], []
    for frame in read_segment(task.video, task.segment):
        tracked.append(tracker.track(frame))
        if task.light:
            brightness.append(task.light.brightness(frame.grey))
        progress(1)
    return tracks_of(tracked, brightness if task.light else None)


def tracks_of(tracked: Sequence[TrackedFrame], brightness: Sequence[float] | None) -> MarkerTracks:
    """Frames that were tracked one after the other, with the brightness of a switched light in each, as arrays over them."""
    arrays = {name: _joined(np.stack, [getattr(t, name) for t in tracked]) for name in _FRAME_FIELDS}
    arrays["prints"] = np.concatenate([t.prints for t in tracked])
    arrays["light"] = None if brightness is None else np.array(brightness)
    return MarkerTracks(**arrays, foreign_ids=tuple(sorted({i for t in tracked for i in t.foreign_ids})))


def _joined(join: Callable[[list[Any]], Any], values: list[Any]) -> Any:
    """The values joined to one array; None where they are None."""
    return None if values[0] is None else join(values)
