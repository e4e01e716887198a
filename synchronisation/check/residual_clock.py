"""A remaining offset between frames and log, as a data set made by hand may have.

To the elongations alone it looks like viscous friction of the motors. The clock's fit tells the two apart by the equation of the
arm.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.dataset.frames import FrameAngles
from identification.dataset.series import Series, numbered_columns
from mechanism.arm import Arm
from state_estimation.motors import Motors
from synchronisation.check.wording import clock_record
from synchronisation.clocks.coarse_alignment import MAX_SECOND_PEAK, MIN_OVERLAP_S, align_coarsely, cable_speeds
from synchronisation.clocks.exchanged_labels import MIN_CORRELATION
from synchronisation.clocks.fine_alignment import align_finely
from synchronisation.clocks.frame_geometry import cable_winding, frame_geometry
from synchronisation.clocks.undetermined import ClockUndetermined
from synchronisation.clocks.usable_frames import EDGE_S, MIN_FRAMES
from synchronisation.clocks.winch_slips import signals_without_slips

Array = NDArray[np.float64]

MIN_OFFSET_S = 1e-3
"""s from which an offset is named (docs/thresholds.md)"""
MIN_SIGNIFICANCE = 5.0
"""sigma from which an offset is named (docs/thresholds.md)"""


def find_clock_fault(arm: Arm, frames: FrameAngles, motors: Motors, fv: Array) -> dict[str, Any] | None:
    """The record of an offset, whose size is how much later than true the frames' times are, s.

    None where there is no offset, or where the recording cannot show one. Frames and motors are taken to be on one clock. fv:
    viscous friction (M,), N s/rad, NaN where not known.
    """
    complete = np.isfinite(frames.alpha).all(axis=1)
    time, alpha, sigma = frames.time[complete], frames.alpha[complete], frames.sigma[complete]
    if len(time) < MIN_FRAMES or min(np.ptp(time), np.ptp(motors.time)) < 2 * MIN_OVERLAP_S:
        return None
    winding = cable_winding(arm, alpha)
    coarse = align_coarsely(cable_speeds(time, winding), cable_speeds(motors.time, arm.drum * motors.theta))
    if coarse.correlation < MIN_CORRELATION or coarse.second_peak > MAX_SECOND_PEAK:
        return None
    at = time + coarse.shift
    inside = (at > motors.time[0] + EDGE_S) & (at < motors.time[-1] - EDGE_S)
    inside &= (time > time[0] + EDGE_S) & (time < time[-1] - EDGE_S)
    if inside.sum() < MIN_FRAMES or np.ptp(time[inside]) < MIN_OVERLAP_S:
        return None
    log = Series(motors.time, numbered_columns("theta", motors.theta) | numbered_columns("f", motors.f))
    signals, _ = signals_without_slips(arm, log, at, winding)
    middle = float(time[inside][0] + time[inside][-1]) / 2
    geometry = frame_geometry(arm, time[inside], alpha[inside], sigma[inside], middle)
    try:
        fine = align_finely(arm, signals, geometry, coarse.shift, fv)
    except ClockUndetermined:
        return None
    offset = fine.fit.unknowns.offset
    if abs(offset) < max(MIN_OFFSET_S, MIN_SIGNIFICANCE * fine.offset_sigma):
        return None
    return clock_record(-offset, fine.offset_sigma)


def shifted_frames(frames: FrameAngles, fault: dict[str, Any]) -> FrameAngles:
    """The frames with the offset of `fault`, a record of `find_clock_fault`, taken off their times."""
    return replace(frames, time=frames.time - fault["size"])
