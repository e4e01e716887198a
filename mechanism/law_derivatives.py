"""Derivatives of a machine's laws by forward differences: each law acts on its own cable, motor or joint alone."""

from dataclasses import dataclass

import numpy as np

from mechanism.arm import Array
from mechanism.laws import Stretching, Turning
from mechanism.machine import Machine

STEP_M, STEP_M_S, STEP_MOTOR_RAD_S, STEP_N, STEP_JOINT_RAD_S, STEP_MEMORY = 1e-7, 1e-6, 1e-5, 1e-4, 1e-6, 1e-6
"""steps of the differences: far below what laws change on, far above rounding"""


@dataclass(frozen=True)
class LawDerivatives:
    """Derivatives at one state of a batch, each (M, B), N, m and s.

    `resist_by_speed` is (N, B); what is taken by a memory variable, or is a memory's rate, is (M, B, states). `pull` is the tension
    of a cable, `rub` the motor's friction, `drift` the rate of the memory.
    """

    pull_by_x: Array
    pull_by_x_d: Array
    pull_by_memory: Array
    rub_by_speed: Array
    rub_by_tension: Array
    resist_by_speed: Array
    drift_by_x: Array
    drift_by_x_d: Array
    drift_by_memory: Array


def law_derivatives(
    machine: Machine, at: Stretching, z: Array, theta_d: Array, wrap: Array, alpha_d: Array
) -> LawDerivatives:
    """Derivatives at a state in batch layout. A slack cable's are zero; memories of one cable do not drive each other."""

    def pull(x: Array, x_d: Array, z: Array) -> Array:
        return machine.pull(Stretching(x, x_d, at.length, at.arm, at.travel_d), z)

    def drift(x: Array, x_d: Array, z: Array) -> Array:
        return machine.drift(Stretching(x, x_d, at.length, at.arm, at.travel_d), z)

    def rub(theta_d: Array, t: Array) -> Array:
        return machine.friction(Turning(theta_d, t, wrap))

    x, x_d = at.x, at.x_d
    pull_0 = pull(x, x_d, z)
    taut = pull_0 > 0
    t = pull_0 * taut
    rub_0 = rub(theta_d, t)
    pull_by_memory = drift_by_memory = drift_by_x = drift_by_x_d = np.zeros(z.shape)
    if machine.states:
        by_each = [
            taut * (pull(x, x_d, z + STEP_MEMORY * unit) - pull_0) / STEP_MEMORY for unit in np.eye(machine.states)
        ]
        drift_0 = drift(x, x_d, z)
        pull_by_memory = np.stack(by_each, axis=-1)
        drift_by_memory = (drift(x, x_d, z + STEP_MEMORY) - drift_0) / STEP_MEMORY
        drift_by_x = (drift(x + STEP_M, x_d, z) - drift_0) / STEP_M
        drift_by_x_d = (drift(x, x_d + STEP_M_S, z) - drift_0) / STEP_M_S
    resist_by_speed = (machine.resistance(alpha_d + STEP_JOINT_RAD_S) - machine.resistance(alpha_d)) / STEP_JOINT_RAD_S
    return LawDerivatives(
        pull_by_x=taut * (pull(x + STEP_M, x_d, z) - pull_0) / STEP_M,
        pull_by_x_d=taut * (pull(x, x_d + STEP_M_S, z) - pull_0) / STEP_M_S,
        pull_by_memory=pull_by_memory,
        rub_by_speed=(rub(theta_d + STEP_MOTOR_RAD_S, t) - rub_0) / STEP_MOTOR_RAD_S,
        rub_by_tension=(rub(theta_d, t + STEP_N) - rub_0) / STEP_N,
        resist_by_speed=np.broadcast_to(resist_by_speed, alpha_d.shape),
        drift_by_x=drift_by_x,
        drift_by_x_d=drift_by_x_d,
        drift_by_memory=drift_by_memory,
    )
