"""Least squares of numbers that may go no further than a wall."""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

Array = NDArray[np.float64]

_TURNS = 100
_LITTLE = 1e-3
"""of a loss: a step that would take no more away is not taken"""
_PARTS, _DESCENT = tuple(0.5**k for k in range(20)), 1e-4
"""of a step, tried one after the other, and of its promise, that it must keep"""


def between_walls(H: Array, b: Array, low: Array, high: Array) -> Array:
    """Where x H x / 2 - b x is least between walls, by Newton's steps along them (Bertsekas 1982, projected Newton)."""
    x = cho_solve(cho_factor(H), b)
    if np.all((x >= low) & (x <= high)):
        return x
    x = np.clip(x, low, high)
    for _ in range(_TURNS):
        slope = H @ x - b
        free = ~(((x <= low) & (slope > 0)) | ((x >= high) & (slope < 0)))
        step = np.zeros(len(x))
        step[free] = -cho_solve(cho_factor(H[np.ix_(free, free)]), slope[free])
        if -slope @ step < _LITTLE:
            break
        for part in _PARTS:
            there = np.clip(x + part * step, low, high)
            moved = there - x
            if slope @ moved + moved @ H @ moved / 2 < _DESCENT * (slope @ moved):
                break
        else:
            break
        x = there
    return x
