"""Motor angles with their derivatives, from counts, and the force beside them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series
from state_estimation.smoother import smooth_signal

Array = NDArray[np.float64]

KNOT_S = 0.01
"""s between knots where rows are not further apart: the spline follows motion to about 30 Hz"""
MAX_ROWS_PER_KNOT = 5
"""rows of the log per knot at most"""


@dataclass(frozen=True)
class Motors:
    """theta with its derivatives and the force at the log's even times (T,), s, each (T, M)."""

    time: Array
    theta: Array
    theta_d: Array
    theta_dd: Array
    f: Array
    sigma: tuple[Array, Array, Array] | None = None
    """standard deviations of theta, theta' and theta'', each (T, M), by the rounding of counts"""


def motors_of(log: Series, count: Array) -> Motors:
    """Motors of a log with even steps; count: angle of one encoder count, (M,), rad, whose rounding is the only noise."""
    row = float(np.mean(np.diff(log.time)))
    step = row * min(MAX_ROWS_PER_KNOT, max(1, round(KNOT_S / row)))
    signals = [
        smooth_signal(log.time, column, np.full(len(log), count[j] / np.sqrt(12)), log.time, step)
        for j, column in enumerate(log.matrix("theta").T)
    ]
    theta, theta_d, theta_dd = (
        np.stack([getattr(s, name) for s in signals], axis=-1) for name in ("value", "d1", "d2")
    )
    sigma, sigma_d, sigma_dd = (np.sqrt(np.stack([s.covariance[:, d, d] for s in signals], axis=-1)) for d in range(3))
    return Motors(
        time=log.time,
        theta=theta,
        theta_d=theta_d,
        theta_dd=theta_dd,
        f=log.matrix("f"),
        sigma=(sigma, sigma_d, sigma_dd),
    )


def motors_in(state: Series) -> Motors:
    """Motors of a data set's state, which holds theta with its derivatives and f."""
    theta, theta_d, theta_dd = (state.matrix("theta", suffix) for suffix in ("", "_d", "_dd"))
    return Motors(time=state.time, theta=theta, theta_d=theta_d, theta_dd=theta_dd, f=state.matrix("f"))
