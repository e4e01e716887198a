"""What frames now and then tell of a model that is a little wrong: by how much each joint stands beside it, pose by pose.

A load, a spring, a friction or play that the model lacks moves the joints by an amount that follows the pose, the way they turn,
and the sides to which motors turned last. It is the same each time the arm comes by, where the pose's error in the filter is
forgotten after a second. So it is taken for linear in these, and each frame corrects the coefficients by least squares. What frames
told is forgotten over minutes: an arm warms up, and a cable slips.

Before any frame each kind of them may make all that calibration left of the angles. Sigma of the joints stays what it is without
them.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TURNING_RAD_S = 0.1
"""rad/s, of a joint that counts as turning, mostly (docs/thresholds.md)"""
PASSING_SHARE = 0.25
"""of the variance of the pose's error, that does not come back where the pose does (docs/thresholds.md)"""
FORGOTTEN_S = 120.0
"""s after which coefficients are nearly as unknown as before any frame (docs/thresholds.md)"""


@dataclass(frozen=True)
class FrameCorrection:
    """Coefficients of each joint, for features of the pose: 1, N scaled angles, N directions of joints, M sides of motors."""

    middle: Array
    """of the angles' range, (N,), rad"""
    half_range: Array
    """(N,), rad"""
    coefficients: Array
    """(features, N), rad"""
    covariance: Array
    """of each joint's coefficients, (N, features, features), rad^2"""
    unknown: Array
    """variance of each joint's coefficients before any frame, (N, features), rad^2"""
    told_at: float = 0.0
    """s since the recording began, of the last frame"""

    def at(self, alpha: Array, alpha_d: Array, sides: Array) -> Array:
        """By how much joints stand beside the model at angles (N,), rad, speeds (N,), rad/s, and motors' sides (M,): (N,), rad."""
        return self.features(alpha, alpha_d, sides) @ self.coefficients

    def rate(self, alpha_d: Array) -> Array:
        """How fast that changes along the motion, (N,), rad/s; where a joint turns round it jumps."""
        return (alpha_d / self.half_range) @ self.coefficients[1 : 1 + len(alpha_d)]

    def settled(self) -> "FrameCorrection":
        """As it stands, whatever frames may come."""
        return replace(self, covariance=np.zeros_like(self.covariance), unknown=np.zeros_like(self.unknown))

    def features(self, alpha: Array, alpha_d: Array, sides: Array) -> Array:
        """Features, (features,)."""
        turning = np.tanh(alpha_d / TURNING_RAD_S)
        return np.concatenate([[1.0], (alpha - self.middle) / self.half_range, turning, sides])

    def variance(self, alpha: Array, alpha_d: Array, sides: Array, since: float) -> Array:
        """Of what `at` says, (N,), rad^2; since: the recording began, s."""
        h = self.features(alpha, alpha_d, sides)
        return np.asarray(self._covariance_at(since) @ h @ h)

    def _covariance_at(self, since: float) -> Array:
        """What is not known of the coefficients, the more the longer ago the last frame was."""
        kept = np.exp(-max(since - self.told_at, 0.0) / FORGOTTEN_S)
        unknown = self.unknown[:, :, None] * np.eye(self.unknown.shape[1])
        return unknown + (self.covariance - unknown) * kept

    def corrected(
        self, alpha: Array, alpha_d: Array, sides: Array, beside: Array, variance: Array, since: float
    ) -> "FrameCorrection":
        """By one frame that saw joints stand `beside` the model, (N,), rad, NaN where not seen.

        variance: of the frame, and of what does not come back, (N,), rad^2; since: the recording began, s."""
        h = self.features(alpha, alpha_d, sides)
        coefficients, covariance = self.coefficients.copy(), self._covariance_at(since)
        for i in np.flatnonzero(np.isfinite(beside)):
            by = covariance[i] @ h
            gain = by / (h @ by + variance[i])
            coefficients[:, i] += gain * (beside[i] - h @ coefficients[:, i])
            covariance[i] -= np.outer(gain, by)
        return replace(self, coefficients=coefficients, covariance=covariance, told_at=since)


def no_correction(middle: Array, half_range: Array, sigma: Array, motors: int) -> FrameCorrection:
    """Before any frame, for joints of which calibration left sigma (N,), rad.

    Each kind of feature may make all of it: an offset, the angles, whose scaled squares are a third in the mean, the directions, or
    the sides."""
    n = len(middle)
    each = np.concatenate([[1.0], np.full(n, 3 / n), np.full(n, 1 / n), np.full(motors, 1 / motors)])
    unknown = sigma[:, None] ** 2 * each
    return FrameCorrection(
        middle=middle,
        half_range=half_range,
        coefficients=np.zeros((len(each), n)),
        covariance=unknown[:, :, None] * np.eye(len(each)),
        unknown=unknown,
    )
