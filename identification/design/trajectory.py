"""A motion that an arm can make within limits, with the motor angles and forces that make it.

    joints     Fourier series between two rests in the straight pose
    tensions   t = Z^+ tau + a level in the null space of Z, which makes no torque and varies on its own
    motors     theta from the elongations under which the cables have the tensions t (41), f by (43)

A level may use all of the room that the motion leaves between the limits of tension, so that these hold by construction. A
motion that is too fast is made smaller, and where motors would pull too hard tensions stay lower.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

from identification.design.elongations import backward_difference, elongations_for
from identification.design.fourier import FourierShape, fourier_signal
from mechanism.arm import Arm
from mechanism.cable_lengths import Z, Z_dot, geometry_of_poses, lengths, wrap_angles
from mechanism.dynamics import terms
from mechanism.geometry import check_angles
from mechanism.laws import JointMotion, MotorMotion
from mechanism.machine import Machine
from xneck_foundation.errors import Refused
from xneck_foundation.one_line import counted

Array = NDArray[np.float64]

_MAX_ITERATIONS = 60
_MARGIN = 0.995
"""factor by which a motion is scaled beyond what the limit needs, so that few iterations do"""
_NO_ROOM_FACTOR, _MIN_SCALE = 0.8, 1e-3
"""factor of the motion where it leaves no room for tensions, and scale at which the search gives up"""
_CLEARANCE = 1e-3
"""share of the range of tension that is kept clear at both ends"""
_FURTHER_LEVEL_SHARE = 0.25
"""share of that range for each further level, where there are more than N + 1 cables"""


@dataclass(frozen=True)
class MotionLimits:
    """What the arm may do."""

    peak: float
    """largest angle of each joint, rad"""
    speed: float
    """largest speed of a motor, rad/s"""
    tension: tuple[float, float]
    """lowest and highest of a cable, N"""
    force: float = np.inf
    """largest force of a motor, N on its cable"""


USUAL_LIMITS = MotionLimits(float(np.radians(30.0)), 300.0, (20.0, 112.0))
"""those of an arm like Fasquelle's, unless others are given"""


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
    """elongations under which the cables have the tension, (T, M), m"""
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
        """Largest values of the limited quantities, by name."""
        return {
            "alpha_rad": np.abs(self.alpha).max(axis=0).tolist(),
            "motor_speed_rad_s": float(np.abs(self.theta_d).max()),
            "tension_min_N": float(self.tension.min()),
            "tension_max_N": float(self.tension.max()),
            "force_max_N": float(np.abs(self.f).max()),
        }


def tension_levels(arm: Arm) -> Array:
    """Tensions without torque in the straight pose, (M, M - N): the first is positive in all cables, of mean 1.

    Raises Refused where there are not more cables than joints, or no such tensions of all cables.
    """
    straight = Z(arm, np.zeros(arm.N))
    null = np.linalg.svd(straight)[2][np.linalg.matrix_rank(straight) :].T
    if arm.M <= arm.N or not null.shape[1]:
        raise Refused(
            "design",
            f"{counted(arm.M, 'cable')} cannot be tensioned against {counted(arm.N, 'joint')}",
            "it takes more cables",
        )
    m, q = null.shape
    # the combination whose lowest tension is largest, all of them between 0 and 1
    best = linprog(
        np.append(np.zeros(q), -1.0),
        A_ub=np.block([[-null, np.ones((m, 1))], [null, np.zeros((m, 1))]]),
        b_ub=np.concatenate([np.zeros(m), np.ones(m)]),
        bounds=[(None, None)] * (q + 1),
    )
    if not best.success or best.x[-1] < 1e-6:
        raise Refused("design", "no tensions of all cables balance in the straight pose", "check the routes")
    first = null @ best.x[:-1]
    # an orthonormal complement of the first within the null space
    across = null @ np.linalg.svd((null.T @ first)[None])[2][1:].T
    return np.column_stack([first / first.mean(), across])


