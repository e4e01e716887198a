"""States step by step: where the arm will be in the middle of each, and what the motors are given there; all in lanes."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from mechanism.arm import Array
from mechanism.cable_lengths import strung
from mechanism.dynamics import terms_in_lanes
from mechanism.laws import Stretching, Turning
from mechanism.machine import Machine
from mechanism.stiff_step import Drive, Lanes, Pose, step_in_pose


@dataclass(frozen=True)
class Forced:
    """Motor forces, (T, M, lanes or 1), N, each held from its row to the next."""

    f: Array

    def at(self, row: int, state: Lanes) -> Lanes:
        """The state at a row."""
        return state

    def drive(self, row: int, interval: float) -> Drive:
        """Of the motors from a row on."""
        return Drive(self.f[row], led=False)

    def force(self, row: int, machine: Machine, state: Lanes, t: Array, wrap: Array) -> Array:
        """What motors give at a row, N."""
        return np.broadcast_to(self.f[row], t.shape)


@dataclass(frozen=True)
class Led:
    """Motor angles with two derivatives, (T, M, lanes or 1): motors turn as given, evenly accelerated between rows."""

    theta: Array
    theta_d: Array
    theta_dd: Array

    def at(self, row: int, state: Lanes) -> Lanes:
        shape = state.theta.shape
        return replace(
            state, theta=np.broadcast_to(self.theta[row], shape), theta_d=np.broadcast_to(self.theta_d[row], shape)
        )

    def drive(self, row: int, interval: float) -> Drive:
        return Drive((self.theta_d[row + 1] - self.theta_d[row]) / interval, led=True)

    def force(self, row: int, machine: Machine, state: Lanes, t: Array, wrap: Array) -> Array:
        inertial = machine.arm.motor_inertia / machine.arm.drum * self.theta_dd[row]
        return t + machine.friction(Turning(state.theta_d, t, wrap)) + inertial


def run(machine: Machine, state: Lanes, time: Array, motors: Forced | Led, max_step: float) -> Iterator[Array]:
    """alpha, alpha', theta, theta', tension and f, one above the other, (2 N + 4 M, lanes), at every time.

    Where the arm has left the range of its mechanisms the angles are not finite or beyond pi.
    """
    rest_length = strung(machine.arm, np.zeros((machine.arm.N, 1))).length
    state = motors.at(0, state)
    gain = np.zeros_like(state.alpha)
    yield _read(machine, state, rest_length, motors, 0)
    for row, interval in enumerate(np.diff(time)):
        substeps = max(1, int(np.ceil(interval / max_step - 1e-9)))
        h = float(interval) / substeps
        drive = motors.drive(row, float(interval))
        for sub in range(substeps):
            if row == sub == 0:  # nothing before tells the acceleration: a first try does
                gain = (_stepped(machine, state, rest_length, gain, drive, h).alpha_d - state.alpha_d) / h
            later = _stepped(machine, state, rest_length, gain, drive, h)
            gain, state = (later.alpha_d - state.alpha_d) / h, later
        state = motors.at(row + 1, state)
        yield _read(machine, state, rest_length, motors, row + 1)


def _stepped(machine: Machine, state: Lanes, rest_length: Array, gain: Array, drive: Drive, h: float) -> Lanes:
    """gain: alpha'' as the step before had it, (N, lanes), rad/s^2."""
    arm = machine.arm
    alpha = state.alpha + h / 2 * state.alpha_d + h**2 / 8 * gain
    pose = Pose(alpha, strung(arm, alpha), terms_in_lanes(arm, alpha, state.alpha_d + h / 2 * gain))
    return step_in_pose(machine, pose, rest_length, state, drive, h)


def _read(machine: Machine, state: Lanes, rest_length: Array, motors: Forced | Led, row: int) -> Array:
    arm, cables = machine.arm, strung(machine.arm, state.alpha)
    x = cables.length - rest_length + arm.drum * state.theta + arm.x0
    x_d = cables.stretch(arm.drum, state.alpha_d, state.theta_d)
    t = machine.tension(Stretching(x, x_d, cables.length, arm, arm.drum * state.theta_d), state.memory)
    f = motors.force(row, machine, state, t, cables.wrap)
    return np.concatenate([state.alpha, state.alpha_d, state.theta, state.theta_d, t, f])
