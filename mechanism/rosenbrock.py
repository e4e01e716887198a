"""One step of arm, cables and motors with the arm's geometry held: a Rosenbrock method, stable however stiff or damped they are.

While Z, M and c + g are held, elongations follow joints and motors linearly, x' = -Z^T alpha' + (rd/R) theta', and only the laws
are nonlinear. A step linearises them once; each of its stages then solves (1/(gamma h) - J) U = rate plus what earlier stages
contribute (Hairer and Wanner, Solving Ordinary Differential Equations II, IV.7). Cables and motors are eliminated one by one, so
that a symmetric system in the N joints is left. Arrays are in batch layout (batch_layout.py), B sets side by side.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mechanism.arm import Array
from mechanism.batched_ldl import ldl_factor, ldl_solve
from mechanism.cable_lengths import CableGeometry
from mechanism.dynamics import Terms
from mechanism.law_derivatives import LawDerivatives, Losses, law_derivatives, losses_at
from mechanism.laws import CableMotion, JointMotion, MotorMotion
from mechanism.machine import Machine

GAMMA = 0.43586652150845899941601945119356
C = ((), (-1.0156171083877702091975600115545,), (4.0759956452537699824805835358067, 9.2076794298330791242156818474003))
WEIGHTS = (1.0, 6.1697947043828245592553615689730, -0.42772256543218573326238373806514)
"""Ros3 of order 3, L-stable, with rates at the beginning and after the first stage only (Sandu et al., Atmos. Environ. 31, 1997)"""


@dataclass(frozen=True)
class HeldPose:
    """The pose whose geometry is held during a step: alpha there (N, B), rad, its cables, and the arm's terms.

    Motor angles (M, B), rad, and the time since the recording began, s, are held as well, for laws that follow these."""

    alpha: Array
    cables: CableGeometry
    terms: Terms
    theta: Array
    time: Array


@dataclass(frozen=True)
class BatchState:
    """A state in batch layout: alpha, alpha_d (N, B), theta, theta_d (M, B), memory of the cables (M, B, states)."""

    alpha: Array
    alpha_d: Array
    theta: Array
    theta_d: Array
    memory: Array


@dataclass(frozen=True)
class MotorInput:
    """What is given of the motors, (M, B): their force, N, or, where `is_acceleration`, their acceleration, rad/s^2."""

    value: Array
    is_acceleration: bool


@dataclass(frozen=True)
class _Coordinates:
    """alpha, theta and x one below the other, (N + 2 M, B), their rates, and the cables' memory (M, B, states)."""

    place: Array
    speed: Array
    memory: Array


@dataclass(frozen=True)
class _Rates:
    """Torque on the joints (N, B), N m, acceleration of the motors (M, B), rate of the memory (M, B, states)."""

    torque: Array
    theta_dd: Array
    memory: Array


@dataclass(frozen=True)
class _Elimination:
    """The linear system of a stage with memory, cables and motors eliminated, so that the joints are left."""

    memory_by_x_d: Array
    """change of the memory by that of x', (M, B, states)"""
    memory_by_speed: Array
    """change of the memory by that of the motor's speed, (M, B, states)"""
    tension_by_x_d: Array
    """change of the tension by that of x', memory included, (M, B)"""
    motor_inertia: Array
    """1/(gamma h) and friction's slope, what a motor's acceleration is divided by, (M, B)"""
    motor_by_tension: Array
    """loss of the motor's speed by the tension, (M, B)"""
    share: Array
    """of an elongation's change that stays when its motor gives way, (M, B)"""
    arriving: Array
    """Z of what cables lose nothing of on their way, (N, M, B), m"""
    joints: Array
    """the joints' system, (N, N, B): as `ldl_factor` gives it, or itself where cables lose on their way and it is not symmetric"""
    symmetric: bool

    def torque(self, t: Array) -> Array:
        """Of tensions (M, B), N, on the joints, (N, B), N m."""
        return np.einsum("ijb,jb->ib", self.arriving, t)

    def solved(self, torque: Array) -> Array:
        """The joints' part of a stage, (N, B), for its torques, (N, B)."""
        if self.symmetric:
            return ldl_solve(self.joints, torque)
        solution = np.linalg.solve(np.moveaxis(self.joints, -1, 0), torque.T[..., None])
        return np.asarray(solution[..., 0].T, dtype=float)


