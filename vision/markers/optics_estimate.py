"""The recording's blur and ink bleed from the markers of its first frames."""

from collections.abc import Sequence

import numpy as np

from vision.markers.photometric import MarkerFit
from vision.markers.template import Optics

MARKER_SCATTER_PX = 0.03
"""px: standard deviation of blur and bleed from marker to marker, by focus and ink (docs/thresholds.md)"""


def estimate_optics(start: Optics, fits: Sequence[MarkerFit]) -> Optics:
    """Weighted means over the fits of sharp and whole markers; `start`, from which all fits began, where there are none.

    The fits must have begun with wide standard deviations of the optics, as their prior is counted with each of them.
    """
    usable = [f for f in fits if f.is_clear]
    if not usable:
        return start
    values = np.array([[f.sigma, f.bleed] for f in usable])
    precision = np.array([f.optics_sd for f in usable]) ** -2.0
    mean = np.sum(precision * values, axis=0) / precision.sum(axis=0)
    scatter = np.sum(precision * (values - mean) ** 2, axis=0) / precision.sum(axis=0)
    sd = np.sqrt(MARKER_SCATTER_PX**2 + 1 / precision.sum(axis=0) + scatter)
    return Optics(
        sigma=float(mean[0]), bleed=float(mean[1]), sigma_sd=float(sd[0]), bleed_sd=float(sd[1]), tone=start.tone
    )
