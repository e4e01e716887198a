"""Motors at rest, where dry friction may hold them at any force up to its greatest, whatever a law of their speed says."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

Array = NDArray[np.float64]

REST_SPEED_RAD_S = 0.2
"""rad/s of the motor: a slower one counts as at rest (docs/thresholds.md)"""
MIN_REST_RATIO = 1.5
"""of what a cable leaves while its motor is at rest over what it leaves while that turns: more is friction that holds the motor
(docs/thresholds.md)"""
MIN_REST_ERROR_M = 2e-5
"""m: what more a cable leaves there at the least: counts of the encoder leave a few micrometres, where speeds are near nothing
(docs/thresholds.md)"""
MIN_OF_A_CLASS = 40
"""frames by which an error is estimated"""
_WINDOW_S = 0.03
"""s over which a motor's mean speed says whether it is at rest"""
_MARGIN_S = 0.04
"""s about rest in which filters spread what friction does there"""


def at_rest(theta: Array, rate: float) -> NDArray[np.bool_]:
    """Whether each motor is at rest, (T, M), by angles (T, M), rad, so many times a second."""
    half = max(1, round(_WINDOW_S * rate / 2))
    rows = np.arange(len(theta))
    after, before = np.minimum(rows + half, len(theta) - 1), np.maximum(rows - half, 0)
    return np.abs(theta[after] - theta[before]) * rate < REST_SPEED_RAD_S * (after - before)[:, None]


def rests_near(theta: Array, rate: float) -> NDArray[np.bool_]:
    """Whether each motor is at rest, or within what filters spread of it, (T, M), by angles (T, M), rad, so many times a second."""
    return np.asarray(maximum_filter1d(at_rest(theta, rate), 2 * round(_MARGIN_S * rate) + 1, axis=0), dtype=bool)


def error_at_rest(residual: Array, at_rest: NDArray[np.bool_]) -> Array:
    """What more of each cable is not explained while its motor is at rest, (M,), m, of residuals (F, M), m; nothing where it
    is hardly more than while the motor turns, or frames are too few."""
    out = np.zeros(residual.shape[1])
    for j, (square, rests) in enumerate(zip(residual.T**2, at_rest.T, strict=True)):
        if min(rests.sum(), (~rests).sum()) >= MIN_OF_A_CLASS:
            resting, turning = float(np.mean(square[rests])), float(np.mean(square[~rests]))
            if resting > max(MIN_REST_RATIO**2 * turning, turning + MIN_REST_ERROR_M**2):
                out[j] = np.sqrt(resting - turning)
    return out