class _HeldSystem:
    """The equations of motion with a pose's geometry held."""

    def __init__(self, machine: Machine, pose: HeldPose, motors: MotorInput) -> None:
        n, m = machine.arm.N, machine.arm.M
        self.machine, self.pose, self.motors, self.drum = machine, pose, motors, machine.arm.drum
        self.joint_rows, self.motor_rows, self.cable_rows = slice(n), slice(n, n + m), slice(n + m, None)
        # rad/s^2 by N at the cable; given accelerations do not answer to forces
        self.motor_lightness = (
            np.zeros_like(self.drum) if motors.is_acceleration else self.drum / machine.arm.motor_inertia
        )

    def coordinates(self, state: BatchState, rest_length: Array) -> _Coordinates:
        """A state with its elongations."""
        cables, pose, drum = self.pose.cables, self.pose, self.drum
        x = cables.length - rest_length + self.machine.arm.x0
        x = x + cables.stretch(drum, state.alpha - pose.alpha, state.theta)
        x_d = cables.stretch(drum, state.alpha_d, state.theta_d)
        place = np.concatenate([state.alpha, state.theta, x])
        return _Coordinates(place, np.concatenate([state.alpha_d, state.theta_d, x_d]), state.memory)

    def cable_motion(self, c: _Coordinates) -> CableMotion:
        """Elongations and their rates."""
        x, x_d, theta_d = c.place[self.cable_rows], c.speed[self.cable_rows], c.speed[self.motor_rows]
        arm, pose = self.machine.arm, self.pose
        return CableMotion(
            x, x_d, pose.cables.length, arm, self.drum * theta_d, pose.theta / arm.gear, pose.theta, pose.time
        )

    def motor_motion(self, theta_d: Array, tension: Array, memory: Array) -> MotorMotion:
        """At the held angles; where motors turn as given their friction is not asked for."""
        pose, force, arm = self.pose, self.motors.value, self.machine.arm
        drum_angle = pose.theta / arm.gear
        return MotorMotion(theta_d, tension, pose.cables.wrap, pose.theta, drum_angle, force, pose.time, arm, memory)

    def joint_motion(self, alpha_d: Array) -> JointMotion:
        """At the held angles."""
        return JointMotion(self.pose.alpha, alpha_d, self.pose.time, joint_axis=0)

    def rates(self, c: _Coordinates) -> _Rates:
        """By the laws."""
        machine, cables, terms = self.machine, self.pose.cables, self.pose.terms
        at, theta_d = self.cable_motion(c), c.speed[self.motor_rows]
        t = machine.tension(at, c.memory)
        alpha_d = c.speed[self.joint_rows]
        torque = cables.torque(t) - terms.c - terms.g - machine.resistance(self.joint_motion(alpha_d))
        if machine.loses_on_the_way:
            torque = torque - machine.torque_lost(t, cables, alpha_d)
        theta_dd = self.motors.value
        if not self.motors.is_acceleration:
            friction = machine.friction(self.motor_motion(theta_d, t, c.memory))
            theta_dd = self.motor_lightness * (self.motors.value - friction - t)
        return _Rates(torque, theta_dd, machine.memory_rate(at, c.memory) if machine.states else c.memory)

    def eliminated(self, k: LawDerivatives, w: float, losses: Losses | None) -> _Elimination:
        """w: 1/(gamma h), 1/s; losses: where cables lose on their way."""
        cables, lightness = self.pose.cables, self.motor_lightness
        memory_by_x_d = (k.memory_rate_by_x / w + k.memory_rate_by_x_d) / (w - k.memory_rate_by_memory)
        tension_by_x_d = k.pull_by_x / w + k.pull_by_x_d + _of_memory(k.pull_by_memory, memory_by_x_d)
        memory_by_speed = k.memory_rate_by_speed / (w - k.memory_rate_by_memory)
        motor_inertia = w + lightness * (k.friction_by_speed + _of_memory(k.friction_by_memory, memory_by_speed))
        motor_by_tension = lightness * (1 + k.friction_by_tension) / motor_inertia
        share = 1 / (1 + self.drum * motor_by_tension * tension_by_x_d)
        arriving = cables.Z if losses is None else cables.Z * losses.arriving
        A = w * self.pose.terms.M + np.einsum("ikb,jkb->ijb", arriving * (tension_by_x_d * share), cables.Z)
        diagonal = np.arange(self.machine.arm.N)
        A[diagonal, diagonal] += k.resistance_by_speed
        if losses is not None:
            A += losses.torque_by_speed
        return _Elimination(
            memory_by_x_d=memory_by_x_d,
            memory_by_speed=memory_by_speed,
            tension_by_x_d=tension_by_x_d,
            motor_inertia=motor_inertia,
            motor_by_tension=motor_by_tension,
            share=share,
            arriving=arriving,
            joints=ldl_factor(A) if losses is None else A,
            symmetric=losses is None,
        )

    def stage(
        self, k: LawDerivatives, e: _Elimination, w: float, speed: Array, rates: _Rates, before: _Coordinates | None
    ) -> _Coordinates:
        """What one stage adds to the coordinates; speed: rate of the place. before: earlier stages' sum, over h."""
        cables, place_d, memory_d = self.pose.cables, speed, rates.memory
        torque, theta_dd = rates.torque, rates.theta_dd
        if before is not None:
            place_d, memory_d = speed + before.place, rates.memory + before.memory
            torque = torque + np.einsum("ijb,jb->ib", self.pose.terms.M, before.speed[self.joint_rows])
            theta_dd = theta_dd + before.speed[self.motor_rows]
        x_change = place_d[self.cable_rows] / w
        memory = (memory_d + k.memory_rate_by_x * x_change[..., None]) / (w - k.memory_rate_by_memory)
        tension = k.pull_by_x * x_change + _of_memory(k.pull_by_memory, memory)
        rubbed = theta_dd - self.motor_lightness * _of_memory(k.friction_by_memory, memory)
        free_motors = rubbed / e.motor_inertia - e.motor_by_tension * tension
        held_torque = e.torque(tension + e.tension_by_x_d * e.share * self.drum * free_motors)
        joints_d = e.solved(torque + held_torque)
        x_d = e.share * cables.stretch(self.drum, joints_d, free_motors)
        motors_d = free_motors - e.motor_by_tension * e.tension_by_x_d * x_d
        speed_change = np.concatenate([joints_d, motors_d, x_d])
        memory = memory + e.memory_by_x_d * x_d[..., None] + e.memory_by_speed * motors_d[..., None]
        return _Coordinates((place_d + speed_change) / w, speed_change, memory)


