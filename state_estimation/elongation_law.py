"""What the motor force explains of a cable's elongation.

x = X beta + e. X holds the force t that reaches the cable (f less motor inertia and friction), behind by the lag of a spring
beside a damper: itself, its square and cube (stiffening), its rate (what the lag is wrong by), its slow parts (creep); the
rate of f (a late command); dry friction with an uncertain transition, and viscous friction (what was taken off wrongly). Friction
and lag are found in passes. What is left, e, wanders (see wander.py).
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, lfilter, sosfiltfilt

from mechanism.arm import Arm
from mechanism.friction import CM

Array = NDArray[np.float64]

CREEP_S = (1.5, 6.0)
"""time constants of the force's slow parts"""
PASSES = 6
"""that friction and lag are found in: three left 8 um of a damped cable's millimetre, six no more than the encoder's noise"""
CUTOFF = 20.0
"""Hz: low-pass of the force's parts; wider than the motion, narrower than what a reversal of friction does to each of them"""
EVEN = 1e-4
"""change of CM theta' over a step below which its middle will do"""
LEAST_LAG_S, MOST_LAG_S = 1e-6, 0.1
"""of a cable behind its force: ca / k; Fasquelle's worst is 805 / 10454 = 0.08 s"""


@dataclass(frozen=True)
class ElongationLaw:
    """Even times (T,), s, and what regressors X come from there, each (T, M)."""

    time: Array
    n: Array
    """force less the motor's inertia"""
    commanded: Array
    rubbing: tuple[Array, ...]
    lag: Array
    """of a cable behind its force, (M,), s"""
    taken: Array
    """of friction's parts from n, for what reaches the cable, (M, 3)"""

    def at(self, time: Array) -> Array:
        """X at times (F,) within, each of mean square 1 over all, shape (F, M, P)."""
        return self.sampled(time)[0]

    def sampled(self, time: Array) -> tuple[Array, Array]:
        """The same, and the size (M, P) that each was divided by. One regressor at a time: all of them would be most of memory."""
        columns, sizes = [], []
        for whole in self._regressors():
            size = np.sqrt(np.mean(whole**2, axis=0))
            sizes.append(np.where(size > 0, size, 1.0))
            columns.append(np.stack([np.interp(time, self.time, c) for c in whole.T], axis=-1) / sizes[-1])
        return np.stack(columns, axis=-1), np.stack(sizes, axis=-1)

    def _regressors(self) -> Iterator[Array]:
        rate = 1 / float(np.mean(np.diff(self.time)))
        rubbing = [slow(part, rate, self.lag) for part in self.rubbing]
        t = slow(self.n, rate, self.lag) + sum(part * taken for part, taken in zip(rubbing, self.taken.T, strict=True))
        t = t - t.mean(axis=0)
        yield np.ones_like(t)
        yield t
        yield t**2
        yield t**3
        yield np.gradient(t, 1 / rate, axis=0)
        yield np.gradient(slow(self.commanded, rate, self.lag), 1 / rate, axis=0)
        for tau in CREEP_S:
            yield slow(t, rate, tau)
        yield from rubbing


def law_of(arm: Arm, time: Array, theta_d: Array, f: Array, seen_time: Array, seen_x: Array) -> ElongationLaw:
    """At even times (T,), from motor speeds and forces (T, M), and elongations seen (F, M), m."""
    rate = 1 / float(np.mean(np.diff(time)))
    # a command is held over its step, so all else is its mean over it: friction turns over within less than a step
    n = f[:-1] - arm.motor_inertia / arm.drum * np.diff(theta_d, axis=0) * rate
    n, commanded, *rubbing = (between(low_pass(part, rate)) for part in (n, f[:-1], *rubs(theta_d)))
    law = ElongationLaw(time, n, commanded, tuple(rubbing), np.full(arm.M, LEAST_LAG_S), np.zeros((arm.M, 3)))
    for _ in range(PASSES - 1):
        seen, size = law.sampled(seen_time)
        lag, taken = law.lag.copy(), law.taken.copy()
        for j in range(arm.M):
            beta = np.linalg.lstsq(seen[:, j], seen_x[:, j], rcond=None)[0] / size[j]
            if beta[1] > 0:
                taken[j] += beta[-3:] / beta[1]
                lag[j] = np.clip(lag[j] - beta[4] / beta[1], LEAST_LAG_S, MOST_LAG_S)
        law = replace(law, lag=lag, taken=taken)
    return law


def rubs(theta_d: Array) -> tuple[Array, Array, Array]:
    """Means over each step of dry friction, its transition and the speed (T - 1, M), from speeds (T, M) straight between."""
    turn = CM * theta_d
    softened = np.log1p(turn**2) / 2
    change = np.diff(turn, axis=0)
    even = np.abs(change) < EVEN
    over = np.where(even, 1.0, change)
    middle = (turn[1:] + turn[:-1]) / 2
    # integrals of atan(u) and of u / (1 + u^2)
    dried = np.where(even, np.arctan(middle), np.diff(turn * np.arctan(turn) - softened, axis=0) / over)
    transition = np.where(even, middle / (1 + middle**2), np.diff(softened, axis=0) / over)
    return 2 / np.pi * dried, transition, middle / CM


def between(means: Array) -> Array:
    """Values (T, M) at the ends of steps from means over them (T - 1, M), smooth ones: exact for cubics."""
    padded = np.pad(means, ((2, 2), (0, 0)), mode="edge")
    return (7 * (padded[1:-2] + padded[2:-1]) - padded[:-3] - padded[3:]) / 12


def low_pass(values: Array, rate: float) -> Array:
    return sosfiltfilt(butter(4, min(CUTOFF / (rate / 2), 0.9), output="sos"), values, axis=0)


def slow(values: Array, rate: float, tau: float | Array) -> Array:
    """(T, M), straight between samples, behind by tau, s, of all columns or of each, (M,)."""
    out = []
    for c, steps in zip(values.T, rate * np.broadcast_to(tau, values.shape[1]), strict=True):
        keep = np.exp(-1 / steps)
        now = 1 - steps * (1 - keep)
        out.append(lfilter([now, 1 - keep - now], [1, -keep], c, zi=[(1 - now) * c[0]])[0])
    return np.stack(out, axis=-1)
