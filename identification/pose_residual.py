"""What the fit of the pose left of the frames beyond their noise: how much, how much of it lasts, and how fast it changes.

Noise of a camera differs from frame to frame, and what a model lacks does not. So products of two frames' residuals tell what is
left, in the mean of many. Noise alone leaves something of them by chance, of a size that is known: it is taken off.
"""

import numpy as np
from numpy.typing import NDArray

from identification.filters import low_pass

Array = NDArray[np.float64]

_SHARED_S = 0.14
"""s by which frames are apart at most whose products tell what is left (docs/thresholds.md)"""
_CHANCE_SIGMAS, _RATE_CHANCE_SIGMAS = 1.0, 2.0
"""of chance, that are taken off what is left, and off how fast it changes (docs/thresholds.md)"""
_LASTS_FROM_S, _LASTS_TO_S = 2.0, 10.0
"""s by which frames are apart whose products tell what lasts (docs/thresholds.md)"""
_CHANGE_SHARE = 0.1
"""of the frames' rate, up to which changes of the residual are told (docs/thresholds.md)"""
_FASTER = 2.0
"""variance of all changes over that of those which are told (docs/thresholds.md)"""


def frame_step(time: Array) -> float:
    """s from one of the frames at times (F,), s, to the next, as most are; 1 where there is one frame."""
    return max(float(np.median(np.diff(time))), 1e-9) if len(time) > 1 else 1.0


def rms_beyond_noise(angles: Array, noise: Array, held: Array, step: float) -> Array:
    """What is left of angles (F, N), rad, NaN where not seen, beyond their noise, (N,), rad.

    noise, held: variances (F, N), rad^2, of a frame and by what friction holds: the larger this one is, the less a frame says.
    step: s, from frame to frame.
    """
    out, lags = [], max(1, round(_SHARED_S / step))
    for own, square, weight in zip(angles.T, noise.T, (noise / (noise + held)).T, strict=True):
        total = weights = chance = 0.0
        for lag in range(1, min(lags, len(own) - 1) + 1):
            both = np.isfinite(own[lag:]) & np.isfinite(own[:-lag])
            each = np.sqrt(weight[lag:] * weight[:-lag])[both]
            total += float(np.sum((own[lag:] * own[:-lag])[both] * each))
            chance += float(np.sum((square[lag:] * square[:-lag])[both] * each**2))
            weights += float(np.sum(each))
        shared = (total - _CHANCE_SIGMAS * np.sqrt(chance)) / weights if weights else float(np.mean(square))
        out.append(np.sqrt(max(shared, 0.0)))
    return np.array(out)


def lasting_rms(residual: Array, time: Array) -> Array:
    """The part of residuals (F, N), rad, NaN where not seen, at times (F,), s, that is the same seconds later, rms, (N,), rad.

    What follows the pose has another value then as often as not, and cancels in the mean; what drifts does not.
    """
    step = frame_step(time)
    lags = np.unique(np.linspace(_LASTS_FROM_S, _LASTS_TO_S, 60) / step).astype(int)
    total, count = np.zeros(residual.shape[1]), np.zeros(residual.shape[1])
    for lag in lags[lags < len(residual)]:
        products = residual[lag:] * residual[:-lag]
        total += np.nansum(products, axis=0)
        count += np.sum(np.isfinite(products), axis=0)
    return np.sqrt(np.maximum(total, 0.0) / np.maximum(count, 1))


def residual_rate(residual: Array, alpha: Array, time: Array) -> tuple[Array, Array]:
    """How fast residuals (F, N), rad, NaN where not seen, change, rms, (N,), rad/s; and along a radian of motion, (N,).

    alpha: angles of the frames, (F, N), rad; time: (F,), s. Frames tell changes that are slower than a tenth of their rate: a
    swinging arm is faster, of which the state that frames were smoothed to holds a part only. What play and friction leave jumps,
    and rates of jumps are as large at all frequencies: what is faster is taken for as much as is told.
    """
    step = frame_step(time)
    at = np.arange(time[0], time[-1], step)
    moved = [np.gradient(_slow(_at_times(at, time, column), step), step) for column in alpha.T]
    motion = float(np.mean(np.sum(np.square(moved), axis=0)))
    rate = np.sqrt(_FASTER) * np.array([_rate_beyond_noise(_at_times(at, time, own), step) for own in residual.T])
    return rate, rate / np.sqrt(motion) if motion > 0 else np.zeros_like(rate)


def _rate_beyond_noise(residual: Array, step: float) -> float:
    """How fast a residual (F,), rad, changes beyond what its noise makes of it, rms, rad/s.

    Noise is white, and no less than changes from frame to frame show."""
    count = len(residual)
    impulse = np.zeros(count)
    impulse[count // 2] = 1.0
    noise = float(np.mean(np.diff(residual) ** 2)) / 2 * float(np.sum(np.gradient(_slow(impulse, step), step) ** 2))
    # rates of noise grow with frequency, so that 5/9 of the band holds as many independent values as all of it
    by_chance = noise * np.sqrt(2 / max(2 * 5 / 9 * _CHANGE_SHARE * count, 1.0))
    rate = float(np.mean(np.gradient(_slow(residual, step), step) ** 2))
    return float(np.sqrt(max(rate - noise - _RATE_CHANCE_SIGMAS * by_chance, 0.0)))


def _slow(values: Array, step: float) -> Array:
    """Values (F,) without what is faster than the share of the frames' rate that is told."""
    return low_pass(values[:, None], 1 / step, _CHANGE_SHARE / step)[:, 0]


def _at_times(at: Array, time: Array, values: Array) -> Array:
    """Values (F,) at other times, between those that are known; zero where none is."""
    known = np.isfinite(values)
    return np.interp(at, time[known], values[known]) if known.any() else np.zeros_like(at)
