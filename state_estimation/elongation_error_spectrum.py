"""The spectrum of a cable's elongation error: what no force explains of its elongation.

Vision alone bounds it, modelled as white noise and two Ornstein-Uhlenbeck processes (`fit_error_spectrum`). Where cables, vision
and smooth motion are solved together, the residuals give its density in each of a few bands (`ErrorSpectrum.reestimated`).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz
from scipy.optimize import minimize

from state_estimation.banded import banded_cholesky

Array = NDArray[np.float64]

MIN_ERROR_M = 3.5e-7
"""m: the smallest error, which rounding leaves where a motor of 2048 counts a turn winds 0.4 mm a radian (docs/thresholds.md)"""
CORRELATION_S = (0.1, 3.0)
"""s: correlation times of the two processes that are fitted to vision's residuals (docs/thresholds.md)"""
MIN_RESIDUAL_SHARE = 0.02
"""share of a band's noise that a solution must leave for the band's density to be estimated from a few probes
(docs/thresholds.md)"""
EDGES_HZ = (0.0, 0.5, 1.5, 4.0, 9.0, 15.0)
"""Hz: lower edges of the bands of constant density; the last one reaches to half the rows' rate (docs/thresholds.md)"""
REGRESSOR_SIGMA_M = 5e-3
"""m: prior standard deviation of what any one regressor moves a cable by (docs/thresholds.md)"""
TAPS = 4
"""of rows 25 ms apart or less: they reach over six knots, for which the normal equations make room (docs/thresholds.md)"""
MAX_SAMPLES = 3000
"""samples from the middle of a recording that the spectrum is fitted to"""


@dataclass(frozen=True)
class ErrorSpectrum:
    """Spectrum of samples `step` s apart."""

    density: Array
    """one-sided, in the bands of EDGES_HZ, m^2/Hz"""
    step: float

    @property
    def variance(self) -> float:
        """m^2"""
        return float(self.density @ np.diff(self._edges))

    @property
    def _edges(self) -> Array:
        return np.append(EDGES_HZ, 0.5 / self.step)

    def scaled(self, factor: float) -> "ErrorSpectrum":
        """Of an error that is `factor` times as large."""
        return ErrorSpectrum(factor**2 * self.density, self.step)

    def at_most(self, density: Array) -> "ErrorSpectrum":
        """With no more than `density` in any band."""
        return ErrorSpectrum(np.minimum(self.density, density), self.step)

    def whitener(self) -> tuple[Array, float]:
        """Filter (TAPS + 1,), newest sample first, that whitens samples to variance one, and the samples' standard deviation, m."""
        lags = self.step * np.arange(TAPS + 1)
        # integral of density cos(2 pi f lag)
        covariance = np.diff(self._edges * np.sinc(2 * self._edges * lags[:, None]), axis=1) @ self.density
        prediction = solve_toeplitz(covariance[:-1], covariance[1:])
        innovation_sigma = np.sqrt(covariance[0] - prediction @ covariance[1:])
        return np.concatenate([[1.0], -prediction]) / innovation_sigma, float(np.sqrt(covariance[0]))

    def reestimated(self, residuals: Array, probes: Array, probe_residuals: Array) -> "ErrorSpectrum":
        """The spectrum under which whitened residuals (K,) have the power in each band that a solution should leave of it.

        probes (K, Q) are white noise put in place of the error, probe_residuals (K, Q) what the solution leaves of them. Where
        the spectrum is right, residuals^2 equals probes * probe_residuals on average: restricted maximum likelihood as a fixed
        point.
        """
        hertz = np.fft.rfftfreq(len(residuals), self.step)
        band = np.clip(np.searchsorted(EDGES_HZ, hertz, side="right") - 1, 0, len(EDGES_HZ) - 1)
        taps, _ = self.whitener()
        model = (
            2 * self.step / np.abs(np.exp(-2j * np.pi * hertz[:, None] * self.step * np.arange(TAPS + 1)) @ taps) ** 2
        )
        power = np.abs(np.fft.rfft(residuals)) ** 2
        expected = np.mean(np.real(np.conj(np.fft.rfft(probes, axis=0)) * np.fft.rfft(probe_residuals, axis=0)), axis=1)
        power, expected, model, count = (
            np.bincount(band, values, len(EDGES_HZ)) for values in (power, expected, model, np.ones(len(hertz)))
        )
        # a band whose noise the solution takes up nearly whole says nothing
        estimable = expected > MIN_RESIDUAL_SHARE * count * len(residuals)
        factors = np.where(estimable, power / np.maximum(expected, 1e-300), 1.0)
        return ErrorSpectrum(np.maximum(factors * model / count, 2 * self.step * MIN_ERROR_M**2), self.step)


