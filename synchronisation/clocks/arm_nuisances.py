"""What may be wrong of the arm in the clock's equation of it: torques by each part's error, and how far each may be off.

They are nuisances of the arm's equation: nobody looks at their values.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mechanism.arm import Arm
from mechanism.drawing_errors import (
    MAX_DRAWING_ERROR,
    MOTOR_INERTIA_SIGMA,
    SPRING_LENGTH_SIGMA,
    SPRING_STIFFNESS_SIGMA,
)
from mechanism.dynamics import gravity_and_springs, terms
from mechanism.laws.pulley_friction import SLIDING_M_S
from synchronisation.clocks.frame_geometry import GEOMETRY_STEP

Array = NDArray[np.float64]

PAYLOAD_SIGMA = 3.0
"""relative standard deviation of the last top bar's mass and inertia: what hangs there is not in neck.yaml (docs/thresholds.md)"""
TILT_SIGMA_RAD = 0.05
"""rad: standard deviation of the base's tilt against gravity (docs/thresholds.md)"""
GAIN_SIGMA = 0.1
"""relative standard deviation of the force by which a motor answers to its command (docs/thresholds.md)"""
LOSS_SIGMA = 0.1
"""standard deviation of the share of its tension that a cable loses on the pulleys before one mechanism's span
(docs/thresholds.md)"""
_MASS_FIELDS = (("top_mass", "top_inertia"), ("diagonal_mass", "diagonal_inertia"))


def torque(arm: Arm, a: Array, a_d: Array, a_dd: Array) -> Array:
    """M alpha'' + c + g, (T, N), N m."""
    dynamics = terms(arm, a, a_d)
    return np.einsum("tij,tj->ti", dynamics.M, a_dd) + dynamics.c + dynamics.g


def parts(arm: Arm) -> list[Arm]:
    """The arm as a sum of 4 N arms that have one mechanism's top bar, diagonals or springs of one side each."""
    bars = [name for fields in _MASS_FIELDS for name in fields]
    nothing = {name: np.zeros_like(getattr(arm, name)) for name in (*bars, "spring_stiffness")}
    of_bars = [
        replace(arm, **nothing | {name: np.where(np.arange(arm.N) == i, getattr(arm, name), 0.0) for name in fields})
        for fields in _MASS_FIELDS
        for i in range(arm.N)
    ]
    of_springs = [
        replace(arm, **nothing | {"spring_stiffness": arm.spring_stiffness * one}) for one in _each_spring(arm)
    ]
    return of_bars + of_springs


def torque_by_free_length(arm: Arm, a: Array) -> Array:
    """Slope of the torque by the relative error of each spring's free length, (T, N, 2 N), N m."""
    described = gravity_and_springs(arm, a)
    others = [
        replace(arm, spring_free_length=arm.spring_free_length * (1 + GEOMETRY_STEP * one)) for one in _each_spring(arm)
    ]
    return np.stack([gravity_and_springs(other, a) - described for other in others], axis=-1) / GEOMETRY_STEP


def _each_spring(arm: Arm) -> Array:
    """One for one side's springs of one mechanism, (2 N, 2, N), and zero for all others."""
    return np.eye(2 * arm.N).reshape(-1, 2, arm.N)


def tilt_torque(arm: Arm, a: Array) -> Array:
    """Torque of gravity by the tilt of the base, (T, N), N m/rad."""
    across = np.stack([-arm.gravity[..., 1], arm.gravity[..., 0]], axis=-1)
    without_springs = replace(arm, gravity=across, spring_stiffness=np.zeros_like(arm.spring_stiffness))
    return terms(without_springs, a, np.zeros_like(a)).g


def pulley_losses(arm: Arm, jacobian: Array, force: Array, joint_speed: Array) -> Array:
    """Torque that each cable loses where the pulleys before each of its spans hold all of it, (T, N, spans), N m.

    The ratio is lost at that span and at those behind it, by the way in which the cable slides over the pulleys."""
    gives = np.einsum("tnm,tn->tnm", jacobian, joint_speed)
    columns = []
    for j, route in enumerate(arm.routes):
        for i in range(len(route)):
            sliding = gives[:, i:, j].sum(axis=1)
            lost = jacobian[:, :, j] * (force[:, j] * sliding / np.hypot(sliding, SLIDING_M_S))[:, None]
            lost[:, :i] = 0.0
            columns.append(lost)
    return np.stack(columns, axis=-1)


def joint_dry_friction(speed: Array, width: float) -> Array:
    """Dry friction of 1 N m of each joint, then its slopes by log(1 / width), (T, N, 2 N), for joint speeds (T, N), rad/s."""
    relative, per_joint = speed / width, np.eye(speed.shape[1])
    turnover = relative / (1 + relative**2)
    return 2 / np.pi * np.concatenate([v[..., None] * per_joint for v in (np.arctan(relative), turnover)], axis=-1)


def nuisance_priors(arm: Arm) -> tuple[Array, NDArray[np.bool_]]:
    """Standard deviations of the nuisances, (Q,), in the order of `ArmRows.by_nuisance`, and which are of lossy arms alone."""
    of_parts = [*(MAX_DRAWING_ERROR,) * len(_MASS_FIELDS), *(SPRING_STIFFNESS_SIGMA,) * 2, *(SPRING_LENGTH_SIGMA,) * 2]
    parts = np.repeat(of_parts, arm.N)
    parts[arm.N - 1] = PAYLOAD_SIGMA
    friction = np.full(4 * arm.N, np.inf)
    gains, losses = np.full(arm.M, GAIN_SIGMA), np.full(sum(map(len, arm.routes)), LOSS_SIGMA)
    sigma = [parts, np.array([TILT_SIGMA_RAD]), np.full(arm.M, MOTOR_INERTIA_SIGMA), gains, losses, friction]
    of_lossy = [np.full(len(values), values is gains or values is losses) for values in sigma]
    return np.concatenate(sigma), np.concatenate(of_lossy)
