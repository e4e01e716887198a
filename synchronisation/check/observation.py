"""Elongations in the camera's frames: what vision and encoders measure together, and how uncertain vision leaves them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset.frames import FrameAngles, ordinary_frames
from identification.dataset.series import interpolated
from identification.motor_rest import error_at_rest, rests_near
from mechanism.arm import Arm
from mechanism.cable_lengths import Z
from mechanism.elasticity import elongation
from mechanism.tolerance import Tolerance
from state_estimation.elongation_law import left_by
from state_estimation.elongation_regressors import VISCOUS
from state_estimation.motors import Motors
from synchronisation.check.absolute_law import AbsoluteLaw, CableForces, absolute_law
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

MIN_FRAMES = 30
"""frames with all angles, as for the clock: a second, and more than the law has unknowns (docs/thresholds.md)"""

UNTOLD_M = 0.1
"""m: standard deviation of the elongation of a cable whose force does not tell it (docs/thresholds.md)"""
MIN_TURNING_FRAMES = 150
"""frames in which no motor is held, five seconds of them: with fewer none is left out (docs/thresholds.md)"""


@dataclass(frozen=True, eq=False)
class ElongationObservation:
    """Frames in which all angles were seen, on the log's clock."""

    arm: Arm
    time: Array
    """(F,), s"""
    alpha: Array
    """as seen, (F, N), rad"""
    adjusted: Array
    """(F, N), rad: as the cables have them too, once these were fitted; what an error of the arm does is computed there, for at
    angles as seen it would share their noise with x"""
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
    tolerance: Tolerance
    """of the drawing and the markers"""

    @property
    def vision(self) -> Array:
        """Covariance of x by vision's noise, (F, M, M), m^2: cables share the angles' errors.

        What a force that hardly changes does not tell of its cable is as good as unknown besides."""
        levers = Z(self.arm, self.alpha)
        unknown = np.diag(np.where(self.law.untold, UNTOLD_M, 0.0) ** 2)
        return np.einsum("tij,ti,tik->tjk", levers, self.variance, levers) + unknown

    def elongation(self, arm: Arm | None = None, alpha: Array | None = None) -> Array:
        """(41) with the dimensions of another arm, or at other angles than the adjusted ones, (F, M), m."""
        arm = arm or self.arm
        alpha = self.adjusted if alpha is None else alpha
        return elongation(arm, alpha, self.theta)


def observe(
    arm: Arm,
    frames: FrameAngles,
    motors: Motors,
    clock_sigma: float = 0.0,
    forces: CableForces | None = None,
    tolerance: Tolerance | None = None,
) -> ElongationObservation:
    """The observation of frames within the motors' time; forces: where a baseline gives them.

    tolerance: a workshop's where it is not said.

    Raises Refused where there are too few frames with all angles.
    """
    complete = ordinary_frames(frames.alpha, frames.sigma)
    complete &= (frames.time >= motors.time[0]) & (frames.time <= motors.time[-1])
    if np.sum(complete) < MIN_FRAMES:
        count = f"only {np.sum(complete)} frames with all angles are within the log's time"
        raise Refused("check", count, "does the camera's clock belong to this log?")
    time, alpha = frames.time[complete], frames.alpha[complete]
    theta = interpolated(time, motors.time, motors.theta)
    x = elongation(arm, alpha, theta)
    law = absolute_law(arm, motors, time, x, forces)
    turning = _where_motors_turn(law, motors, time, x)
    if not turning.all():
        complete[complete] = turning
        time, alpha, theta, x = time[turning], alpha[turning], theta[turning], x[turning]
        law = absolute_law(arm, motors, time, x, forces)
    return ElongationObservation(
        arm=arm,
        time=time,
        alpha=alpha,
        adjusted=alpha,
        theta=theta,
        theta_d=law.X[..., VISCOUS],
        variance=frames.sigma[complete] ** 2,
        common=np.sqrt(np.mean(frames.common[complete] ** 2, axis=0)),
        clock_sigma=clock_sigma,
        x=x,
        law=law,
        tolerance=tolerance or Tolerance(),
    )


def _where_motors_turn(law: AbsoluteLaw, motors: Motors, time: Array, x: Array) -> NDArray[np.bool_]:
    """Of frames at times (F,), s, with elongations x (F, M), m, those in which no motor rests that friction holds there otherwise
    than the law says; all of them where these are too few."""
    step = float(np.mean(np.diff(motors.time)))
    rows = np.rint((time - motors.time[0]) / step).astype(int)
    at_rest = rests_near(motors.theta, 1 / step)[np.clip(rows, 0, len(motors.time) - 1)]
    held = error_at_rest(left_by(law.X, x), at_rest) > 0
    turning = ~np.asarray((at_rest & held).any(axis=1))
    return turning if turning.sum() >= MIN_TURNING_FRAMES else np.ones_like(turning)
