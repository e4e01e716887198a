"""What the motor force explains of a cable's elongation: x = X beta + e.

The regressors X (see elongation_regressors) are not linear in friction and in the lag of damped cables. Both are estimated in
passes, each from the factors that a linear fit gives to friction and to the rate of the tension. The error e is coloured (see
elongation_error_spectrum).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import interpolated
from mechanism.arm import Arm
from state_estimation.elongation_regressors import (
    FRICTION,
    FRICTION_TERMS,
    TENSION,
    TENSION_RATE,
    ForceSignals,
    force_signals,
)
from state_estimation.motors import Motors

Array = NDArray[np.float64]

PASSES = 6
"""passes in which friction and lag are estimated (docs/thresholds.md)"""
MIN_LAG_S, MAX_LAG_S = 1e-6, 0.5
"""s, of a cable behind its force: ca / k; Fasquelle's worst is 805 / 10454 = 0.08 s (docs/thresholds.md)"""


@dataclass(frozen=True)
class ElongationLaw:
    """Signals with the lag and the friction of each cable, which give regressors X."""

    arm: Arm
    motors: Motors
    """whose speeds within the rows, where they have any, friction is taken at"""
    signals: ForceSignals
    """of these motors"""
    lag: Array
    """of a cable behind its force, (M,), s"""
    friction: Array
    """sizes of friction's terms, which are taken off the force, (M, FRICTION_TERMS)"""

    def at(self, time: Array) -> Array:
        """X at times (F,) within the log, each column of mean square 1 over the log, shape (F, M, P)."""
        return self.sampled(time)[0]

    def sampled(self, time: Array) -> tuple[Array, Array]:
        """X as `at` gives it, and the sizes (M, P) that its columns were divided by."""
        columns, sizes = [], []
        signals = self.signals.lagged(self.lag)
        tension = signals.tension(self.friction)
        for whole in signals.regressors(tension - tension.mean(axis=0)):
            size = np.sqrt(np.mean(whole**2, axis=0))
            sizes.append(np.where(size > 0, size, 1.0))
            columns.append(interpolated(time, signals.time, whole) / sizes[-1])
        return np.stack(columns, axis=-1), np.stack(sizes, axis=-1)

    def corrected(self, beta: Array) -> "ElongationLaw":
        """The law with the friction and the lag that factors beta (M, P) of its regressors, not divided by sizes, ask for."""
        lag, friction = self.lag.copy(), self.friction.copy()
        for j, of_cable in enumerate(beta):
            if of_cable[TENSION] > 0:
                friction[j] -= of_cable[FRICTION] / of_cable[TENSION]
                lag[j] = np.clip(lag[j] - of_cable[TENSION_RATE] / of_cable[TENSION], MIN_LAG_S, MAX_LAG_S)
        return replace(self, lag=lag, friction=friction)

    @property
    def with_own_friction(self) -> "ElongationLaw":
        """The law with speeds within the rows as its own friction makes them by the motors' equations."""
        dry, _, *bent, viscous = self.friction.T
        dry = dry - np.sum(bent, axis=0)
        motors = self.motors.with_friction(self.arm, dry, viscous)
        return replace(self, motors=motors, signals=force_signals(self.arm, motors))


def left_by(X: Array, x: Array) -> Array:
    """What regressors X (F, M, P) leave of elongations x (F, M), m, by least squares of each cable: (F, M), m."""
    explained = [X[:, j] @ np.linalg.lstsq(X[:, j], x[:, j], rcond=None)[0] for j in range(x.shape[1])]
    return x - np.stack(explained, axis=-1)


def law_of(arm: Arm, motors: Motors, seen_time: Array, seen_x: Array) -> ElongationLaw:
    """The law whose friction and lag fit elongations seen_x (F, M), m, at seen_time (F,), s, best."""
    law = ElongationLaw(
        arm=arm,
        motors=motors,
        signals=force_signals(arm, motors),
        lag=np.full(arm.M, MIN_LAG_S),
        friction=np.zeros((arm.M, FRICTION_TERMS)),
    )
    return fitted(law, seen_time, seen_x)


def fitted(law: ElongationLaw, seen_time: Array, seen_x: Array) -> ElongationLaw:
    """The law with the friction and the lags that fit elongations seen_x (F, M), m, at seen_time (F,), s, best."""
    for _ in range(PASSES - 1):
        X, size = law.sampled(seen_time)
        beta = [np.linalg.lstsq(X[:, j], seen_x[:, j], rcond=None)[0] for j in range(law.arm.M)]
        law = law.corrected(np.stack(beta) / size)
    return law
