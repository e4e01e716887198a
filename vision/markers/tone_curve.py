"""The curve by which a camera turns light into grey levels.

Cameras for people write a power of the light, about 1 / 2.2; those for measuring mostly the light itself. On a blurred edge
between ink and paper the power looks as if the paper had grown. At the corners of cells it does not, and a marker whose corners
lie unevenly comes out turned by hundredths of a degree where the curve is left out.
"""

import numpy as np
from numpy.typing import NDArray

Single = NDArray[np.float32]

INK_OVER_PAPER = 0.06
"""reflectance of printed black over that of white: what stands for no light at all in the curve (docs/thresholds.md)"""
LINEAR = 1.0


def through_tone_curve(channels: Single, exponent: float) -> Single:
    """A template's channels (5, n), its value (0 ink, 1 paper) and the value's derivatives, as a camera with this exponent writes
    them."""
    if exponent == LINEAR:
        return channels
    rest = INK_OVER_PAPER**exponent
    light = np.float32(INK_OVER_PAPER) + np.float32(1 - INK_OVER_PAPER) * channels[0]
    np.maximum(light, np.float32(INK_OVER_PAPER / 4), out=light)
    power = light ** np.float32(exponent)
    slope = power / light
    slope *= np.float32(exponent * (1 - INK_OVER_PAPER) / (1 - rest))
    through = channels * slope
    through[0] = (power - np.float32(rest)) / np.float32(1 - rest)
    return through
