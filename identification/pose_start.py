"""Pre-elongations that the motors themselves tell: where the fit of the pose begins.

No model has the pre-elongation of each of several recordings, and that of one is of other numbers than the fit begins with. An arm
whose cables are a few millimetres too long has no tension to begin with: angles are degrees off, and a fit that weighs the motors'
equation by what it leaves would let it go. With friction and elasticity as the model has them, tension grows with pre-elongation:
the one whose forces are right in the mean is found by bisection, of all cables at once.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from identification.pose_equations import PoseEquations
from identification.pose_numbers import SoughtNumber
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

_HALVINGS = 16
"""of the range of a pre-elongation: to 2 um of 100 mm"""
LEAST_MOTOR_N = 0.1
"""N: sigma of the motors' equation at least"""
_MAX_MOTOR_RATIO = 3.0
"""of what numbers leave of the motors' equation and what those of the model leave (docs/thresholds.md)"""


def begun_by_motors(equations: PoseEquations) -> list[SoughtNumber]:
    """The equations' numbers with the pre-elongations of each recording by which its motors' forces are right in the mean."""
    numbers = list(equations.numbers)
    for r in range(len(equations.rows)):
        places = [i for i, n in enumerate(numbers) if n.name == "x0" and n.recording == r]
        for place, x0 in zip(places, _pre_elongations(equations, r, places), strict=True):
            numbers[place] = replace(numbers[place], mean=float(x0))
    return numbers


def _pre_elongations(equations: PoseEquations, r: int, places: list[int]) -> Array:
    """Of a recording's cables, (M,), m, in the order of their places among the numbers."""
    p = np.zeros(len(equations.numbers))
    low, high = equations.low[places], equations.high[places]
    for _ in range(_HALVINGS):
        p[places] = (low + high) / 2
        pulls_too_little = np.mean(equations.motor_misfit(p, r), axis=0) > 0
        low, high = np.where(pulls_too_little, p[places], low), np.where(pulls_too_little, high, p[places])
    return equations.mean[places] + equations.sigma[places] * (low + high) / 2


def motor_rms(equations: PoseEquations, p: Array) -> Array:
    """What numbers p (P,) leave of the motors' equation where the equations are linearised, rms over all recordings, (M,), N."""
    forces = [equations.motor_misfit(p, r) for r in range(len(equations.rows))]
    return np.sqrt(np.mean(np.concatenate(forces) ** 2, axis=0))


def check_motors(begun: Array, left: Array) -> None:
    """Refused where fitted numbers leave much more of the motors' equation, (M,), N, than those that the fit began with."""
    limit = _MAX_MOTOR_RATIO * np.maximum(begun, LEAST_MOTOR_N)
    if np.any(left > limit):
        j = int(np.argmax(left / limit))
        raise Refused(
            "identify",
            f"numbers that put the arm where the camera saw it leave {left[j]:.3g} N of the forces of motor {j + 1}, where the "
            f"model leaves {begun[j]:.3g} N",
            "is it this arm's neck.yaml, and the model of this recording?",
        )
