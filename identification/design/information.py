"""Fisher information of a planned motion on each parameter, from the rows of the identification and vision's noise in them.

Noise is independent in every frame. In the motors' equation it acts through the elongation, k Z^T; in the arm's through smoothed
angles and their alpha''. Both are taken as white below the filter's cutoff and as independent of each other, channel by channel, as
the fit weighs them. Errors of clocks, errors that all frames share, the rounding of motor angles, and what frames leave uncertain
of the cables' law that the angles follow from are left out: by the last, friction is told four or five times less well than that.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.cable_memory import memory_states
from identification.dataset.half_row_speeds import unrefined_speeds
from identification.decimation import CUTOFF_HZ, decimating_filter
from identification.design.trajectory import Trajectory
from identification.residuals import cable_motion, mean_friction, residual_rows
from identification.signals import Signals
from identification.unknowns import Unknowns
from mechanism.cable_lengths import Z, geometry_of_poses, lengths
from mechanism.dynamics import mass_matrix, terms
from mechanism.machine import Machine

Array = NDArray[np.float64]

STATE_NOISE_HZ = 0.5
"""Hz: up to it the state, fused with the cables, follows the noise of its angles (docs/thresholds.md)"""
_STEP_M, _STEP_RAD = 1e-5, 1e-4
_ROW_STRIDE = 8
"""every so many of the filter's rows the noise of the arm's equation is evaluated"""


@dataclass(frozen=True)
class AngleNoise:
    """White noise of the angles, independent in every frame."""

    sigma: float
    """rad"""
    frame_hz: float

    @property
    def density(self) -> float:
        """Two-sided power spectral density, rad^2/Hz."""
        return self.sigma**2 / self.frame_hz


def noise_free_signals(motion: Trajectory, clock_sigma: tuple[float, float] = (0.0, 0.0)) -> Signals:
    """The signals of the motion if it were recorded without noise; clock_sigma: s, of its clock, and where laws are in doubt."""
    arm = motion.arm
    jacobian, k = Z(arm, motion.alpha), terms(arm, motion.alpha, motion.alpha_d)
    step = float(motion.time[1] - motion.time[0])
    return Signals(
        arm=arm,
        time=motion.time,
        alpha=motion.alpha,
        alpha_d=motion.alpha_d,
        alpha_dd=motion.alpha_dd,
        vision_alpha=motion.alpha,
        vision_alpha_d=motion.alpha_d,
        theta=motion.theta,
        theta_d=motion.theta_d,
        theta_dd=motion.theta_dd,
        speeds=unrefined_speeds(motion.theta_d, np.zeros(arm.M)),
        f=motion.f,
        inertial=arm.motor_inertia / arm.drum * motion.theta_dd,
        Z=jacobian,
        load=np.einsum("tij,tj->ti", k.M, motion.alpha_dd) + k.c + k.g,
        wraps=geometry_of_poses(arm, motion.alpha).wraps,
        length=lengths(arm, motion.alpha),
        x=motion.x,
        x_d=motion.x_d,
        low_pass=decimating_filter(step, np.ones(len(motion.time), dtype=bool)),
        clock_sigma=(clock_sigma[0], 0.0),
        relaxed_clock_sigma=clock_sigma[1],
        angle_sigma=np.zeros(arm.N),
    )


def fisher_information(s: Signals, u: Unknowns, p: Array, noise: AngleNoise) -> Array:
    """Fisher information, (P, P), of one recording at the vector p, with a prior as wide as each term's range."""
    J = residual_rows(s, u, p, 0).jacobian
    per_row = s.step * s.low_pass.factor
    weights = 1 / channel_noise(s, u, p, noise) ** 2
    # of white noise below the cutoff as many rows are independent as twice the cutoff gives
    weights *= 2 * CUTOFF_HZ * per_row
    return np.einsum("c,csp,csq->pq", weights, J, J) + np.diag(1 / (u.high - u.low) ** 2)


def channel_noise(s: Signals, u: Unknowns, p: Array, noise: AngleNoise) -> Array:
    """Standard deviation of the noise that passes the filter in each channel, (M + N,), N and N m."""
    values = u.values(p, 0)
    machine = Machine(s.arm, u.laws, values)
    at = cable_motion(s, u.get(p, "x0", 0))
    x = at.x

    def pull(x: Array, z: Array) -> Array:
        return np.broadcast_to(machine.pull(replace(at, x=x), z), x.shape)

    z = memory_states(machine, at, s.step)
    stiffness = (pull(x + _STEP_M, z) - pull(x, z)) / _STEP_M
    motor = np.mean(stiffness**2 * np.sum(s.Z**2, axis=1), axis=0) * noise.density * 2 * CUTOFF_HZ
    return np.sqrt(np.concatenate([motor, _arm_noise_variance(s, u, values, noise)]))


def _arm_noise_variance(s: Signals, u: Unknowns, values: dict[str, Array], noise: AngleNoise) -> Array:
    """Variance in the arm's equation by errors of smoothed angles, (N,), (N m)^2: the factor is (S - M w^2) at each frequency w."""
    rows = s.low_pass.kept[::_ROW_STRIDE]
    alpha, at_rest = s.alpha[rows], np.zeros_like(s.alpha[rows])
    friction = mean_friction(s, Machine(s.arm, u.laws, values), np.zeros_like(s.theta_d))
    net = (s.f - s.inertial - friction)[rows]

    def torque(alpha: Array) -> Array:
        return terms(s.arm, alpha, at_rest).g - np.einsum("tij,tj->ti", Z(s.arm, alpha), net)

    torque_0 = torque(alpha)
    steps = _STEP_RAD * np.eye(s.arm.N)
    stiffness = np.stack([(torque(alpha + h) - torque_0) / _STEP_RAD for h in steps], axis=-1)
    inertia, w, b = mass_matrix(s.arm, alpha), 2 * np.pi, STATE_NOISE_HZ
    of_angles = stiffness**2 * b - 2 * stiffness * inertia * w**2 * b**3 / 3 + inertia**2 * w**4 * b**5 / 5
    return 2 * noise.density * np.mean(np.sum(of_angles, axis=2), axis=0)


def covariance_from(information: Array) -> Array:
    """Inverse of an information matrix, (P, P), scaled so that the units of its parameters do not matter."""
    scale = np.sqrt(np.diag(information))
    return np.linalg.inv(information / np.outer(scale, scale)) / np.outer(scale, scale)


def predicted_sigma(information: Array) -> Array:
    """Standard deviations that the identification is expected to report, (P,)."""
    return np.sqrt(np.diag(covariance_from(information)))
