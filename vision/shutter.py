"""When a picture was really taken: exposure, the rows of a rolling shutter, and what the frame's stamp means.

All angles of a frame are stated for one moment: the middle of the exposure of the middle row. A delay that is the same for
all frames is left to the clocks.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_FRAMES_AT_ONCE = 2000
"""frames that are worked on at once, so that memory does not grow with the recording"""
Stamp = Literal["start", "middle", "end"]


@dataclass(frozen=True)
class Shutter:
    """The camera's timing; the default stands for nothing known."""

    exposure_s: float = 0.0
    row_s: float = 0.0
    """s from the exposure of a row to that of the row below it; negative where the shutter runs upwards"""
    stamp: Stamp = "middle"
    """what a frame's stamp marks: begin of the first row's exposure, middle of the middle row's, end of the last row's"""

    def middle(self, stamps: Array, height: int) -> Array:
        """Times at which the exposure of the middle row is half over, shape (F,), s."""
        half = self.exposure_s / 2 + abs(self.row_s) * (height - 1) / 2
        return stamps + {"start": half, "middle": 0.0, "end": -half}[self.stamp]


UNKNOWN_SHUTTER = Shutter()


def at_middle_row(time: Array, corners: Array, height: int, shutter: Shutter) -> Array:
    """Corners (F, markers, 4, 2), px, moved along their own motion to where they were when the middle row was exposed."""
    if not shutter.row_s:
        return corners
    delay = (corners[..., 1:] - (height - 1) / 2) * shutter.row_s
    return corners - velocity(time, corners) * delay


def velocity(time: Array, corners: Array) -> Array:
    """Velocity of corners in px/s by central differences; one-sided where a neighbour is missing, zero where both are."""
    parts = [
        velocity_at(time, corners, np.arange(begin, min(begin + _FRAMES_AT_ONCE, len(corners))))
        for begin in range(0, len(corners), _FRAMES_AT_ONCE)
    ]
    return np.concatenate(parts)


def velocity_at(time: Array, corners: Array, frames: NDArray[np.intp]) -> Array:
    """`velocity` in some of the frames alone."""
    last = len(corners) - 1
    earlier, later = np.maximum(frames - 1, 0), np.minimum(frames + 1, last)
    shape = (-1, *[1] * (corners.ndim - 1))
    first, end = (frames == 0).reshape(shape), (frames == last).reshape(shape)
    gap, next_gap = (time[frames] - time[earlier]).reshape(shape), (time[later] - time[frames]).reshape(shape)
    # before the first frame and after the last one nothing is known, and the interval is that of the other side
    gap, next_gap = np.where(first, next_gap, gap), np.where(end, gap, next_gap)
    before = np.where(first, np.nan, (corners[frames] - corners[earlier]) / gap)
    after = np.where(end, np.nan, (corners[later] - corners[frames]) / next_gap)
    # weights by the other side's interval make the mean exact for a parabola
    both = (before * next_gap + after * gap) / (gap + next_gap)
    return np.nan_to_num(np.where(np.isnan(both), np.where(np.isnan(before), after, before), both))