def white_spectrum(sigma: float, step: float) -> ErrorSpectrum:
    """Of independent samples of standard deviation sigma, m."""
    return ErrorSpectrum(np.full(len(EDGES_HZ), 2 * step * sigma**2), step)


def fit_error_spectrum(time: Array, x: Array, variance: Array, X: Array, step: float) -> ErrorSpectrum:
    """The spectrum that makes elongations x (F,), m, measured with `variance` (F,), most likely, X (F, P) fitted along.

    step: s, between the samples that the spectrum is for.
    """
    part = slice(max(0, len(time) // 2 - MAX_SAMPLES // 2), len(time) // 2 + MAX_SAMPLES // 2)
    t, y, r, D = time[part], x[part], variance[part], X[part]
    D_and_y = np.column_stack([D, y])
    least = float(np.log(undetectable_error(r)))
    units = [_process_precision(tau, t) for tau in CORRELATION_S]

    def cost(v: Array) -> float:
        if not (least <= v[0] < -3 and least - 5 <= v[1] < -3):
            return 1e12
        fast, slow = np.exp(v)
        noise = r + fast**2
        weighted = D_and_y / noise[:, None]
        # both processes' precision, interleaved
        band = np.zeros((3, 2 * len(t)))
        log_determinant = 0.0
        for k, (sigma, (diagonal, beside, of_unit)) in enumerate(zip((fast, slow), units, strict=True)):
            band[0, k::2] = diagonal / sigma**2 + 1 / noise
            band[2, k : 2 * len(t) - 2 : 2] = beside / sigma**2
            log_determinant += of_unit - 2 * len(t) * float(np.log(sigma))
        band[1, ::2] = 1 / noise
        cholesky = banded_cholesky(band)
        half = cholesky.solve_first_half(np.repeat(weighted, 2, axis=0))
        products = D_and_y.T @ weighted - half.T @ half
        normal = products[:-1, :-1] + np.eye(D.shape[1]) / REGRESSOR_SIGMA_M**2
        beta = np.linalg.solve(normal, products[:-1, -1])
        return (
            cholesky.log_determinant
            - log_determinant
            + float(np.sum(np.log(noise)))
            + float(np.linalg.slogdet(normal)[1])
            + float(products[-1, -1] - products[:-1, -1] @ beta)
        )

    start = np.full(2, least + 0.1)
    simplex = start + np.array([[0, 0], [1.0, 0], [0, 1.0]])
    minimum = minimize(
        cost, start, method="Nelder-Mead", options={"xatol": 0.05, "fatol": 0.1, "initial_simplex": simplex}
    )
    fast, slow = np.exp(minimum.x)
    return _processes_spectrum((float(fast), float(slow)), step)


def undetectable_error(variance: Array) -> float:
    """The largest error, m, that samples of this `variance` (F,) cannot tell from none: the standard error of their variance."""
    return max(float(np.sqrt(np.median(variance)) * (2 / len(variance)) ** 0.25), MIN_ERROR_M)


def _processes_spectrum(sigmas: tuple[float, float], step: float) -> ErrorSpectrum:
    """Of both processes, and of white noise as large as the fast one."""
    edges = np.append(EDGES_HZ, 0.5 / step)
    below = sum(
        sigma**2 * 2 / np.pi * np.arctan(2 * np.pi * edges * tau)
        for sigma, tau in zip(sigmas, CORRELATION_S, strict=True)
    )
    return ErrorSpectrum(np.diff(below + sigmas[0] ** 2 * 2 * step * edges) / np.diff(edges), step)


def _process_precision(tau: float, time: Array) -> tuple[Array, Array, float]:
    """Precision of a process of variance 1: its diagonal (F,), what stands beside it (F - 1,), the logarithm of its determinant."""
    decay = np.exp(-np.diff(time) / tau)
    innovation = 1 - decay**2
    diagonal = np.ones(len(time))
    diagonal[1:] = 1 / innovation
    diagonal[:-1] += decay**2 / innovation
    return diagonal, -decay / innovation, -float(np.sum(np.log(innovation)))
