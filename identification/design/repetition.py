"""How much a motion resembles itself later on: one that repeats tells no clock between camera and log."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def likeness_to_itself(values: Array) -> float:
    """Greatest correlation of values (T, N), such as joint speeds, with themselves later, over what overlaps: at most half of them.

    Beyond the first time at which they do not correlate any more; 0 where there is none such.
    """
    count = len(values)
    length = 1 << (2 * count - 1).bit_length()
    spectrum = np.fft.rfft(values, length, axis=0)
    product = np.fft.irfft(np.sum(np.abs(spectrum) ** 2, axis=1), length)[: count // 2 + 1]
    energy = np.concatenate([[0.0], np.cumsum(np.sum(values**2, axis=1))])
    lags = np.arange(len(product))
    before, after = energy[count - lags], energy[-1] - energy[lags]
    correlation = product / np.sqrt(np.maximum(before * after, 1e-300))
    apart = np.flatnonzero(correlation <= 0)
    return float(correlation[apart[0] :].max()) if len(apart) else 0.0
