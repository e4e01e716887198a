"""Autoregressive whitening of every residual channel: rows of correlated residuals count for no more than they are worth."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz

Array = NDArray[np.float64]

WHITENING_ORDER = 6
"""order of the autoregression at 32 Hz: it covers the low-pass filter's shape and what smoothing leaves of vision's noise"""
_ROWS_AT_ONCE = 24
"""that one product whitens: a longer band holds more zeros, a shorter one takes more calls"""
_WHITE_SHARE = 1e-6
"""share of a channel's variance that is added as white noise, so that whitening does not amplify what the filter removed"""


@dataclass(frozen=True)
class Whitener:
    """Taps of the whitening filter, (C, order + 1), from the present backwards, over the innovation's standard deviation."""

    taps: Array

    def __call__(self, values: Array, starts: NDArray[np.bool_], input_variance: Array | None = None) -> Array:
        """Values (C, S, ...) whitened, of the same shape; rows without `order` rows before them in their segment become zero.

        starts (S,): True in the first row of each segment. input_variance (C, S): variance of rows beyond the noise that the taps
        were fitted to, in units of the innovation's; what the taps bring of it into a row reduces that row's weight. Weights before
        the taps would turn slow noise into fast noise, which counts more.
        """
        order = self.taps.shape[1] - 1
        weights = np.tile(np.where(has_full_history(starts, order), 1.0, 0.0), (len(values), 1))
        if input_variance is not None:
            pairs = zip(input_variance, self.taps, strict=True)
            weights /= np.sqrt(1 + np.stack([np.convolve(v, taps**2)[: len(v)] for v, taps in pairs]))
        rows = values.reshape(*values.shape[:2], -1)
        out = np.zeros(rows.shape)
        # the taps as a band matrix: a product with it goes once through the many columns of a few rows
        band = np.zeros((len(self.taps), _ROWS_AT_ONCE, _ROWS_AT_ONCE + order))
        for i in range(_ROWS_AT_ONCE):
            band[:, i, i : i + order + 1] = self.taps[:, ::-1]
        for begin in range(order, rows.shape[1], _ROWS_AT_ONCE):
            count = min(_ROWS_AT_ONCE, rows.shape[1] - begin)
            weighted = band[:, :count, : count + order] * weights[:, begin : begin + count, None]
            np.matmul(weighted, rows[:, begin - order : begin + count], out=out[:, begin : begin + count])
        return out.reshape(values.shape)

    def rescaled(self, factors: Array) -> "Whitener":
        """The whitener of channels whose noise is `factors` (C,) times as large."""
        return Whitener(self.taps / factors[:, None])


def has_full_history(starts: NDArray[np.bool_], order: int = WHITENING_ORDER) -> NDArray[np.bool_]:
    """Which rows have `order` rows before them in their segment, (S,)."""
    place = np.arange(len(starts))
    first = np.maximum.accumulate(np.where(starts, place, 0))
    return place - first >= order


def fit_whitener(residuals: list[Array], starts: list[NDArray[np.bool_]], order: int = WHITENING_ORDER) -> Whitener:
    """The whitener of residuals (C, S) of recordings, by the Yule-Walker equations; starts (S,): first rows of segments."""
    channels = residuals[0].shape[0]
    taps = np.zeros((channels, order + 1))
    for c in range(channels):
        covariance = np.zeros(order + 1)
        count = sum(r.shape[1] for r in residuals)
        for r, begin in zip(residuals, starts, strict=True):
            for lag in range(order + 1):
                complete = has_full_history(begin, lag) if lag else np.ones(len(begin), dtype=bool)
                covariance[lag] += np.sum((r[c, lag:] * r[c, : r.shape[1] - lag])[complete[lag:]]) / count
        covariance[0] = covariance[0] * (1 + _WHITE_SHARE) + 1e-300
        a = solve_toeplitz(covariance[:-1], covariance[1:]) if order else np.zeros(0)
        innovation = covariance[0] - float(a @ covariance[1:])
        taps[c] = np.concatenate([[1.0], -a]) / np.sqrt(max(innovation, _WHITE_SHARE * covariance[0]))
    return Whitener(taps)
