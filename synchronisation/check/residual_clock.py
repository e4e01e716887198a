"""An offset that is left between frames and log, as a data set made by hand may have.

To the elongations alone it looks like viscous friction of the motors. The clock's own fit tells the two apart by the arm's
equation.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.dataset.frames import FrameAngles
from identification.dataset.series import Series, numbered_columns
from mechanism.arm import Arm
from state_estimation.motors import Motors
from synchronisation.check.wording import fault_of_clock
from synchronisation.clocks.coarse_alignment import MAX_SECOND_PEAK, MIN_OVERLAP_S, align_coarsely, cable_speeds
from synchronisation.clocks.exchanged_labels import MIN_CORRELATION
from synchronisation.clocks.fine_alignment import align_finely
from synchronisation.clocks.frame_geometry import cable_winding, frame_geometry
from synchronisation.clocks.undetermined import ClockUndetermined
from synchronisation.clocks.usable_frames import EDGE_S, MIN_FRAMES
from synchronisation.clocks.winch_slips import signals_without_slips

Array = NDArray[np.float64]

LEAST_S = 1e-3
"""s that are named: faults of other kinds, of the sizes that are found, pulled the clock by up to 0.4 ms"""
BEYOND = 5.0
"""sigma"""


def clock_left(arm: Arm, seen: FrameAngles, motors: Motors, fv: Array) -> dict[str, Any] | None:
    """The fault, its size being how much later than true the frames' times are, s; None where there is none, or none can be told.

    Frames of `seen` and `motors` are taken to be on one clock. fv (M,), N s/rad, NaN where not known.
    """
    whole = np.isfinite(seen.alpha).all(axis=1)
    time, alpha, sigma = seen.time[whole], seen.alpha[whole], seen.sigma[whole]
    if len(time) < MIN_FRAMES or min(np.ptp(time), np.ptp(motors.time)) < 2 * MIN_OVERLAP_S:
        return None
    winding = cable_winding(arm, alpha)
    found = align_coarsely(cable_speeds(time, winding), cable_speeds(motors.time, arm.drum * motors.theta))
    if found.correlation < MIN_CORRELATION or found.second_peak > MAX_SECOND_PEAK:
        return None
    at = time + found.shift
    inside = (at > motors.time[0] + EDGE_S) & (at < motors.time[-1] - EDGE_S)
    inside &= (time > time[0] + EDGE_S) & (time < time[-1] - EDGE_S)
    if inside.sum() < MIN_FRAMES or np.ptp(time[inside]) < MIN_OVERLAP_S:
        return None
    log = Series(motors.time, numbered_columns("theta", motors.theta) | numbered_columns("f", motors.f))
    signals, _ = signals_without_slips(arm, log, at, winding)
    middle = float(time[inside][0] + time[inside][-1]) / 2
    frames = frame_geometry(arm, time[inside], alpha[inside], sigma[inside], middle)
    try:
        fine = align_finely(arm, signals, frames, found.shift, fv)
    except ClockUndetermined:
        return None
    offset = fine.fit.unknowns.offset
    if abs(offset) < max(LEAST_S, BEYOND * fine.offset_sigma):
        return None
    return fault_of_clock(-offset, fine.offset_sigma)


def mended(seen: FrameAngles, fault: dict[str, Any]) -> FrameAngles:
    """The frames at the times at which the fit would have them."""
    return replace(seen, time=seen.time - fault["size"])
