"""An arm with the laws that its motors, cables and joints obey, and their numbers."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from mechanism.arm import Arm, Array
from mechanism.laws import LAWS, Law, Stretching, Turning


@dataclass(frozen=True)
class Machine:
    """Arm, the names of laws, and their terms' values: (..., M) for cables, (..., N) for joints, (..., 1) for one of a kind."""

    arm: Arm
    names: tuple[str, ...]
    values: Mapping[str, Array]

    @cached_property
    def laws(self) -> tuple[Law, ...]:
        """In the order of their names."""
        return tuple(LAWS[name] for name in self.names)

    @cached_property
    def states(self) -> int:
        """Numbers that each cable remembers."""
        return sum(law.states for law in self.laws)

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Between which these stay, (states,) each."""
        most = np.array([law.most for law in self.laws for _ in range(law.states)])
        return -most, most

    @property
    def given_forces(self) -> "Machine":
        """The same where forces are given that act, not those that are written."""
        return replace(self, names=tuple(law.name for law in self.laws if type(law).command is Law.command))

    def command(self, f: Array, step: float) -> Array:
        """Forces that act where f (..., T, M), N, are written, on rows `step` s apart."""
        for law in self.laws:
            f = law.command(self.values, f, step)
        return f

    def written(self, force: Array, step: float) -> Array:
        """What is written where forces (..., T, M), N, act."""
        for law in reversed(self.laws):
            force = law.written(self.values, force, step)
        return force

    def friction(self, at: Turning) -> Array:
        """Force that friction takes from each motor's command, (..., M), N."""
        return sum((law.rub(self.values, at) for law in self.laws), start=np.zeros(()))

    def tension(self, at: Stretching, z: Array) -> Array:
        """Tension of each cable, (..., M), N, never below zero: a cable cannot push; z (..., M, states)."""
        return np.maximum(self.pull(at, z), 0.0)

    def pull(self, at: Stretching, z: Array) -> Array:
        """The same as if a cable could push, (..., M), N."""
        total, first = np.zeros(()), 0
        for law in self.laws:
            total = total + law.pull(self.values, at, z[..., first : first + law.states])
            first += law.states
        return total

    def drift(self, at: Stretching, z: Array) -> Array:
        """Rate of what cables remember, (..., M, states)."""
        out, first = np.empty(np.broadcast_shapes(z.shape, (*at.x.shape, self.states))), 0
        for law in self.laws:
            if law.states:
                part = slice(first, first + law.states)
                out[..., part] = law.drift(self.values, at, z[..., part])
                first += law.states
        return out

    def resistance(self, alpha_d: Array) -> Array:
        """Torque against the joints' motion, (..., N), N m."""
        return sum((law.resist(self.values, alpha_d) for law in self.laws), start=np.zeros(()))
