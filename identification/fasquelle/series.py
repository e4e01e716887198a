"""Fasquelle's own chain from recorded signals to its regressors: decimate, interpolate, filter, differentiate (its 6.5)."""

import numpy as np
from numpy.typing import NDArray
from scipy.signal import decimate

from identification.dataset.dataset import state_series
from identification.dataset.series import Series
from identification.filters import low_pass
from mechanism.arm import Arm
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

FASQUELLE_RATE_HZ = 31.25
"""Hz: what 500 Hz gives when divided by 16, the value closest to the video's 30 Hz"""
FASQUELLE_CUTOFF_HZ = 5.0
"""Hz: of the zero-phase Butterworth low-pass"""


def fasquelle_series(arm: Arm, log: Series, angle_time: Array, alpha: Array, cutoff: float = FASQUELLE_CUTOFF_HZ) -> Series:
    """The data set's series as Fasquelle makes it.

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
    if len(time) < 2 * FASQUELLE_RATE_HZ:
        raise Refused("data set", f"only {len(time) / FASQUELLE_RATE_HZ:.1f} s of the log overlap the video", "record both longer")
    seen = np.stack([np.interp(time, angle_time, column) for column in alpha.T], axis=-1)
    step = float(np.mean(np.diff(time)))
    alpha0, theta0, f0 = (low_pass(part, 1 / step, cutoff) for part in (seen, theta, f))
    alpha_parts, theta_parts = _differentiated(alpha0, step), _differentiated(theta0, step)
    made = state_series(arm, time, alpha_parts, theta_parts, f0)
    x_d = np.gradient(made.matrix("x"), step, axis=0)
    return state_series(arm, time, alpha_parts, theta_parts, f0, x_d=x_d)


def _differentiated(values: Array, step: float) -> tuple[Array, Array, Array]:
    first = np.gradient(values, step, axis=0)
    return values, first, np.gradient(first, step, axis=0)
