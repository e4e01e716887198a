"""Residuals as they are judged and shown: where they stand above noise, and against what.

Fits weigh every frequency by its noise. A root mean square does not: the arm's equation, with angles that nothing smoothed, is
full of their noise above a few hertz, and what is wrong at lower ones would drown in it.
"""

import numpy as np
from numpy.typing import NDArray

from identification.signals import Signals

Array = NDArray[np.float64]

ARM_CUTOFF_HZ = 4.0
"""up to which the arm's equation is judged (docs/thresholds.md)"""


def judged(values: Array, s: Signals) -> Array:
    """Residuals (C, S) of a recording, their noise, or columns of them: those of the arm's equation below ARM_CUTOFF_HZ."""
    motors = s.arm.M
    return np.concatenate([values[:motors], s.low_pass.slower(values[motors:], s.step, ARM_CUTOFF_HZ)])
