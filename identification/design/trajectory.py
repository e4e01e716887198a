"""A motion that an arm can make within limits, and what its motors must do for it.

    joints     Fourier series between two rests in the straight pose
    tensions   t = Z^+ tau + what makes no torque: a level along Z's null space that rises and falls on its own
    motors     theta from elongations under which the cables pull with t (41), f from friction and the rotor (43)

A level may use all of the room that the motion leaves between the limits of tension, so that these hold by construction. A
motion that is too fast is made smaller, and where motors would pull too hard tensions stay lower.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

from identification.design.fourier import FourierShape, fourier_signal
from identification.design.elongations import backward_difference, elongations_for
from mechanism.arm import Arm
from mechanism.cable_lengths import Z, Z_dot, lengths, wrap_angles
from mechanism.dynamics import terms
from mechanism.geometry import check_angles
from mechanism.laws import Turning
from mechanism.machine import Machine
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

_ROUNDS = 60
_NEARER = 0.995
"""made smaller by this beyond what the limit asks for, so that few rounds do"""
_SMALLER, _STILL = 0.8, 1e-3
"""shares of the motion: where it leaves no room for tensions, and of which nothing is left"""
_WITHIN = 1e-3
"""of the range of tension, kept clear at its ends"""
_SIDE = 0.25
"""share of that range for each further direction in which more than N + 1 cables can be tensioned"""


@dataclass(frozen=True)
class MotionLimits:
    """What the arm may do."""

    peak: float
    """of each joint, rad"""
    speed: float
    """of a motor, rad/s"""
    tension: tuple[float, float]
    """least and most, N"""
    force: float = np.inf
    """of a motor, N on the cable"""


@dataclass(frozen=True)
class Trajectory:
    """Rows of even steps; joints N, cables M; SI units and radians."""

    machine: Machine
    time: Array
    """(T,), s"""
    alpha: Array
    """(T, N), with its derivatives"""
    alpha_d: Array
    alpha_dd: Array
    tension: Array
    """(T, M), N"""
    x: Array
    """(T, M), m, under which the cables pull with the tension"""
    x_d: Array
    theta: Array
    """(T, M), with its derivatives"""
    theta_d: Array
    theta_dd: Array
    f: Array
    """(T, M), N"""

    @property
    def arm(self) -> Arm:
        return self.machine.arm

    def reached(self) -> dict[str, float | list[float]]:
        """The largest of everything that is limited."""
        return {
            "alpha_rad": np.abs(self.alpha).max(axis=0).tolist(),
            "motor_speed_rad_s": float(np.abs(self.theta_d).max()),
            "tension_min_N": float(self.tension.min()),
            "tension_max_N": float(self.tension.max()),
            "force_max_N": float(np.abs(self.f).max()),
        }


def tension_levels(arm: Arm) -> Array:
    """Tensions that make no torque in the straight pose, (M, M - N): first all cables', of mean 1, then others across it.

    Raises Refused where cables are no more than joints or cannot all be pulled at once.
    """
    straight = Z(arm, np.zeros(arm.N))
    null = np.linalg.svd(straight)[2][np.linalg.matrix_rank(straight) :].T
    if arm.M <= arm.N or not null.shape[1]:
        raise Refused("design", f"{arm.M} cables cannot be tensioned against {arm.N} joints", "it takes more cables")
    m, q = null.shape
    # the combination whose least tension is largest, all of them between 0 and 1
    best = linprog(
        np.append(np.zeros(q), -1.0),
        A_ub=np.block([[-null, np.ones((m, 1))], [null, np.zeros((m, 1))]]),
        b_ub=np.concatenate([np.zeros(m), np.ones(m)]),
        bounds=[(None, None)] * (q + 1),
    )
    if not best.success or best.x[-1] < 1e-6:
        raise Refused("design", "no tensions of all cables balance in the straight pose", "check the routes")
    first = null @ best.x[:-1]
    # what is left of the null space across the first, by QR
    across = null @ np.linalg.svd((null.T @ first)[None])[2][1:].T
    return np.column_stack([first / first.mean(), across])


def trajectory(machine: Machine, shape: FourierShape, limits: MotionLimits, seconds: float, rate_hz: float) -> Trajectory:
    """The shape's motion as large as the limits and its own reach allow.

    Raises Refused where even a small motion breaks them.
    """
    arm = machine.arm
    time = np.arange(round(seconds * rate_hz) + 1) / rate_hz
    directions = tension_levels(arm)
    signal = fourier_signal(shape, time)
    check_angles(arm, np.full((1, arm.N), limits.peak), "design --peak-deg")
    joints, fade, (low, high) = slice(0, arm.N), 1.0, limits.tension
    for _ in range(_ROUNDS):
        if fade < _STILL or high <= low:
            break
        size = fade * limits.peak * shape.reach[joints]
        alpha, alpha_d, alpha_dd = (size * part[:, joints] for part in (signal.value, signal.d1, signal.d2))
        swing = fade * shape.reach[arm.N :] * signal.value[:, arm.N :]
        tension = _tension(machine, alpha, alpha_d, alpha_dd, swing, directions, (low, high))
        if tension is None:
            fade *= _SMALLER
            continue
        made = _made(machine, time, alpha, alpha_d, alpha_dd, tension)
        fast = np.abs(made.theta_d).max() / limits.speed
        beyond = np.abs(made.f).max() - limits.force
        if fast <= 1 and beyond <= 0:
            return made
        if fast > 1:
            fade *= max(_NEARER / fast, 0.3)
        if beyond > 0:
            high -= beyond / _NEARER
    raise Refused(
        "design",
        f"no motion keeps tensions of {limits.tension[0]:g} to {limits.tension[1]:g} N, motors below {limits.speed:g} rad/s "
        f"and {limits.force:g} N",
        "widen --tension, --max-speed or --max-force",
    )


def _tension(
    machine: Machine,
    alpha: Array,
    alpha_d: Array,
    alpha_dd: Array,
    swing: Array,
    directions: Array,
    within: tuple[float, float],
) -> Array | None:
    """Tensions (T, M) that make the motion, between the limits; None where the motion leaves no room for them.

    swing (T, M - N), -1..1: of each direction.
    """
    arm = machine.arm
    k = terms(arm, alpha, alpha_d)
    torque = np.einsum("tij,tj->ti", k.M, alpha_dd) + k.c + k.g + machine.resistance(alpha_d)
    jacobian = Z(arm, alpha)
    inverse = np.linalg.pinv(jacobian)  # (T, M, N)
    wide = within[1] - within[0]
    low, high = within[0] + _WITHIN * wide, within[1] - _WITHIN * wide
    still = directions - np.einsum("tmn,tnk,kq->tmq", inverse, jacobian, directions)  # (T, M, M - N)
    side = _SIDE * wide * swing[:, 1:] / np.abs(directions[:, 1:]).max(axis=0, initial=1e-300)
    needed = np.einsum("tmn,tn->tm", inverse, torque) + np.einsum("tmq,tq->tm", still[..., 1:], side)
    up = still[..., 0]
    if up.min() <= 0:
        return None
    least, most = ((low - needed) / up).max(), ((high - needed) / up).min()
    if least >= most:
        return None
    level = (least + most) / 2 + (most - least) / 2 * swing[:, :1]
    return needed + level * up


def _made(machine: Machine, time: Array, alpha: Array, alpha_d: Array, alpha_dd: Array, tension: Array) -> Trajectory:
    """What motors do for angles and tensions."""
    arm, step = machine.arm, float(time[1] - time[0])
    length, jacobian = lengths(arm, alpha), Z(arm, alpha)
    x, x_d = elongations_for(machine, tension, length, step)
    theta = (x - arm.x0 - length + lengths(arm, np.zeros(arm.N))) / arm.drum
    theta_d = (x_d + np.einsum("tij,ti->tj", jacobian, alpha_d)) / arm.drum
    turning = np.einsum("tij,ti->tj", jacobian, alpha_dd) + np.einsum("tij,ti->tj", Z_dot(arm, alpha, alpha_d), alpha_d)
    theta_dd = (backward_difference(x_d, step) + turning) / arm.drum
    friction = machine.friction(Turning(theta_d, tension, wrap_angles(arm, alpha)))
    f = tension + friction + arm.motor_inertia / arm.drum * theta_dd
    return Trajectory(machine, time, alpha, alpha_d, alpha_dd, tension, x, x_d, theta, theta_d, theta_dd, f)
