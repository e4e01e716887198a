"""Fasquelle's chain from recorded signals to regressors: decimate, interpolate, filter, differentiate (section 6.5)."""

import numpy as np
from numpy.typing import NDArray
from scipy.signal import decimate

from identification.dataset.dataset import state_series
from identification.dataset.series import Series, interpolated
from identification.filters import low_pass
from mechanism.arm import Arm
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

FASQUELLE_RATE_HZ = 31.25
"""Hz: 500 Hz divided by 16, the closest to the video's 30 Hz"""
FASQUELLE_CUTOFF_HZ = 5.0
"""Hz: of the zero-phase Butterworth low-pass"""
MIN_OVERLAP_S = 2.0
"""s of log and video that must overlap"""


def fasquelle_series(
    arm: Arm, log: Series, angle_time: Array, alpha: Array, cutoff: float = FASQUELLE_CUTOFF_HZ
) -> Series:
    """The series of a data set by Fasquelle's chain.

    log: thetaJ, fJ on a uniform clock. angle_time: (F,), s, frame times on the log's clock; alpha: (F, N), rad, no NaN.
    Derivatives are central differences after filtering. Raises Refused where less than two seconds overlap.
    """
    rate = 1 / float(np.median(np.diff(log.time)))
    factor = max(1, round(rate / FASQUELLE_RATE_HZ))
    theta, f = log.matrix("theta"), log.matrix("f")
    if factor > 1:
        theta, f = (
            np.asarray(decimate(part, factor, n=8, ftype="iir", axis=0, zero_phase=True)) for part in (theta, f)
        )
    time = log.time[::factor]
    inside = (time >= angle_time[0]) & (time <= angle_time[-1])
    time, theta, f = time[inside], theta[inside], f[inside]
    if (overlap := len(time) * factor / rate) < MIN_OVERLAP_S:
        raise Refused("data set", f"only {overlap:.1f} s of the log overlap the video", "record both longer")
    alpha_of_rows = interpolated(time, angle_time, alpha)
    step = float(np.mean(np.diff(time)))
    alpha0, theta0, f0 = (low_pass(part, 1 / step, cutoff) for part in (alpha_of_rows, theta, f))
    alpha_parts, theta_parts = _differentiated(alpha0, step), _differentiated(theta0, step)
    without_rate = state_series(arm, time, alpha_parts, theta_parts, f0)
    x_d = np.gradient(without_rate.matrix("x"), step, axis=0)
    return state_series(arm, time, alpha_parts, theta_parts, f0, x_d=x_d)


def _differentiated(values: Array, step: float) -> tuple[Array, Array, Array]:
    first = np.gradient(values, step, axis=0)
    return values, first, np.gradient(first, step, axis=0)
