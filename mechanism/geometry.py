"""The shape of stacked X-joints: sides, bars and diagonals.

Conventions, said once for the whole project: the plane of motion has x right, y up, z towards the viewer, its origin at
the middle of the base bar; SI units and radians. Mechanism i (1..N from the base up) joins bar i-1 to bar i; alpha_i is
bar i's orientation relative to bar i-1, positive counter-clockwise; gamma_i = alpha_1 + ... + alpha_i. Points of the
plane are complex numbers x + jy, so that turning by an angle is multiplying by exp(j angle). Equation numbers are those
of Fasquelle 2021 (hal-03137199).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mechanism.arm import Arm, Array
from xneck_foundation.errors import Refused

Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Sides:
    """Middle distance and side lengths of the mechanisms with their derivatives by alpha, all (..., N), m."""

    d: Array
    d1: Array
    d2: Array
    left: Array
    left1: Array
    left2: Array
    right: Array
    right1: Array
    right2: Array


def sides(arm: Arm, alpha: Array) -> Sides:
    """(4), (5), (6) and their first and second derivatives by alpha; alpha of shape (..., N), rad."""
    c, s = np.cos(alpha / 2), np.sin(alpha / 2)
    b2 = arm.b**2
    d = np.sqrt(arm.L**2 - b2 * c**2)
    d1 = b2 * c * s / (2 * d)
    d2 = (b2 * (c**2 - s**2) / 4 - d1**2) / d
    h, h1, h2 = arm.b * s, arm.b * c / 2, -arm.b * s / 4
    return Sides(
        d=d,
        d1=d1,
        d2=d2,
        left=d - h,
        left1=d1 - h1,
        left2=d2 - h2,
        right=d + h,
        right1=d1 + h1,
        right2=d2 + h2,
    )


def check_angles(arm: Arm, alpha: Array, where: str = "alpha") -> None:
    """Refused where an angle is not finite, reaches the singular pose, or leaves no room for a pulley on a side."""
    if not np.all(np.isfinite(alpha)):
        raise Refused(where, "has values that are not finite", "leave such samples out")
    worst = np.unravel_index(np.argmax(np.abs(alpha)), np.shape(alpha))
    shown = f"alpha{worst[-1] + 1} = {np.degrees(np.asarray(alpha)[worst]):.1f} deg"
    if np.any(np.abs(alpha) >= np.pi):
        raise Refused(where, f"{shown} is at or past the singular pose of 180 deg", "are the angles in radians?")
    s = sides(arm, alpha)
    room = np.minimum(s.left, s.right) - arm.r
    if np.any(room <= 0):
        worst = np.unravel_index(np.argmin(room), room.shape)
        shown = f"alpha{worst[-1] + 1} = {np.degrees(np.asarray(alpha)[worst]):.1f} deg"
        raise Refused(where, f"at {shown} a pulley no longer fits between the bars", "check angles, L, b and r")


@dataclass(frozen=True)
class Poses:
    """Points and orientations in the base frame: complex, m, and rad."""

    bar_middle: Complex
    """bars 0..N, shape (..., N + 1)"""
    bar_angle: Array
    """gamma of bars 0..N, shape (..., N + 1)"""
    diagonal_middle: Complex
    """shape (..., N, 2): diagonal A (bottom left to top right), B (bottom right to top left)"""
    diagonal_angle: Array
    """shape (..., N, 2)"""


def diagonal_angle(arm: Arm, alpha: Array) -> Array:
    """phi and psi of each mechanism against its bottom bar, shape (..., N, 2), rad."""
    s = sides(arm, alpha)
    lean = np.arctan2(s.d, arm.b * np.cos(alpha / 2))
    return np.stack([alpha / 2 + lean, alpha / 2 + np.pi - lean], axis=-1)


def poses(arm: Arm, alpha: Array) -> Poses:
    """Where every bar and diagonal is at joint angles alpha, shape (..., N), rad."""
    s = sides(arm, alpha)
    gamma = np.concatenate([np.zeros((*alpha.shape[:-1], 1)), np.cumsum(alpha, axis=-1)], axis=-1)
    below = np.exp(1j * gamma[..., :-1])
    along = 1j * np.exp(1j * alpha / 2) * below  # from bar i-1's middle to bar i's
    origin = np.zeros((*alpha.shape[:-1], 1), dtype=complex)
    middle = np.concatenate([origin, np.cumsum(s.d * along, axis=-1)], axis=-1)
    # the middles of A and B lie at half the right and left side's length along the same direction
    half = np.stack([s.right, s.left], axis=-1) / 2
    diagonals = middle[..., :-1, None] + half * along[..., None]
    return Poses(middle, gamma, diagonals, gamma[..., :-1, None] + diagonal_angle(arm, alpha))
