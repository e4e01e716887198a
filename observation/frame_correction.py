"""What frames now and then tell of a model that is a little wrong: by how much each joint stands beside it, pose by pose.

A load, a spring or a friction that the model lacks moves the joints by an amount that follows the pose and the way they turn.
It is the same each time the arm comes by, where the pose's error in the filter is forgotten after a second. So it is taken for
linear in the angles and in the directions in which the joints turn, and each frame corrects the coefficients by least squares.

Before any frame they are as large as what calibration left of the angles. Sigma of the joints stays what it is without them.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TURNING_RAD_S = 0.1
"""rad/s, of a joint that counts as turning, mostly (docs/thresholds.md)"""
PASSING_SHARE = 0.25
"""of the variance of the pose's error, that does not come back where the pose does (docs/thresholds.md)"""


@dataclass(frozen=True)
class FrameCorrection:
    """Coefficients of each joint, for features of the pose: 1, N scaled angles, N directions."""

    middle: Array
    """of the angles' range, (N,), rad"""
    half_range: Array
    """(N,), rad"""
    coefficients: Array
    """(features, N), rad"""
    covariance: Array
    """of each joint's coefficients, (N, features, features), rad^2"""

    def at(self, alpha: Array, alpha_d: Array) -> Array:
        """By how much joints stand beside the model at angles (N,), rad, and speeds (N,), rad/s: (N,), rad."""
        return self.features(alpha, alpha_d) @ self.coefficients

    def rate(self, alpha_d: Array) -> Array:
        """How fast that changes along the motion, (N,), rad/s; where a joint turns round it jumps."""
        return (alpha_d / self.half_range) @ self.coefficients[1 : 1 + len(alpha_d)]

    def settled(self) -> "FrameCorrection":
        """As it stands, whatever frames may come."""
        return replace(self, covariance=np.zeros_like(self.covariance))

    def features(self, alpha: Array, alpha_d: Array) -> Array:
        """Features, (features,)."""
        return np.concatenate([[1.0], (alpha - self.middle) / self.half_range, np.tanh(alpha_d / TURNING_RAD_S)])

    def corrected(self, alpha: Array, alpha_d: Array, beside: Array, variance: Array) -> "FrameCorrection":
        """By one frame that saw joints stand `beside` the model, (N,), rad, NaN where not seen.

        variance: of the frame, and of what does not come back, (N,), rad^2."""
        h = self.features(alpha, alpha_d)
        coefficients, covariance = self.coefficients.copy(), self.covariance.copy()
        for i in np.flatnonzero(np.isfinite(beside)):
            by = covariance[i] @ h
            gain = by / (h @ by + variance[i])
            coefficients[:, i] += gain * (beside[i] - h @ coefficients[:, i])
            covariance[i] -= np.outer(gain, by)
        return replace(self, coefficients=coefficients, covariance=covariance)


def no_correction(middle: Array, half_range: Array, sigma: Array) -> FrameCorrection:
    """Before any frame, for joints of which calibration left sigma (N,), rad."""
    n = len(middle)
    count = 1 + 2 * n
    each = sigma[:, None, None] ** 2 / count
    return FrameCorrection(middle, half_range, np.zeros((count, n)), each * np.eye(count))
