"""Which tone curve a camera writes, told by the grey levels of a picture's markers."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from vision.markers.photometric import MarkerStart, fit_markers
from vision.markers.template import Optics
from vision.markers.tone_curve import LINEAR

EXPONENTS = (LINEAR, 0.85, 0.7, 0.55, 0.45, 0.35)
"""that are tried; what cameras write lies between the last two and the first"""


def estimate_tone(grey: NDArray[np.uint8], starts: Sequence[MarkerStart], start: Optics) -> float | None:
    """The exponent with which the templates of sharp and whole markers leave least; None where there are none in the picture.

    start: optics with wide standard deviations, as blur and bleed are another with each curve.
    """
    tried = [fit_markers(grey, starts, replace(start, tone=exponent)) for exponent in EXPONENTS]
    usable = [k for k in range(len(starts)) if all(fits[k].is_clear and fits[k].rms > 0 for fits in tried)]
    if not usable:
        return None
    left = [float(np.mean([np.log(fits[k].rms) for k in usable])) for fits in tried]
    best = int(np.argmin(left))
    if best in (0, len(EXPONENTS) - 1):
        return EXPONENTS[best]
    near = slice(best - 1, best + 2)
    curvature, slope, _ = np.polyfit(EXPONENTS[near], left[near], 2)
    return float(np.clip(-slope / (2 * curvature), EXPONENTS[best + 1], EXPONENTS[best - 1]))
