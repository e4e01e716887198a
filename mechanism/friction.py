"""Friction of the gear motors, as a force on the cable (47)-(50)."""

import numpy as np

from mechanism.arm import Array

CM = 0.5
"""s/rad: slope of the arc tangent around rest (48), on the motor side"""
REST_POWER = 4.0
"""how soon friction that slides holds no more, beyond the speed over which it turns over (docs/thresholds.md)"""
HELD_VARIANCE = 1 / 3
"""mean square of what friction at rest holds, its greatest being 1: anything between -1 and 1 is as likely"""


def dry(theta_d: Array, cm: float | Array = CM) -> Array:
    """(48) for fs = 1 N: (2/pi) atan(cm theta'), theta' in rad/s on the motor side; of the shape given."""
    return 2 / np.pi * np.arctan(cm * theta_d)


def turned_over(s: Array, power: float | Array) -> Array:
    """Share of its greatest that dry friction has at a speed of s times that over which it changes sign; of the shape given.

    power: how soon it is whole, 1 slowly, 2.7 much as tanh, 8 almost at once."""
    return s / (1 + np.abs(s) ** power) ** (1 / power)


def share_at_rest(s: Array) -> Array:
    """Of its greatest, by which dry friction may be off what a law says at a speed of s times that over which it changes sign.

    It holds what rests against any force up to its greatest, and what slides faster less and less, however its law."""
    return np.sqrt(np.maximum(1 - turned_over(s, REST_POWER) ** 2, 0.0))
