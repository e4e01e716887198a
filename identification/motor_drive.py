"""What turns the motors, and the angles for which their cables' tension is as smooth as the counts allow.

A memory that friction has of the motor's path makes tension depend on all angles before. Where each step begins it is an unknown
beside the angle there, tied to the one before by what the step does to it: equations stay between neighbours.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.banded_equations import BandedEquations
from mechanism.laws import MotorMotion
from mechanism.machine import Machine
from mechanism.path_memory import PathMemory

Array = NDArray[np.float64]

STEPS_PER_ROW = 2
"""steps of the angles within a row of the log: friction is taken at each step's mean speed"""
_MAX_ITERATIONS = 8
_LEAST_GAIN = 0.5
"""of a motor's sum of squares: a step that changes it by less was its last (docs/thresholds.md)"""
_SPEED_STEP_RAD_S, _MEMORY_STEP = 1e-3, 1e-3
"""of the differences for friction's slopes"""
_MEMORY_START_SIGMA = 1.0
"""of a memory where a recording begins, before any of its motion is seen: bristles bend either way (docs/thresholds.md)"""
_TIE = 100.0
"""weight of what ties a memory to the one before, over the greatest by which tension depends on it: a ten-thousandth stays loose,
and sums of squares keep their digits"""


@dataclass(frozen=True)
class DrivenMotion:
    """A motion of the motors on G angles, and the tension of their cables that it takes."""

    angles: Array
    """(G, M), rad"""
    turning: MotorMotion
    """in the mean over the steps between the angles"""
    memory: PathMemory | None
    """on which friction depends, if on any"""
    memory_start: Array
    """of that where the first step begins, (M, states)"""
    friction: Array
    """over the steps, (G - 1, M), N"""
    tension: Array
    """at the inner angles, (G - 2, M), N"""


