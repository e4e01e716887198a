"""Whether a load hangs on the arm's tip that the model does not have.

A load lowers the arm on its cables and must be accelerated with it, and tensions change with the pose and its motion in a way that
is known in advance. Motor forces that the laws do not model are fitted by it, beside a constant and a part along each motor's
direction, over stretches of the log, in rows in which the motor turns. Blocks of a second tell the standard deviation.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mechanism.arm import Arm
from mechanism.dynamics import terms
from mechanism.friction import dry
from mechanism.machine import Machine
from observation.resting_arm import cables_at_rest, compliance, pull_at_rest
from observation.turning_rows import turning_rows

Array = NDArray[np.float64]

LOAD_STRETCH_S = 16.0
"""s of the log in which a load is looked for (docs/thresholds.md)"""
MIN_LOAD_SIGMAS = 4.0
"""sigmas by which a load must differ from none (docs/thresholds.md)"""
MIN_LOAD_KG = 0.03
"""kg: a lighter load is not spoken of; a law that was not quite right looks like it (docs/thresholds.md)"""
_BLOCK_S = 1.0
"""s: blocks whose errors are independent, nearly"""
_SMALL_KG = 1e-3
"""kg, of the differences"""


@dataclass(frozen=True)
class FoundLoad:
    """The load in one stretch of the log."""

    time: float
    """s, where the stretch begins"""
    mass: float
    """kg, on the last bar; below zero where the arm became lighter"""
    sigma: float
    """kg"""


@dataclass(frozen=True)
class JointRows:
    """The joints in T rows that are evenly spaced."""

    time: Array
    """(T,), s"""
    alpha: Array
    """(T, N), rad"""
    alpha_d: Array
    alpha_dd: Array

    def part(self, rows: slice) -> "JointRows":
        """Some of the rows."""
        return JointRows(self.time[rows], self.alpha[rows], self.alpha_d[rows], self.alpha_dd[rows])


def forces_of_load(machine: Machine, joints: JointRows, theta: Array) -> Array:
    """Change of the cables' tensions by a kilogram on the last bar, (T, M), N, with the motors held at angles (T, M), rad."""
    arm, alpha = machine.arm, joints.alpha
    heavier = replace(arm, top_mass=arm.top_mass + np.eye(arm.N)[-1])
    torque = _needed(heavier, joints) - _needed(arm, joints)
    lowered = -_SMALL_KG * np.einsum("tij,tj->ti", compliance(machine, alpha, theta), torque)
    before, after = (pull_at_rest(machine, cables_at_rest(machine, a, theta)) for a in (alpha, alpha + lowered))
    return (np.maximum(after, 0.0) - np.maximum(before, 0.0)) / _SMALL_KG


def _needed(arm: Arm, joints: JointRows) -> Array:
    """Torques that the arm's masses and springs need for its motion, (T, N), N m."""
    k = terms(arm, joints.alpha, joints.alpha_d)
    return np.einsum("tij,tj->ti", k.M, joints.alpha_dd) + k.c + k.g


def find_loads(
    machine: Machine, joints: JointRows, theta: Array, theta_d: Array, error: Array, sigma: Array
) -> list[FoundLoad]:
    """Stretches in which a load shows, of T rows. theta, theta_d: of the motors, (T, M), rad and rad/s.

    error: the motors' unmodelled forces, (T, M), N; sigma: of these when the arm was calibrated, (M,), N.
    """
    found, time = [], joints.time
    first, count = 0, int(np.ceil(LOAD_STRETCH_S / max(float(np.median(np.diff(time))), 1e-9))) if len(time) > 1 else 1
    while first + count <= len(time):
        part = slice(first, first + count)
        signature = forces_of_load(machine, joints.part(part), theta[part])
        load = _fitted(time[part], signature / sigma, error[part] / sigma, dry(theta_d[part]))
        if abs(load.mass) > max(MIN_LOAD_SIGMAS * load.sigma, MIN_LOAD_KG):
            found.append(load)
        first += count
    return found


def _fitted(time: Array, signature: Array, error: Array, turning: Array) -> FoundLoad:
    """Mass by least squares, with what a constant and the direction explain taken from both sides."""
    x, y = np.zeros_like(signature.T), np.zeros_like(signature.T)
    for j, turn in enumerate(turning.T):
        fast = turning_rows(turn)
        if fast is not None:
            x[j, fast], y[j, fast] = (_without(v[fast, j], turn[fast]) for v in (signature, error))
    power = float(np.sum(x**2))
    if power == 0:
        return FoundLoad(float(time[0]), 0.0, np.inf)
    mass = float(np.sum(x * y)) / power
    block = ((time - time[0]) / _BLOCK_S).astype(int)
    pulls = np.bincount(block, weights=np.sum(x * (y - mass * x), axis=0))
    count = int(np.sum(np.bincount(block, weights=np.sum(x**2, axis=0)) > 0))
    return FoundLoad(float(time[0]), mass, float(np.sqrt(np.sum(pulls**2) * count / max(count - 1, 1)) / power))


def _without(column: Array, turning: Array) -> Array:
    """A column (T,) less what a constant and the motor's direction explain of it."""
    basis = np.stack([np.ones_like(turning), turning], axis=1)
    return column - basis @ np.linalg.lstsq(basis, column, rcond=None)[0]
