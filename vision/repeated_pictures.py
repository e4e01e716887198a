"""Frames that show the picture before them again, as a camera's driver or a converter of frame rates delivers when none is ready.

Such a frame has a stamp of its own but the arm of an earlier moment, so its angles are wrong by what the arm moved since. A lossy
codec changes the copy a little: equal grey levels tell nothing. What tells is that all markers stand still for a frame while they
move on, the same way, before and after it. Where the motion turns over, the pictures around it lie on one smooth path, and the
still one lies beside it. An arm at rest cannot be told from a repeated picture of it, and need not be.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

STILL_PX = 0.1
"""px: markers that all moved by less stand still (docs/thresholds.md)"""
STILL_SHARE = 0.05
"""of what a marker moved in the frame before, by which it may move further and stand still: that far a codec changes the copy of a
fast marker (docs/thresholds.md)"""
MIN_MOTION_PX = 0.5
"""px: a marker that moves by more, in the frame before and in the frame after, shows that a stop is none (docs/thresholds.md)"""
MIN_CATCH_UP = 1.5
"""apparent speed of the frame after several still ones over the speed later: an arm that moved unseen is at once where it would be,
one that stood still speeds up (docs/thresholds.md)"""
AROUND = 3
"""pictures on each side that tell a smooth path (docs/thresholds.md)"""
MAX_SPAN_S = 0.5
"""s from the first to the last of these, above which they tell none (docs/thresholds.md)"""
MAX_STILL = 3
"""still frames beside a smooth path that may repeat a picture: an arm that stands for longer leaves as smooth a path
(docs/thresholds.md)"""
MAX_ROUGHNESS = 0.1
"""how far the pictures around are from their path, over how far a still one is from it, up to which it is a repeated one
(docs/thresholds.md)"""


@dataclass(frozen=True)
class _Stop:
    """Successive frames in which no marker moves: the first shows where they are, the others may repeat it."""

    first: int
    last: int


def repeated_pictures(time: Array, corners: Array) -> NDArray[np.bool_]:
    """Frames that repeat the picture before them, (F,), of markers that move; frames of an arm at rest are none.

    time: (F,), s; corners: (F, markers, 4, 2), px, NaN where a marker was not found.
    """
    places = corners.mean(axis=2)
    stops = _stops(places)
    repeated = np.zeros(len(time), dtype=bool)
    for k in range(1, len(stops) - 2):
        if stops[k].last == stops[k].first:
            continue
        around = stops[k - AROUND + 1 : k + AROUND + 1] if k >= AROUND - 1 else []
        if _moves_on(time, places, stops[k - 1 : k + 3]) or _is_beside_path(time, places, around):
            repeated[stops[k].first + 1 : stops[k].last + 1] = True
    return repeated


def _stops(places: Array) -> list[_Stop]:
    """All frames, those together in which markers are where they are in the first of them.

    That is within STILL_PX, and a share of what they moved in the frame before it."""
    firsts, still_px = [0], np.full(places.shape[1], STILL_PX)
    for frame in range(1, len(places)):
        moved = np.linalg.norm(places[frame] - places[firsts[-1]], axis=-1)
        if np.isnan(moved).all() or np.nanmax(moved - still_px) > 0:
            firsts.append(frame)
            arrival = np.linalg.norm(places[frame] - places[frame - 1], axis=-1)
            still_px = STILL_PX + STILL_SHARE * np.nan_to_num(arrival)
    return [_Stop(first, after - 1) for first, after in pairwise([*firsts, len(places)])]


def _moves_on(time: Array, places: Array, stops: list[_Stop]) -> bool:
    """Whether the markers were moving when they came to the second of four stops, and are at speed when they leave it."""
    before, stop, after, later = stops
    arrival, departure = places[stop.first] - places[before.last], places[after.first] - places[stop.last]
    moved = np.minimum(np.linalg.norm(arrival, axis=-1), np.linalg.norm(departure, axis=-1))
    several = stop.last - stop.first > 1
    if not several:
        # a motion that turns over may stand still for a frame; one that goes on does not
        moved = np.where(np.sum(arrival * departure, axis=-1) > 0, moved, 0.0)
    if np.isnan(moved).all() or np.nanmax(moved) < MIN_MOTION_PX:
        return False
    if not several:
        return True
    marker = int(np.nanargmax(moved))
    speed = np.linalg.norm(departure[marker]) / (time[after.first] - time[stop.last])
    # what the next pictures show happened since the first frame of the last one, if that was repeated too
    speed_later = np.linalg.norm(places[later.first, marker] - places[after.last, marker]) / (
        time[later.first] - time[after.first]
    )
    return bool(speed > MIN_CATCH_UP * speed_later)


def _is_beside_path(time: Array, places: Array, stops: list[_Stop]) -> bool:
    """Whether the still frames of the middle one of 2 AROUND stops lie beside the path that the first pictures of all are on.

    The path is a cubic in time. An arm that was braked, stood, and was driven back leaves the corners of its path, which no cubic
    goes through; one that turned over at that place lies on it."""
    if len(stops) < 2 * AROUND:
        return False
    pictures = [stop.first for stop in stops]
    still = np.arange(stops[AROUND - 1].first + 1, stops[AROUND - 1].last + 1)
    seen = ~np.isnan(places[[*pictures, *still]]).any(axis=(0, 2))
    if len(still) > MAX_STILL or not seen.any() or time[pictures[-1]] - time[pictures[0]] > MAX_SPAN_S:
        return False
    start = time[pictures[AROUND - 1]]
    powers = np.vander(time[pictures] - start, 4, increasing=True)
    at = places[pictures][:, seen].reshape(len(pictures), -1)
    path = np.linalg.lstsq(powers, at, rcond=None)[0]
    beside = places[still][:, seen].reshape(len(still), -1) - np.vander(time[still] - start, 4, increasing=True) @ path
    furthest = float(np.linalg.norm(beside.reshape(len(still), -1, 2), axis=2).max())
    return furthest > MIN_MOTION_PX and float(np.abs(at - powers @ path).max()) < MAX_ROUGHNESS * furthest