def rosenbrock_step(
    machine: Machine, pose: HeldPose, rest_length: Array, start: BatchState, motors: MotorInput, h: float
) -> BatchState:
    """The state h seconds later; machine in batch layout, rest_length l(0) (M, B), m."""
    system = _HeldSystem(machine, pose, motors)
    at = system.coordinates(start, rest_length)
    motors_at = system.motor_motion(start.theta_d, np.zeros(()), at.memory)
    k = law_derivatives(machine, system.cable_motion(at), at.memory, motors_at, system.joint_motion(start.alpha_d))
    w = 1 / (GAMMA * h)
    losses = None
    if machine.loses_on_the_way:
        losses = losses_at(machine, pose.cables, machine.tension(system.cable_motion(at), at.memory), start.alpha_d)
    elimination = system.eliminated(k, w, losses)
    stages: list[_Coordinates] = []
    rates, speed = system.rates(at), at.speed
    for number, c in enumerate(C):
        if number == 1:  # the third stage takes the same rates
            first = stages[0]
            after_first = _Coordinates(at.place + first.place, at.speed + first.speed, at.memory + first.memory)
            rates, speed = system.rates(after_first), after_first.speed
        before = _combined([weight / h for weight in c], stages) if number else None
        stages.append(system.stage(k, elimination, w, speed, rates, before))
    step = _combined(WEIGHTS, stages)
    place, speed = at.place + step.place, at.speed + step.speed
    memory = np.clip(at.memory + step.memory, *machine.bounds)
    joints, cable_motors = system.joint_rows, system.motor_rows
    return BatchState(place[joints], speed[joints], place[cable_motors], speed[cable_motors], memory)


def _of_memory(slope: Array, memory: Array) -> Array:
    """Change of a force (M, B) with that of the memory, by its slope; both (M, B, states)."""
    return np.sum(slope * memory, axis=-1) if memory.shape[-1] else np.zeros(())


def _combined(weights: Sequence[float], stages: Sequence[_Coordinates]) -> _Coordinates:
    """Weighted sum of stages."""

    def weighted(name: str) -> Array:
        total = weights[0] * getattr(stages[0], name)
        for weight, stage in zip(weights[1:], stages[1:], strict=True):
            total = total + weight * getattr(stage, name)
        return total

    return _Coordinates(weighted("place"), weighted("speed"), weighted("memory"))
