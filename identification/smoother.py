"""A signal and its first two derivatives from noisy samples: the Gauss-Markov smoother with a Wiener-jerk prior.

The prior lets the jerk wander as a Wiener process, driven by white noise of spectral density q, which maximum
likelihood finds in the data. Filter and Rauch-Tung-Striebel smoother run over the samples; between two samples the state given
both ends is again Gaussian, in closed form, so any other clock is served in one vectorised step.
"""

from dataclasses import dataclass
from math import factorial

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from xneck.errors import Refused

Array = NDArray[np.float64]

_STATES = 4
"""value, velocity, acceleration, jerk"""
_ENOUGH = 3000
"""samples from the middle that tell q well enough"""
_FACTORIALS = np.array([1.0, 1.0, 2.0, 6.0])


@dataclass(frozen=True)
class Smoothed:
    """Value, first and second derivative, each (T,), and their covariance (T, 3, 3)."""

    value: Array
    d1: Array
    d2: Array
    covariance: Array


def smooth(time: Array, values: Array, sigma: Array, at: Array) -> Smoothed:
    """Samples `values` (F,) with standard deviations `sigma` (F,) at `time` (F,), s, NaN left out, evaluated at `at` (T,).

    `at` must lie within the samples: nothing is extrapolated. Raises Refused where it does not, or samples are too few.
    """
    known = ~np.isnan(values)
    t, y, r = time[known], values[known], sigma[known] ** 2
    if len(t) < 8:
        raise Refused("smoother", f"only {len(t)} samples", "record longer")
    if at[0] < t[0] - 1e-9 or at[-1] > t[-1] + 1e-9:
        raise Refused("smoother", "asked outside the samples", "nothing is extrapolated")
    scale = float(np.var(np.diff(y, n=2))) / float(np.median(np.diff(t))) ** 7 + 1e-12
    part = slice(max(0, len(t) // 2 - _ENOUGH // 2), len(t) // 2 + _ENOUGH // 2)
    best = minimize_scalar(
        lambda log_q: -_filter(t[part], y[part], r[part], np.exp(log_q))[3],
        bounds=(np.log(scale) - 35, np.log(scale) + 5),
        method="bounded",
        options={"xatol": 0.2},
    )
    return _evaluate(t, y, r, float(np.exp(best.x)), at)


def _transition(step: Array) -> tuple[Array, Array]:
    """Phi and Q / q over steps (T,): shapes (T, 4, 4)."""
    h = np.asarray(step, dtype=float)[:, None, None]
    phi = sum((h**k / factorial(k) * np.eye(_STATES, k=k) for k in range(1, _STATES)), np.eye(_STATES))
    # integral of (h^a / a!) (h^b / b!) over the step, a and b counting down to the driven state
    a = _STATES - 1 - np.arange(_STATES)
    power = a[:, None] + a + 1
    return phi, h**power / (_FACTORIALS[a][:, None] * _FACTORIALS[a] * power)


def _filter(t: Array, y: Array, r: Array, q: float) -> tuple[Array, Array, tuple[Array, Array], float]:
    """Filtered means (F, 4) and covariances (F, 4, 4), the transitions used, and the log likelihood."""
    phi, noise = _transition(np.diff(t))
    noise = noise * q
    n = len(t)
    means, covariances = np.empty((n, _STATES)), np.empty((n, _STATES, _STATES))
    step = float(np.median(np.diff(t)))
    # a start that knows nothing: many times what the samples can vary
    spread = np.ptp(y) + np.sqrt(r[0])
    m = np.zeros(_STATES)
    m[0] = y[0]
    P = np.diag(spread / step ** np.arange(_STATES)) ** 2 * 10.0
    likelihood = 0.0
    for k in range(n):
        if k:
            F = phi[k - 1]
            m, P = F @ m, F @ P @ F.T + noise[k - 1]
        s = P[0, 0] + r[k]
        gain = P[:, 0] / s
        e = y[k] - m[0]
        m = m + gain * e
        P = P - np.outer(gain, P[0])
        P = (P + P.T) / 2
        means[k], covariances[k] = m, P
        if k >= _STATES:
            likelihood -= 0.5 * (e * e / s + np.log(s))
    return means, covariances, (phi, noise), float(likelihood)


def _evaluate(t: Array, y: Array, r: Array, q: float, at: Array) -> Smoothed:
    means, covariances, (phi, noise), _ = _filter(t, y, r, q)
    n = len(t)
    sm, sP = means.copy(), covariances.copy()
    cross = np.empty((n - 1, _STATES, _STATES))  # covariance of state k with state k + 1, given everything
    for k in range(n - 2, -1, -1):
        ahead = phi[k] @ covariances[k] @ phi[k].T + noise[k]
        G = np.linalg.solve(ahead, phi[k] @ covariances[k]).T
        sm[k] = means[k] + G @ (sm[k + 1] - phi[k] @ means[k])
        sP[k] = covariances[k] + G @ (sP[k + 1] - ahead) @ G.T
        cross[k] = G @ sP[k + 1]
    k = np.clip(np.searchsorted(t, at, side="right") - 1, 0, n - 2)
    tau = np.clip(at - t[k], 0, None)
    phi_a, noise_a = _transition(tau)
    phi_b, _ = _transition(t[k + 1] - t[k] - tau)
    noise_a = noise_a * q
    towards = noise_a @ np.swapaxes(phi_b, 1, 2)
    # weight of the later sample's state, and of the earlier one's
    W1 = np.swapaxes(np.linalg.solve(noise[k], np.swapaxes(towards, 1, 2)), 1, 2)
    W0 = phi_a - W1 @ phi[k]
    mean = np.einsum("tij,tj->ti", W0, sm[k]) + np.einsum("tij,tj->ti", W1, sm[k + 1])
    mixed = W0 @ cross[k] @ np.swapaxes(W1, 1, 2)
    own = noise_a - W1 @ np.swapaxes(towards, 1, 2)
    P = W0 @ sP[k] @ np.swapaxes(W0, 1, 2) + W1 @ sP[k + 1] @ np.swapaxes(W1, 1, 2)
    P = P + mixed + np.swapaxes(mixed, 1, 2) + own
    return Smoothed(mean[:, 0], mean[:, 1], mean[:, 2], P[:, :3, :3])
