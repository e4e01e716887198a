"""Elongations in the camera's frames: what vision and encoders measure together, and how uncertain vision leaves them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset.frames import FrameAngles
from identification.dataset.series import interpolated
from mechanism.arm import Arm
from mechanism.cable_lengths import Z
from mechanism.elasticity import elongation
from state_estimation.elongation_regressors import VISCOUS
from state_estimation.motors import Motors
from synchronisation.check.absolute_law import AbsoluteLaw, absolute_law
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

MIN_FRAMES = 30
"""frames with all angles, as for the clock: a second, and more than the law has unknowns (docs/thresholds.md)"""


@dataclass(frozen=True)
class ElongationObservation:
    """Frames in which all angles were seen, on the log's clock."""

    arm: Arm
    time: Array
    """(F,), s"""
    alpha: Array
    """(F, N), rad"""
    theta: Array
    """(F, M), rad"""
    theta_d: Array
    """(F, M), rad/s, as the law filters it: an error of the clock is then exactly what viscous friction can pass for"""
    variance: Array
    """of noise in alpha, (F, N), rad^2"""
    common: Array
    """standard deviation of an error that alpha has in all frames, (N,), rad"""
    clock_sigma: float
    """of the offset between frames and log, s"""
    x: Array
    """elongation (41), (F, M), m"""
    law: AbsoluteLaw

    @property
    def vision(self) -> Array:
        """Covariance of x by vision's noise, (F, M, M), m^2: cables share the angles' errors."""
        levers = Z(self.arm, self.alpha)
        return np.einsum("tij,ti,tik->tjk", levers, self.variance, levers)

    def elongation(self, arm: Arm | None = None, alpha: Array | None = None) -> Array:
        """(41) with the dimensions of another arm, or at other angles, (F, M), m."""
        arm = arm or self.arm
        alpha = self.alpha if alpha is None else alpha
        return elongation(arm, alpha, self.theta)


def observe(
    arm: Arm, frames: FrameAngles, motors: Motors, clock_sigma: float = 0.0, friction: Array | None = None
) -> ElongationObservation:
    """The observation of frames within the motors' time; friction (M, FRICTION_TERMS), N, where a baseline gives it.

    Raises Refused where there are too few frames with all angles.
    """
    complete = np.isfinite(frames.alpha).all(axis=1)
    complete &= (frames.time >= motors.time[0]) & (frames.time <= motors.time[-1])
    if np.sum(complete) < MIN_FRAMES:
        count = f"only {np.sum(complete)} frames with all angles are within the log's time"
        raise Refused("check", count, "does the camera's clock belong to this log?")
    time, alpha = frames.time[complete], frames.alpha[complete]
    theta = interpolated(time, motors.time, motors.theta)
    x = elongation(arm, alpha, theta)
    law = absolute_law(arm, motors, time, x, friction)
    return ElongationObservation(
        arm=arm,
        time=time,
        alpha=alpha,
        theta=theta,
        theta_d=law.X[..., VISCOUS],
        variance=frames.sigma[complete] ** 2,
        common=np.sqrt(np.mean(frames.common[complete] ** 2, axis=0)),
        clock_sigma=clock_sigma,
        x=x,
        law=law,
    )
