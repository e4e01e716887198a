"""What a motion will tell of each parameter before it is made: the rows of the identification, and vision's noise in them.

Noise is independent in every frame. In the motors' equation it is an elongation, k Z^T; in the arm's it is angles, smoothed,
with their alpha''. Both are taken as white below the filter's cutoff and as independent of each other, channel by channel, as the
fit weighs them. Clocks, what all frames share and the rounding of motor angles are not in a sigma.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.cable_memory import memory_states
from identification.decimation import CUTOFF_HZ, decimating_filter
from identification.design.trajectory import Trajectory
from identification.residuals import residual_rows, cable_motion
from identification.signals import Signals
from identification.unknowns import Unknowns
from mechanism.cable_lengths import Z, lengths, wrap_angles
from mechanism.dynamics import mass_matrix, terms
from mechanism.laws import Turning
from mechanism.machine import Machine

Array = NDArray[np.float64]

STATE_NOISE_HZ = 0.5
"""up to which a state follows the noise of its angles, as cables help it: on eight recordings of 30 and 60 s at 0.1 deg friction is
claimed with the sigmas predicted, on the geometric mean of fs (1.2 times), fv (0.8) and cm (0.7)"""
_SMALL_M, _SMALL_RAD = 1e-5, 1e-4
_ROWS_APART = 8
"""of the filter's, where the arm's noise is looked at"""


@dataclass(frozen=True)
class AngleNoise:
    """Of an angle in each frame."""

    sigma: float
    """rad"""
    frame_hz: float

    @property
    def density(self) -> float:
        """Two-sided, rad^2/Hz."""
        return self.sigma**2 / self.frame_hz


def noise_free_signals(motion: Trajectory) -> Signals:
    """The motion as if it had been recorded without noise."""
    arm = motion.arm
    jacobian, k = Z(arm, motion.alpha), terms(arm, motion.alpha, motion.alpha_d)
    step = float(motion.time[1] - motion.time[0])
    return Signals(
        arm=arm,
        time=motion.time,
        alpha=motion.alpha,
        alpha_d=motion.alpha_d,
        alpha_dd=motion.alpha_dd,
        seen=motion.alpha,
        seen_d=motion.alpha_d,
        theta=motion.theta,
        theta_d=motion.theta_d,
        theta_dd=motion.theta_dd,
        f=motion.f,
        inertial=arm.motor_inertia / arm.drum * motion.theta_dd,
        Z=jacobian,
        load=np.einsum("tij,tj->ti", k.M, motion.alpha_dd) + k.c + k.g,
        wrap=wrap_angles(arm, motion.alpha),
        length=lengths(arm, motion.alpha),
        x=motion.x,
        x_d=motion.x_d,
        low_pass=decimating_filter(step, np.ones(len(motion.time), dtype=bool)),
        clock_sigma=(0.0, 0.0),
        clock_doubt=0.0,
        angle_sigma=np.zeros(arm.N),
    )


def fisher_information(s: Signals, u: Unknowns, p: Array, noise: AngleNoise) -> Array:
    """Fisher's, (P, P), of one recording at the vector p, beside that no number lies beyond its term's range."""
    J = residual_rows(s, u, p, 0).jacobian
    per_row = s.step * s.low_pass.factor
    weights = 1 / channel_noise(s, u, p, noise) ** 2
    # of white noise below the cutoff as many rows are independent as twice the cutoff gives
    weights *= 2 * CUTOFF_HZ * per_row
    return np.einsum("c,csp,csq->pq", weights, J, J) + np.diag(1 / (u.high - u.low) ** 2)


def channel_noise(s: Signals, u: Unknowns, p: Array, noise: AngleNoise) -> Array:
    """What passes the filter in each channel, (M + N,), N and N m."""
    values = u.values(p)
    machine = Machine(s.arm, u.laws, values)
    at = cable_motion(s, u.get(p, "x0", 0))
    x = at.x

    def pull(x: Array, z: Array) -> Array:
        return np.broadcast_to(machine.pull(replace(at, x=x), z), x.shape)

    z = memory_states(machine, at, s.step)
    stiffness = (pull(x + _SMALL_M, z) - pull(x, z)) / _SMALL_M
    motor = np.mean(stiffness**2 * np.sum(s.Z**2, axis=1), axis=0) * noise.density * 2 * CUTOFF_HZ
    return np.sqrt(np.concatenate([motor, _on_arm(s, u, values, noise)]))


def _on_arm(s: Signals, u: Unknowns, values: dict[str, Array], noise: AngleNoise) -> Array:
    """Variance of what errors of smoothed angles do to the arm's equation, (N,), (N m)^2: (S - M w^2) on each frequency."""
    at = s.low_pass.kept[::_ROWS_APART]
    alpha, still = s.alpha[at], np.zeros_like(s.alpha[at])
    rub = Machine(s.arm, u.laws, values).friction(Turning(s.theta_d, np.zeros_like(s.theta_d), s.wrap))
    net = (s.f - s.inertial - rub)[at]

    def torque(alpha: Array) -> Array:
        return terms(s.arm, alpha, still).g - np.einsum("tij,tj->ti", Z(s.arm, alpha), net)

    now = torque(alpha)
    steps = _SMALL_RAD * np.eye(s.arm.N)
    stiffness = np.stack([(torque(alpha + h) - now) / _SMALL_RAD for h in steps], axis=-1)
    inertia, w, b = mass_matrix(s.arm, alpha), 2 * np.pi, STATE_NOISE_HZ
    each = stiffness**2 * b - 2 * stiffness * inertia * w**2 * b**3 / 3 + inertia**2 * w**4 * b**5 / 5
    return 2 * noise.density * np.mean(np.sum(each, axis=2), axis=0)


def covariance_from(matrix: Array) -> Array:
    """Inverse of an information matrix, (P, P), whatever units its parameters have."""
    scale = np.sqrt(np.diag(matrix))
    return np.linalg.inv(matrix / np.outer(scale, scale)) / np.outer(scale, scale)


def predicted_sigma(matrix: Array) -> Array:
    """Standard deviations that the identification will claim, (P,)."""
    return np.sqrt(np.diag(covariance_from(matrix)))
