"""Motors, cables and arm under the controller, in steps far below its period."""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from samples.generator.motion import RATE_HZ
from samples.generator.motors import Motors
from samples.generator.mujoco_arm import MujocoArm
from samples.generator.routes import cable_table
from samples.generator.taut_string import Array


class Commands(Protocol):
    """Anything that turns measured motor angles into force commands, once a period."""

    def command(self, sample: int, theta: Array) -> Array: ...


@dataclass(frozen=True)
class Run:
    """The state at every tick of the controller, just after it has given its command."""

    time: Array
    """shape (T,), s"""
    alpha: Array
    """shape (T, N), rad"""
    alpha_d: Array
    """shape (T, N), rad/s"""
    alpha_dd: Array
    """shape (T, N), rad/s^2"""
    theta: Array
    """true motor angles, shape (T, M), rad"""
    theta_d: Array
    """shape (T, M), rad/s"""
    theta_dd: Array
    """shape (T, M), rad/s^2"""
    counted: Array
    """motor angles as the encoders give them, shape (T, M), rad"""
    f: Array
    """command, held until the next tick, shape (T, M), N"""
    x: Array
    """elongation of the cables, shape (T, M), m"""
    x_d: Array
    """shape (T, M), m/s"""
    tension: Array
    """shape (T, M), N"""
    arm_energy: Array
    """kinetic and potential energy of the arm, shape (T,), J"""


def quantum(neck: dict[str, Any]) -> Array:
    """Motor angle per encoder count, shape (M,), rad."""
    return np.array([2 * np.pi / m["counts"] for m in neck["motors"]])


def simulate(
    neck: dict[str, Any],
    arm: MujocoArm,
    motors: Motors,
    controller: Commands,
    theta: Array,
    ticks: int,
    settle_ticks: int,
) -> Run:
    """`ticks` controller periods from the straight pose and motor angles `theta`, shape (M,), rad, after settling.

    While it settles (samples -settle_ticks to -1) nothing is kept. The motors go by semi-implicit Euler, like MuJoCo's
    arm: speeds first, then places, with the forces of the state at the beginning of the step.
    """
    step = float(arm.model.opt.timestep)
    substeps = round(1 / (RATE_HZ * step))
    table = cable_table(neck)
    straight, _ = table(np.zeros(len(neck["mechanisms"])))
    count = quantum(neck)
    theta, theta_d = np.array(theta, dtype=float), np.zeros(len(theta))
    arm.place(np.zeros(len(neck["mechanisms"])))
    kept: list[tuple[Array | float, ...]] = []
    for sample in range(-settle_ticks, ticks):
        counted = np.round(theta / count) * count
        f = controller.command(sample, counted)
        for sub in range(substeps):
            alpha, alpha_d = arm.alpha, arm.alpha_d
            length, slope = table(alpha)
            x = length - straight + motors.drum * theta + motors.x0
            x_d = alpha_d @ slope + motors.drum * theta_d
            t = motors.tension(x, x_d)
            alpha_dd = arm.step(-slope @ t)
            theta_dd = motors.acceleration(f, theta_d, t)
            if sub == 0 and sample >= 0:
                energy = arm.energy().total
                state = (alpha, alpha_d, alpha_dd, theta, theta_d, theta_dd, counted, f, x, x_d, t, energy)
                kept.append((sample / RATE_HZ, *state))
            theta_d = theta_d + step * theta_dd
            theta = theta + step * theta_d
    return Run(*(np.array(series) for series in zip(*kept, strict=True)))
