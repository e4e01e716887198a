"""The noise of single frames' angles as the frames themselves tell it.

Compression disturbs neighbouring markers, and the parts of a marker, together: what grey levels and the linkage's residuals leave
says too little of it, half and less at usual rates. Frame after frame it is drawn anew, and motion is not: the scatter of the
angles about a smooth motion measures it, whatever the codec.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from synchronisation.frame_noise import frame_noise
from vision.linkage.linkage_fit import LinkageFit

Array = NDArray[np.float64]

MIN_EXCESS_SIGMAS = 2.0
"""standard deviations by chance, by which the frames must scatter more than stated for sigma to follow (docs/thresholds.md)"""


def with_noise_by_frames(fit: LinkageFit, time: Array) -> LinkageFit:
    """The fit with its noise as large as the angles of frames at times (F,), s, scatter, where these scatter more than it says."""
    if fit.noise is None:
        return fit
    stated = np.sqrt(np.diagonal(fit.noise, axis1=1, axis2=2))
    factor = noise_factor(time, fit.alpha, np.where(np.isnan(fit.alpha), np.nan, stated))
    noise = fit.noise * np.outer(factor, factor)
    return replace(
        fit, noise=noise, covariance=fit.covariance - fit.noise + noise, noise_by_frames=tuple(factor.tolist())
    )


def noise_factor(time: Array, angles: Array, sigma: Array) -> Array:
    """By how much angles (F, n), rad, NaN where not known, scatter about a smooth motion more than sigma (F, n) says, (n,)."""
    told = frame_noise(time, angles, sigma)
    plain = np.nan_to_num(told.ratio - 1) > MIN_EXCESS_SIGMAS * np.nan_to_num(told.ratio_sigma, nan=np.inf)
    return np.where(plain, told.ratio, 1.0)
