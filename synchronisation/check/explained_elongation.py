"""What the motor force explains of the cables' elongations.

A healthy cable stretches by x = c0 + c1 n + c2 n^2 + h dry(theta'), with n = f - Ia (R/rd) theta'' the force that friction
and tension share; h is friction's part of it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series
from mechanism.arm import Arm
from mechanism.friction import dry
from xneck_foundation.least_squares import Estimate, linear_least_squares

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Explained:
    """Fits of c0, c1, c2, h for every cable of a series."""

    force: Array
    """n, (T, M), N"""
    x: Array
    """(T, M), m"""
    explained: Array
    """(T, M), m"""
    fits: tuple[Estimate, ...]

    def curve(self, cable: int, force: Array, turning: int) -> Array:
        """x of a cable (from 0) at forces (K,), N, winding in (`turning` 1) or paying out (-1), m."""
        c0, c1, c2, h = self.fits[cable].value
        return c0 + c1 * force + c2 * force**2 + turning * h


def explain(arm: Arm, series: Series) -> Explained:
    """Least squares of each cable's elongation over a series with theta_d, theta_dd, f and x."""
    x = series.matrix("x")
    n = series.matrix("f") - arm.motor_inertia / arm.drum * series.matrix("theta", "_dd")
    rubbing = dry(series.matrix("theta", "_d"))
    fits = tuple(
        linear_least_squares(np.column_stack([np.ones(len(x)), n[:, j], n[:, j] ** 2, rubbing[:, j]]), x[:, j]) for j in range(arm.M)
    )
    return Explained(n, x, x - np.stack([fit.residuals for fit in fits], axis=-1), fits)
