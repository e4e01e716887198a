"""An offset that is left between frames and log, as a data set made by hand may have.

To the elongations alone it looks like viscous friction of the motors. The clock's own fit tells the two apart by the arm's
equation.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.dataset.frames import FrameAngles
from identification.dataset.series import Series, numbered
from mechanism.arm import Arm
from state_estimation.motors import Motors
from synchronisation.check.wording import fault_of_clock
from synchronisation.clocks.cables import frames_of, wound
from synchronisation.clocks.clock import EDGE, LEAST_FRAMES, PERIODIC
from synchronisation.clocks.coarse import MIN_OVERLAP, match, speeds
from synchronisation.clocks.fine import fit_fine
from synchronisation.clocks.labels import ALIKE
from synchronisation.clocks.rope_steps import steady_signals
from synchronisation.clocks.undetermined import NoClue

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
    if len(time) < LEAST_FRAMES or min(np.ptp(time), np.ptp(motors.time)) < 2 * MIN_OVERLAP:
        return None
    winding = wound(arm, alpha)
    found = match(speeds(time, winding), speeds(motors.time, arm.drum * motors.theta))
    if found.likeness < ALIKE or found.second > PERIODIC:
        return None
    at = time + found.shift
    inside = (at > motors.time[0] + EDGE) & (at < motors.time[-1] - EDGE)
    inside &= (time > time[0] + EDGE) & (time < time[-1] - EDGE)
    if inside.sum() < LEAST_FRAMES or np.ptp(time[inside]) < MIN_OVERLAP:
        return None
    log = Series(motors.time, numbered("theta", motors.theta) | numbered("f", motors.f))
    signals, _ = steady_signals(arm, log, at, winding)
    middle = float(time[inside][0] + time[inside][-1]) / 2
    frames = frames_of(arm, time[inside], alpha[inside], sigma[inside], middle)
    try:
        fine = fit_fine(arm, signals, frames, found.shift, fv)
    except NoClue:
        return None
    offset = fine.fit.state.offset
    if abs(offset) < max(LEAST_S, BEYOND * fine.offset_sigma):
        return None
    return fault_of_clock(-offset, fine.offset_sigma)


def mended(seen: FrameAngles, fault: dict[str, Any]) -> FrameAngles:
    """The frames at the times at which the fit would have them."""
    return replace(seen, time=seen.time - fault["size"])
