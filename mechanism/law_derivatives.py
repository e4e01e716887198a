"""Derivatives of a machine's laws by forward differences: each law acts on its own cable, motor or joint alone."""

from dataclasses import dataclass, replace

import numpy as np

from mechanism.arm import Array
from mechanism.cable_lengths import CableGeometry
from mechanism.laws import CableMotion, JointMotion, MotorMotion
from mechanism.machine import Machine

STEP_M, STEP_M_S, STEP_MOTOR_RAD_S, STEP_N, STEP_JOINT_RAD_S, STEP_MEMORY = 1e-7, 1e-6, 1e-5, 1e-4, 1e-6, 1e-6
"""steps of the differences: far below what laws change on, far above rounding"""
CHORD_RAD_S = 0.2
"""rad/s: half of the chord by which what cables lose is softened, about what it takes from a joint's speed in a step"""


@dataclass(frozen=True)
class LawDerivatives:
    """Derivatives at one state of a batch, each (M, B), N, m and s.

    `resistance_by_speed` is (N, B); derivatives by or of memory variables are (M, B, states). `pull` is the tension
    of a cable, `friction` the motor's, `memory_rate` the rate of the memory variables, `resistance` the joints' friction.
    """

    pull_by_x: Array
    pull_by_x_d: Array
    pull_by_memory: Array
    friction_by_speed: Array
    friction_by_tension: Array
    friction_by_memory: Array
    """of laws that remember the path, as is the next"""
    memory_rate_by_speed: Array
    """by the motor's"""
    resistance_by_speed: Array
    memory_rate_by_x: Array
    memory_rate_by_x_d: Array
    memory_rate_by_memory: Array


def law_derivatives(
    machine: Machine, at: CableMotion, z: Array, motors: MotorMotion, joints: JointMotion
) -> LawDerivatives:
    """Derivatives at a state in batch layout. A slack cable's are zero; memories of one cable do not drive each other.

    What `motors` says of the tension is not used: it follows from the cables."""

    def pull(x: Array, x_d: Array, z: Array) -> Array:
        return machine.pull(replace(at, x=x, x_d=x_d), z)

    def memory_rate(x: Array, x_d: Array, z: Array) -> Array:
        return machine.memory_rate(replace(at, x=x, x_d=x_d), z)

    def friction(theta_d: Array, t: Array, z: Array) -> Array:
        return machine.friction(replace(motors, theta_d=theta_d, tension=t, memory=z))

    x, x_d, theta_d = at.x, at.x_d, motors.theta_d
    pull_0 = pull(x, x_d, z)
    taut = pull_0 > 0
    t = pull_0 * taut
    friction_0 = friction(theta_d, t, z)
    pull_by_memory = memory_rate_by_memory = memory_rate_by_x = memory_rate_by_x_d = np.zeros(z.shape)
    friction_by_memory = memory_rate_by_speed = np.zeros(z.shape)
    if machine.states:
        by_each = [
            taut * (pull(x, x_d, z + STEP_MEMORY * unit) - pull_0) / STEP_MEMORY for unit in np.eye(machine.states)
        ]
        memory_rate_0 = memory_rate(x, x_d, z)
        pull_by_memory = np.stack(by_each, axis=-1)
        memory_rate_by_memory = (memory_rate(x, x_d, z + STEP_MEMORY) - memory_rate_0) / STEP_MEMORY
        memory_rate_by_x = (memory_rate(x + STEP_M, x_d, z) - memory_rate_0) / STEP_M
        memory_rate_by_x_d = (memory_rate(x, x_d + STEP_M_S, z) - memory_rate_0) / STEP_M_S
    if machine.remembers_path:
        by_each = [(friction(theta_d, t, z + STEP_MEMORY * unit) - friction_0) for unit in np.eye(machine.states)]
        friction_by_memory = np.stack(np.broadcast_arrays(*by_each), axis=-1) / STEP_MEMORY
        faster_drums = replace(at, travel_d=at.travel_d + STEP_MOTOR_RAD_S * machine.arm.drum)
        by_speed = (machine.memory_rate(faster_drums, z) - machine.memory_rate(at, z)) / STEP_MOTOR_RAD_S
        memory_rate_by_speed = np.where(friction_by_memory != 0, by_speed, 0.0)
    faster = replace(joints, alpha_d=joints.alpha_d + STEP_JOINT_RAD_S)
    resistance_by_speed = (machine.resistance(faster) - machine.resistance(joints)) / STEP_JOINT_RAD_S
    return LawDerivatives(
        pull_by_x=taut * (pull(x + STEP_M, x_d, z) - pull_0) / STEP_M,
        pull_by_x_d=taut * (pull(x, x_d + STEP_M_S, z) - pull_0) / STEP_M_S,
        pull_by_memory=pull_by_memory,
        friction_by_speed=(friction(theta_d + STEP_MOTOR_RAD_S, t, z) - friction_0) / STEP_MOTOR_RAD_S,
        friction_by_tension=(friction(theta_d, t + STEP_N, z) - friction_0) / STEP_N,
        friction_by_memory=friction_by_memory,
        memory_rate_by_speed=memory_rate_by_speed,
        resistance_by_speed=np.broadcast_to(resistance_by_speed, joints.alpha_d.shape),
        memory_rate_by_x=memory_rate_by_x,
        memory_rate_by_x_d=memory_rate_by_x_d,
        memory_rate_by_memory=memory_rate_by_memory,
    )


@dataclass(frozen=True)
class Losses:
    """What cables lose on their way along the arm, at one state of a batch."""

    arriving: Array
    """share of a cable's tension that is left at each mechanism, (N, M, B)"""
    torque_by_speed: Array
    """change of the torque that is lost by the joints' speeds, (N, N, B), N m s/rad: the slope and a chord's together

    A joint that friction brings to rest within a step does not know it by the slope where it begins, and would turn back."""


def losses_at(machine: Machine, cables: CableGeometry, t: Array, alpha_d: Array) -> Losses:
    """At tensions t (M, B), N, and joint speeds (N, B), rad/s."""
    N = len(alpha_d)
    steps = np.array([STEP_JOINT_RAD_S, CHORD_RAD_S])
    # all joints, widths and signs at once: a step of a simulation asks for them each time
    speeds = alpha_d[:, None] + np.multiply.outer(np.eye(N), np.outer(steps, [-1.0, 1.0])).reshape(N, -1, 1)
    Z, wraps = cables.Z[:, None], cables.wraps[:, None]
    lost = np.sum(Z * t * -np.expm1(-machine.losses(Z, speeds[:, :, None], wraps)), axis=2)
    low, high = np.moveaxis(lost.reshape(N, N, len(steps), 2, -1), 3, 0)
    slopes = (high - low) / (2 * steps[:, None])
    arriving = np.exp(-machine.losses(cables.Z, alpha_d[:, None], cables.wraps))
    return Losses(arriving, np.sum(slopes, axis=2))
