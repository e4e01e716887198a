"""What a camera with a clock of its own says of the joints: means over exposures, white noise, frames that are missing."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from samples.forward_arms.plant import Array
from samples.forward_arms.settings import Settings


@dataclass(frozen=True)
class Film:
    """Of the frames that arrived, F."""

    stamp: Array
    """(F,), s, camera clock, at mid-exposure"""
    log_time: Array
    """(F,), s: offset + (1 + skew) stamp"""
    mean: Array
    """(F, N), rad, true angle over the exposure"""
    seen: Array
    """(F, N), rad, with noise"""
    offset: float
    skew: float
    exposure: float
    noise: float
    dropped: int


def film(settings: Settings, time: Array, alpha: Array, alpha_d: Array, rng: np.random.Generator) -> Film:
    """Of true angles and speeds (steps, N) at log times `time`."""
    offset, skew = rng.uniform(*settings.offset), 1e-6 * rng.uniform(*settings.skew_ppm)
    exposure, noise = rng.uniform(*settings.exposure), np.radians(settings.noise_deg)
    stamp = np.arange(int(settings.seconds * settings.camera_rate)) / settings.camera_rate
    log_time = offset + (1 + skew) * stamp
    within = (log_time - exposure / 2 >= time[0]) & (log_time + exposure / 2 <= time[-1])
    arrived = within & (rng.random(len(stamp)) >= settings.dropped)
    area = CubicHermiteSpline(time, alpha, alpha_d, axis=0).antiderivative()
    stamp, log_time = stamp[arrived], log_time[arrived]
    mean = (area(log_time + exposure / 2) - area(log_time - exposure / 2)) / exposure
    seen = mean + noise * rng.standard_normal(mean.shape)
    return Film(
        stamp=stamp,
        log_time=log_time,
        mean=mean,
        seen=seen,
        offset=offset,
        skew=skew,
        exposure=exposure,
        noise=noise,
        dropped=int(within.sum() - arrived.sum()),
    )
