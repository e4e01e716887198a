"""Bend of the bristles by which dry friction holds a motor before it slides, along a path of motor angles (Dahl 1968).

The bend z follows z' = (theta' - |theta'| z) / width: of the greatest friction it says which share acts, and with which sign. It
depends on the path alone, not on how fast the motor runs along it.
"""

import numpy as np

from mechanism.affine_steps import accumulated
from mechanism.arm import Array

BEND_WIDTHS_RAD = (0.01, 0.04, 0.16)
"""rad of the motor: sums of bends over these come near any that motors have (docs/thresholds.md)"""


def mean_bend(theta: Array, width: float | Array) -> Array:
    """Means of the bend over the steps of a path, (T - 1, M), that runs straight between angles (T, M), rad; none at first.

    width: rad, over which bristles bend, of all motors or of each (M,).
    """
    travel = np.diff(theta, axis=0) / width
    turned, end = -np.expm1(-np.abs(travel)), np.sign(travel)
    bend = accumulated(np.zeros(theta.shape[1]), 1 - turned, end * turned)[:-1]
    # of a bend that dies away over a step, the mean over the step
    share = np.divide(turned, np.abs(travel), out=np.ones_like(travel), where=turned > 0)
    return end + (bend - end) * share
