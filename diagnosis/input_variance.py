"""What is not known of motors' forces where these are jerked or about to turn round: more than noise says, for a few rows."""

import numpy as np
from numpy.typing import NDArray

from identification.signals import Signals
from mechanism.description import Neck
from mechanism.friction import dry

Array = NDArray[np.float64]

ACCELERATION_SMOOTHING_S = 4e-3
"""s, over which motor counts are smoothed to an acceleration (docs/thresholds.md)"""
ROUNDING_SHARE = 0.2
"""of the speed that rounding of counts may make between two of the filter's rows: counts turn over many times in between
(docs/thresholds.md)"""


def input_variance(neck: Neck, s: Signals, fs: Array, cm: Array) -> Array:
    """Variance of every channel's rows beyond noise, (C, S), N^2 and (N m)^2.

    Smoothing over ACCELERATION_SMOOTHING_S takes from inertial forces what their second derivative says; near rest a count more
    or less between two of the filter's rows is a speed by which friction differs. Both last shorter than the filter does.
    """
    smoothed_away = (
        ACCELERATION_SMOOTHING_S**2 / 2 * np.gradient(np.gradient(s.inertial, s.step, axis=0), s.step, axis=0)
    )
    count = 2 * np.pi / np.array([motor.counts for motor in neck.motors])
    speed = ROUNDING_SHARE * np.sqrt(2 / 12) * count / (s.step * s.low_pass.factor)
    friction = fs * (dry(s.theta_d + speed, cm) - dry(s.theta_d - speed, cm)) / 2
    motor = s.low_pass(smoothed_away.T) ** 2 + s.low_pass(friction.T) ** 2
    lever = (s.Z[s.low_pass.kept] ** 2).transpose(1, 2, 0)
    return np.concatenate([motor, np.einsum("nms,ms->ns", lever, motor)])
