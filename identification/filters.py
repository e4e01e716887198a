"""The two recursive filters that all stages share: a zero-phase low-pass and a first-order lag, along the first axis."""

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
    sos = butter(ORDER, min(cutoff / (rate / 2), MAX_CUTOFF), output="sos")
    return sosfiltfilt(sos, values, axis=0, padlen=min(len(values) - 1, int(EXTENSION_S * rate)))


def first_order_lag(values: Array, rate: float, tau: float | Array) -> Array:
    """How a first-order element of time constant tau, s, follows values (T, M) sampled at `rate`, Hz; shape (T, M).

    tau: one for all columns, or of each, (M,); zero leaves a column as it is. The solution is exact for values that are
    straight lines between samples, and at rest before the first.
    """
    lagged = []
    for column, steps in zip(values.T, rate * np.broadcast_to(tau, values.shape[1]), strict=True):
        if steps == 0:
            lagged.append(column)
            continue
        decay = np.exp(-1 / steps)
        newest = 1 - steps * (1 - decay)
        weights = [newest, 1 - decay - newest]
        lagged.append(lfilter(weights, [1, -decay], column, zi=[(1 - newest) * column[0]])[0])
    # each column in one piece, as filters and interpolation take them
    return np.stack(lagged).T
