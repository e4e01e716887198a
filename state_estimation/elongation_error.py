"""What no force explains of a cable's elongation: how much of it there is at which frequencies.

Vision alone bounds it, as white noise and two Ornstein-Uhlenbeck processes (`fit_wander`). Where cables, vision and joints that
move smoothly are solved together, their residuals tell how dense it is in each of a few bands (`Wander.retold`).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz
from scipy.optimize import minimize

from state_estimation.banded import factor

Array = NDArray[np.float64]

LEAST_M = 3.5e-7
"""m: no error is smaller; what rounding leaves where a motor of 2048 counts a turn winds 0.4 mm a radian"""
MEMORY_S = (0.1, 3.0)
"""of the two processes that vision bounds"""
UNTOLD = 0.02
"""share of a band's noise: where a solution leaves less, a few probes cannot tell what it should leave"""
EDGES_HZ = (0.0, 0.5, 1.5, 4.0, 9.0, 15.0)
"""of bands in which the error is as dense everywhere; the last one reaches to half the rows' rate"""
SPREAD_M = 5e-3
"""m: how far any one regressor may move a cable, before the data speak (standard deviation)"""
TAPS = 4
"""of rows 25 ms apart or less: they reach over three knots, which the band of the normal equations has room for"""
ENOUGH = 3000
"""samples from the middle that tell the error well enough"""


@dataclass(frozen=True)
class Wander:
    """Spectral density, m^2/Hz, one-sided, in the bands of EDGES_HZ, of samples `step` s apart."""

    density: Array
    step: float

    @property
    def variance(self) -> float:
        """m^2"""
        return float(self.density @ np.diff(self._edges))

    @property
    def _edges(self) -> Array:
        return np.append(EDGES_HZ, 0.5 / self.step)

    def times(self, factor: float) -> "Wander":
        return Wander(factor**2 * self.density, self.step)

    def whitener(self) -> tuple[Array, float]:
        """Filter (TAPS + 1,), newest first, that whitens samples to variance one as far as it reaches, and their own sigma."""
        lags = self.step * np.arange(TAPS + 1)
        # integral of density cos(2 pi f lag)
        covariance = np.diff(self._edges * np.sinc(2 * self._edges * lags[:, None]), axis=1) @ self.density
        ahead = solve_toeplitz(covariance[:-1], covariance[1:])
        fresh = np.sqrt(covariance[0] - ahead @ covariance[1:])
        return np.concatenate([[1.0], -ahead]) / fresh, float(np.sqrt(covariance[0]))

    def retold(self, left: Array, probes: Array, kept: Array) -> "Wander":
        """As dense in each band as whitened residuals `left` (K,) say it is.

        probes (K, Q): white noise in place of the error; kept (K, Q): what a solution leaves of it. Where the error is what
        the model says, left^2 is probes * kept on average (restricted maximum likelihood, as a fixed point).
        """
        hertz = np.fft.rfftfreq(len(left), self.step)
        band = np.clip(np.searchsorted(EDGES_HZ, hertz, side="right") - 1, 0, len(EDGES_HZ) - 1)
        taps, _ = self.whitener()
        model = (
            2 * self.step / np.abs(np.exp(-2j * np.pi * hertz[:, None] * self.step * np.arange(TAPS + 1)) @ taps) ** 2
        )
        found = np.abs(np.fft.rfft(left)) ** 2
        expected = np.mean(np.real(np.conj(np.fft.rfft(probes, axis=0)) * np.fft.rfft(kept, axis=0)), axis=1)
        found, expected, model, count = (
            np.bincount(band, values, len(EDGES_HZ)) for values in (found, expected, model, np.ones(len(hertz)))
        )
        # a band that a solution takes whole is not told
        factors = np.where(expected > UNTOLD * count * len(left), found / np.maximum(expected, 1e-300), 1.0)
        return Wander(np.maximum(factors * model / count, 2 * self.step * LEAST_M**2), self.step)


def white(sigma: float, step: float) -> Wander:
    """Of samples that have nothing in common; m."""
    return Wander(np.full(len(EDGES_HZ), 2 * step * sigma**2), step)


def _of_processes(sigmas: tuple[float, float], step: float) -> Wander:
    """Of both processes and what is new at every sample, as much as the fast one."""
    edges = np.append(EDGES_HZ, 0.5 / step)
    below = sum(
        sigma**2 * 2 / np.pi * np.arctan(2 * np.pi * edges * memory)
        for sigma, memory in zip(sigmas, MEMORY_S, strict=True)
    )
    return Wander(np.diff(below + sigmas[0] ** 2 * 2 * step * edges) / np.diff(edges), step)


def fit_wander(time: Array, x: Array, variance: Array, X: Array, step: float) -> Wander:
    """The error that makes samples of an elongation x (F,), m, of `variance` (F,) most likely, X (F, P) fitted along.

    step: s, of the samples that the error is told for.
    """
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
    return _of_processes((float(fast), float(slow)), step)


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
