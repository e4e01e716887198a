"""What the motor force explains of a cable's elongation, and how much it leaves.

x = X beta + e. X holds the force t that reaches the cable (f less motor inertia and friction): itself, its square and cube
(stiffening), its rate (damping), its slow parts (creep); the rate of n = f - Ia (R/rd) theta'' (a late force); dry friction
with an uncertain transition, and viscous friction (what was taken off wrongly). Friction is taken off n as a first fit finds
it. What is left, e, is the sum of two Ornstein-Uhlenbeck processes and white noise.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz
from scipy.optimize import minimize
from scipy.signal import butter, lfilter, sosfiltfilt

from identification.banded import factor
from mechanism.arm import Arm
from mechanism.friction import CM, dry

Array = NDArray[np.float64]

CREEP_S = (1.5, 6.0)
"""time constants of the force's slow parts"""
PASSES = 3
"""that friction is found in, before the force is believed"""
LEAST_M = 1e-6
"""m: no error is smaller"""
CUTOFF = 15.0
"""Hz: low-pass of the force's parts; wider than the motion, narrower than what a reversal of friction does to each of them"""
SPREAD_M = 5e-3
"""m: how far any one regressor may move a cable, before the data speak (standard deviation)"""
MEMORY_S = (0.1, 3.0)
"""of the fast and of the slow process"""
TAPS = 4
ENOUGH = 3000
"""samples from the middle that tell the error well enough"""


@dataclass(frozen=True)
class Wander:
    """Two Ornstein-Uhlenbeck processes, one that forgets fast and one that forgets slowly: standard deviations in m.

    As much as the fast one again is new at every sample: what reversals of friction leave.
    """

    fast: float
    slow: float

    def whitener(self, step: float) -> tuple[Array, float]:
        """Filter (TAPS + 1,), newest first, that whitens samples `step` s apart to variance one, and their own sigma."""
        lags = step * np.arange(TAPS + 1)
        covariance = self.fast**2 * np.exp(-lags / MEMORY_S[0]) + self.slow**2 * np.exp(-lags / MEMORY_S[1])
        covariance[0] += self.fast**2
        ahead = solve_toeplitz(covariance[:-1], covariance[1:])
        fresh = np.sqrt(covariance[0] - ahead @ covariance[1:])
        return np.concatenate([[1.0], -ahead]) / fresh, float(np.sqrt(covariance[0]))


@dataclass(frozen=True)
class Law:
    """Even times (T,), s, and the regressors X (T, M, P) there, each of mean square 1."""

    time: Array
    X: Array

    def at(self, time: Array) -> Array:
        """X at other times (F,) within, shape (F, M, P)."""
        flat = self.X.reshape(len(self.time), -1)
        return np.stack([np.interp(time, self.time, column) for column in flat.T], axis=-1).reshape(
            -1, *self.X.shape[1:]
        )


def law_of(arm: Arm, time: Array, theta_d: Array, theta_dd: Array, f: Array, seen_time: Array, seen_x: Array) -> Law:
    """Regressors at even times (T,), from motor speeds, accelerations and forces (T, M), and elongations seen (F, M), m."""
    rate = 1 / float(np.mean(np.diff(time)))
    turn = CM * theta_d
    raw = [f - arm.motor_inertia / arm.drum * theta_dd, dry(theta_d), turn / (1 + turn**2)]
    n, rubbing, transition = (low_pass(part, rate) for part in raw)
    n = n - n.mean(axis=0)
    late = np.gradient(n, 1 / rate, axis=0)
    friction = np.stack([rubbing, transition, theta_d], axis=-1)
    t = n
    law = Law(time, n[..., None])
    for _ in range(PASSES):
        stretch = [t, t**2, t**3, np.gradient(t, 1 / rate, axis=0), *(slow(t, rate, tau) for tau in CREEP_S), late]
        X = np.concatenate([np.ones_like(n)[..., None], np.stack(stretch, axis=-1), friction], axis=-1)
        size = np.sqrt(np.mean(X**2, axis=0))
        law = Law(time, X / np.where(size > 0, size, 1.0))
        seen = law.at(seen_time)
        t = t.copy()
        for j in range(arm.M):
            beta = np.linalg.lstsq(seen[:, j], seen_x[:, j], rcond=None)[0] / size[j]
            if beta[1] > 0:
                t[:, j] += friction[:, j] @ beta[-3:] / beta[1]
        t = t - t.mean(axis=0)
    return law


