"""What a motion will tell of each parameter before it is made: the rows of the identification, and vision's noise in them.

Noise is independent in every frame. In the motors' equation it is an elongation, k Z^T; in the arm's it is alpha'' of
smoothed angles, M. Both are taken as white below the filter's cutoff and as independent of each other, channel by channel, as
the fit weighs them. A sigma holds the fit's own floor too; clocks and what all frames share are not in it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.design.trajectory import Trajectory
from identification.fitting import PREPARED
from identification.low_pass import CUTOFF_HZ, low_pass
from identification.memory import remembered
from identification.residuals import rows
from identification.signals import Signals
from identification.unknowns import Unknowns
from mechanism.cable_lengths import Z, lengths, wraps
from mechanism.dynamics import mass_matrix, terms
from mechanism.laws import Stretching
from mechanism.machine import Machine

Array = NDArray[np.float64]

FOLLOWED_HZ = 2.8
"""up to which a state follows angles: noise of 0.1 deg at 30 Hz, differentiated twice up to here, is the 0.10 rad/s^2 that states of
such recordings claim of their alpha''"""
_SMALL_M = 1e-5


@dataclass(frozen=True)
class Noise:
    """Of an angle in each frame."""

    sigma: float
    """rad"""
    frame_hz: float

    @property
    def density(self) -> float:
        """Two-sided, rad^2/Hz."""
        return self.sigma**2 / self.frame_hz

    @property
    def acceleration(self) -> float:
        """Standard deviation of alpha'' as smoothed, rad/s^2."""
        return float(np.sqrt(2 * self.density * (2 * np.pi) ** 4 * FOLLOWED_HZ**5 / 5))


def signals_for(motion: Trajectory) -> Signals:
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
        theta_d=motion.theta_d,
        f=motion.f,
        inertial=arm.motor_inertia / arm.drum * motion.theta_dd,
        Z=jacobian,
        load=np.einsum("tij,tj->ti", k.M, motion.alpha_dd) + k.c + k.g,
        wrap=wraps(arm, motion.alpha),
        length=lengths(arm, motion.alpha),
        x=motion.x,
        x_d=motion.x_d,
        low_pass=low_pass(step, np.ones(len(motion.time), dtype=bool)),
        clock_sigma=(0.0, 0.0),
        angle_sigma=np.zeros(arm.N),
    )


def information(s: Signals, u: Unknowns, p: Array, noise: Noise) -> Array:
    """Fisher's, (P, P), of one recording at the vector p, beside that no number lies beyond its term's range."""
    J = rows(s, u, p, 0).jacobian
    per_row = s.step * s.low_pass.factor
    weights = 1 / channel_noise(s, u, p, noise) ** 2
    # of white noise below the cutoff as many rows are independent as twice the cutoff gives
    weights *= 2 * CUTOFF_HZ * per_row
    return np.einsum("c,csp,csq->pq", weights, J, J) + np.diag(1 / (u.high - u.low) ** 2)


def channel_noise(s: Signals, u: Unknowns, p: Array, noise: Noise) -> Array:
    """What passes the filter in each channel, (M + N,), N and N m."""
    values = u.values(p)
    machine = Machine(s.arm, u.laws, values)
    x = s.x + u.get(p, "x0", 0)

    def pull(x: Array, z: Array) -> Array:
        return np.broadcast_to(machine.pull(Stretching(x, s.x_d, s.length, s.arm), z), x.shape)

    z = remembered(machine, Stretching(x, s.x_d, s.length, s.arm), s.step)
    stiffness = (pull(x + _SMALL_M, z) - pull(x, z)) / _SMALL_M
    motor = np.mean(stiffness**2 * np.sum(s.Z**2, axis=1), axis=0) * noise.density * 2 * CUTOFF_HZ
    inertia = mass_matrix(s.arm, s.alpha[s.low_pass.kept])
    arm = np.mean(np.sum(inertia**2, axis=2), axis=0) * noise.acceleration**2
    return np.sqrt(np.concatenate([motor, arm]))


def covariance(matrix: Array) -> Array:
    """Inverse of an information matrix, (P, P), whatever units its parameters have."""
    scale = np.sqrt(np.diag(matrix))
    return np.linalg.inv(matrix / np.outer(scale, scale)) / np.outer(scale, scale)


def predicted(matrix: Array, u: Unknowns, p: Array) -> Array:
    """Standard deviations that the identification will claim, (P,)."""
    of_laws = np.array([e.recording is None for e in u.entries])
    return np.sqrt(np.diag(covariance(matrix)) + (PREPARED * p * of_laws) ** 2)
