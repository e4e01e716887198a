"""Places of what the observer estimates, in one vector."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mechanism.machine import Machine


@dataclass(frozen=True)
class StateLayout:
    """N joints, M cables with as many motors, S memory variables of each cable. Each row of a log asks for the places."""

    N: int
    M: int
    S: int
    play: int | None = None
    """which of a cable's memory variables says where its drum lies within its play; None where drums have none"""

    @cached_property
    def alpha(self) -> slice:
        """Joint angles, rad."""
        return slice(0, self.N)

    @cached_property
    def alpha_d(self) -> slice:
        """Joint speeds, rad/s."""
        return slice(self.N, 2 * self.N)

    @cached_property
    def theta(self) -> slice:
        """Motor angles, rad."""
        return slice(2 * self.N, 2 * self.N + self.M)

    @cached_property
    def theta_d(self) -> slice:
        """Motor speeds, rad/s."""
        return self._after(self.theta, self.M)

    @cached_property
    def memory(self) -> slice:
        """Memory variables of the cables, one cable after the other."""
        return self._after(self.theta_d, self.M * self.S)

    @cached_property
    def sides(self) -> NDArray[np.intp]:
        """Those of them that say where drums lie within their play, (M,), or (0,) where they have none."""
        none = np.empty(0, dtype=np.intp)
        return none if self.play is None else self.memory.start + self.S * np.arange(self.M) + self.play

    @cached_property
    def x0(self) -> slice:
        """Pre-elongations, m."""
        return self._after(self.memory, self.M)

    @cached_property
    def dragged(self) -> slice:
        """Share of a motor's speed that its cable's damper feels while the motor crosses its play; none where there is no play."""
        return self._after(self.x0, 0 if self.play is None else self.M)

    @cached_property
    def friction_error(self) -> slice:
        """What the motors' laws do not say, N at the cable."""
        return self._after(self.dragged, self.M)

    @cached_property
    def pose_error(self) -> slice:
        """By how much a joint stands beside where the model's cables pull it to, rad."""
        return self._after(self.friction_error, self.N)

    @cached_property
    def size(self) -> int:
        """Entries of the vector."""
        return self.pose_error.stop

    def vector(self, **parts: ArrayLike) -> NDArray[np.float64]:
        """A vector (size,) of parts by their names, such as `theta`; the others are zero."""
        out = np.zeros(self.size)
        for name, values in parts.items():
            out[getattr(self, name)] = values
        return out

    @staticmethod
    def _after(before: slice, count: int) -> slice:
        return slice(before.stop, before.stop + count)


def layout_of(machine: Machine) -> StateLayout:
    """The state of a machine."""
    return StateLayout(machine.arm.N, machine.arm.M, machine.states, machine.play_place)
