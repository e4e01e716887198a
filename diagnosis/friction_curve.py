"""How far dry friction may lie from the arc tangent (48) and still be the base model's: small bumps of its curve over speed.

No motor's friction turns over exactly as an arc tangent does. Each motor has bumps about a few speeds, in shares of its dry
friction and odd as friction is; the description's tolerance says how large they are.
"""

import numpy as np
from numpy.typing import NDArray

from diagnosis.linearisation import RecordingLinearisation
from identification.residuals import UNIT_FORCE, changes_by_forces

Array = NDArray[np.float64]

BUMP_SPEEDS = (0.3, 1.2, 5.0)
"""rad/s of the motor, evenly in their logarithm (docs/thresholds.md)"""
_BUMP_WIDTH = 0.5 * float(np.log(BUMP_SPEEDS[1] / BUMP_SPEEDS[0]))
"""in the logarithm of speed: bumps overlap where each is at 0.37 of its height, and add up to a smooth curve"""


def friction_bumps(speed: Array) -> Array:
    """Bumps of friction at motor speeds (...), rad/s, as shares of dry friction, (..., bumps): odd, at most 1."""
    size = np.log(np.maximum(np.abs(speed), 1e-9)[..., None] / np.array(BUMP_SPEEDS))
    return np.sign(speed)[..., None] * np.exp(-((size / _BUMP_WIDTH) ** 2))


def friction_curve_columns(recording: RecordingLinearisation, share: float) -> Array:
    """What bumps of `share` of each motor's dry friction do to the residuals, (C, S, bumps M)."""
    s = recording.signals
    size = share * np.broadcast_to(np.abs(recording.values["fs"]), s.f.shape[1:])
    bumps = friction_bumps(s.speeds.mean).mean(axis=0) * size[:, None]  # (T, M, bumps)
    changes = changes_by_forces(s, UNIT_FORCE, friction=np.moveaxis(bumps, -1, 0))
    return changes.reshape(*changes.shape[:2], -1)
