"""What no force explains of a cable's elongation: how much it is, and how fast it forgets.

e is white noise and two Ornstein-Uhlenbeck processes. Vision alone bounds it (`fit_wander`); where cables, joints that move smoothly
and vision are solved together, their residuals tell it (`retold`).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz
from scipy.optimize import minimize

from identification.banded import factor

Array = NDArray[np.float64]

LEAST_M = 1e-6
"""m: no error is smaller"""
MEMORY_S = (0.1, 3.0)
"""of the fast and of the slow process"""
SPREAD_M = 5e-3
"""m: how far any one regressor may move a cable, before the data speak (standard deviation)"""
TAPS = 4
ENOUGH = 3000
"""samples from the middle that tell the error well enough"""


@dataclass(frozen=True)
class Wander:
    """Standard deviations, m: new at every sample, forgotten fast, forgotten slowly."""

    fresh: float
    fast: float
    slow: float

    @property
    def variance(self) -> float:
        return self.fresh**2 + self.fast**2 + self.slow**2

    def times(self, factor: float) -> "Wander":
        return Wander(factor * self.fresh, factor * self.fast, factor * self.slow)

    def densities(self, step: float, turn: Array) -> Array:
        """(3, K): variance of samples `step` s apart per their number, of the three, at `turn` (K,), rad a sample."""
        out = [np.full(turn.shape, self.fresh**2)]
        for sigma, memory in zip((self.fast, self.slow), MEMORY_S, strict=True):
            keep = np.exp(-step / memory)
            out.append(sigma**2 * (1 - keep**2) / (1 - 2 * keep * np.cos(turn) + keep**2))
        return np.stack(out)

    def whitener(self, step: float) -> tuple[Array, float]:
        """Filter (TAPS + 1,), newest first, that whitens samples `step` s apart to variance one, and their own sigma."""
        lags = step * np.arange(TAPS + 1)
        covariance = self.fast**2 * np.exp(-lags / MEMORY_S[0]) + self.slow**2 * np.exp(-lags / MEMORY_S[1])
        covariance[0] += self.fresh**2
        ahead = solve_toeplitz(covariance[:-1], covariance[1:])
        fresh = np.sqrt(covariance[0] - ahead @ covariance[1:])
        return np.concatenate([[1.0], -ahead]) / fresh, float(np.sqrt(covariance[0]))


def retold(wander: Wander, step: float, left: Array, probes: Array, kept: Array) -> Wander:
    """Each part as large as whitened residuals `left` (K,) say it is.

    probes (K, Q): white noise in place of the error; kept (K, Q): what a solution leaves of it. A part's share of left^2 over what the
    model expects of it, summed over frequencies, is what its variance was wrong by: restricted maximum likelihood as a fixed point.
    """
    turn = 2 * np.pi * np.fft.rfftfreq(len(left))
    parts = wander.densities(step, turn)
    share = parts / parts.sum(axis=0)
    found = np.abs(np.fft.rfft(left)) ** 2
    expected = np.mean(np.real(np.conj(np.fft.rfft(probes, axis=0)) * np.fft.rfft(kept, axis=0)), axis=1)
    factors = np.sqrt((share @ found) / np.maximum(share @ expected, 1e-12))
    fresh, fast, slow = np.array([wander.fresh, wander.fast, wander.slow]) * factors
    return Wander(max(float(fresh), LEAST_M), float(fast), float(slow))


def fit_wander(time: Array, x: Array, variance: Array, X: Array) -> Wander:
    """The process that makes samples of an elongation x (F,), m, of `variance` (F,) most likely, X (F, P) fitted along."""
    part = slice(max(0, len(time) // 2 - ENOUGH // 2), len(time) // 2 + ENOUGH // 2)
    t, y, r, D = time[part], x[part], variance[part], X[part]
    both = np.column_stack([D, y])
    least = float(np.log(unseen(r)))

    def cost(v: Array) -> float:
        if not (least <= v[0] < -3 and least - 5 <= v[1] < -3):
            return 1e12
        fast, slow = np.exp(v)
        noise = r + fast**2
        weighed = both / noise[:, None]
        band, log_determinant = _precision((fast, slow), t)
        band[0] += np.repeat(1 / noise, 2)
        band[1, ::2] += 1 / noise
        found = factor(band)
        twice = np.repeat(weighed, 2, axis=0)
        inner = both.T @ weighed - twice.T @ found.solve(twice)
        normal = inner[:-1, :-1] + np.eye(D.shape[1]) / SPREAD_M**2
        own = np.linalg.solve(normal, inner[:-1, -1])
        return (
            found.log_determinant
            - log_determinant
            + float(np.sum(np.log(noise)))
            + float(np.linalg.slogdet(normal)[1])
            + float(inner[-1, -1] - inner[:-1, -1] @ own)
        )

    start = np.full(2, least + 0.1)
    simplex = start + np.array([[0, 0], [1.0, 0], [0, 1.0]])
    found = minimize(
        cost, start, method="Nelder-Mead", options={"xatol": 0.05, "fatol": 0.1, "initial_simplex": simplex}
    )
    fast, slow = np.exp(found.x)
    return Wander(float(fast), float(fast), float(slow))


def unseen(variance: Array) -> float:
    """The largest error, m, that samples of this `variance` (F,) cannot tell from none: the standard error of their variance."""
    return max(float(np.sqrt(np.median(variance)) * (2 / len(variance)) ** 0.25), LEAST_M)


def _precision(sigmas: tuple[float, float], time: Array) -> tuple[Array, float]:
    """Lower band (3, 2 F) of both processes' precision, interleaved, and the logarithm of its determinant."""
    out = np.zeros((3, 2 * len(time)))
    log_determinant = 0.0
    for k, (sigma, memory) in enumerate(zip(sigmas, MEMORY_S, strict=True)):
        keep = np.exp(-np.diff(time) / memory)
        fresh = sigma**2 * (1 - keep**2)
        own = np.zeros(len(time))
        own[0] = sigma**-2
        own[1:] += 1 / fresh
        own[:-1] += keep**2 / fresh
        out[0, k::2] = own
        out[2, k : 2 * len(time) - 2 : 2] = -keep / fresh
        log_determinant -= 2 * float(np.log(sigma)) + float(np.sum(np.log(fresh)))
    return out, log_determinant
