"""Frames that show another moment than their stamps say, as where a stamp tells when a picture arrived and not when it was taken.

Three frames before and three after tell by a cubic in time where each marker was when. Where all markers are where they were at one
other moment, the picture is of that. Where an arm stops or starts between two frames it is off too; but then the frames around
hardly follow a cubic: where they come and go at unlike speeds a closer one is asked for.
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
"""slower over faster of the steps before and after, below which the arm may stop, start or turn over there (docs/thresholds.md)"""
MAX_ROUGHNESS_OF_TURNS = 0.05
"""MAX_ROUGHNESS where it may (docs/thresholds.md)"""
MIN_EXPLAINED_OF_TURNS = 0.98
"""MIN_EXPLAINED where it may (docs/thresholds.md)"""
_MAX_OFF_PERIODS = 2.0
"""periods before and after a frame's stamp in which its moment is looked for"""
_MOMENTS = 161


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
            off = _off(time[around] - time[frame], places[around][:, seen], places[frame, seen], period)
            late[frame] = -off if abs(off) > MIN_LATE_PERIODS * period else np.nan
    return late


def _off(since: Array, beside: Array, place: Array, period: float) -> float:
    """By how much later than its stamp a frame was taken, s; NaN where its distance from the others has another reason.

    since: (n,), s, of the frames around it; beside: (n, markers, 2), px, in these; place: (markers, 2), px, in the frame.
    """
    markers = len(place)
    beside, place = beside.reshape(len(since), -1), place.ravel()
    steps = np.diff(beside, axis=0)
    arrival, departure = steps[AROUND - 2], steps[AROUND]
    speeds = np.linalg.norm(arrival), np.linalg.norm(departure)
    goes_on = arrival @ departure > 0 and min(speeds) >= MIN_SPEED_RATIO * max(speeds)
    roughness, explained = (
        (MAX_ROUGHNESS, MIN_EXPLAINED) if goes_on else (MAX_ROUGHNESS_OF_TURNS, MIN_EXPLAINED_OF_TURNS)
    )
    powers = np.vander(since, 4, increasing=True)
    cubic = np.linalg.lstsq(powers, beside, rcond=None)[0]
    distance = place - cubic[0]
    by_marker = np.sort(np.linalg.norm(distance.reshape(markers, 2), axis=1))
    furthest = by_marker[-1]
    if markers < 2 or by_marker[-2] < MIN_OFF_PX or np.abs(beside - powers @ cubic).max() > roughness * furthest:
        return np.nan
    moments = period * np.linspace(-_MAX_OFF_PERIODS, _MAX_OFF_PERIODS, _MOMENTS)
    rest = np.sum((place - np.vander(moments, 4, increasing=True) @ cubic) ** 2, axis=1)
    nearest = int(rest.argmin())
    return float(moments[nearest]) if rest[nearest] < (1 - explained) * (distance @ distance) else np.nan
