"""An arm with the laws that its motors, cables and joints obey, and their numbers."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from mechanism.arm import Arm, Array
from mechanism.laws import CableMotion, JointMotion, Law, MotorMotion, law_named

SPEED_STEP_RAD_S = 1e-3
"""of the differences for friction's slope"""


@dataclass(frozen=True)
class Machine:
    """Arm, names of its laws, and values of their terms: (..., M) for cables, (..., N) for joints, (..., 1) where all share one."""

    arm: Arm
    names: tuple[str, ...]
    values: Mapping[str, Array]

    @cached_property
    def laws(self) -> tuple[Law, ...]:
        """The laws, in the order of `names`."""
        return tuple(law_named(name) for name in self.names)

    @cached_property
    def states(self) -> int:
        """Number of memory variables of each cable."""
        return sum(law.states for law in self.laws)

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds of the memory variables, (states,) each."""
        bound = np.array([law.memory_bound for law in self.laws for _ in range(law.states)])
        return -bound, bound

    @property
    def memory_start(self) -> Array:
        """Memory variables where a recording begins, (M, states): nothing where `values` do not say."""
        starts = [
            self.values.get(law.memory_start.name, np.zeros(1)) if law.memory_start else np.zeros(1)
            for law in self.laws
            for _ in range(law.states)
        ]
        return np.stack([np.broadcast_to(start, self.arm.M) for start in starts], axis=-1)

    @property
    def rubs_under_tension(self) -> bool:
        """Whether friction depends on the cables' tension and on how far they are wound around pulleys."""
        return any(law.rubs_under_tension for law in self.laws)

    @property
    def follows_force(self) -> bool:
        """Whether friction depends on what the motors are told."""
        return any(law.follows_force for law in self.laws)

    @property
    def without_actuator_laws(self) -> "Machine":
        """This machine without the laws of its actuators: for forces as they act, not as they are logged."""
        return replace(self, names=tuple(law.name for law in self.laws if type(law).acting_force is Law.acting_force))

    def acting_force(self, f: Array, step: float) -> Array:
        """Forces that act where the log says f (..., T, M), N, on rows `step` s apart."""
        for law in self.laws:
            f = law.acting_force(self.values, f, step)
        return f

    def commanded_force(self, force: Array, step: float) -> Array:
        """Forces that the log says where `force` (..., T, M), N, acts, on rows `step` s apart: the inverse of `acting_force`."""
        for law in reversed(self.laws):
            force = law.commanded_force(self.values, force, step)
        return force

    def friction(self, at: MotorMotion) -> Array:
        """Force that friction takes from each motor's command, (..., M), N."""
        return sum((law.friction(self.values, at) for law in self.laws), start=np.zeros(()))

    def friction_slope(self, at: MotorMotion) -> Array:
        """Change of that force with the speed, (..., M), N s/rad, by differences."""
        low, high = (
            self.friction(replace(at, theta_d=at.theta_d + step)) for step in (-SPEED_STEP_RAD_S, SPEED_STEP_RAD_S)
        )
        return np.broadcast_to((high - low) / (2 * SPEED_STEP_RAD_S), at.theta_d.shape)

    def tension(self, at: CableMotion, z: Array) -> Array:
        """Tension of each cable, (..., M), N, never below zero: a cable cannot push; z (..., M, states)."""
        return np.maximum(self.pull(at, z), 0.0)

    def pull(self, at: CableMotion, z: Array) -> Array:
        """Tension of each cable as if it could push, (..., M), N; z (..., M, states)."""
        total, first = np.zeros(()), 0
        for law in self.laws:
            total = total + law.pull(self.values, at, z[..., first : first + law.states])
            first += law.states
        return total

    def memory_rate(self, at: CableMotion, z: Array) -> Array:
        """Rate of the cables' memory variables, (..., M, states)."""
        out, first = np.empty_like(z, shape=np.broadcast_shapes(z.shape, (*at.x.shape, self.states))), 0
        for law in self.laws:
            if law.states:
                part = slice(first, first + law.states)
                out[..., part] = law.memory_rate(self.values, at, z[..., part])
                first += law.states
        return out

    def resistance(self, at: JointMotion) -> Array:
        """Torque against the joints' motion, (..., N), N m."""
        return sum((law.resistance(self.values, at) for law in self.laws), start=np.zeros(()))
