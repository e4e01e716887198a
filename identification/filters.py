"""The two recursive filters that all stages share: a zero-phase low-pass and a first-order lag, along the first axis."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, lfilter, sosfiltfilt

Array = NDArray[np.float64]

ORDER = 4
"""of the Butterworth low-pass; forwards and backwards it falls off like one of twice that order"""
MAX_CUTOFF = 0.95
"""of half the sampling rate: a higher cutoff is lowered to this, where the filter is still well conditioned (docs/thresholds.md)"""
EXTENSION_S = 1.0
"""s by which a signal is mirrored through each of its ends, so that the filter has settled where the signal begins
(docs/thresholds.md)"""


def low_pass(values: Array, rate: float, cutoff: float) -> Array:
    """Zero-phase Butterworth low-pass of values (T, ...) sampled at `rate`, Hz, with -6 dB at `cutoff`, Hz.

    A signal shorter than EXTENSION_S is mirrored as a whole.
    """
    sections = _butterworth(min(cutoff / (rate / 2), MAX_CUTOFF))
    return sosfiltfilt(sections, values, axis=0, padlen=min(len(values) - 1, int(EXTENSION_S * rate)))


@lru_cache(maxsize=64)
def _butterworth(cutoff: float) -> Array:
    """Second-order sections of the low-pass with its cutoff over half the sampling rate."""
    return np.asarray(butter(ORDER, cutoff, output="sos"))


def first_order_lag(values: Array, rate: float, tau: float | Array) -> Array:
    """How a first-order element of time constant tau, s, follows values (T, ..., M) sampled at `rate`, Hz; of the same shape.

    tau: one for all columns of the last axis, or of each, (M,); zero leaves a column as it is. The solution is exact for values
    that are straight lines between samples, and at rest before the first.
    """
    taus = np.broadcast_to(tau, values.shape[-1])
    # time last: each column in one piece, as filters and interpolation take them
    columns = np.ascontiguousarray(np.moveaxis(values, 0, -1))
    lagged = columns.copy()
    for steps in rate * np.unique(taus[taus != 0]):
        decay = np.exp(-1 / steps)
        newest = 1 - steps * (1 - decay)
        weights = [newest, 1 - decay - newest]
        chosen = rate * taus == steps
        block = columns[..., chosen, :]
        lagged[..., chosen, :] = lfilter(weights, [1, -decay], block, zi=(1 - newest) * block[..., :1])[0]
    return np.moveaxis(lagged, -1, 0)
