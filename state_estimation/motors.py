"""Motor angles with their derivatives, from counts, and the force beside them."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.dataset.half_row_speeds import HalfRowSpeeds
from identification.dataset.series import Series
from identification.motor_speeds import motor_speeds
from mechanism.arm import Arm
from mechanism.friction import CM
from mechanism.machine import Machine
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
    counted: Array | None = None
    """theta as the encoders counted it, (T, M)"""
    count: Array | None = None
    """angle of one count, (M,), rad"""
    delay: float = 0.0
    """s, by which forces act later than the log says"""
    within_rows: HalfRowSpeeds | None = None
    """speeds by the motors' equations, where friction is known"""

    def with_friction(self, arm: Arm, dry: Array, viscous: Array) -> "Motors":
        """These motors with their speeds within the rows, for dry friction (M,), N, and viscous friction (M,), N s/rad.

        As they are where nobody knows what was counted.
        """
        if self.counted is None or self.count is None:
            return self
        values = {"fs": np.maximum(dry, 0.0), "cm": np.array([CM]), "fv": np.maximum(viscous, 0.0)}
        machine = Machine(arm, ("dry_friction", "viscous_friction"), values)
        step = float(np.mean(np.diff(self.time)))
        return replace(self, within_rows=motor_speeds(arm, machine, self.counted, self.f, step, self.count, self.delay))


def motors_of(log: Series, count: Array, delay: float = 0.0) -> Motors:
    """Motors of a log with even steps; count: angle of one encoder count, (M,), rad, whose rounding is the only noise.

    delay: s, by which forces act later than the log says.
    """
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
        counted=log.matrix("theta"),
        count=count,
        delay=delay,
    )


def motors_in(state: Series) -> Motors:
    """Motors of a data set's state, which holds theta with its derivatives and f."""
    theta, theta_d, theta_dd = (state.matrix("theta", suffix) for suffix in ("", "_d", "_dd"))
    return Motors(time=state.time, theta=theta, theta_d=theta_d, theta_dd=theta_dd, f=state.matrix("f"))
