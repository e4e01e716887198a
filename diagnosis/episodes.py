"""Residuals over time, by windows: RMS before and after, and the windows in which they stand above all that noise does."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diagnosis.linearisation import RecordingLinearisation

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

WINDOW_S = 0.5
"""a push of a hand lasts about so long; 8 Hz leave some 8 numbers in it"""
MOST = 120
"""windows of a recording"""
MOSTLY = 0.8
"""of what a channel has above noise, that short episodes hold together"""
_LISTED = 0.9
"""of the same, that the episodes hold which are listed"""
SELDOM = 1 / 3
"""of the time, that they take at most: else it is no episode but the rule"""


@dataclass(frozen=True)
class Course:
    """Of one recording: begins of windows (W,), s from its start, their length, and RMS of each channel (C, W)."""

    begin: Array
    length: float
    before: Array
    after: Array
    noise: Array
    """of noise alone, (C,)"""
    above: Mask
    """(C, W): where before is more than noise comes to in any window"""


@dataclass(frozen=True)
class Episode:
    """s from the start of a recording, counted from 0."""

    recording: int
    begin: float
    end: float


def course(place: RecordingLinearisation, before: Array, after: Array, drawn: Sequence[Array]) -> Course:
    """Of residuals (C, S), and of noise's draws."""
    s = place.signals
    time = s.time[s.low_pass.kept] - s.time[0]
    length = max(WINDOW_S, float(time[-1] - time[0]) / MOST)
    which = ((time - time[0]) / length).astype(int)
    used, which = np.unique(which, return_inverse=True)
    noise = [_rms(d, which) for d in drawn]
    was = _rms(before, which)
    most = np.max([n.max(axis=1) for n in noise], axis=0)
    floor = np.sqrt(np.mean([np.mean(d**2, axis=1) for d in drawn], axis=0))
    return Course(time[0] + used * length, length, was, _rms(after, which), floor, was > most[:, None])


def _rms(residual: Array, which: NDArray[np.intp]) -> Array:
    count = np.bincount(which)
    return np.sqrt(np.stack([np.bincount(which, r**2) / count for r in residual]))


def brief(courses: Sequence[Course], channel: int) -> float:
    """Share of what a channel has above noise that its episodes hold; 0 where they are not short and few."""
    above = np.concatenate([c.above[channel] for c in courses])
    excess = np.concatenate([np.maximum(c.before[channel] ** 2 - c.noise[channel] ** 2, 0) for c in courses])
    # the fewest windows that hold most of it
    order = np.sort(excess * above)[::-1]
    if excess.sum() <= 0 or order.sum() < MOSTLY * excess.sum():
        return 0.0
    needed = int(np.searchsorted(np.cumsum(order), MOSTLY * excess.sum())) + 1
    return float(order[:needed].sum() / excess.sum()) if needed <= SELDOM * len(order) else 0.0


def episodes(courses: Sequence[Course], channels: Sequence[int]) -> tuple[Episode, ...]:
    """Stretches of windows that hold _LISTED of what these channels have above noise, in units of it; neighbours are one."""
    weight = [
        sum((np.maximum(c.before[k] ** 2 / c.noise[k] ** 2 - 1, 0) for k in channels), np.zeros(len(c.begin)))
        for c in courses
    ]
    flat = np.sort(np.concatenate(weight))[::-1]
    least = flat[min(int(np.searchsorted(np.cumsum(flat), _LISTED * flat.sum())), len(flat) - 1)]
    out = []
    for recording, (c, w) in enumerate(zip(courses, weight, strict=True)):
        edge = np.flatnonzero(np.diff(np.concatenate([[False], w >= least, [False]]).astype(int)))
        for first, beyond in zip(edge[::2].tolist(), edge[1::2].tolist(), strict=True):
            out.append(Episode(recording, float(c.begin[first]), float(c.begin[beyond - 1] + c.length)))
    return tuple(out)
