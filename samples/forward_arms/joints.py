"""A mechanism folded by alpha: four corners, two equal bars and two crossing diagonals, an isosceles trapezium.

Its parallel sides s_left, s_right, its legs b and its diagonals L obey Ptolemy, L^2 = b^2 + s_left s_right; the legs lean
against each other by alpha, so s_right - s_left = 2 b sin(alpha/2). Points of the plane are complex numbers, x + iy.
"""

from dataclasses import dataclass

import numpy as np

from samples.forward_arms.plant import Array, Complex, Plant


@dataclass(frozen=True)
class Fold:
    """Sides and their derivatives by alpha, each (N, B), m."""

    half: Complex
    """exp(i alpha/2)"""
    mean: Array
    """of both sides"""
    mean1: Array
    left: Array
    right: Array
    left1: Array
    right1: Array


def folded(plant: Plant, alpha: Array) -> Fold:
    """alpha (N, B), rad."""
    cosine, sine = np.cos(alpha / 2), np.sin(alpha / 2)
    half = cosine + 1j * sine
    lean = plant.b * sine
    mean = np.sqrt((plant.L - plant.b) * (plant.L + plant.b) + lean * lean)
    across = plant.b * cosine / 2
    mean1 = lean * across / mean
    return Fold(
        half=half,
        mean=mean,
        mean1=mean1,
        left=mean - lean,
        right=mean + lean,
        left1=mean1 - across,
        right1=mean1 + across,
    )


@dataclass(frozen=True)
class Place:
    """Where bars are: of bar 0 to N, (N + 1, B), and of mechanisms, (N, B)."""

    along: Complex
    """unit vector from a bar's left end to its right end"""
    middle: Complex
    """of a bar, m"""
    up: Complex
    """unit vector along a mechanism's sides"""


def placed(fold: Fold) -> Place:
    """From the base bar up."""
    n, count = fold.half.shape
    along, middle = np.empty((n + 1, count), dtype=complex), np.empty((n + 1, count), dtype=complex)
    up = np.empty((n, count), dtype=complex)
    along[0], middle[0] = 1.0, 0.0
    turned = 1j * fold.half
    for k in range(n):
        np.multiply(along[k], turned[k], out=up[k])
        np.add(middle[k], fold.mean[k] * up[k], out=middle[k + 1])
        np.multiply(up[k], -1j * fold.half[k], out=along[k + 1])
    return Place(along, middle, up)
