"""The recording's blur and bleed from the markers of its first frames."""

from collections.abc import Sequence

import numpy as np

from vision.markers.photometric import MarkerFit
from vision.markers.template import Optics

FLOOR = 0.03
"""px: focus and ink differ by as much from marker to marker"""


def pooled(before: Optics, fits: Sequence[MarkerFit]) -> Optics:
    """Weighted means over the fits that are sharp and whole; `before`, from which they started, where there are none.

    Meant for fits that started from wide standard deviations: what they knew before does not count again.
    """
    good = [f for f in fits if not (f.fell_back or f.blurred) and f.hidden < 0.2 and f.clipped < 0.2]
    if not good:
        return before
    values = np.array([[f.sigma, f.bleed] for f in good])
    precision = np.array([f.optics_sd for f in good]) ** -2.0
    mean = np.sum(precision * values, axis=0) / precision.sum(axis=0)
    scatter = np.sum(precision * (values - mean) ** 2, axis=0) / precision.sum(axis=0)
    sd = np.sqrt(FLOOR**2 + 1 / precision.sum(axis=0) + scatter)
    return Optics(float(mean[0]), float(mean[1]), float(sd[0]), float(sd[1]))
