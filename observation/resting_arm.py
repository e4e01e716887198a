"""The arm where its motors are held: its cables, what is missing to hold it in a pose, and how far it gives way.

It rests, or it goes through the pose without being accelerated."""

import numpy as np
from numpy.typing import NDArray

from mechanism.cable_lengths import PoseGeometry, geometry_of_poses, lengths
from mechanism.dynamics import gravity_and_springs
from mechanism.laws import CableMotion, JointMotion
from mechanism.machine import Machine

Array = NDArray[np.float64]

_DIFFERENCE_RAD = 1e-5
"""rad, of derivatives by the angles"""


def cables_at_rest(machine: Machine, alpha: Array, theta: Array) -> CableMotion:
    """Motion of the cables, (poses, M)."""
    return _cables(machine, geometry_of_poses(machine.arm, alpha), theta, np.zeros_like(alpha), np.zeros_like(theta))


def _cables(machine: Machine, g: PoseGeometry, theta: Array, alpha_d: Array, x_d: Array) -> CableMotion:
    arm = machine.arm
    return CableMotion(
        x=g.length - lengths(arm, np.zeros(arm.N)) + arm.drum * theta + arm.x0,
        x_d=x_d,
        length=g.length,
        arm=arm,
        travel_d=x_d + np.einsum("pij,pi->pj", g.Z, alpha_d),
        drum_angle=theta / arm.gear,
        theta=theta,
        time=np.zeros(()),
    )


def pull_at_rest(machine: Machine, at: CableMotion) -> Array:
    """Tensions of the cables as if they could push, (poses, M), N."""
    return np.broadcast_to(machine.pull(at, machine.memory_in_motion(at)), at.x.shape)


def sides_in_motion(machine: Machine, alpha: Array, theta: Array, alpha_d: Array, x_d: Array) -> Array:
    """Where drums lie within their play, (poses, M), or (poses, 0) where they have none; arguments as of `missing_torque`."""
    if machine.play_place is None:
        return np.empty((len(alpha), 0))
    at = _cables(machine, geometry_of_poses(machine.arm, alpha), theta, alpha_d, x_d)
    return machine.memory_in_motion(at)[..., machine.play_place]


def missing_torque(
    machine: Machine, alpha: Array, theta: Array, alpha_d: Array | None = None, x_d: Array | None = None
) -> tuple[Array, Array]:
    """What is missing to hold each pose, (poses, N), N m, and the mean tension there, (poses,), N.

    alpha_d (poses, N), rad/s, and x_d (poses, M), m/s: speeds of joints and rates of elongation, zero unless given.
    """
    speed = np.zeros_like(alpha) if alpha_d is None else alpha_d
    g = geometry_of_poses(machine.arm, alpha)
    at = _cables(machine, g, theta, speed, np.zeros_like(theta) if x_d is None else x_d)
    t = np.maximum(pull_at_rest(machine, at), 0.0)
    pulled = np.einsum("pij,pj->pi", machine.arriving(g.Z, speed, g.wraps), t)
    resisted = gravity_and_springs(machine.arm, alpha) + machine.resistance(JointMotion(alpha, speed))
    return pulled - resisted, t.mean(axis=1)


def compliance(machine: Machine, alpha: Array, theta: Array) -> Array:
    """By how much each angle gives way to torques, (poses, N, N), rad/(N m)."""
    columns = []
    for i in range(machine.arm.N):
        step = _DIFFERENCE_RAD * np.eye(machine.arm.N)[i]
        change = missing_torque(machine, alpha + step, theta)[0] - missing_torque(machine, alpha - step, theta)[0]
        columns.append(change / (2 * _DIFFERENCE_RAD))
    return -np.linalg.pinv(np.stack(columns, axis=-1))
