"""Coarse alignment: the shift at which log and video show the same motion, from the cross-correlation of cable speeds.

It also says how well the motions correlate there, whether another shift does nearly as well, and how each cable does by itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft
from scipy.signal import correlate

from identification.dataset.series import Series, clear_of_gaps, interpolated
from identification.filters import low_pass

Array = NDArray[np.float64]

SPEED_RATE_HZ = 50.0
"""Hz: rate at which speeds are compared"""
SPEED_CUTOFF_HZ = 6.0
"""Hz: low-pass of the speeds"""
MIN_OVERLAP_S = 5.0
"""s of common motion that a shift must leave (docs/thresholds.md)"""
MIN_PEAK_SEPARATION_S = 0.25
"""s: peaks of the correlation that are nearer than this are one (docs/thresholds.md)"""
MAX_BRIDGED_S = 0.5
"""s without a sample that speeds are interpolated over"""
WINDOW_S = 12.0
"""s of video that are aligned alone where the whole does not correlate, as after lost frames (docs/thresholds.md)"""
SHORT_WINDOW_S = 5.0
"""s of video that are aligned alone where longer windows do not correlate either (docs/thresholds.md)"""
WHOLE_CORRELATION = 0.9
"""correlation below which windows of the video are tried beside the whole (docs/thresholds.md)"""
_STRETCH_ROUNDS = 3
"""of telling how far forces stretch the cables, and aligning"""
REVERSAL_SPEED_RATIO = 0.1
"""ratio to the rms speed of a motor, over which its dry friction turns over"""
MAX_SECOND_PEAK = 0.9
"""ratio of the second peak of the correlation to the first, above which the motion repeats itself and the clock is refused
(docs/thresholds.md)"""
SECOND_PEAK_WARNING = 0.85
"""the same ratio from which on a warning says that the motion nearly repeats itself (docs/thresholds.md)"""


@dataclass(frozen=True)
class CableSpeeds:
    """Cable speeds at SPEED_RATE_HZ."""

    first: float
    """s: time of the first row"""
    values: Array
    """(T, M), m/s; zero where not known"""
    known: NDArray[np.bool_]
    """(T,): rows that are in no long gap"""

    def part(self, rows: slice) -> "CableSpeeds":
        """Some of the rows, in one piece."""
        begin = rows.start or 0
        return CableSpeeds(self.first + begin / SPEED_RATE_HZ, self.values[rows], self.known[rows])

    @property
    def last(self) -> float:
        """Time of the last row, s."""
        return self.first + (len(self.values) - 1) / SPEED_RATE_HZ

    def rows(self, span: tuple[float, float]) -> slice:
        """The rows from one time to another, s."""
        return slice(*(max(0, int((t - self.first) * SPEED_RATE_HZ)) for t in span))


@dataclass(frozen=True)
class CoarseAlignment:
    """The best shift between camera and log, and what speaks against it."""

    shift: float
    """log time less camera time, s"""
    correlation: float
    """normalised correlation of all cables' speeds at the shift"""
    second_peak: float
    """the next best peak's correlation over the best one's"""
    cable_correlation: Array
    """(M,): each cable's correlation around the shift"""
    cable_peak: Array
    """(M,): each cable's best correlation over all shifts"""
    cable_peak_shift: Array
    """(M,), s: where each cable's best correlation is, less the shift"""
    span: tuple[float, float]
    """camera times that were compared, s"""


def cable_speeds(time: Array, travel: Array, gaps: Sequence[tuple[float, float]] = ()) -> CableSpeeds:
    """Speeds of travels (F, M), m, at increasing times (F,), s: interpolated linearly, filtered, differentiated.

    They are not known in gaps longer than MAX_BRIDGED_S: between two times, or those that are given, s."""
    wide = np.diff(time) > MAX_BRIDGED_S
    gaps = [g for g in (*gaps, *zip(time[:-1][wide], time[1:][wide], strict=True)) if g[1] - g[0] > MAX_BRIDGED_S]
    grid = np.arange(time[0], time[-1], 1 / SPEED_RATE_HZ)
    smooth = low_pass(interpolated(grid, time, travel), SPEED_RATE_HZ, SPEED_CUTOFF_HZ)
    known = clear_of_gaps(grid, gaps, 0.0)
    speeds = np.gradient(smooth, 1 / SPEED_RATE_HZ, axis=0)
    return CableSpeeds(float(grid[0]), np.where(known[:, None], speeds, 0.0), known)


