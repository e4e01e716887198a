"""Friction of the gear motors, as a force on the cable (47)-(50)."""

import numpy as np

from mechanism.arm import Array

CM = 0.5
"""s/rad: slope of the arc tangent around rest (48), on the motor side"""


def dry(theta_d: Array, cm: float | Array = CM) -> Array:
    """(48) for fs = 1 N: (2/pi) atan(cm theta'), theta' in rad/s on the motor side; of the shape given."""
    return 2 / np.pi * np.arctan(cm * theta_d)
