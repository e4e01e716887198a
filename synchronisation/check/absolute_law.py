"""What the motor force explains of the elongations, in absolute terms, so that laws of two recordings can be compared.

x = X beta with the regressors of state_estimation.elongation_regressors. Forces are counted in NEWTON and no column is scaled or
centred, so that beta means the same in every recording and has a prior.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import interpolated
from mechanism.arm import Arm
from mechanism.bristles import BEND_WIDTHS_RAD
from state_estimation.elongation_law import MAX_LAG_S, MIN_LAG_S, PASSES
from state_estimation.elongation_regressors import (
    CREEP,
    CREEP_S,
    FRICTION,
    FRICTION_TERMS,
    TENSION,
    TENSION_RATE,
    ForceSignals,
    force_signals,
)
from state_estimation.motors import Motors

Array = NDArray[np.float64]

NEWTON = 50.0
"""N: brings forces to the size of one"""
_CREEP_SIGMA, _BEND_SIGMA = [3e-3] * len(CREEP_S), [3e-3] * len(BEND_WIDTHS_RAD)
BETA_SIGMA = np.array([0.1, 0.03, 0.01, 0.003, 5e-4, 2e-4, *_CREEP_SIGMA, 3e-3, 2e-3, *_BEND_SIGMA, 1e-5])
"""prior standard deviation of beta, (P,): m for each NEWTON of force, m s for rates, m for friction, m s/rad for the viscous one
(docs/thresholds.md)"""
MIN_FORCE_SPREAD = 0.05
"""of the spread of the force that changes most: one that changes less tells nothing of its cable (docs/thresholds.md)"""
ELONGATION_SIGMA_M = 5e-5
"""m: of an elongation, while friction is estimated (docs/thresholds.md)"""


@dataclass(frozen=True)
class CableForces:
    """Between a motor's force and its cable's elongation: what the law is not linear in."""

    friction: Array
    """sizes of friction's terms, which are taken off the force, (M, FRICTION_TERMS), N"""
    lag: Array
    """of a damped cable behind its force, (M,), s"""


@dataclass(frozen=True)
class AbsoluteLaw:
    """The regressors at the frames, and what they were computed with."""

    X: Array
    """(F, M, P)"""
    tension: Array
    """force less friction, (F, M), N"""
    forces: CableForces
    untold: NDArray[np.bool_]
    """cables whose force hardly changes, (M,): it does not tell how far they stretch, nor what friction takes off it"""


def absolute_law(arm: Arm, motors: Motors, time: Array, x: Array, forces: CableForces | None = None) -> AbsoluteLaw:
    """At frames (F,), s, with elongations x (F, M), m.

    forces: what a baseline gives; estimated from x where there is none.
    """
    signals = force_signals(arm, motors).in_unit(NEWTON)
    spread = np.std(motors.f, axis=0)
    untold = spread < MIN_FORCE_SPREAD * spread.max()
    if forces is None:
        forces = _estimated(signals, time, x, untold)
    X = _sampled(signals, forces, time)
    return AbsoluteLaw(X, X[..., TENSION] * NEWTON, forces, untold)


def _estimated(signals: ForceSignals, time: Array, x: Array, untold: NDArray[np.bool_]) -> CableForces:
    """Friction and lags that fit elongations x (F, M), m, at frames (F,), s, best; none of `untold` cables (M,)."""
    M = x.shape[1]
    friction, lag = np.zeros((M, FRICTION_TERMS)), np.full(M, MIN_LAG_S)
    for _ in range(PASSES):
        X = _sampled(signals, CableForces(friction * NEWTON, lag), time)
        for j in np.flatnonzero(~untold):
            beta = _ridge(X[:, j], x[:, j])
            # dx/dt of the lasting elongation at the mean tension
            t = float(X[:, j, TENSION].mean())
            slope = beta[TENSION] + 2 * t * beta[TENSION + 1] + 3 * t**2 * beta[TENSION + 2] + beta[CREEP].sum()
            if slope > 0:
                friction[j] -= beta[FRICTION] / slope
                lag[j] = np.clip(lag[j] - beta[TENSION_RATE] / slope, MIN_LAG_S, MAX_LAG_S)
    return CableForces(friction * NEWTON, lag)


def _sampled(signals: ForceSignals, forces: CableForces, time: Array) -> Array:
    """X (F, M, P) at times (F,), s."""
    lagged = signals.lagged(forces.lag)
    columns = lagged.regressors(lagged.tension(forces.friction / NEWTON))
    return np.stack([interpolated(time, lagged.time, column) for column in columns], axis=-1)


def _ridge(X: Array, x: Array) -> Array:
    normal = X.T @ X / ELONGATION_SIGMA_M**2 + np.diag(BETA_SIGMA**-2.0)
    return np.asarray(np.linalg.solve(normal, X.T @ x / ELONGATION_SIGMA_M**2), dtype=float)
