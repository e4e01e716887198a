"""Least squares of numbers that have a least and a greatest value."""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

Array = NDArray[np.float64]

_MAX_STEPS = 100
_MIN_GAIN = 1e-3
"""of a loss: a step that promises no more is not taken"""
_STEP_FACTORS, _ARMIJO = tuple(0.5**k for k in range(20)), 1e-4
"""of a step, tried one after the other, and the part of its promise that it must keep"""


def bounded_minimum(H: Array, b: Array, low: Array, high: Array | float = np.inf) -> Array:
    """Where x H x / 2 - b x is least among x from `low` to `high`, by projected Newton steps (Bertsekas 1982)."""
    x = cho_solve(cho_factor(H), b)
    if np.all((x >= low) & (x <= high)):
        return x
    x = np.clip(x, low, high)
    for _ in range(_MAX_STEPS):
        gradient = H @ x - b
        free = ~((x <= low) & (gradient > 0) | (x >= high) & (gradient < 0))
        step = np.zeros(len(x))
        step[free] = -cho_solve(cho_factor(H[np.ix_(free, free)]), gradient[free])
        if -gradient @ step < _MIN_GAIN:
            break
        for factor in _STEP_FACTORS:
            candidate = np.clip(x + factor * step, low, high)
            move = candidate - x
            if gradient @ move + move @ H @ move / 2 < _ARMIJO * (gradient @ move):
                break
        else:
            break
        x = candidate
    return x
