"""A law of four terms that explains the cables' elongations along the whole log, for tables and figures.

A healthy cable stretches by x = c0 + c1 n + c2 n^2 + h dry(theta'), with n = f - Ia (R/rd) theta'' the force that friction and
tension share; h is friction's part of it. The check itself uses more terms (see absolute_law) than a curve over the force can show.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series
from mechanism.arm import Arm
from state_estimation.elongation_regressors import force_signals
from state_estimation.motors import motors_in
from xneck_foundation.least_squares import Estimate, linear_least_squares

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ExplainedElongation:
    """Fits of c0, c1, c2, h for every cable of a series."""

    force: Array
    """n, (T, M), N"""
    x: Array
    """(T, M), m"""
    explained: Array
    """(T, M), m"""
    fits: tuple[Estimate, ...]

    def curve(self, cable: int, force: Array, direction: int) -> Array:
        """x of a cable (from 0) at forces (K,), N, winding in (`direction` 1) or paying out (-1), m."""
        c0, c1, c2, h = self.fits[cable].value
        return c0 + c1 * force + c2 * force**2 + direction * h


def explain(arm: Arm, series: Series) -> ExplainedElongation:
    """Least squares of each cable's elongation over a series with theta and its derivatives, f and x."""
    x = series.matrix("x")
    signals = force_signals(arm, motors_in(series))
    n, dry = signals.force, signals.friction[0]
    fits = tuple(
        linear_least_squares(np.column_stack([np.ones(len(x)), n[:, j], n[:, j] ** 2, dry[:, j]]), x[:, j])
        for j in range(arm.M)
    )
    return ExplainedElongation(n, x, x - np.stack([fit.residuals for fit in fits], axis=-1), fits)
