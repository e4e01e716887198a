"""Residuals that follow each other: autoregressive whitening of every channel, so that each row counts for what it is worth."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz

Array = NDArray[np.float64]

WHITENING_ORDER = 6
"""at 32 Hz: the filter's own shape and what smoothing leaves of vision's noise"""
_FLOOR = 1e-6
"""of a channel's variance, added as white noise: what the filter has taken away is not blown up again"""


@dataclass(frozen=True)
class Whitener:
    """Taps (C, ORDER + 1) from the present backwards, divided by the innovation's standard deviation."""

    taps: Array

    def __call__(self, values: Array, starts: NDArray[np.bool_], unsure: Array | None = None) -> Array:
        """(C, S, ...) to the same shape; rows that lack a past within their stretch become zero. starts (S,): first rows.

        unsure (C, S): variance of rows beyond the noise that the taps were told from; a row counts for less by what of it they
        bring there. Weights before the taps would turn slow noise into fast, which counts more.
        """
        out = np.zeros_like(values)
        order = self.taps.shape[1] - 1
        for lag in range(order + 1):
            tap = self.taps[:, lag].reshape(-1, *([1] * (values.ndim - 1)))
            out[:, order:] += tap * values[:, order - lag : values.shape[1] - lag]
        out[:, ~has_full_history(starts, order)] = 0.0
        if unsure is not None:
            variance = 1 + np.stack([np.convolve(u, t**2)[: len(u)] for u, t in zip(unsure, self.taps, strict=True)])
            out /= np.sqrt(variance).reshape(*unsure.shape, *([1] * (values.ndim - 2)))
        return out

    def quieter(self, by: Array) -> "Whitener":
        """Of channels that are so many times as loud, (C,)."""
        return Whitener(self.taps / by[:, None])


def has_full_history(starts: NDArray[np.bool_], order: int = WHITENING_ORDER) -> NDArray[np.bool_]:
    """Rows with `order` rows before them in their stretch, (S,)."""
    place = np.arange(len(starts))
    first = np.maximum.accumulate(np.where(starts, place, 0))
    return place - first >= order


def fit_whitener(residuals: list[Array], starts: list[NDArray[np.bool_]], order: int = WHITENING_ORDER) -> Whitener:
    """From residuals (C, S) of recordings, by Yule and Walker."""
    channels = residuals[0].shape[0]
    taps = np.zeros((channels, order + 1))
    for c in range(channels):
        covariance = np.zeros(order + 1)
        count = sum(r.shape[1] for r in residuals)
        for r, begin in zip(residuals, starts, strict=True):
            for lag in range(order + 1):
                whole = has_full_history(begin, lag) if lag else np.ones(len(begin), dtype=bool)
                covariance[lag] += np.sum((r[c, lag:] * r[c, : r.shape[1] - lag])[whole[lag:]]) / count
        covariance[0] = covariance[0] * (1 + _FLOOR) + 1e-300
        a = solve_toeplitz(covariance[:-1], covariance[1:]) if order else np.zeros(0)
        innovation = covariance[0] - float(a @ covariance[1:])
        taps[c] = np.concatenate([[1.0], -a]) / np.sqrt(max(innovation, _FLOOR * covariance[0]))
    return Whitener(taps)
