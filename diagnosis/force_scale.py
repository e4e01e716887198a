"""How far a newton of the log may lie from one: a force is a motor's torque over the radius of a drum known to a tolerance.

A drum that is off by a share of itself pulls by as much less than the log says, where the log's forces come from the motor's torque
and the drawn drum. Where they come from elsewhere they are as well known at best. Were they held to be exact, lengths, angles and
friction would make good for them, and be told with far too small a sigma.
"""

import numpy as np
from numpy.typing import NDArray

from diagnosis.linearisation import RecordingLinearisation
from identification.residuals import UNIT_FORCE, changes_by_forces, delayed_forces

Array = NDArray[np.float64]


def force_scale_columns(recording: RecordingLinearisation, share: float) -> Array:
    """What forces that are larger by `share` of themselves do to the residuals, motor by motor, (C, S, M)."""
    more = share * delayed_forces(recording.signals, recording.delay)
    return changes_by_forces(recording.signals, UNIT_FORCE, friction=-more[None])[:, :, 0]