def trajectory(
    machine: Machine, shape: FourierShape, limits: MotionLimits, seconds: float, rate_hz: float
) -> Trajectory:
    """The motion of a shape, as large as the limits and the shape's reach allow.

    Raises Refused where even a small motion breaks them.
    """
    arm = machine.arm
    time = np.arange(round(seconds * rate_hz) + 1) / rate_hz
    directions = tension_levels(arm)
    signal = fourier_signal(shape, time)
    check_angles(arm, np.full((1, arm.N), limits.peak), "design --peak-deg")
    joints, scale, (low, high) = slice(0, arm.N), 1.0, limits.tension
    for _ in range(_MAX_ITERATIONS):
        if scale < _MIN_SCALE or high <= low:
            break
        size = scale * limits.peak * shape.reach[joints]
        alpha, alpha_d, alpha_dd = (size * part[:, joints] for part in (signal.value, signal.d1, signal.d2))
        swing = scale * shape.reach[arm.N :] * signal.value[:, arm.N :]
        tension = _tension(machine, alpha, alpha_d, alpha_dd, swing, directions, (low, high))
        if tension is None:
            scale *= _NO_ROOM_FACTOR
            continue
        motion = _with_motors(machine, time, alpha, alpha_d, alpha_dd, tension)
        speed_ratio = np.abs(motion.theta_d).max() / limits.speed
        excess_force = np.abs(motion.f).max() - limits.force
        if speed_ratio <= 1 and excess_force <= 0:
            return motion
        if speed_ratio > 1:
            scale *= max(_MARGIN / speed_ratio, 0.3)
        if excess_force > 0:
            high -= excess_force / _MARGIN
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
    tension_range: tuple[float, float],
) -> Array | None:
    """Tensions (T, M), N, that make the motion within the range; None where the motion leaves no room for them.

    swing (T, M - N), -1..1: course of each level; directions (M, M - N): the levels in the straight pose.
    """
    arm = machine.arm
    k = terms(arm, alpha, alpha_d)
    torque = np.einsum("tij,tj->ti", k.M, alpha_dd) + k.c + k.g + machine.resistance(JointMotion(alpha, alpha_d))
    cables = geometry_of_poses(arm, alpha)
    jacobian = machine.arriving(cables.Z, alpha_d, cables.wraps)
    inverse = np.linalg.pinv(jacobian)  # (T, M, N)
    width = tension_range[1] - tension_range[0]
    low, high = tension_range[0] + _CLEARANCE * width, tension_range[1] - _CLEARANCE * width
    null = directions - np.einsum("tmn,tnk,kq->tmq", inverse, jacobian, directions)  # (T, M, M - N)
    further = _FURTHER_LEVEL_SHARE * width * swing[:, 1:] / np.abs(directions[:, 1:]).max(axis=0, initial=1e-300)
    needed = np.einsum("tmn,tn->tm", inverse, torque) + np.einsum("tmq,tq->tm", null[..., 1:], further)
    first = null[..., 0]
    if first.min() <= 0:
        return None
    lowest, highest = ((low - needed) / first).max(), ((high - needed) / first).min()
    if lowest >= highest:
        return None
    level = (lowest + highest) / 2 + (highest - lowest) / 2 * swing[:, :1]
    return needed + level * first


def _with_motors(
    machine: Machine, time: Array, alpha: Array, alpha_d: Array, alpha_dd: Array, tension: Array
) -> Trajectory:
    """The trajectory of given angles and tensions, with the motors' angles and forces."""
    arm, step = machine.arm, float(time[1] - time[0])
    length, jacobian = lengths(arm, alpha), Z(arm, alpha)
    x, x_d = elongations_for(machine, tension, length, step)
    theta = (x - arm.x0 - length + lengths(arm, np.zeros(arm.N))) / arm.drum
    theta_d = (x_d + np.einsum("tij,ti->tj", jacobian, alpha_d)) / arm.drum
    winding = np.einsum("tij,ti->tj", jacobian, alpha_dd) + np.einsum("tij,ti->tj", Z_dot(arm, alpha, alpha_d), alpha_d)
    theta_dd = (backward_difference(x_d, step) + winding) / arm.drum
    memory = machine.memory_about_rows(theta)
    friction = machine.friction(MotorMotion(theta_d, tension, wrap_angles(arm, alpha), memory=memory))
    f = tension + friction + arm.motor_inertia / arm.drum * theta_dd
    return Trajectory(
        machine=machine,
        time=time,
        alpha=alpha,
        alpha_d=alpha_d,
        alpha_dd=alpha_dd,
        tension=tension,
        x=x,
        x_d=x_d,
        theta=theta,
        theta_d=theta_d,
        theta_dd=theta_dd,
        f=f,
    )
