"""The noise that residuals of a planned motion would have: angles that are noisy in every frame, through the equations.

Motors take elongations from the frames themselves, the arm angles that vision alone has smoothed (diagnosis/noise_ensemble.py). A
smoother that follows a lively motion lets through most of what the equations' filter does, and alpha'' is noisy accordingly.
"""

import numpy as np
from numpy.typing import NDArray

from diagnosis.linearisation import Linearisation, RecordingLinearisation
from diagnosis.noise_ensemble import noise_whitener
from identification.design.information import AngleNoise
from identification.fitting import segment_starts
from identification.residual_sensitivity import AngleError
from identification.whitening import Whitener

Array = NDArray[np.float64]

_SMOOTHER_HZ = 8.0
"""Hz: up to it angles that vision alone smoothed follow the noise of a lively motion's frames (docs/thresholds.md)"""
_SMOOTHER_POWER = 6
"""of its gain beyond that: knots of a spline whose third derivative is white noise"""
_DRAWS = 4


def planned_whitener(at: Linearisation, noise: AngleNoise) -> Whitener:
    """Of the one recording of a linearisation along a planned motion."""
    (recording,) = at.recordings
    rng = np.random.default_rng(0)
    draws = [_residuals(recording, noise, rng) for _ in range(_DRAWS)]
    return noise_whitener([draws], [segment_starts(recording.signals)], recording.signals.arm.M)


def _residuals(recording: RecordingLinearisation, noise: AngleNoise, rng: np.random.Generator) -> Array:
    """One draw, (C, S)."""
    s, change = recording.signals, recording.sensitivity.residual_change
    rows, joints = s.alpha.shape
    hertz = np.fft.rfftfreq(rows, s.step)[:, None]
    white = np.fft.rfft(np.sqrt(noise.density / s.step) * rng.normal(size=(rows, joints)), axis=0)
    of_frames = white * (hertz < noise.frame_hz / 2)
    smoothed = of_frames / (1 + (hertz / _SMOOTHER_HZ) ** _SMOOTHER_POWER)
    w = 2j * np.pi * hertz

    def error(spectrum: NDArray[np.complex128]) -> AngleError:
        series = (np.fft.irfft(factor * spectrum, rows, axis=0) for factor in (1, w, w**2))
        return AngleError(*(s.low_pass(values.T).T for values in series))

    motors = s.arm.M
    return np.concatenate([change(angle_error=error(of_frames))[:motors], change(angle_error=error(smoothed))[motors:]])
