"""What stamps of rows mean: times of sampling or of receipt, often enough or too rare."""

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import PAUSE_S
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

MAX_BURST_SHARE = 0.3
"""share of steps that may be shorter than BURST_STEP_RATIO of the mean one (docs/thresholds.md)"""
BURST_STEP_RATIO = 0.2
"""ratio to the mean step, below which a step is one within a burst (docs/thresholds.md)"""
MIN_LOG_HZ = 45.0
"""rows a second of a log at least, 50 less a tenth: of logs with 25 one clock in 12 was a third of a second off
(docs/thresholds.md)"""
_MISSING_STEPS = 1.5
"""steps to the next row from which on one may be missing"""
_FOLLOWED_ROWS = 10
"""rows over which the even grid of a log follows its stamps, as their mean step is not known exactly"""


def check_stamped(time: Array, where: str, topic: str) -> None:
    """Refused where several messages of a topic, with stamps (T,), s, all have one: header.stamp was never set."""
    if len(time) > 1 and np.all(time == time[0]):
        raise Refused(
            where,
            f"header.stamp is {time[0]:g} s in every message of /{topic}: it was never set",
            "stamp each message when it is sampled; the time of its receipt is not read",
        )


def sampling_step(time: Array, where: str) -> float:
    """The median step, s, of increasing stamps (T,). Refused where stamps come in bursts, as those of a receiver do."""
    steps = np.diff(time)
    mean = float(np.mean(steps[steps <= PAUSE_S])) if np.any(steps <= PAUSE_S) else float(np.mean(steps))
    if (share := burst_share(steps, mean)) > MAX_BURST_SHARE:
        raise Refused(
            where,
            f"its rows come in bursts: {100 * share:.0f} % follow the one before within "
            f"{1e3 * BURST_STEP_RATIO * mean:.3g} ms, and {1e3 * mean:.3g} ms is the mean",
            "stamp each row when it is sampled, not when it is received or written",
        )
    return float(np.median(steps))


def burst_share(steps: Array, mean: float) -> float:
    """Share of the steps (T - 1,) that are within a burst; mean: of those that are no pauses, in their unit."""
    return float(np.mean(steps < BURST_STEP_RATIO * mean))


def check_log_rate(time: Array, where: str) -> None:
    """Refused where increasing stamps (T,), s, of a log come in bursts, or too rarely to follow friction's reversals."""
    rate = 1 / sampling_step(time, where)
    if rate < MIN_LOG_HZ:
        raise Refused(
            where,
            f"has {rate:.3g} rows a second, between which friction turns over unseen",
            "log every control step, at least 50 rows a second; 500 are best",
        )


def row_numbers(time: Array, step: float) -> NDArray[np.intp]:
    """Number of each row (T,) in a loop whose rows follow each other every `step` s or about, those counted that are missing.

    Each stamp is held against the even grid on which rows are due. A stamp that is late by jitter is followed by one that is due,
    and none after a lost row is.
    """
    steps = np.diff(time)
    if np.all(steps < _MISSING_STEPS * step):
        return np.arange(len(time))
    period = float(np.mean(steps[steps < 2 * step]))
    due, missing = float(time[0]), np.zeros(len(time), dtype=np.intp)
    for row, at in enumerate(time[1:].tolist(), 1):
        due += period
        missing[row] = late = max(round((at - due) / period), 0)
        due += late * period
        due += (at - due) / _FOLLOWED_ROWS
    return np.arange(len(time)) + np.cumsum(missing)
