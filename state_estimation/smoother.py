"""A signal and its first two derivatives from noisy samples: a smoothing spline whose prior is fitted to the samples.

The order, corner and innovation of the prior (see spline.py) maximise the likelihood of the samples. Within a gap the signal
returns to its mean, with the standard deviation that it has over the recording.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from state_estimation.banded import banded_cholesky, inverse_windows
from state_estimation.spline import SUPPORT, Knots, SplinePrior, knots_over
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

ORDERS = (2, 3, 4, 6, 8)
"""orders that are tried for the prior, one after the other until one makes the samples less likely (docs/thresholds.md)"""
MAX_SAMPLES = 3000
"""samples from the middle of a signal that the prior is fitted to (docs/thresholds.md)"""
MIN_SAMPLES = 8
"""samples that a signal is smoothed from at least (docs/thresholds.md)"""
BANDWIDTH = max(*ORDERS, SUPPORT - 1)
"""of the normal equations, in coefficients"""
_MIN_LOG_CORNER = np.log(1e-5)
"""order log(corner step): below it the prior's precision matrix is lost in rounding"""
_BLOCK = 4 * SUPPORT


@dataclass(frozen=True)
class Smoothed:
    """A signal with its first and second derivative, each (T,), and their covariance (T, 3, 3)."""

    value: Array
    d1: Array
    d2: Array
    covariance: Array


def smooth_signal(time: Array, values: Array, sigma: Array, at: Array, step: float | None = None) -> Smoothed:
    """Samples `values` (F,) with standard deviations `sigma` (F,) at `time` (F,), s, NaN left out, evaluated at `at` (T,).

    step: of the knots, s; the samples' own by default. `at`, rising, must lie within the samples: nothing is extrapolated. Raises
    Refused where it does not, or samples are too few.
    """
    known = ~np.isnan(values)
    t, y, r = time[known], values[known], sigma[known] ** 2
    check_span(t, at)
    knots = knots_over(t[0], t[-1], step or float(np.median(np.diff(t))))
    mean = float(np.mean(y))
    prior = _fit_prior(t, y - mean, r, knots.step)
    band, right = normal_equations(knots, t, y - mean, r)
    cholesky = banded_cholesky(band + padded_band(prior.band(knots)))
    c = cholesky.solve(right)
    first, _ = knots.rows(at)
    parts = [knots.rows(at, d)[1] for d in range(3)]
    local = c[first[:, None] + np.arange(SUPPORT)]
    value, d1, d2 = (np.einsum("tk,tk->t", w, local) for w in parts)
    weights, covariance = np.stack(parts, axis=1), np.empty((len(at), 3, 3))
    for rows, window in inverse_windows(cholesky, _BLOCK, first, SUPPORT):
        covariance[rows] = weights[rows] @ window @ np.swapaxes(weights[rows], 1, 2)
    return Smoothed(value + mean, d1, d2, covariance)


def check_span(time: Array, at: Array) -> None:
    """Refused where samples at `time` are too few, or `at` reaches beyond them."""
    if len(time) < MIN_SAMPLES:
        raise Refused("smoother", f"only {len(time)} samples", "record longer")
    if at[0] < time[0] - 1e-9 or at[-1] > time[-1] + 1e-9:
        raise Refused("smoother", "asked outside the samples", "nothing is extrapolated")


def _fit_prior(time: Array, values: Array, variance: Array, step: float) -> SplinePrior:
    """The prior for knots `step` apart that makes samples of mean zero most likely."""
    part = slice(max(0, len(time) // 2 - MAX_SAMPLES // 2), len(time) // 2 + MAX_SAMPLES // 2)
    t, y, r = time[part], values[part], variance[part]
    knots = knots_over(t[0], t[-1], step)
    measured, right = normal_equations(knots, t, y, r)
    constant = float(np.sum(np.log(r)) + np.sum(y**2 / r))
    initial_sigma = 10 * float(np.std(y)) + 10 * float(np.sqrt(np.median(r)))

    def prior(order: int, v: Array) -> SplinePrior:
        """v: logarithms of the corner in rad/s and of the signal's standard deviation over `initial_sigma`."""
        corner = float(np.exp(v[0]))
        # the innovation that gives the process that standard deviation
        innovation_sigma = float(np.exp(v[1])) * initial_sigma * (corner * step) ** (order - 0.5)
        return SplinePrior(order, corner, innovation_sigma, initial_sigma)

    def cost(order: int, v: Array) -> float:
        if not (-3 < v[0] < np.log(0.8 / step) and -12 < v[1] < 12) or (v[0] + np.log(step)) * order < _MIN_LOG_CORNER:
            return 1e12
        p = prior(order, v)
        # no wider than this prior needs
        of_prior, band = p.band(knots), measured[: max(order, SUPPORT - 1) + 1].copy()
        band[: len(of_prior)] += of_prior
        try:
            cholesky = banded_cholesky(band)
        except np.linalg.LinAlgError:
            return 1e12
        explained = float(np.sum(cholesky.solve_first_half(right) ** 2))
        return cholesky.log_determinant - p.log_determinant(knots) + constant - explained

    best: tuple[float, SplinePrior] | None = None
    for order in ORDERS:
        start = np.array([np.log(6.0 * np.sqrt(order)), 0.0])
        minimum = minimize(
            lambda v, order=order: cost(order, v),
            start,
            method="Nelder-Mead",
            options={"xatol": 0.05, "fatol": 0.1, "initial_simplex": start + np.array([[0, 0], [0.7, 0], [0, 1.5]])},
        )
        if best is not None and minimum.fun > best[0]:
            break
        best = float(minimum.fun), prior(order, minimum.x)
    assert best is not None
    return best[1]


def padded_band(band: Array) -> Array:
    """A lower band (k, count) with rows of zeros added, (BANDWIDTH + 1, count)."""
    return np.vstack([band, np.zeros((BANDWIDTH + 1 - len(band), band.shape[1]))])


def normal_equations(knots: Knots, t: Array, y: Array, r: Array) -> tuple[Array, Array]:
    """Lower band (BANDWIDTH + 1, count) and right side (count,) of the normal equations of samples y (T,) of variance r (T,)."""
    first, weights = knots.rows(t)
    band, right = np.zeros((BANDWIDTH + 1, knots.count)), np.zeros(knots.count)
    for k in range(SUPPORT):
        right += np.bincount(first + k, weights[:, k] * y / r, knots.count)
        for lag in range(SUPPORT - k):
            band[lag] += np.bincount(first + k, weights[:, k] * weights[:, k + lag] / r, knots.count)
    return band, right
