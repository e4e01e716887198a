"""Whether the forces of a log can be those on the cables, before the joints are told by them."""

import numpy as np
from numpy.typing import NDArray

from identification.dataset.constant_forces import constant_forces
from identification.dataset.series import Series
from identification.estimates import MIN_MOTOR_SPEED_RAD_S, PUSH_N
from xneck_foundation.errors import Refused
from xneck_foundation.one_line import listed

Array = NDArray[np.float64]

MIN_TURN_RAD = 3.0
"""rad by which some motor turns in a log whose forces must change: constant ones may hold an arm at rest (docs/thresholds.md)"""


def check_forces(log: Series) -> None:
    """Raises Refused where forces do not change while motors turn, or push on cables."""
    constant = constant_forces(log)
    turns = bool(np.any(np.ptp(log.matrix("theta"), axis=0) > MIN_TURN_RAD))
    if constant is not None and constant.tell_nothing and turns:
        what = f"{constant.words} while motors turn, which says nothing of how far a cable stretches"
        raise Refused("log", what, "log the commanded forces")
    pull = _mean_pull(log)
    pushing = np.flatnonzero(pull < -PUSH_N)
    if len(pushing):
        raise Refused(
            "log",
            f"{listed(f'f{j + 1}' for j in pushing)} would push on cables ({float(np.mean(pull[pushing])):.0f} N in the mean)",
            "is the sign of f turned? write f_scale of these motors with the other sign into neck.yaml",
        )


def _mean_pull(log: Series) -> Array:
    """Of the cables, (M,), N, NaN where a motor turns one way only: what winding in and letting out have in common."""
    if len(log) < 2:
        return np.full(log.matrix("f").shape[1], np.nan)
    speed = np.gradient(log.matrix("theta"), log.time, axis=0)
    pull = []
    for v, f in zip(speed.T, log.matrix("f").T, strict=True):
        least = max(float(np.median(np.abs(v))), MIN_MOTOR_SPEED_RAD_S)
        ways = [f[v > least], f[v < -least]]
        pull.append(np.mean([np.mean(way) for way in ways]) if all(len(way) for way in ways) else np.nan)
    return np.array(pull)
