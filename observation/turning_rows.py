"""Rows of a log in which a motor turns: near rest friction holds any force up to its whole, and no force is unmodelled there."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TURNING_SHARE = 0.85
"""of its whole that the seed's dry friction has where a motor counts as turning: faster than about 8 rad/s (docs/thresholds.md)"""
MIN_FAST_SHARE = 0.15
"""of a window in which a motor must turn each way, to be judged (docs/thresholds.md)"""


def turning_rows(turn: Array) -> NDArray[np.bool_] | None:
    """Which of the rows, (T,), a motor turns in; None where it does not turn both ways for long enough to be judged.

    turn: share of its whole that the seed's dry friction has, with its sign, (T,).
    """
    fast = np.abs(turn) > TURNING_SHARE
    share = min(np.mean(fast & (turn > 0)), np.mean(fast & (turn < 0)))
    return fast if share >= MIN_FAST_SHARE else None
