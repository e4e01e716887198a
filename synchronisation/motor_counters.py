"""What counters and loggers do to motor angles: they wrap around, begin anew, and single samples are absurd.

A counter is unwrapped only where it is certain: it stays within one period of a kind that counters have, wraps by that period, and
moves by little from row to row otherwise.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from mechanism.description import Motor

Array = NDArray[np.float64]

COUNTER_BITS = (8, 10, 12, 13, 14, 15, 16, 17, 18, 20, 24, 32)
"""widths of counters that are thought of"""
MAX_STEP_PERIODS = 0.25
"""ratio to a counter's period of the largest step from row to row beside the wraps: beyond it nobody knows which way it went
(docs/thresholds.md)"""
MIN_RANGE_PERIODS = 0.9
"""ratio to a counter's period of the range that a counter which wraps covers at least (docs/thresholds.md)"""
MAX_WRAP_SHARE = 0.1
"""share of rows that may wrap (docs/thresholds.md)"""
MAX_WRAP_RATIO = 2.0
"""ratio of the largest move at a wrap to the largest elsewhere: a jump to anywhere is no wrap (docs/thresholds.md)"""
MIN_LEVELS = 20
"""different values that a counter takes at least, before a jump is thought to be a wrap (docs/thresholds.md)"""
OUTLIER_WIDTH = 11
"""samples about one whose median it is compared with"""
MAX_OUTLYING = 0.02
"""share of samples that may be absurd (docs/thresholds.md)"""
OUTLIER_RATIO = 40.0
"""distance of an absurd sample from the median of those about it, over that of nearly all samples (docs/thresholds.md)"""
THETA_OUTLIER_RANGE, F_OUTLIER_RANGE = 0.02, 3.0
"""the same distance over the range of nearly all samples, at least: a motor cannot be back within a row, while a force can be
(docs/thresholds.md)"""
MIN_LEAP_RATIO = 10.0
"""ratio of the step with which counters are set to the largest other one, of every motor: no motor goes so much faster for one row
(docs/thresholds.md)"""
MAX_RESET_SHARE = 0.1
"""share of the rows before counters are set that are left out: later it may be rows that are missing (docs/thresholds.md)"""


@dataclass(frozen=True)
class Counter:
    """One motor's angles as logged, (T,), after what was certain was undone."""

    values: Array
    period: float = 0.0
    """of the counter that was unwrapped, in the log's unit; zero where none wraps"""
    wraps: int = 0
    ambiguous: bool = False
    """it wraps by `period`, and too fast to be unwrapped"""


def unwrapped(theta: Array, motor: Motor) -> Counter:
    """A motor's angles (T,), as logged, without the wraps of a counter."""
    steps = np.diff(theta)
    size = np.abs(steps)
    width = float(np.ptp(theta))
    if width == 0 or len(np.unique(theta[:: max(1, len(theta) // 2000)])) < MIN_LEVELS:
        return Counter(theta)
    for period in _periods(motor):
        if not MIN_RANGE_PERIODS * period <= width <= period * (1 + 1e-9):
            continue
        wrapping = size > period / 2
        if not wrapping.any():
            continue
        moves = np.abs(steps - period * np.rint(steps / period))
        if np.max(moves) <= MAX_STEP_PERIODS * period:
            as_elsewhere = np.max(moves[wrapping]) <= MAX_WRAP_RATIO * np.max(moves[~wrapping], initial=0.0)
            if as_elsewhere and np.mean(wrapping) <= MAX_WRAP_SHARE:
                return Counter(np.unwrap(theta, period=period), period, int(wrapping.sum()))
        elif np.mean(size > MAX_STEP_PERIODS * period) > MAX_WRAP_SHARE / 10:
            return Counter(theta, period, int(wrapping.sum()), ambiguous=True)
    return Counter(theta)


def absurd_samples(values: Array, min_range: float) -> NDArray[np.bool_]:
    """Which samples (T,) are far from the median of those about them; min_range: at least so many ranges away.

    The median follows motion, steps and turns; up to OUTLIER_WIDTH // 2 absurd samples in turn do not move it."""
    if len(values) < 100:
        return np.zeros(len(values), dtype=bool)
    distance = np.abs(values - median_filter(values, OUTLIER_WIDTH, mode="reflect"))
    low, high = np.quantile(values, [MAX_OUTLYING, 1 - MAX_OUTLYING])
    limit = max(OUTLIER_RATIO * float(np.quantile(distance, 1 - MAX_OUTLYING)), min_range * float(high - low))
    return distance > limit if limit else np.zeros(len(values), dtype=bool)


def row_of_reset(time: Array, theta: Array) -> int:
    """The row from which on the counters count from where the motors are; 0 where they do so from the first row on.

    A drive writes zeros, or where it believes to be, until it has found its zero; then all motors leap in one row.
    time: (T,), s; theta: (T, M), in any unit, unwrapped."""
    between = np.diff(time)
    if len(between) < 2 or not theta.shape[1]:
        return 0
    # over missing rows motors move on, and over repeated ones, but for those with which the log begins
    rows = np.maximum(between / np.median(between), 1.0) + _repeated_before(np.all(np.diff(theta, axis=0) == 0, axis=1))
    steps = np.abs(np.diff(theta, axis=0)) / rows[:, None]
    row = int(np.argmax(steps[:, 0]))
    others = np.max(np.delete(steps, row, axis=0), axis=0)
    is_reset = bool(np.all(steps[row] > MIN_LEAP_RATIO * others)) and row < MAX_RESET_SHARE * len(time)
    return row + 1 if is_reset else 0


def _repeated_before(equal: NDArray[np.bool_]) -> NDArray[np.intp]:
    """How many steps (S,) in turn, right before each, go nowhere; none of those with which all begins."""
    steps = np.arange(len(equal))
    last = np.maximum.accumulate(np.where(equal, -1, steps))  # the last one that went somewhere
    before = np.r_[-1, last[:-1]]
    return np.where(before >= 0, steps - 1 - before, 0)


def _periods(motor: Motor) -> list[float]:
    """Periods that a counter of this motor may have, in the log's unit, the smallest first."""
    turn = 2 * np.pi / motor.theta_scale
    periods = {2.0**bits for bits in COUNTER_BITS} | {1.0, 360.0, 2 * np.pi, turn, turn * motor.R}
    return sorted(periods | {float(motor.counts), 4.0 * motor.counts})
