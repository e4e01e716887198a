"""Residuals over time, by windows: RMS before and after, and the windows in which they stand above all that noise does."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

WINDOW_S = 0.5
"""s: length of the windows in which episodes are looked for (docs/thresholds.md)"""
MAX_WINDOWS = 120
"""of a recording: of a long one they are longer (docs/thresholds.md)"""
MIN_EPISODE_SHARE = 0.8
"""of what a channel has above noise, that short episodes hold together (docs/thresholds.md)"""
_LISTED_SHARE = 0.9
"""of what the channels have above noise, that the episodes hold which are listed (docs/thresholds.md)"""
MAX_TIME_SHARE = 1 / 3
"""of the time, that short episodes take at most: else it is no episode but the rule (docs/thresholds.md)"""


@dataclass(frozen=True)
class RmsCourse:
    """RMS of a recording's residuals by W windows."""

    window_starts: Array
    """(W,), s from the recording's start"""
    window_s: float
    before: Array
    """of each channel with the base model, (C, W)"""
    after: Array
    """of each channel with the causes, (C, W)"""
    noise: Array
    """of noise alone, (C,)"""
    above: Mask
    """(C, W): where `before` is more than noise comes to in any window"""


@dataclass(frozen=True)
class Episode:
    """A stretch of a recording, which is counted from 0; s from its start."""

    recording: int
    begin: float
    end: float


def rms_course(time: Array, before: Array, after: Array, noise_draws: Sequence[Array]) -> RmsCourse:
    """Of residuals (C, S), and of draws of noise; time: of their rows, (S,), s from the recording's start."""
    window_s = max(WINDOW_S, float(time[-1] - time[0]) / MAX_WINDOWS)
    window = ((time - time[0]) / window_s).astype(int)
    used, window = np.unique(window, return_inverse=True)
    noise = [_rms(d, window) for d in noise_draws]
    rms_before = _rms(before, window)
    noise_maximum = np.max([n.max(axis=1) for n in noise], axis=0)
    return RmsCourse(
        window_starts=time[0] + used * window_s,
        window_s=window_s,
        before=rms_before,
        after=_rms(after, window),
        noise=np.sqrt(np.mean([np.mean(d**2, axis=1) for d in noise_draws], axis=0)),
        above=rms_before > noise_maximum[:, None],
    )


def _rms(residual: Array, window: NDArray[np.intp]) -> Array:
    """Of every channel by windows, (C, W); window: of each row, (S,)."""
    count = np.bincount(window)
    return np.sqrt(np.stack([np.bincount(window, r**2) / count for r in residual]))


def episode_share(courses: Sequence[RmsCourse], channel: int) -> float:
    """Share of what a channel has above noise that its episodes hold; 0 where they are not short and few."""
    above = np.concatenate([c.above[channel] for c in courses])
    excess = np.concatenate([np.maximum(c.before[channel] ** 2 - c.noise[channel] ** 2, 0) for c in courses])
    # the fewest windows that hold most of it
    order = np.sort(excess * above)[::-1]
    if excess.sum() <= 0 or order.sum() < MIN_EPISODE_SHARE * excess.sum():
        return 0.0
    needed = int(np.searchsorted(np.cumsum(order), MIN_EPISODE_SHARE * excess.sum())) + 1
    return float(order[:needed].sum() / excess.sum()) if needed <= MAX_TIME_SHARE * len(order) else 0.0


def episodes(courses: Sequence[RmsCourse], channels: Sequence[int]) -> tuple[Episode, ...]:
    """Stretches of windows that hold _LISTED_SHARE of what these channels have above noise, in units of it; neighbours are one."""
    weights = [
        sum((np.maximum(c.before[k] ** 2 / c.noise[k] ** 2 - 1, 0) for k in channels), np.zeros(len(c.window_starts)))
        for c in courses
    ]
    flat = np.sort(np.concatenate(weights))[::-1]
    least = flat[min(int(np.searchsorted(np.cumsum(flat), _LISTED_SHARE * flat.sum())), len(flat) - 1)]
    out = []
    for recording, (c, weight) in enumerate(zip(courses, weights, strict=True)):
        edge = np.flatnonzero(np.diff(np.concatenate([[False], weight >= least, [False]]).astype(int)))
        for first, beyond in zip(edge[::2].tolist(), edge[1::2].tolist(), strict=True):
            end = float(c.window_starts[beyond - 1] + c.window_s)
            out.append(Episode(recording, float(c.window_starts[first]), end))
    return tuple(out)
