"""Whether gravity pulls where neck.yaml says, by what the described arm needs to move as it does.

A wrong sign, or an arm that lies on a table, explains little of a motion that its own gravity explains. Masses that are wrong, a
load or a base that leans do not take gravity from where it is described, nor turn it by a quarter.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mechanism.arm import Arm
from mechanism.description import Neck
from synchronisation.log_regression import GravityFit, LoggedMotion, fitted_gravity

Array = NDArray[np.float64]

MAX_LEFT_RATIO = 0.95
"""ratio of what another gravity leaves unexplained to what the described one leaves (docs/thresholds.md)"""
MAX_GRAVITY_SIGMA = 1.0
"""m/s^2: standard deviation of a component that is believed (docs/thresholds.md)"""
MIN_PULL, LEAST_PULL = 5.0, 3.0
"""m/s^2: of a component that is there where none is described, and at most of one that is described and not there
(docs/thresholds.md)"""
_EARTH = 9.81
_ALONG = ("across the base", "along the straight arm")


def other_gravity(neck: Neck, arm: Arm, motion: LoggedMotion) -> tuple[Arm, tuple[str, ...]]:
    """The arm with the gravity by which it moves, and a warning, where that is plainly another one than is described."""
    fit = fitted_gravity(arm, motion)
    other = _other_components(fit, arm.gravity)
    if not len(other):
        return arm, ()
    c = int(other[0])
    found, sigma = float(fit.gravity[c]), float(fit.sigma[c])
    described = ", ".join(f"{v:g}" for v in neck.gravity)
    words = (
        f"the arm moves as with gravity of {found:.1f} +- {sigma:.1f} m/s^2 {_ALONG[c]}, and neck.yaml has gravity: [{described}], "
        f"which leaves "
        f"{fit.left_as_described / fit.left:.1f} times as much unexplained: is a sign wrong, or is it mounted otherwise? "
    )
    if abs(found) > MIN_PULL:
        upright = np.where(np.arange(2) == c, np.copysign(_EARTH, found), 0.0)
        words += f"if so, write gravity: [{upright[0]:g}, {upright[1]:g}] into neck.yaml"
    else:
        words += "an arm that moves in a level plane has gravity: [0, 0]"
    believed = np.isin(np.arange(2), other)
    return replace(arm, gravity=np.where(believed, fit.gravity, 0.0)), (words,)


def _other_components(fit: GravityFit, described: Array) -> NDArray[np.intp]:
    """Which of the two components are plainly others, the surest first."""
    if not fit.left < MAX_LEFT_RATIO * fit.left_as_described:
        return np.zeros(0, dtype=np.intp)
    is_described = np.abs(described) > MIN_PULL
    gone = is_described & (fit.gravity * np.sign(described) < LEAST_PULL)
    new = (np.abs(described) < LEAST_PULL) & (np.abs(fit.gravity) > MIN_PULL)
    other = np.flatnonzero((gone | new) & (fit.sigma < MAX_GRAVITY_SIGMA))
    return other[np.argsort(fit.sigma[other])]
