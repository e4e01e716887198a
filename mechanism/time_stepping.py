"""A simulation step by step: the pose in the middle of each step, and what the motors are given there; all in batch layout."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from mechanism.arm import Array
from mechanism.cable_lengths import cable_geometry
from mechanism.dynamics import terms_batch_last
from mechanism.laws import CableMotion, MotorMotion
from mechanism.machine import Machine
from mechanism.rosenbrock import BatchState, HeldPose, MotorInput, rosenbrock_step

LOSSES_STEP_S = 1e-3
"""s: longest step where cables lose on their way. It brings a joint to rest within less than a row (docs/thresholds.md)"""
_FORCE_PASSES = 4
"""for forces on which friction depends: each pass is nearer by the share of the force that friction takes"""


@dataclass(frozen=True)
class GivenForces:
    """Motor forces, (T, M, B or 1), N, each held from its row to the next."""

    f: Array

    def at(self, row: int, state: BatchState) -> BatchState:
        """The state at a row, with what is given of the motors."""
        return state

    def motor_input(self, row: int, interval: float) -> MotorInput:
        """What the motors are given from a row to the next, `interval` s later."""
        return MotorInput(self.f[row], is_acceleration=False)

    def force(self, row: int, machine: Machine, state: BatchState, t: Array, wrap: Array, time: Array) -> Array:
        """Force of the motors at a row, (M, B), N; t: tensions, N; wrap: angles of wrap, rad; time since the beginning, s."""
        return np.broadcast_to(self.f[row], t.shape)


@dataclass(frozen=True)
class GivenAngles:
    """Motor angles with two derivatives, (T, M, B or 1): motors turn as given, evenly accelerated between rows."""

    theta: Array
    theta_d: Array
    theta_dd: Array

    def at(self, row: int, state: BatchState) -> BatchState:
        shape = state.theta.shape
        return replace(
            state, theta=np.broadcast_to(self.theta[row], shape), theta_d=np.broadcast_to(self.theta_d[row], shape)
        )

    def motor_input(self, row: int, interval: float) -> MotorInput:
        return MotorInput((self.theta_d[row + 1] - self.theta_d[row]) / interval, is_acceleration=True)

    def force(self, row: int, machine: Machine, state: BatchState, t: Array, wrap: Array, time: Array) -> Array:
        without = t + machine.arm.motor_inertia / machine.arm.drum * self.theta_dd[row]
        drum_angle, force = state.theta / machine.arm.gear, without
        for _ in range(_FORCE_PASSES if machine.follows_force else 1):
            force = without + machine.friction(
                MotorMotion(state.theta_d, t, wrap, state.theta, drum_angle, force, time, machine.arm, state.memory)
            )
        return force


def integrate(
    machine: Machine,
    state: BatchState,
    time: Array,
    motors: GivenForces | GivenAngles,
    max_step: float,
    began: Array,
) -> Iterator[Array]:
    """alpha, alpha', theta, theta', tension and f, one below the other, (2 N + 4 M, B), at every time.

    began: (B,) or one, s, when the recording began, in the same time.

    Where the arm has left the range of its mechanisms the angles are not finite or beyond pi.
    """
    rest_length = cable_geometry(machine.arm, np.zeros((machine.arm.N, 1))).length
    if machine.loses_on_the_way:
        max_step = min(max_step, LOSSES_STEP_S)
    state = motors.at(0, state)
    alpha_dd = np.zeros_like(state.alpha)
    yield _output(machine, state, rest_length, motors, 0, time[0] - began)
    for row, interval in enumerate(np.diff(time)):
        substeps = max(1, int(np.ceil(interval / max_step - 1e-9)))
        h = float(interval) / substeps
        motor_input = motors.motor_input(row, float(interval))
        for substep in range(substeps):
            at = time[row] + (substep + 0.5) * h - began
            if row == substep == 0:  # no step before it gives the acceleration: a trial step does
                trial = _step(machine, state, rest_length, alpha_dd, motor_input, h, at)
                alpha_dd = (trial.alpha_d - state.alpha_d) / h
            after = _step(machine, state, rest_length, alpha_dd, motor_input, h, at)
            alpha_dd, state = (after.alpha_d - state.alpha_d) / h, after
        state = motors.at(row + 1, state)
        yield _output(machine, state, rest_length, motors, row + 1, time[row + 1] - began)


def _step(
    machine: Machine,
    state: BatchState,
    rest_length: Array,
    alpha_dd: Array,
    motor_input: MotorInput,
    h: float,
    time: Array,
) -> BatchState:
    """The state h seconds later, by the pose in the step's middle, at `time`; alpha_dd: of the step before, (N, B), rad/s^2."""
    arm = machine.arm
    alpha = state.alpha + h / 2 * state.alpha_d + h**2 / 8 * alpha_dd
    terms = terms_batch_last(arm, alpha, state.alpha_d + h / 2 * alpha_dd)
    pose = HeldPose(alpha, cable_geometry(arm, alpha), terms, state.theta + h / 2 * state.theta_d, time)
    return rosenbrock_step(machine, pose, rest_length, state, motor_input, h)


def _output(
    machine: Machine, state: BatchState, rest_length: Array, motors: GivenForces | GivenAngles, row: int, time: Array
) -> Array:
    arm, cables = machine.arm, cable_geometry(machine.arm, state.alpha)
    x = cables.length - rest_length + arm.drum * state.theta + arm.x0
    x_d = cables.stretch(arm.drum, state.alpha_d, state.theta_d)
    at = CableMotion(x, x_d, cables.length, arm, arm.drum * state.theta_d, state.theta / arm.gear, state.theta, time)
    t = machine.tension(at, state.memory)
    f = motors.force(row, machine, state, t, cables.wrap, time)
    return np.concatenate([state.alpha, state.alpha_d, state.theta, state.theta_d, t, f])