@dataclass(frozen=True)
class MotorDrive:
    """What turns the motors, on G angles that are half a row apart."""

    machine: Machine
    """of laws of the motors alone"""
    held: Array
    """forces between the angles, (G - 1, M), N"""
    inertia: Array
    """Ia (R/rd), (M,)"""
    length: float
    """s, from angle to angle"""
    rubs: MotorMotion
    """under which tension, and wound how far, cables rub on their pulleys between the angles; its speeds are not used"""

    def rubbing(self, tension: Array, wrap: Array) -> "MotorDrive":
        """The same under a tension at the inner angles, (G - 2, M), N, and wound by `wrap`, (T, M), rad, at the rows."""
        pulled = np.concatenate([tension[:1], (tension[:-1] + tension[1:]) / 2, tension[-1:]])
        rows, between = np.arange(len(wrap)), (np.arange(len(self.held)) + 0.5) / STEPS_PER_ROW
        wound = np.stack([np.interp(between, rows, column) for column in wrap.T], axis=-1)
        return replace(self, rubs=MotorMotion(np.zeros_like(pulled), np.maximum(pulled, 0.0), wound))

    def motion(self, angles: Array, memory_start: Array) -> DrivenMotion:
        """The motion along angles (G, M), rad, that begins with a memory (M, states)."""
        travel = np.diff(angles, axis=0)
        turning, memory = replace(self.rubs, theta_d=travel / self.length), None
        if self.machine.remembers_path:
            memory = self.machine.memory_along(travel, memory_start)
            turning = replace(turning, memory=memory.mean)
        friction = np.broadcast_to(self.machine.friction(turning), travel.shape)
        net = self.held - friction
        tension = (net[:-1] + net[1:]) / 2 - self.inertia * np.diff(angles, 2, axis=0) / self.length**2
        return DrivenMotion(angles, turning, memory, memory_start, friction, tension)

    def smoothed(
        self, angles: Array, memory_start: Array, measured: Array, sigma: Array, cutoff: Array
    ) -> DrivenMotion:
        """The motion that fits measured angles (T, M), rad, at the rows, within sigma (M,), and whose tension is smooth.

        By Gauss and Newton's steps from angles (G, M), rad, and a memory (M, states) at their beginning; where a motor turns
        round one may lead uphill, and the next one far down. cutoff: (M,), Hz, up to which tension follows the angles.
        """
        row = self.length * STEPS_PER_ROW
        # a motor whose tension alone counts follows its angles up to the cutoff: |inertia w^4|^2 roughness = 1 / (sigma^2 row)
        root = np.sqrt(self.length / (sigma**2 * row)) / ((2 * np.pi * cutoff) ** 4 * self.inertia) / self.length**2

        def loss(at: DrivenMotion) -> Array:
            misfit, rough = (measured - at.angles[::STEPS_PER_ROW]) / sigma, root * np.diff(at.tension, 2, axis=0)
            of_start = np.sum((at.memory_start / _MEMORY_START_SIGMA) ** 2, axis=1)
            return np.sum(misfit**2, axis=0) + np.sum(rough**2, axis=0) + of_start

        motors, stride = angles.shape[1], self._stride
        at, unsettled = self.motion(angles, memory_start), np.ones(motors, dtype=bool)
        left = least = loss(at)
        best = at
        for _ in range(_MAX_ITERATIONS):
            by_travel, by_memory = self._friction_slopes(at)
            change = np.zeros((motors, len(angles), stride))
            for j in np.flatnonzero(unsettled).tolist():
                misfit = measured[:, j] - at.angles[::STEPS_PER_ROW, j]
                equations = self._equations(at, j, root[j], by_travel[:, j], by_memory[:, j])
                equations.add({0: np.full(len(misfit), 1 / sigma[j])}, misfit / sigma[j], stride * STEPS_PER_ROW)
                change[j] = equations.solved().reshape(-1, stride)
            at = self.motion(at.angles + change[..., 0].T, at.memory_start + change[:, 0, 1:])
            before, left = left, loss(at)
            is_best = left < least
            if is_best.all():
                best = at
            elif is_best.any():
                both = (at.angles, best.angles), (at.memory_start.T, best.memory_start.T)
                best_angles, best_start = (np.where(is_best, new, old) for new, old in both)
                best = self.motion(best_angles, best_start.T)
            least = np.minimum(left, least)
            unsettled = np.abs(before - left) >= _LEAST_GAIN
            if not unsettled.any():
                break
        return best

    @property
    def _stride(self) -> int:
        """Unknowns of each angle: itself, and the memory with which the step from there begins."""
        return 1 + self.machine.states

    def _friction_slopes(self, at: DrivenMotion) -> tuple[Array, Array]:
        """Slopes of friction over steps by their travel, (G - 1, M), N/rad, and by memory where they start, (..., states), N."""
        faster = replace(at.turning, theta_d=at.turning.theta_d + _SPEED_STEP_RAD_S)
        by_travel = (self.machine.friction(faster) - at.friction) / _SPEED_STEP_RAD_S / self.length
        if at.memory is None:
            return by_travel, np.zeros((*by_travel.shape, 0))
        bent = [
            replace(at.turning, memory=at.memory.mean + _MEMORY_STEP * unit) for unit in np.eye(self.machine.states)
        ]
        by_mean = np.stack([(self.machine.friction(b) - at.friction) / _MEMORY_STEP for b in bent], axis=-1)
        by_travel = by_travel + np.sum(by_mean * at.memory.mean_by_travel, axis=-1)
        return by_travel, by_mean * at.memory.mean_by_start

    def _equations(self, at: DrivenMotion, j: int, root: float, by_travel: Array, by_memory: Array) -> BandedEquations:
        """Of one motor's changes: no second differences of tension, and memory that follows from step to step."""
        stride, inertia = self._stride, self.inertia[j] / self.length**2
        # of the tension between steps k and k + 1, by the angles k to k + 2 and by memory at both steps' start
        by_unknowns = {
            0: by_travel[:-1] / 2 - inertia,
            stride: 2 * inertia + (by_travel[1:] - by_travel[:-1]) / 2,
            2 * stride: -by_travel[1:] / 2 - inertia,
        }
        for state in range(stride - 1):
            by_unknowns[1 + state] = -by_memory[:-1, state] / 2
            by_unknowns[stride + 1 + state] = -by_memory[1:, state] / 2
        count = len(by_travel) - 3
        rough: dict[int, Array] = {}
        for place, weight in enumerate((root, -2.0 * root, root)):
            for k, by_one in by_unknowns.items():
                part, there = weight * by_one[place : place + count], k + place * stride
                rough[there] = rough[there] + part if there in rough else part
        equations = BandedEquations(stride * len(at.angles), 4 * stride)
        equations.add(rough, -root * np.diff(at.tension[:, j], 2), stride)
        if at.memory is not None:
            greatest = max(1.0, *(float(np.abs(by_one).max()) for k, by_one in rough.items() if k % stride))
            tie, zero = np.full(len(by_travel), _TIE * greatest), np.zeros(len(by_travel))
            for state in range(stride - 1):
                by_start, by_step = (tie * by[:, j, state] for by in (at.memory.end_by_start, at.memory.end_by_travel))
                here, after = 1 + state, stride + 1 + state
                equations.add({0: by_step, here: -by_start, stride: -by_step, after: tie}, zero, stride)
                known = np.full(1, 1 / _MEMORY_START_SIGMA)
                equations.add({here: known}, -known * at.memory_start[j, state], stride)
        return equations