def align_coarsely(video: CableSpeeds, log: CableSpeeds) -> CoarseAlignment:
    """The best shift of the whole video, or of its best lively window where the whole does not correlate."""
    whole = _align(video, log)
    if whole.correlation > WHOLE_CORRELATION or len(video.values) < 2 * WINDOW_S * SPEED_RATE_HZ:
        return whole
    best = whole
    for seconds in (WINDOW_S, SHORT_WINDOW_S):
        windows = _lively_windows(video, int(seconds * SPEED_RATE_HZ))
        best = max((whole, *(_align(window, log) for window in windows)), key=lambda window: window.correlation)
        if best.correlation > WHOLE_CORRELATION:
            break
    return best if best.correlation > WHOLE_CORRELATION else whole


def force_rates(log: Series, gaps: Sequence[tuple[float, float]] = ()) -> CableSpeeds | None:
    """How fast the forces of a log change, N/s, as `cable_speeds` tells travels; None where it has none."""
    f = log.matrix("f")
    return cable_speeds(log.time, f, gaps) if f.shape[1] else None


def dry_direction(speed: Array) -> Array:
    """Dry friction's direction, -1 to 1, of motors by their speeds (T, M)."""
    width = REVERSAL_SPEED_RATIO * np.sqrt(np.mean(speed**2, axis=0))
    return 2 / np.pi * np.arctan(speed / np.where(width > 0, width, 1.0))


def align_stretched(
    video: CableSpeeds, log: CableSpeeds, rates: CableSpeeds | None
) -> tuple[CoarseAlignment, CableSpeeds]:
    """As `align_coarsely`, and the log's speeds as they were compared: where cables are soft, less what forces stretch them.

    rates: of the forces, on the log's rows; None where there are none."""
    best = align_coarsely(video, log), log
    for _ in range(_STRETCH_ROUNDS):
        if rates is None or best[0].correlation > WHOLE_CORRELATION:
            break
        relaxed = _without_stretch(video, log, rates, best[0].shift)
        alignment = align_coarsely(video, relaxed)
        if alignment.correlation <= best[0].correlation:
            break
        best = alignment, relaxed
    return best


def _without_stretch(video: CableSpeeds, log: CableSpeeds, rates: CableSpeeds, shift: float) -> CableSpeeds:
    """The log's speeds less what forces stretch each cable, by what the video shows at a shift; no force makes one shorter.

    Of a force dry friction takes a part, which turns over with the motor."""
    ahead = round((video.first + shift - log.first) * SPEED_RATE_HZ)
    rows = np.arange(max(0, -ahead), min(len(video.values), len(log.values) - ahead))
    rows = rows[video.known[rows] & log.known[rows + ahead]]
    rates_of_direction = np.gradient(dry_direction(log.values), 1 / SPEED_RATE_HZ, axis=0)
    turning = low_pass(rates_of_direction, SPEED_RATE_HZ, SPEED_CUTOFF_HZ)
    values = log.values.copy()
    for j in range(values.shape[1]):
        columns = np.stack([log.values[:, j], rates.values[:, j], turning[:, j]], axis=-1)
        by_motor, by_force, by_turning = np.linalg.lstsq(columns[rows + ahead], video.values[rows, j], rcond=None)[0]
        if not by_motor > 0 > by_force:
            continue
        stretch = -columns[:, 1:] @ [by_force / by_motor, max(by_turning, 0.0) / by_motor]
        # of what a motor winds it may stretch a part: more is told by a column that is no force
        if np.sum(stretch**2) < np.sum(values[:, j] ** 2):
            values[:, j] -= stretch
    return replace(log, values=values)


