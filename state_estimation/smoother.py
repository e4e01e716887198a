"""A signal and its first two derivatives from noisy samples: a spline whose spectrum the samples themselves tell.

The prior (see spline.py) has three numbers, its order, corner and drive, which maximise the likelihood of the samples. An
order that falls off faster than a Wiener jerk is believed where the samples say so, and a signal without samples goes back to its
mean with the spread that it usually has.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from state_estimation.banded import Factor, factor, inverse_windows
from state_estimation.spline import SUPPORT, Knots, Prior, knots_over
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

ORDERS = (2, 3, 4, 6, 8)
"""tried for the prior"""
ENOUGH = 6000
"""samples from the middle that tell the prior well enough"""
LEAST = 8
"""samples"""
WIDTH = max(*ORDERS, SUPPORT - 1)
"""of the bands, in coefficients"""
_STIFFEST = np.log(1e-5)
"""(corner step)^order below it would lose the prior's precision in rounding"""
_BLOCK = 4 * SUPPORT


@dataclass(frozen=True)
class Smoothed:
    """Value, first and second derivative, each (T,), and their covariance (T, 3, 3)."""

    value: Array
    d1: Array
    d2: Array
    covariance: Array


def smooth(time: Array, values: Array, sigma: Array, at: Array, step: float | None = None) -> Smoothed:
    """Samples `values` (F,) with standard deviations `sigma` (F,) at `time` (F,), s, NaN left out, evaluated at `at` (T,).

    step: of the knots, s; the samples' own by default. `at`, rising, must lie within the samples: nothing is extrapolated. Raises
    Refused where it does not, or samples are too few.
    """
    known = ~np.isnan(values)
    t, y, r = time[known], values[known], sigma[known] ** 2
    check_span(t, at)
    knots = knots_over(t[0], t[-1], step or float(np.median(np.diff(t))))
    mean = float(np.mean(y))
    prior = fit_prior(t, y - mean, r, knots.step)
    found, b = _system(knots, prior, t, y - mean, r)
    c = found.solve(b)
    first, _ = knots.rows(at)
    parts = [knots.rows(at, d)[1] for d in range(3)]
    near = c[first[:, None] + np.arange(SUPPORT)]
    value, d1, d2 = (np.einsum("tk,tk->t", w, near) for w in parts)
    weights, covariance = np.stack(parts, axis=1), np.empty((len(at), 3, 3))
    for rows, window in inverse_windows(found, _BLOCK, first, SUPPORT):
        covariance[rows] = weights[rows] @ window @ np.swapaxes(weights[rows], 1, 2)
    return Smoothed(value + mean, d1, d2, covariance)


def check_span(time: Array, at: Array) -> None:
    """Refused where samples at `time` are too few, or `at` reaches beyond them."""
    if len(time) < LEAST:
        raise Refused("smoother", f"only {len(time)} samples", "record longer")
    if at[0] < time[0] - 1e-9 or at[-1] > time[-1] + 1e-9:
        raise Refused("smoother", "asked outside the samples", "nothing is extrapolated")


def fit_prior(time: Array, values: Array, variance: Array, step: float) -> Prior:
    """The prior for knots `step` apart that makes samples of mean zero most likely."""
    part = slice(max(0, len(time) // 2 - ENOUGH // 2), len(time) // 2 + ENOUGH // 2)
    t, y, r = time[part], values[part], variance[part]
    knots = knots_over(t[0], t[-1], step)
    design, b = normal_equations(knots, t, y, r)
    fixed = float(np.sum(np.log(r)) + np.sum(y**2 / r))
    spread = 10 * float(np.std(y)) + 10 * float(np.sqrt(np.median(r)))

    def prior(order: int, v: Array) -> Prior:
        """v: logarithms of the corner in rad/s and of the signal's standard deviation over the samples'."""
        corner = float(np.exp(v[0]))
        # standard deviation of the driven noise that gives the process its own
        return Prior(order, corner, float(np.exp(v[1])) * spread * (corner * step) ** (order - 0.5), spread)

    def cost(order: int, v: Array) -> float:
        if not (-3 < v[0] < np.log(0.8 / step) and -12 < v[1] < 12) or (v[0] + np.log(step)) * order < _STIFFEST:
            return 1e12
        p = prior(order, v)
        band = padded(p.band(knots))
        try:
            found = factor(band + design)
        except np.linalg.LinAlgError:
            return 1e12
        return found.log_determinant - p.log_determinant(knots) + fixed - float(b @ found.solve(b))

    best: tuple[float, Prior] | None = None
    for order in ORDERS:
        start = np.array([np.log(6.0 * np.sqrt(order)), 0.0])
        found = minimize(
            lambda v, order=order: cost(order, v),
            start,
            method="Nelder-Mead",
            options={"xatol": 0.05, "fatol": 0.1, "initial_simplex": start + np.array([[0, 0], [0.7, 0], [0, 1.5]])},
        )
        if best is None or found.fun < best[0]:
            best = float(found.fun), prior(order, found.x)
    assert best is not None
    return best[1]


def padded(band: Array) -> Array:
    """A lower band with rows of zeros down to WIDTH."""
    return np.vstack([band, np.zeros((WIDTH + 1 - len(band), band.shape[1]))])


def normal_equations(knots: Knots, t: Array, y: Array, r: Array) -> tuple[Array, Array]:
    """Band (WIDTH + 1, count) and right side (count,) of the samples' normal equations."""
    first, weights = knots.rows(t)
    band, b = np.zeros((WIDTH + 1, knots.count)), np.zeros(knots.count)
    for k in range(SUPPORT):
        b += np.bincount(first + k, weights[:, k] * y / r, knots.count)
        for lag in range(SUPPORT - k):
            band[lag] += np.bincount(first + k, weights[:, k] * weights[:, k + lag] / r, knots.count)
    return band, b


def _system(knots: Knots, prior: Prior, t: Array, y: Array, r: Array) -> tuple[Factor, Array]:
    design, b = normal_equations(knots, t, y, r)
    return factor(design + padded(prior.band(knots))), b
