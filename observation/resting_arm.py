"""The arm at rest in many poses: its cables, what is missing to hold it there, and how far it gives way."""

import numpy as np
from numpy.typing import NDArray

from mechanism.cable_lengths import geometry_of_poses, lengths
from mechanism.dynamics import gravity_and_springs
from mechanism.laws import CableMotion
from mechanism.machine import Machine

Array = NDArray[np.float64]

_DIFFERENCE_RAD = 1e-5
"""rad, of derivatives by the angles"""


def cables_at_rest(machine: Machine, alpha: Array, theta: Array) -> tuple[CableMotion, Array]:
    """Motion of the cables, (poses, M), and Z (poses, N, M)."""
    arm, g = machine.arm, geometry_of_poses(machine.arm, alpha)
    x = g.length - lengths(arm, np.zeros(arm.N)) + arm.drum * theta + arm.x0
    still = np.zeros_like(x)
    return CableMotion(
        x=x,
        x_d=still,
        length=g.length,
        arm=arm,
        travel_d=still,
        drum_angle=theta / arm.gear,
        theta=theta,
        time=np.zeros(()),
    ), g.Z


def pull_at_rest(machine: Machine, at: CableMotion) -> Array:
    """Tensions of the cables as if they could push, (poses, M), N."""
    # of a cable at rest memory fades: creep has ended, strands stand anywhere
    return np.broadcast_to(machine.pull(at, np.zeros((*at.x.shape, machine.states))), at.x.shape)


def missing_torque(machine: Machine, alpha: Array, theta: Array) -> tuple[Array, Array]:
    """What is missing to hold each pose, (poses, N), N m, and the mean tension there, (poses,), N."""
    at, Z = cables_at_rest(machine, alpha, theta)
    t = np.maximum(pull_at_rest(machine, at), 0.0)
    return np.einsum("pij,pj->pi", Z, t) - gravity_and_springs(machine.arm, alpha), t.mean(axis=1)


def compliance(machine: Machine, alpha: Array, theta: Array) -> Array:
    """By how much each angle gives way to torques, (poses, N, N), rad/(N m)."""
    columns = []
    for i in range(machine.arm.N):
        step = _DIFFERENCE_RAD * np.eye(machine.arm.N)[i]
        change = missing_torque(machine, alpha + step, theta)[0] - missing_torque(machine, alpha - step, theta)[0]
        columns.append(change / (2 * _DIFFERENCE_RAD))
    return -np.linalg.pinv(np.stack(columns, axis=-1))