def _lively_windows(video: CableSpeeds, length: int) -> list[CableSpeeds]:
    """The windows of so many rows, half overlapping, that hold at least half of an average one's motion."""
    starts = range(0, len(video.values) - length + 1, length // 2)
    min_energy = 0.5 * length / len(video.values) * np.sum(video.values**2)
    windows = [video.part(slice(start, start + length)) for start in starts]
    return [window for window in windows if np.sum(window.values**2) > min_energy]


def shift_near(
    video: CableSpeeds, log: CableSpeeds, shift: float, span: tuple[float, float], max_change: float
) -> float:
    """The best shift of a span of camera time, at most max_change s away from `shift`, s."""
    part = video.rows(span)
    a, b = video.values[part], log.values
    first = video.first + part.start / SPEED_RATE_HZ
    product = np.asarray(sum(correlate(b[:, j], a[:, j]) for j in range(a.shape[1])))
    lags = log.first - first + (np.arange(len(product)) - (len(a) - 1)) / SPEED_RATE_HZ
    near = np.abs(lags - shift) <= max_change
    return float(lags[near][int(np.argmax(product[near]))]) if near.any() else shift


def _align(video: CableSpeeds, log: CableSpeeds) -> CoarseAlignment:
    """The shift of the correlation's peak, by a parabola through its top."""
    correlations, lively = _normalised_cross_correlations(video, log)
    correlation, *of_lively_cables = np.where(lively, correlations, 0.0)
    lags = np.arange(len(correlation)) - (len(video.values) - 1)
    best = int(np.argmax(correlation))
    away = np.abs(lags - lags[best]) > MIN_PEAK_SEPARATION_S * SPEED_RATE_HZ
    inner = correlation[1:-1]
    peaks = np.r_[False, (inner > correlation[:-2]) & (inner >= correlation[2:]), False]
    second = float(np.max(correlation, where=away & peaks, initial=0.0) / max(correlation[best], 1e-12))
    left, middle, right = correlation[best - 1 : best + 2] if 0 < best < len(correlation) - 1 else (0.0, 1.0, 0.0)
    curvature = left - 2 * middle + right
    fraction = 0.5 * (left - right) / curvature if curvature else 0.0
    return CoarseAlignment(
        shift=log.first - video.first + float(lags[best] + fraction) / SPEED_RATE_HZ,
        correlation=float(correlation[best]),
        second_peak=second,
        cable_correlation=correlations[1:, ~away].max(axis=1),
        cable_peak=np.array([curve.max() for curve in of_lively_cables]),
        cable_peak_shift=np.array(
            [(lags[int(np.argmax(curve))] - lags[best]) / SPEED_RATE_HZ for curve in of_lively_cables]
        ),
        span=(video.first, video.last),
    )


def _normalised_cross_correlations(video: CableSpeeds, log: CableSpeeds) -> tuple[Array, NDArray[np.bool_]]:
    """Correlation of the speeds of video (T, M) and log (S, M) over all lags of the log, where both are known, (1 + M, T + S - 1).

    Of all cables together, then of each; zero where too little overlaps. Beside it where enough moves in the overlap: of a video
    that is longer than the log, a part of what moves in an average stretch as long as the log."""
    a, b = video.values.T, log.values.T
    m, lags = len(a), a.shape[1] + b.shape[1] - 1
    size = next_fast_len(lags, real=True)

    def transformed(speeds: Array, known: NDArray[np.bool_]) -> NDArray[np.complex128]:
        return np.asarray(rfft(np.vstack([speeds, speeds**2, known]), size))

    def over_lags(of_cables: NDArray[np.complex128]) -> Array:
        return np.asarray(irfft(np.vstack([of_cables.sum(axis=0), of_cables]), size))[:, :lags]

    of_video, of_log = transformed(a[:, ::-1], video.known[::-1]), transformed(b, log.known)
    product = over_lags(of_video[:m] * of_log[:m])
    video_energy, log_energy = over_lags(of_video[m:-1] * of_log[-1]), over_lags(of_video[-1] * of_log[m:-1])
    overlap = np.rint(np.asarray(irfft(of_video[-1] * of_log[-1], size))[:lags])
    of_all = [np.r_[np.sum(v**2), np.sum(v**2, axis=1)][:, None] for v in (a, b)]
    out = product / np.sqrt(np.maximum(video_energy * log_energy, 1e-300))
    min_rows = min(MIN_OVERLAP_S * SPEED_RATE_HZ, 0.5 * a.shape[1])
    min_energy = 0.2 * min(1.0, b.shape[1] / a.shape[1]) * of_all[0]
    out[(overlap < min_rows) | (log_energy <= 1e-6 * of_all[1])] = 0.0
    return out, video_energy >= min_energy
