"""Motor angles with their derivatives, from counts, and the force beside them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series
from state_estimation.smoother import smooth

Array = NDArray[np.float64]

ROWS_PER_KNOT = 5
"""of the log: at 500 Hz the spline follows motion to about 30 Hz"""


@dataclass(frozen=True)
class Motors:
    """theta with its derivatives and the force at the log's even times (T,), s, each (T, M)."""

    time: Array
    theta: Array
    theta_d: Array
    theta_dd: Array
    f: Array
    sigma: tuple[Array, Array, Array] | None = None
    """of theta and its derivatives, from rounding"""


def motors_of(log: Series, count: Array) -> Motors:
    """From a log of even steps; count: angle of one encoder count, (M,), rad, whose rounding is the only noise."""
    step = ROWS_PER_KNOT * float(np.mean(np.diff(log.time)))
    found = [
        smooth(log.time, column, np.full(len(log), count[j] / np.sqrt(12)), log.time, step)
        for j, column in enumerate(log.matrix("theta").T)
    ]
    theta, theta_d, theta_dd = (np.stack([getattr(s, name) for s in found], axis=-1) for name in ("value", "d1", "d2"))
    one, two, three = (np.sqrt(np.stack([s.covariance[:, d, d] for s in found], axis=-1)) for d in range(3))
    return Motors(log.time, theta, theta_d, theta_dd, log.matrix("f"), (one, two, three))
