"""What the motor force explains of the elongations, in absolute terms, so that one recording's law can be held against another's.

x = X beta: c0, the force t that reaches the cable with its square, cube, rate and slow parts, the rate of n = f - Ia (R/rd) theta''
(a late force), and friction where it was taken off n wrongly (dry, its transition, viscous). Forces count in NEWTON.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.filters import first_order_lag, low_pass
from mechanism.arm import Arm
from mechanism.friction import CM, dry
from state_estimation.elongation_law import PASSES
from state_estimation.elongation_regressors import CREEP_S, CUTOFF_HZ
from state_estimation.motors import Motors

Array = NDArray[np.float64]

NEWTON = 50.0
"""N: brings forces to the size of one"""
SPREAD = np.array([0.1, 0.03, 0.01, 0.003, 5e-4, *([3e-3] * len(CREEP_S)), 2e-4, 3e-3, 2e-3, 1e-5])
"""how far each regressor may move a cable before the data speak (standard deviation): m, m s for rates, m s/rad"""
FIRST_NOISE_M = 5e-5
"""m: of an elongation, while friction is sought"""
FRICTION = 3
"""regressors at the end that are friction's"""


@dataclass(frozen=True)
class Regressors:
    """X (F, M, P) at the frames, the force t (F, M), N, and the friction that was taken off, (M, FRICTION), N."""

    X: Array
    force: Array
    friction: Array


def regressors(arm: Arm, motors: Motors, time: Array, x: Array, friction: Array | None = None) -> Regressors:
    """At frames (F,), s, with elongations x (F, M), m; friction as found here, unless it is known from a baseline."""
    rate = 1 / float(np.mean(np.diff(motors.time)))
    turn = CM * motors.theta_d
    raw = [motors.f - arm.motor_inertia / arm.drum * motors.theta_dd, dry(motors.theta_d), turn / (1 + turn**2)]
    n, rubbing, transition = (low_pass(part, rate, CUTOFF_HZ) for part in raw)
    n = n / NEWTON
    late = np.gradient(n, 1 / rate, axis=0)
    rubs = (rubbing, transition, motors.theta_d)
    taken = np.zeros((arm.M, FRICTION)) if friction is None else friction / NEWTON
    for _ in range(PASSES if friction is None else 0):
        X = _stretched(time, motors.time, n, late, rubs, taken)
        for j in range(arm.M):
            beta = _ridge(X[:, j], x[:, j])
            # at the mean force, where the slope is that of the cable
            mean = float(X[:, j, 1].mean())
            slope = beta[1] + 2 * mean * beta[2] + 3 * mean**2 * beta[3] + beta[5 : 5 + len(CREEP_S)].sum()
            if slope > 0:
                taken[j] = taken[j] - beta[-FRICTION:] / slope
    X = _stretched(time, motors.time, n, late, rubs, taken)
    return Regressors(X, X[..., 1] * NEWTON, taken * NEWTON)


def _stretched(time: Array, even: Array, n: Array, late: Array, rubs: tuple[Array, ...], taken: Array) -> Array:
    """X at frames (F,) from signals at even times (T,); friction `taken` (M, FRICTION) off n, in NEWTON."""
    rate = 1 / float(np.mean(np.diff(even)))
    t = n - sum(part * share for part, share in zip(rubs, taken.T, strict=True))

    def regressors() -> Iterator[Array]:
        """One at a time: all of them would be most of memory."""
        yield np.ones_like(t)
        yield t
        yield t**2
        yield t**3
        yield np.gradient(t, 1 / rate, axis=0)
        for tau in CREEP_S:
            yield first_order_lag(t, rate, tau)
        yield late
        yield from rubs

    return np.stack([np.stack([np.interp(time, even, c) for c in whole.T], axis=-1) for whole in regressors()], axis=-1)


def _ridge(D: Array, y: Array) -> Array:
    normal = D.T @ D / FIRST_NOISE_M**2 + np.diag(SPREAD**-2.0)
    return np.asarray(np.linalg.solve(normal, D.T @ y / FIRST_NOISE_M**2), dtype=float)
