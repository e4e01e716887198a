"""Where the bars are: the stacked crossed linkages solved as intersections of circles.

Points are complex numbers in the plane of motion (x right, y up, m); the base bar's middle is 0. This is a construction
of its own, without the closed forms that the `mechanism` package uses, so that each can be held against the other.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Bars:
    """Poses of bars 0..N; leading shape (...) is that of the angles."""

    middle: NDArray[np.complex128]
    """shape (..., N + 1), m"""
    orientation: NDArray[np.float64]
    """shape (..., N + 1), rad against the base bar"""
    left: NDArray[np.complex128]
    """left bar ends, shape (..., N + 1), m"""
    right: NDArray[np.complex128]
    """right bar ends, shape (..., N + 1), m"""


def solve(alpha: NDArray[np.float64], L: NDArray[np.float64], b: NDArray[np.float64]) -> Bars:
    """Bars of an arm at joint angles `alpha`, shape (..., N), rad; L, b of shape (N,), m.

    Bar i has a known direction; its middle is where both diagonals have length L: the upper intersection of two circles.
    Diagonals run from left[i - 1] to right[i] and from right[i - 1] to left[i].
    """
    alpha = np.asarray(alpha, dtype=float)
    n = alpha.shape[-1]
    gamma = np.concatenate([np.zeros((*alpha.shape[:-1], 1)), np.cumsum(alpha, axis=-1)], axis=-1)
    along = np.exp(1j * gamma)
    middle = np.zeros(gamma.shape, dtype=complex)
    for i in range(1, n + 1):
        half_below = b[i - 1] / 2 * along[..., i - 1]
        half_above = b[i - 1] / 2 * along[..., i]
        centre_a = middle[..., i - 1] - half_below - half_above  # |middle + half_above - left below| = L
        centre_b = middle[..., i - 1] + half_below + half_above
        across = centre_b - centre_a
        height = np.sqrt(L[i - 1] ** 2 - np.abs(across) ** 2 / 4)
        middle[..., i] = (centre_a + centre_b) / 2 + 1j * across / np.abs(across) * height
    # of a bar that carries unlike mechanisms these are the ends of the one above
    half = np.asarray(along * (np.concatenate([b, b[-1:]]) / 2), dtype=complex)
    return Bars(middle, gamma, middle - half, middle + half)


def diagonal(bars: Bars, b: NDArray[np.float64], name: str) -> tuple[complex, float]:
    """Middle, m, and direction from lower to upper end, rad, of a diagonal of an arm at one pose; b of shape (N,), m.

    A2 is mechanism 2's from bottom left to top right, B2 the one from bottom right to top left.
    """
    i, side = int(name[1:]), {"A": 1, "B": -1}[name[0]]
    half = side * b[i - 1] / 2 * np.exp(1j * bars.orientation)
    lower, upper = bars.middle[i - 1] - half[i - 1], bars.middle[i] + half[i]
    return complex(lower + upper) / 2, float(np.angle(upper - lower))
