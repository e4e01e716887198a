"""The elongations of a recording as the check explains them: by force, stiffening and dry friction."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset import DataSet
from mechanism.friction import dry

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Explained:
    """x = c0 + c1 n + c2 n^2 + h dry(theta') for every cable, n = f - Ia (R/rd) theta''."""

    force: Array
    """n, (T, M), N"""
    x: Array
    """(T, M), m"""
    explained: Array
    """(T, M), m"""
    coefficients: Array
    """c0, c1, c2, h in rows, (4, M)"""

    def curve(self, cable: int, force: Array, turning: int) -> Array:
        """x of a cable (from 0) at forces (K,), N, winding in (`turning` 1) or paying out (-1), m."""
        c0, c1, c2, h = self.coefficients[:, cable]
        return c0 + c1 * force + c2 * force**2 + turning * h


def explain(data: DataSet) -> Explained:
    """Least squares of each cable's elongation over the whole state."""
    arm, state = data.arm, data.state
    x = state.matrix("x")
    n = state.matrix("f") - arm.motor_inertia / arm.drum * state.matrix("theta", "_dd")
    rubbing = dry(state.matrix("theta", "_d"))
    explained, coefficients = np.empty_like(x), np.empty((4, arm.M))
    for j in range(arm.M):
        D = np.column_stack([np.ones(len(x)), n[:, j], n[:, j] ** 2, rubbing[:, j]])
        coefficients[:, j] = np.linalg.lstsq(D, x[:, j], rcond=None)[0]
        explained[:, j] = D @ coefficients[:, j]
    return Explained(n, x, explained, coefficients)
