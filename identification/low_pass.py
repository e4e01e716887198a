"""One low-pass and decimation for every signal alike, which leaves out what touches rows that are not known."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import firwin, upfirdn

Array = NDArray[np.float64]

CUTOFF_HZ = 8.0
"""carries what vision at 30 Hz can tell"""
RATE_HZ = 32.0
LENGTH_S = 0.5
"""of the filter: down to nothing some 3 Hz beyond the cutoff, so that 16 Hz do not fold back"""


@dataclass(frozen=True)
class LowPass:
    """A symmetric filter on rows of even steps, kept at every `factor`-th row."""

    taps: Array
    factor: int
    kept: NDArray[np.intp]
    """(S,): rows in the middle of each window that is known throughout"""
    _windows: NDArray[np.intp]

    def __call__(self, values: Array) -> Array:
        """(..., T) to (..., S): time is the last axis."""
        return upfirdn(self.taps, values, down=self.factor, axis=-1)[..., self._windows]


def low_pass(step: float, known: NDArray[np.bool_]) -> LowPass:
    """For rows `step` s apart; known (T,): False where a row tells nothing."""
    half = round(LENGTH_S / 2 / step)
    taps = np.asarray(firwin(2 * half + 1, CUTOFF_HZ, fs=1 / step), dtype=float)
    factor = max(1, round(1 / (RATE_HZ * step)))
    ends = np.arange(0, len(known), factor)
    missing = np.concatenate([[0], np.cumsum(~known)])
    first = np.maximum(ends - 2 * half, 0)
    whole = (ends >= 2 * half) & (missing[ends + 1] == missing[first])
    windows = np.flatnonzero(whole)
    return LowPass(taps, factor, ends[windows] - half, windows)
