"""Markers followed as the frames of a growing video come, and what of it `run` can go on from.

Frames are followed just as `vision.markers.video_tracking` does it, each segment by a tracker of its own, so that a segment without
skipped frames has the tracks that `run` would make.
"""

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mechanism.description import Markers
from vision.extract import ExtractionOptions
from vision.markers.tracking import MarkerTracker, TrackedFrame
from vision.markers.video_tracking import MarkerTracks, tracks_of
from vision.video import Frame, Segment, Video
from xneck.watch.growing_video import GrowingFrame

Array = NDArray[np.float64]

KEPT_S = 30.0
"""s of the newest frames from which clock and identifiability are told at the end"""
MAX_KEPT_FRAMES = 100_000
"""frames whose tracks are kept for `run`: 55 minutes at 30 Hz, 0.2 GB"""
MAX_BEHIND_S, CAUGHT_UP_S = 3.0, 1.0
"""s behind the newest frame from which on frames are skipped, and until when"""
SKIPPED_OF = 5
"""while behind, one frame of so many is looked at"""
WHITE_PERCENTILE, BRIGHT_PERCENTILE, BLACK_PERCENTILE = 95, 75, 5
_SAMPLED_PX = 8
"""of a picture without markers, one pixel of so many in each direction is looked at"""


@dataclass(frozen=True)
class SeenFrame:
    """A frame with its markers and its light."""

    tracked: TrackedFrame
    white: Array
    """(markers,): grey level that the brightest twentieth of each marker exceeds, NaN where it was not found"""
    black: Array
    """(markers,): the same of the darkest"""
    bright: Array
    """(markers,): grey level that the brightest quarter of each marker exceeds; where white is clipped, it is `white`"""
    picture: tuple[float, float]
    """darkest and brightest twentieth of the whole picture"""

    @property
    def time(self) -> float:
        """s, camera clock."""
        return self.tracked.time


class VideoWatch:
    """Follows markers, frame by frame."""

    def __init__(self, markers: Markers, options: ExtractionOptions) -> None:
        self._markers, self._options = markers, options
        self._tracker = MarkerTracker(markers, options.tracking)
        self._segment_stamp: int | None = None
        self._whole = True
        self._open: list[TrackedFrame] = []
        self._brightness: list[float] = []
        self._done: dict[int, MarkerTracks] = {}
        """tracks of whole segments by their first stamp"""
        self._kept = 0
        self.recent: deque[SeenFrame] = deque()
        self.times: deque[float] = deque(maxlen=400)
        """s, of the newest frames, skipped ones too"""
        self.first_s: float | None = None
        self.frames = self.skipped = 0
        self.catching_up = False

    def take(self, frame: GrowingFrame, behind_s: float) -> SeenFrame | None:
        """Follows the markers into a frame that is `behind_s` older than the newest one; None where it was skipped."""
        if frame.segment_stamp != self._segment_stamp:
            self._begin_segment(frame.segment_stamp)
        self.frames += 1
        self.first_s = frame.frame.time if self.first_s is None else self.first_s
        self.times.append(frame.frame.time)
        self.catching_up = behind_s > (CAUGHT_UP_S if self.catching_up else MAX_BEHIND_S)
        if self.catching_up and self.frames % SKIPPED_OF:
            self._whole = False
            self._open.clear()
            self.skipped += 1
            return None
        tracked = self._tracker.track(frame.frame)
        if self._whole and self._kept < MAX_KEPT_FRAMES:
            self._kept += 1
            self._open.append(tracked)
            if self._options.light:
                self._brightness.append(self._options.light.brightness(frame.frame.grey))
        else:
            self._whole = False
        seen = _with_light(frame.frame, tracked)
        self.recent.append(seen)
        while self.recent[0].time < seen.time - KEPT_S:
            self.recent.popleft()
        return seen

    def kept_tracks(self, video: Video) -> dict[Segment, MarkerTracks]:
        """The tracks of those segments of the finished video that were followed without a gap."""
        self._end_segment()
        return {
            segment: tracks
            for segment in video.segments
            if (tracks := self._done.get(segment.first_stamp)) is not None and len(tracks.time) == segment.count
        }

    def _begin_segment(self, stamp: int) -> None:
        self._end_segment()
        self._segment_stamp, self._whole = stamp, True
        self._tracker = MarkerTracker(self._markers, self._options.tracking)

    def _end_segment(self) -> None:
        if self._whole and self._open and self._segment_stamp is not None:
            brightness = self._brightness if self._options.light else None
            self._done[self._segment_stamp] = tracks_of(self._open, brightness)
        self._open, self._brightness = [], []


def _with_light(frame: Frame, tracked: TrackedFrame) -> SeenFrame:
    height, width = frame.grey.shape
    levels = np.full((len(tracked.corners), 3), np.nan)
    for k, corners in enumerate(tracked.corners):
        if np.isnan(corners).any():
            continue
        low, high = np.floor(corners.min(axis=0)).astype(int), np.ceil(corners.max(axis=0)).astype(int)
        x0, y0 = np.clip(low, 0, (width - 1, height - 1))
        x1, y1 = np.clip(high, (x0 + 1, y0 + 1), (width, height))
        levels[k] = np.percentile(frame.grey[y0:y1, x0:x1], [BLACK_PERCENTILE, BRIGHT_PERCENTILE, WHITE_PERCENTILE])
    picture = np.percentile(frame.grey[::_SAMPLED_PX, ::_SAMPLED_PX], [BLACK_PERCENTILE, WHITE_PERCENTILE])
    return SeenFrame(tracked, levels[:, 2], levels[:, 0], levels[:, 1], (float(picture[0]), float(picture[1])))
