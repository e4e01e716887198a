"""What joints do between frames, where a camera's frames alone would not tell it.

A spline through frames follows a motion up to a third of their rate; a camera of 5 frames a second leaves out much of what joints
do within half a second. The log knows that: between frames the joints turn as the cables are wound.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from mechanism.arm import Arm
from mechanism.cable_lengths import Z
from synchronisation.clocks.frame_geometry import cable_winding, turns_of
from synchronisation.clocks.signals import cubic_spline

Array = NDArray[np.float64]

_STEPS = 2
"""Gauss-Newton steps from the spline through the frames to the angles that the cables give"""
_MAX_STEP_RAD = 0.2
"""rad: longest step; a log that contradicts the frames must not lead out of the poses that an arm can take"""


def missed_by_spline(
    arm: Arm, time: Array, frame_time: Array, alpha: Array, winding: BSpline, cable_error: Array
) -> Array:
    """What a spline through frames at frame_time (F,), s, log clock, misses of the angles at times (T,), s; (T, N), rad.

    alpha: (F, N), rad, of the frames; their noise does not enter. winding: (..., M), m, over log time: how far cables are wound in
    by the log, less their elongation; cable_error: (M,), m, of the cables' laws: one that errs by much tells little."""
    both = np.concatenate([time, frame_time])
    by_cables = cubic_spline(frame_time, alpha)(both)
    for _ in range(_STEPS):
        by_cables = by_cables + _step(arm, by_cables, winding(both), cable_error)
    of_times, of_frames = by_cables[: len(time)], by_cables[len(time) :]
    return of_times - cubic_spline(frame_time, of_frames)(time)


def _step(arm: Arm, alpha: Array, winding: Array, cable_error: Array) -> Array:
    """Turns (T, N), rad, that bring the windings at alpha nearest to those given (T, M), m; cable_error: (M,), m."""
    turns = turns_of(Z(arm, alpha), winding - cable_winding(arm, alpha), cable_error)
    return np.clip(turns, -_MAX_STEP_RAD, _MAX_STEP_RAD)
