"""How far angles scatter from frame to frame, told by the frames alone.

A joint's motion dies away towards high frequencies, and white noise does not. A least-squares spline with fewer knots than frames
follows the motion up to some frequency and leaves the noise above it. Splines with more knots leave less of fast motion, and less
noise to tell it by: the coarsest spline is taken whose remainder no finer one denies (Lepski's rule). Where all of them deny one
another, motion is faster than the frames show, and only an upper bound is known.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from state_estimation.banded import banded_cholesky, inverse_windows
from state_estimation.smoother import BANDWIDTH, normal_equations
from state_estimation.spline import SUPPORT, knots_over

Array = NDArray[np.float64]

KNOTS_PER_FRAME = (0.4, 0.5, 0.6, 0.7, 0.8, 0.88)
"""of the splines, from coarse to fine: at 30 frames a second they follow 6 to 13 Hz (docs/thresholds.md)"""
DENIAL_SIGMAS = 2.0
"""standard deviations by which a finer spline must leave less variance, to deny a coarser one (docs/thresholds.md)"""
MIN_FREEDOM = 60.0
"""degrees of freedom below which the frames are too few to tell their noise (docs/thresholds.md)"""
OUTLYING_SIGMAS = 6.0
"""residuals of robust standard deviations beyond which a frame is left out (docs/thresholds.md)"""
MAX_OUTLYING_SHARE = 0.1
"""share of the frames that may be left out: where more stand out they are the noise (docs/thresholds.md)"""
MIN_NOISE_RAD = 1e-5
"""rad: no camera tells an angle better (docs/thresholds.md)"""
MOTION_HZ = 3.0
"""Hz: splines that follow less leave the motion itself (docs/thresholds.md)"""
RESONANCE_HZ, RESONANCE_RAD = 10.0, np.radians(0.05)
"""Hz, rad: an arm on its cables swings by itself up to this frequency; where no spline follows that, only a noise as large as this
is told from it (docs/thresholds.md)"""
CORRELATED_SIGMAS = 4.0
"""standard deviations of chance from which on the noise of two joints is correlated (docs/thresholds.md)"""
_NORMAL_MEDIAN = 0.6745
"""median of the absolute value of a normal variable of variance 1"""
_LEAST_SHARE = 0.01
"""of one joint's variance: no sum of joints is told better"""
_RIDGE = 1e-9
"""relative: holds coefficients that no frame measures"""


@dataclass(frozen=True)
class FrameNoise:
    """Of N joints."""

    ratio: Array
    """(N,): true over stated noise; NaN where the frames cannot tell"""
    ratio_sigma: Array
    """(N,): standard deviation of `ratio` by chance; NaN where the frames cannot tell"""
    bound: Array
    """(N,): what the ratio is at most, but for chance; infinite where the frames are too few"""
    outlying: Array
    """(F, N), rad: distance of a frame that stands out, zero elsewhere"""


def frame_noise(time: Array, alpha: Array, sigma: Array) -> FrameNoise:
    """The noise of angles (F, N), rad, NaN where not seen, at camera times (F,), s, over what sigma (F, N), rad, states."""
    joints = [_of_joint(time, a, s) for a, s in zip(alpha.T, sigma.T, strict=True)]
    ratio, ratio_sigma, bound, outlying = (np.stack(part, axis=-1) for part in zip(*joints, strict=True))
    return FrameNoise(ratio, ratio_sigma, bound, outlying)


def noise_correlation(time: Array, alpha: Array, sigma: Array) -> Array:
    """Correlation (N, N) of the noise of angles (F, N), rad, all known, at camera times (F,), s; sigma (F, N), rad, as stated.

    Who sees bars tells each joint by two of them, and what makes one joint's angle too large makes its neighbour's too small. Told
    by what splines through the frames leave, of the coarsest that no finer one denies for any joint; of independent noise where
    frames are too few or too far apart, motion is too fast, or chance explains it."""
    independent = np.eye(alpha.shape[1])
    if len(time) < MIN_FREEDOM or KNOTS_PER_FRAME[-1] * 0.5 / np.median(np.diff(time)) < RESONANCE_HZ:
        return independent  # what joints have in common may be motion
    of_joints = [_fits(time, a - a.mean(), r) for a, r in zip(alpha.T, sigma.T**2, strict=True)]
    # the finest has none that could deny it
    for i in range(min(len(fits) for fits in of_joints) - 1):
        if not any(_denied(*_variance_and_freedom(fits[i:])) for fits in of_joints):
            residual, free = (np.stack(part, axis=1) for part in zip(*(fits[i] for fits in of_joints), strict=True))
            told = np.corrcoef(residual, rowvar=False).reshape(independent.shape)
            by_chance = CORRELATED_SIGMAS / np.sqrt(free.sum(axis=0).min())
            return _invertible(told) if np.any(np.abs(told - independent) > by_chance) else independent
    return independent


def _invertible(correlation: Array) -> Array:
    """The nearest to it in which no sum of joints is told far better than by chance, (N, N)."""
    value, vector = np.linalg.eigh(correlation)
    out = vector * np.maximum(value, _LEAST_SHARE) @ vector.T
    size = np.sqrt(np.diag(out))
    return out / np.outer(size, size)


