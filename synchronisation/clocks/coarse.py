"""Where the log and the video show the same motion: correlation of cable speeds over all shifts.

Says how alike the motions are at the best shift, whether another shift is nearly as good, and how each cable does by itself.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import correlate

from synchronisation.clocks.signals import low_pass

Array = NDArray[np.float64]

RATE = 50.0
"""Hz, of the comparison"""
CUTOFF = 6.0
"""Hz"""
MIN_OVERLAP = 5.0
"""s"""
APART = 0.25
"""s: peaks nearer than this are one"""
WINDOW = 12.0
"""s of video that are looked for in the log where the whole does not fit, as after lost frames"""


@dataclass(frozen=True)
class Match:
    """The best shift and what speaks against it."""

    shift: float
    """log time less camera time, s"""
    likeness: float
    """normalised correlation of all cables' speeds at the best shift"""
    second: float
    """the next best peak's correlation over the best one's"""
    own: Array
    """(M,): each cable's correlation around the best shift"""
    elsewhere: Array
    """(M,): each cable's best correlation over all shifts"""
    elsewhere_shift: Array
    """(M,), s: where that is, against the best shift"""
    span: tuple[float, float]
    """camera times that were compared, s"""


@dataclass(frozen=True)
class Speeds:
    """Cable speeds at RATE, (T, M), m/s, from time `first` on, s; rows that are not known are zero and out of `known`."""

    first: float
    values: Array

    @property
    def last(self) -> float:
        """Time of the last row, s."""
        return self.first + (len(self.values) - 1) / RATE


def speeds(time: Array, travel: Array) -> Speeds:
    """Of travels (F, M), m, at any times (F,), s: bridged straight and filtered."""
    grid = np.arange(time[0], time[-1], 1 / RATE)
    bridged = np.stack([np.interp(grid, time, column) for column in travel.T], axis=-1)
    return Speeds(float(grid[0]), np.gradient(low_pass(bridged, RATE, CUTOFF), 1 / RATE, axis=0))


def match(seen: Speeds, logged: Speeds) -> Match:
    """The best shift of the whole, or of the liveliest window where the whole is not alike."""
    whole = _match(seen, logged)
    if whole.likeness > 0.9 or len(seen.values) < 2 * WINDOW * RATE:
        return whole
    length = int(WINDOW * RATE)
    starts = range(0, len(seen.values) - length + 1, length // 2)
    parts = [
        _match(Speeds(seen.first + begin / RATE, seen.values[begin : begin + length]), logged)
        for begin in starts
        if np.sum(seen.values[begin : begin + length] ** 2) > 0.5 * length / len(seen.values) * np.sum(seen.values**2)
    ]
    best = max(parts, key=lambda part: part.likeness, default=whole)
    return best if best.likeness > max(0.9, whole.likeness) else whole


def nearby(seen: Speeds, logged: Speeds, shift: float, span: tuple[float, float], reach: float) -> float:
    """The best shift of a span of camera time within `reach` of another, s."""
    part = slice(*(max(0, int((t - seen.first) * RATE)) for t in span))
    a, b = seen.values[part], logged.values
    first = seen.first + part.start / RATE
    dot = np.asarray(sum(correlate(b[:, j], a[:, j]) for j in range(a.shape[1])))
    lags = logged.first - first + (np.arange(len(dot)) - (len(a) - 1)) / RATE
    close = np.abs(lags - shift) <= reach
    return float(lags[close][int(np.argmax(dot[close]))]) if close.any() else shift


def curves(a: Array, b: Array) -> Array:
    """Normalised correlation of speeds a (T, M) and b (S, M) over all lags of b against a, (T + S - 1,)."""
    least = min(MIN_OVERLAP * RATE, 0.5 * len(a))
    dot = sum(correlate(b[:, j], a[:, j]) for j in range(a.shape[1]))
    ones = np.ones(len(a)), np.ones(len(b))
    energy_a = correlate(ones[1], np.sum(a**2, axis=1))
    energy_b = correlate(np.sum(b**2, axis=1), ones[0])
    overlap = np.rint(correlate(ones[1], ones[0]))
    out = np.asarray(dot) / np.sqrt(np.maximum(energy_a * energy_b, 1e-300))
    out[(overlap < least) | (energy_a < 0.2 * np.sum(a**2)) | (energy_b <= 1e-6 * np.sum(b**2))] = 0.0
    return out


def _match(seen: Speeds, logged: Speeds) -> Match:
    a, b = seen.values, logged.values
    both = curves(a, b)
    lags = np.arange(len(both)) - (len(a) - 1)
    best = int(np.argmax(both))
    away = np.abs(lags - lags[best]) > APART * RATE
    rising = np.r_[False, (both[1:-1] > both[:-2]) & (both[1:-1] >= both[2:]), False]
    second = float(np.max(both, where=away & rising, initial=0.0) / max(both[best], 1e-12))
    left, mid, right = both[best - 1 : best + 2] if 0 < best < len(both) - 1 else (0.0, 1.0, 0.0)
    bend = left - 2 * mid + right
    part = 0.5 * (left - right) / bend if bend else 0.0
    each = [curves(a[:, [j]], b[:, [j]]) for j in range(a.shape[1])]

    def shift(lag: float) -> float:
        return logged.first - seen.first + lag / RATE

    return Match(
        shift(float(lags[best] + part)),
        float(both[best]),
        second,
        np.array([one[~away].max() for one in each]),
        np.array([one.max() for one in each]),
        np.array([(lags[int(np.argmax(one))] - lags[best]) / RATE for one in each]),
        (seen.first, seen.last),
    )
