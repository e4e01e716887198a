"""All numbers of an arm with its motors, and many arms side by side."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

ROW = 0.002
"""s, from row to row of the controller and its log"""


@dataclass(frozen=True, kw_only=True)
class Plant:
    """One arm: shapes (N,) and (M,). Many: (N, B) and (M, B), the batch last. SI units."""

    L: Array
    b: Array
    r: Array
    diagonal_mass: Array
    diagonal_inertia: Array
    bar_mass: Array
    bar_inertia: Array
    bar_com: Complex
    """x + iy in the bar's frame"""
    spring_left: Array
    spring_right: Array
    free_left: Array
    free_right: Array
    gravity: Complex
    """shape (1,) or (1, B)"""
    routes: NDArray[np.intp]
    """(N, M) or (N, M, B): the place of a route word in WORDS, or that of none where the cable does not pass"""
    gear: Array
    drum: Array
    motor_inertia: Array
    dry: Array
    viscous: Array
    presliding: Array
    """rad, over which the friction's bristles bend; 0: friction is a curve over speed"""
    hyperbola: Array
    """share of a hyperbola in that curve, the rest is the arctangent"""
    stiffness: Array
    damping: Array
    x0: Array
    counts: Array

    @property
    def N(self) -> int:
        return self.L.shape[0]

    @property
    def M(self) -> int:
        return self.gear.shape[0]

    @cached_property
    def travel(self) -> Array:
        """Of the cable by radian of the motor, rd / R, m."""
        return self.drum / self.gear

    @cached_property
    def root_weights(self) -> Array:
        """(5, N, B): roots of the masses that belong to the rows of `dynamics`."""
        spin = 2 * self.diagonal_inertia / self.L**2
        pair = 2 * self.diagonal_mass
        return np.sqrt(np.stack([self.bar_mass, pair, pair, spin, spin]))

    @cached_property
    def weights_of_those_above(self) -> Array:
        """(N, 5, N, B): those roots where a mechanism is a joint's own or above it, else 0."""
        above = np.triu(np.ones((self.N, self.N)))
        return above[:, None, :, None] * self.root_weights

    @cached_property
    def turning(self) -> Array:
        """(N, N, B): what the bars' own inertia adds to the mass matrix, which no pose changes."""
        above = np.cumsum(self.bar_inertia[::-1], axis=0)[::-1]
        i = np.arange(self.N)
        return above[np.maximum(i[:, None], i[None, :])]

    @cached_property
    def crossing(self) -> Array:
        """(N, B), m, of a string over a strut: between the pulleys of a diagonal, and between those of the upper bar."""
        return np.sqrt(self.L**2 - 4 * self.r**2) + np.sqrt(self.b**2 - 4 * self.r**2)

    @cached_property
    def slopes_of_crossing(self) -> tuple[Array, Array]:
        """(N, B) each, rad: by how much a string that crosses leans against the diagonal, and against the upper bar."""
        return np.arcsin(2 * self.r / self.L), np.arcsin(2 * self.r / self.b)

    @cached_property
    def grip(self) -> Array:
        """1/rad, of the friction's bristles; 0 where there are none."""
        return np.where(self.slides, 0.0, 1 / np.where(self.slides, 1.0, self.presliding))

    @cached_property
    def slides(self) -> NDArray[np.bool_]:
        """Whether friction is a curve over speed."""
        return self.presliding == 0

    @cached_property
    def slides_everywhere(self) -> bool:
        """No motor has bristles."""
        return bool(np.all(self.slides))

    @cached_property
    def _places(self) -> dict[int, NDArray[np.intp]]:
        return {}

    def places_of_words(self, count: int) -> NDArray[np.intp]:
        """(N, M, count): where the words of the routes stand among (word, N, count), counted through."""
        if count not in self._places:
            i, column = np.arange(self.N)[:, None, None], np.arange(count)
            self._places[count] = (self.routes * self.N + i) * count + column
        return self._places[count]


def side_by_side(plants: Sequence[Plant]) -> Plant:
    """Arms with as many mechanisms and cables each, as one batch."""
    return Plant(**{f.name: np.stack([getattr(p, f.name) for p in plants], axis=-1) for f in fields(Plant)})
