"""The spectrum of the cables' errors: whitened samples, and its re-estimation from what a solution leaves of the error."""

import numpy as np

from state_estimation.elongation_error_spectrum import EDGES_HZ, ErrorSpectrum, white_spectrum

STEP = 0.024
COUNT = 2500
EDGES = np.append(EDGES_HZ, 0.5 / STEP)
FALLING = ErrorSpectrum(1e-12 * np.array([30.0, 20.0, 10.0, 5.0, 3.0, 2.0]), STEP)
"""an error that is denser where it is slow"""


def drawn(spectrum: ErrorSpectrum, seed: int) -> np.ndarray:
    """Samples (COUNT,) of that density, made in the frequency domain."""
    rng = np.random.default_rng(seed)
    hertz = np.fft.rfftfreq(COUNT, STEP)
    density = spectrum.density[np.clip(np.searchsorted(EDGES, hertz, side="right") - 1, 0, len(EDGES_HZ) - 1)]
    return np.fft.irfft(np.fft.rfft(rng.normal(size=COUNT)) * np.sqrt(density / (2 * STEP)), COUNT)


def lines() -> np.ndarray:
    """Fourier lines in each band."""
    return np.histogram(np.fft.rfftfreq(COUNT, STEP), EDGES)[0]


def test_variance_is_the_integral_of_the_density() -> None:
    """A sum of about 1250 exponential lines of uneven size: a spread below 7 %, four of which are allowed."""
    assert abs(np.var(drawn(FALLING, 0)) / FALLING.variance - 1) < 0.28
    assert np.isclose(white_spectrum(3e-6, STEP).variance, 9e-12)


def test_whitened_samples_are_white_and_of_variance_one() -> None:
    """2500 samples: their variance spreads by sqrt(2 / 2500) = 0.028, a correlation by 0.02; four times that is allowed."""
    taps, sigma = FALLING.whitener()
    assert np.isclose(sigma**2, FALLING.variance)
    out = np.convolve(drawn(FALLING, 1), taps, mode="valid")
    assert abs(np.var(out) - 1) < 0.12
    for lag in range(1, len(taps)):
        assert abs(np.mean(out[lag:] * out[:-lag])) < 0.08


def test_a_wrong_spectrum_is_corrected_by_residuals() -> None:
    """From ten times too much and white: each band is estimated to 1 / sqrt(lines); three of them are allowed.

    The solution takes a constant and 100 lines of 2 to 4 Hz: unless that is accounted for, the third band of 150 lines comes out
    too small by 100 / 150. It keeps 50 lines.
    """
    t = np.arange(COUNT) * STEP
    hertz = 2 + np.arange(100) / (COUNT * STEP)
    angles = 2 * np.pi * np.outer(t, hertz)
    basis = np.linalg.qr(np.column_stack([np.ones(COUNT), np.cos(angles), np.sin(angles)]))[0]
    e = drawn(FALLING, 2)
    spectrum, rng = white_spectrum(1e-4, STEP), np.random.default_rng(3)
    for _ in range(4):
        taps, _ = spectrum.whitener()

        def residuals(v: np.ndarray) -> np.ndarray:
            return v - basis @ (basis.T @ v)

        whitened = np.convolve(e, taps)[:COUNT]
        probes = rng.normal(size=(COUNT, 8))
        spectrum = spectrum.reestimated(residuals(whitened), probes, residuals(probes))
    ratio = spectrum.density / FALLING.density
    assert np.all(np.abs(ratio - 1) < 3 / np.sqrt(lines() - np.array([0, 0, 100, 0, 0, 0])))
