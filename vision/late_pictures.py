"""Frames that show another moment than their stamps say, as where a stamp tells when a picture arrived and not when it was taken.

Three frames before and three after tell by a cubic in time where each marker is at the frame's stamp, and how fast it is. Where all
markers are off along their velocities by the same time, the picture is of that other moment. Where an arm stops or turns over
between two frames it is off too; but then the frames around follow no cubic, or go on in another way than they came.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

AROUND = 3
"""frames on each side that tell where the markers should be (docs/thresholds.md)"""
MAX_SPAN_S = 0.5
"""s from the first to the last of these frames, above which they tell nothing (docs/thresholds.md)"""
MIN_LATE_PERIODS = 0.35
"""periods of the frames by which a picture must be off (docs/thresholds.md)"""
MIN_OFF_PX = 0.5
"""px by which two markers must be off: one alone may have been measured wrong (docs/thresholds.md)"""
MAX_ROUGHNESS = 0.15
"""how far the frames around are from their cubic, over how far the frame is, above which the arm does not move smoothly
(docs/thresholds.md)"""
MIN_EXPLAINED = 0.9
"""share of the squared distance of all markers that one other moment must explain (docs/thresholds.md)"""
MIN_SPEED_RATIO = 0.5
"""slower over faster of the steps before and after, below which the arm stops or starts there (docs/thresholds.md)"""


def late_pictures(time: Array, corners: Array) -> Array:
    """By how much earlier than its stamp a frame was taken, (F,), s; NaN where it is on time, or nothing tells.

    time: (F,), s; corners: (F, markers, 4, 2), px, NaN where a marker was not found.
    """
    late = np.full(len(time), np.nan)
    places = corners.mean(axis=2)
    period = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    for frame in range(AROUND, len(time) - AROUND):
        around = [*range(frame - AROUND, frame), *range(frame + 1, frame + AROUND + 1)]
        seen = ~np.isnan(places[[frame, *around]]).any(axis=(0, 2))
        if seen.any() and time[around[-1]] - time[around[0]] < MAX_SPAN_S:
            off = _off(time[around] - time[frame], places[around][:, seen], places[frame, seen])
            late[frame] = -off if abs(off) > MIN_LATE_PERIODS * period else np.nan
    return late


def _off(since: Array, beside: Array, place: Array) -> float:
    """By how much later than its stamp a frame was taken, s; NaN where its distance from the others has another reason.

    since: (n,), s, of the frames around it; beside: (n, markers, 2), px, in these; place: (markers, 2), px, in the frame.
    """
    markers = len(place)
    beside, place = beside.reshape(len(since), -1), place.ravel()
    steps = np.diff(beside, axis=0)
    arrival, departure = steps[AROUND - 2], steps[AROUND]
    speeds = np.linalg.norm(arrival), np.linalg.norm(departure)
    if arrival @ departure <= 0 or min(speeds) < MIN_SPEED_RATIO * max(speeds):
        return np.nan
    powers = np.vander(since, 4, increasing=True)
    cubic = np.linalg.lstsq(powers, beside, rcond=None)[0]
    distance, velocity = place - cubic[0], cubic[1]
    by_marker = np.sort(np.linalg.norm(distance.reshape(markers, 2), axis=1))
    furthest = by_marker[-1]
    if markers < 2 or by_marker[-2] < MIN_OFF_PX or np.abs(beside - powers @ cubic).max() > MAX_ROUGHNESS * furthest:
        return np.nan
    off = float(distance @ velocity / (velocity @ velocity))
    rest = distance - off * velocity
    return off if rest @ rest < (1 - MIN_EXPLAINED) * (distance @ distance) else np.nan
