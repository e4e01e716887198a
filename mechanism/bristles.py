"""Bend of the bristles by which dry friction holds a motor before it slides, along a path of motor angles (Dahl 1968).

The bend z follows z' = (theta' - |theta'| z) / width: of the greatest friction it says which share acts, and with which sign. It
depends on the path alone, not on how fast the motor runs along it.
"""

import numpy as np

from mechanism.arm import Array
from mechanism.path_memory import PathSteps

BEND_WIDTHS_RAD = (0.01, 0.025, 0.06, 0.16)
"""rad of the motor: sums of bends over these come near any that motors have (docs/thresholds.md)"""


def bend_steps(travel: Array, width: float | Array) -> PathSteps:
    """What steps of a travel (S, M), rad, do to the bend, (S, M, 1).

    width: rad, over which bristles bend, of all motors or of each (M,).
    """
    widths = np.abs(travel) / width
    turned, end = -np.expm1(-widths), np.sign(travel)
    # of a bend that dies away over a step, the mean over the step
    share = np.divide(turned, widths, out=np.ones_like(widths), where=turned > 0)
    return PathSteps(*(part[..., None] for part in (1 - turned, end * turned, share, end * (1 - share))))


def mean_bend(theta: Array, width: float | Array) -> Array:
    """Means of the bend over the steps of a path, (T - 1, M), that runs straight between angles (T, M), rad; none at first.

    width: as in `bend_steps`.
    """
    steps = bend_steps(np.diff(theta, axis=0), width)
    return steps.means(steps.starts())[..., 0]