def _of_joint(time: Array, alpha: Array, sigma: Array) -> tuple[Array, Array, Array, Array]:
    known = np.flatnonzero(np.isfinite(alpha))
    outlying, nan = np.zeros(len(time)), np.array(np.nan)
    if len(known) < MIN_FREEDOM:
        return nan, nan, np.array(np.inf), outlying
    t, y, r = time[known], alpha[known] - np.mean(alpha[known]), sigma[known] ** 2
    distance = _outlying(t, y, r)
    kept = distance == 0
    outlying[known] = distance
    fits = _fits(t[kept], y[kept], r[kept])
    if not fits:
        return nan, nan, np.array(np.inf), outlying
    unit, half_rate = np.sqrt(np.median(r)), 0.5 / np.median(np.diff(t))
    least = (MIN_NOISE_RAD / unit) ** 2
    variance, freedom = _variance_and_freedom(fits)
    variance = np.maximum(variance, least)
    bound = np.sqrt(variance[-1])
    chosen = next(i for i in range(len(fits)) if not _denied(variance[i:], freedom[i:]))
    ratio = np.sqrt(variance[chosen])
    if KNOTS_PER_FRAME[len(fits) - 1] * half_rate < RESONANCE_HZ:
        agreed = chosen < len(fits) - 1 and KNOTS_PER_FRAME[chosen] * half_rate >= MOTION_HZ
        if not (agreed and ratio * unit >= RESONANCE_RAD):
            return nan, nan, bound, outlying
    return ratio, ratio / np.sqrt(2 * freedom[chosen]), bound, outlying


def _fits(t: Array, y: Array, r: Array) -> list[tuple[Array, Array]]:
    """`_remainder` of splines from coarse to fine, as far as frames are enough."""
    fits = (_remainder(t, y, r, share) for share in KNOTS_PER_FRAME)
    return [(residual, free) for residual, free in fits if np.sum(free) >= MIN_FREEDOM]


def _variance_and_freedom(fits: Sequence[tuple[Array, Array]]) -> tuple[Array, Array]:
    """Of each fit, over what is stated: what it leaves, and by how many independent frames that is told."""
    freedom = np.array([np.sum(free) for _, free in fits])
    return np.array([np.sum(residual**2) for residual, _ in fits]) / freedom, freedom


def _denied(variance: Array, freedom: Array) -> bool:
    """Whether the first of these variances exceeds any of finer splines by more than chance."""
    # a finer spline leaves a part of what the coarser one leaves, so the variance of the difference is that of the variances
    chance = variance[1:] * np.sqrt(2 / freedom[1:] - 2 / freedom[0])
    return bool(np.any(variance[0] - variance[1:] > DENIAL_SIGMAS * chance))


def _remainder(t: Array, y: Array, r: Array, share: float) -> tuple[Array, Array]:
    """What a spline with `share` knots per frame leaves of y (F,) of variance r, over its sigma, and the freedom of each frame."""
    knots = knots_over(t[0], t[-1], float(np.median(np.diff(t))) / share)
    band, right = normal_equations(knots, t, y, r)
    band[0] += _RIDGE * np.max(band[0])
    cholesky = banded_cholesky(band)
    first, weights = knots.rows(t)
    local = cholesky.solve(right)[first[:, None] + np.arange(SUPPORT)]
    taken = np.empty(len(t))
    for rows, window in inverse_windows(cholesky, BANDWIDTH, first, SUPPORT):
        taken[rows] = np.einsum("ta,tab,tb->t", weights[rows], window, weights[rows])
    return (y - np.sum(weights * local, axis=1)) / np.sqrt(r), 1 - taken / r


def _outlying(t: Array, y: Array, r: Array) -> Array:
    """Distance, rad, of frames (F,) that stand out of a spline through the others, zero elsewhere."""
    out = np.zeros(len(t), dtype=bool)
    distance = np.zeros(len(t))
    while True:
        kept = np.flatnonzero(~out)
        residual, free = _remainder(t[kept], y[kept], r[kept], KNOTS_PER_FRAME[1])
        # what the spline would miss a frame by that it did not know
        missed = np.abs(residual) / np.maximum(free, 0.05)
        score = np.abs(residual) / np.sqrt(np.maximum(free, 0.05))
        robust = max(float(np.median(score)) / _NORMAL_MEDIAN, MIN_NOISE_RAD / float(np.sqrt(np.median(r))))
        # an outlying frame draws its neighbours' splines with it: of those near each other the one that stands out most
        highest = score >= np.max([np.roll(score, k) for k in range(-3, 4)], axis=0)
        found = highest & (score > OUTLYING_SIGMAS * robust)
        if not np.any(found):
            return distance
        distance[kept[found]] = (missed * np.sqrt(r[kept]))[found]
        out[kept[found]] = True
        if np.mean(out) > MAX_OUTLYING_SHARE:
            return np.zeros(len(t))
