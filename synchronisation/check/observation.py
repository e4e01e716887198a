"""Elongations in the camera's frames: what vision and encoders say together, and how far vision leaves them uncertain."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset.frames import FrameAngles
from mechanism.arm import Arm
from mechanism.cable_lengths import Z
from mechanism.elasticity import elongation
from state_estimation.motors import Motors
from synchronisation.check.elongation_law import Regressors, regressors
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

LEAST_FRAMES = 30
"""as for the clock: a second, and more than the law has unknowns"""


@dataclass(frozen=True)
class Observed:
    """Frames in which all angles were seen, on the log's clock: time (F,), s; alpha (F, N), rad; theta (F, M), rad."""

    arm: Arm
    time: Array
    alpha: Array
    theta: Array
    theta_d: Array
    variance: Array
    """of noise in alpha, (F, N), rad^2"""
    common: Array
    """standard deviation of what is constant in alpha, (N,), rad"""
    clock_sigma: float
    """s"""
    x: Array
    """elongation (41), (F, M), m"""
    law: Regressors

    @property
    def vision(self) -> Array:
        """Covariance of x by vision's noise, (F, M, M), m^2: cables share the angles' errors."""
        pull = Z(self.arm, self.alpha)
        return np.einsum("tij,ti,tik->tjk", pull, self.variance, pull)

    def elongation(self, arm: Arm | None = None, alpha: Array | None = None) -> Array:
        """(41) as another arm, or other angles, would have it, (F, M), m."""
        arm = arm or self.arm
        alpha = self.alpha if alpha is None else alpha
        return elongation(arm, alpha, self.theta)


def observe(
    arm: Arm, seen: FrameAngles, motors: Motors, clock_sigma: float = 0.0, friction: Array | None = None
) -> Observed:
    """Frames of `seen` within the motors' time; friction (M, 3), N, where it is known from a baseline."""
    whole = np.isfinite(seen.alpha).all(axis=1) & (seen.time >= motors.time[0]) & (seen.time <= motors.time[-1])
    if np.sum(whole) < LEAST_FRAMES:
        word = f"only {np.sum(whole)} frames with all angles are within the log's time"
        raise Refused("check", word, "does the camera's clock belong to this log?")
    time, alpha = seen.time[whole], seen.alpha[whole]
    theta, theta_d = (
        np.stack([np.interp(time, motors.time, c) for c in values.T], axis=-1)
        for values in (motors.theta, motors.theta_d)
    )
    x = elongation(arm, alpha, theta)
    law = regressors(arm, motors, time, x, friction)
    common = np.sqrt(np.mean(seen.common[whole] ** 2, axis=0))
    return Observed(arm, time, alpha, theta, theta_d, seen.sigma[whole] ** 2, common, clock_sigma, x, law)