def low_pass(values: Array, rate: float) -> Array:
    return sosfiltfilt(butter(4, min(CUTOFF / (rate / 2), 0.9), output="sos"), values, axis=0)


def slow(values: Array, rate: float, tau: float) -> Array:
    keep = np.exp(-1 / rate / tau)
    return np.stack([lfilter([1 - keep], [1, -keep], c, zi=[keep * c[0]])[0] for c in values.T], axis=-1)


def fit_wander(time: Array, x: Array, variance: Array, X: Array) -> Wander:
    """The process that makes samples of an elongation x (F,), m, of `variance` (F,) most likely, X (F, P) fitted along."""
    part = slice(max(0, len(time) // 2 - ENOUGH // 2), len(time) // 2 + ENOUGH // 2)
    t, y, r, D = time[part], x[part], variance[part], X[part]
    both = np.column_stack([D, y])
    least = float(np.log(unseen(r)))

    def cost(v: Array) -> float:
        if not (least <= v[0] < -3 and least - 5 <= v[1] < -3):
            return 1e12
        wander = Wander(*np.exp(v))
        noise = r + wander.fast**2
        weighed = both / noise[:, None]
        band, log_determinant = _precision(wander, t)
        band[0] += np.repeat(1 / noise, 2)
        band[1, ::2] += 1 / noise
        found = factor(band)
        twice = np.repeat(weighed, 2, axis=0)
        inner = both.T @ weighed - twice.T @ found.solve(twice)
        normal = inner[:-1, :-1] + np.eye(D.shape[1]) / SPREAD_M**2
        own = np.linalg.solve(normal, inner[:-1, -1])
        return (
            found.log_determinant
            - log_determinant
            + float(np.sum(np.log(noise)))
            + float(np.linalg.slogdet(normal)[1])
            + float(inner[-1, -1] - inner[:-1, -1] @ own)
        )

    start = np.full(2, least + 0.1)
    simplex = start + np.array([[0, 0], [1.0, 0], [0, 1.0]])
    found = minimize(
        cost, start, method="Nelder-Mead", options={"xatol": 0.05, "fatol": 0.1, "initial_simplex": simplex}
    )
    return Wander(*(float(v) for v in np.exp(found.x)))


def unseen(variance: Array) -> float:
    """The largest error, m, that samples of this `variance` (F,) cannot tell from none: the standard error of their variance."""
    return max(float(np.sqrt(np.median(variance)) * (2 / len(variance)) ** 0.25), LEAST_M)


def _precision(wander: Wander, time: Array) -> tuple[Array, float]:
    """Lower band (3, 2 F) of both processes' precision, interleaved, and the logarithm of its determinant."""
    out = np.zeros((3, 2 * len(time)))
    log_determinant = 0.0
    for k, (sigma, memory) in enumerate(zip((wander.fast, wander.slow), MEMORY_S, strict=True)):
        keep = np.exp(-np.diff(time) / memory)
        fresh = sigma**2 * (1 - keep**2)
        own = np.zeros(len(time))
        own[0] = sigma**-2
        own[1:] += 1 / fresh
        own[:-1] += keep**2 / fresh
        out[0, k::2] = own
        out[2, k : 2 * len(time) - 2 : 2] = -keep / fresh
        log_determinant -= 2 * float(np.log(sigma)) + float(np.sum(np.log(fresh)))
    return out, log_determinant
