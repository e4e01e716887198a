"""Joints that dry friction holds at rest: against any torque up to its greatest, whatever a law of their speed says.

What stands there beyond a law is neither noise nor another cause. Where a law has dry friction of joints, or of cables on their
pulleys, rows at rest count by what is seen of it.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from identification.signals import Signals

Array = NDArray[np.float64]

_SLIDES, _RESTS = 0.1, 0.5
"""of the greatest square of the torque that may hold a joint: up to where it slides, and from where it is at rest"""
_MIN_ROWS = 30
"""of either, for what is seen of it to be told"""
_HELD_S = 0.2
"""s: how long friction that holds a joint stays alike, at least"""


def square_at_rows(held: Array, s: Signals) -> Array:
    """Of torques (T, N) that may hold joints, in the rows of the equations, (N, S), (N m)^2."""
    return np.maximum(s.low_pass((held**2).T), 0.0)


def held_share(excess: Sequence[Array], squares: Sequence[Array]) -> float:
    """Of the square of torques that may hold joints, what is seen where they rest beyond what is left where they slide.

    excess: squares of each recording's residuals beyond those of noise, of its joints, (N, S); squares: as `square_at_rows` gives
    them. Friction holds by no more than all of it.
    """
    seen = possible = 0.0
    for left, square in zip(np.concatenate(excess, axis=1), np.concatenate(squares, axis=1), strict=True):
        slides, rests = square < _SLIDES * square.max(), square > _RESTS * square.max()
        if min(slides.sum(), rests.sum()) >= _MIN_ROWS:
            seen += float(np.sum(left[rests] - max(0.0, np.mean(left[slides]))))
            possible += float(np.sum(square[rests]))
    return seen / possible if possible else 0.0


def residuals_of_held_joints(s: Signals, torque: Array, rng: np.random.Generator) -> Array:
    """Residuals, (C, S), by one draw of what holds joints; torque: its standard deviation, (T, N), N m."""
    rows, joints = torque.shape
    stays = np.exp(-s.step / _HELD_S)
    drawn = lfilter([np.sqrt(1 - stays**2)], [1.0, -stays], rng.normal(size=(rows, joints)), axis=0)
    return np.concatenate([np.zeros((s.arm.M, len(s.low_pass.kept))), -s.low_pass((torque * drawn).T)])
