"""Low-pass and decimation of a recording's equations, the same for all their signals.

Another thing than `filters.low_pass`: this filter has a finite impulse response, so that a row which is not known spoils only the
outputs whose window holds it, and it computes only the rows that are kept.
"""

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.ndimage import convolve1d
from scipy.signal import firwin

Array = NDArray[np.float64]

CUTOFF_HZ = 8.0
"""carries what vision at 30 Hz can tell"""
RATE_HZ = 32.0
LENGTH_S = 0.5
"""of the filter: down to nothing some 3 Hz beyond the cutoff, so that 16 Hz do not fold back"""


@dataclass(frozen=True)
class DecimatingFilter:
    """A symmetric filter on rows of even steps, kept at every `factor`-th row."""

    taps: Array
    factor: int
    kept: NDArray[np.intp]
    """(S,): rows in the middle of each window that is known throughout"""
    _windows: NDArray[np.intp]
    """(S,): place of a window's end, counted in `factor` rows"""
    _unknown: NDArray[np.intp]
    """rows that tell nothing"""

    @property
    def starts(self) -> NDArray[np.bool_]:
        """Kept rows that have none right before them, (S,)."""
        return np.concatenate([[True], np.diff(self.kept) > self.factor])

    def __call__(self, values: Array) -> Array:
        """(..., T) to (..., S): time is the last axis."""
        q, count = self.factor, -(-values.shape[-1] // self.factor)
        # in blocks of `factor` rows that each end where a window may, the filter is a product of two matrices
        lags = -(-len(self.taps) // q)
        taps = np.zeros(lags * q)
        taps[: len(self.taps)] = self.taps
        rows = np.zeros((*values.shape[:-1], count * q), dtype=np.result_type(values, np.float64))
        rows[..., q - 1 :] = values[..., : (count - 1) * q + 1]
        # beside a window too, where its taps are zero: zero times what is no number is none
        rows[..., self._unknown + q - 1] = 0.0
        parts = taps.reshape(lags, q)[:, ::-1] @ rows.reshape(*values.shape[:-1], count, q).swapaxes(-1, -2)
        first = lags - 1
        whole = (parts[..., j, first - j : max(count, first) - j] for j in range(lags))
        return sum(whole, start=np.zeros(()))[..., self._windows - first]

    def of_waves(self, sizes: Array, frequencies: Array) -> Array:
        """What passes of cosines, then of sines, whose sizes are (M, T), at frequencies (K,) in waves a row: (2, M, K, S).

        Phases count from each window's end, so that one filter for each frequency serves all windows."""
        phase = 2 * np.pi * frequencies[:, None] * np.arange(len(self.taps))[::-1]
        taps = np.concatenate([self.taps * np.cos(phase), -self.taps * np.sin(phase)])
        known = sizes.copy()
        known[:, self._unknown] = 0.0
        windows = sliding_window_view(known, len(self.taps), axis=1)[:, self.kept - len(self.taps) // 2]
        passed = taps @ windows.swapaxes(1, 2)
        return passed.reshape(len(sizes), 2, len(frequencies), -1).swapaxes(0, 1)

    def slower(self, values: Array, step: float, cutoff: float) -> Array:
        """Values (..., S) in the kept rows, which passed this filter, low-passed once more, with -6 dB at `cutoff`, Hz.

        step: s, between the rows that were filtered. Stretches of rows are mirrored at their ends.
        """
        rate = 1 / (step * self.factor)
        taps = np.asarray(firwin(2 * round(LENGTH_S / 2 * rate) + 1, cutoff, fs=rate), dtype=float)
        out = np.empty(values.shape)
        for stretch in np.split(np.arange(len(self.kept)), np.flatnonzero(self.starts)[1:]):
            out[..., stretch] = convolve1d(values[..., stretch], taps, mode="mirror")
        return out


def decimating_filter(step: float, known: NDArray[np.bool_]) -> DecimatingFilter:
    """For rows `step` s apart; known (T,): False where a row tells nothing."""
    half = round(LENGTH_S / 2 / step)
    taps = np.asarray(firwin(2 * half + 1, CUTOFF_HZ, fs=1 / step), dtype=float)
    factor = max(1, round(1 / (RATE_HZ * step)))
    ends = np.arange(0, len(known), factor)
    missing = np.concatenate([[0], np.cumsum(~known)])
    first = np.maximum(ends - 2 * half, 0)
    whole = (ends >= 2 * half) & (missing[ends + 1] == missing[first])
    windows = np.flatnonzero(whole)
    unknown = np.flatnonzero(~known[: ends[-1] + 1])
    return DecimatingFilter(taps, factor, ends[windows] - half, windows, unknown)
