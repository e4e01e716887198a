"""What hides between the force command and the arm: motors with dry friction, and cables that stretch."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Law = Callable[[Array, Array], Array]

SHARPNESS = 0.5
"""c_m of the friction law, s/rad on the motor side"""


@dataclass(frozen=True)
class Motors:
    """Motors, gears, drums and cables of an arm; all of shape (M,)."""

    drum: Array
    """rd/R, cable travel per motor angle, m/rad"""
    inertia: Array
    """Ia of the rotor, kg m^2"""
    friction: Law
    """(theta', f) -> the force that friction takes from the command, N at the cable"""
    tension: Law
    """(x, x') -> tension of the cables, N"""
    x0: Array
    """elongation in the straight pose at theta = 0, m"""

    def acceleration(self, f: Array, theta_d: Array, t: Array) -> Array:
        """theta'' (43), rad/s^2, under the command f and the cable tension t, N, at theta_d, rad/s."""
        return self.drum / self.inertia * (f - self.friction(theta_d, f) - t)


def dry_and_viscous(fs: Array, fv: Array) -> Law:
    """Friction of the gears: fs (N) with a smooth change of sign, and fv (N s/rad), shape (M,)."""

    def friction(theta_d: Array, f: Array) -> Array:
        return fs * (2 / np.pi) * np.arctan(SHARPNESS * theta_d) + fv * theta_d

    return friction


def linear_cable(k: Array, ca: Array) -> Law:
    """A spring k (N/m) and a damper ca (N s/m) side by side, shape (M,), which never push."""

    def tension(x: Array, x_d: Array) -> Array:
        return np.maximum(k * x + ca * x_d, 0.0)

    return tension


def motors_of(neck: dict[str, Any], friction: Law, tension: Law) -> Motors:
    """The motors that a parsed neck.yaml describes, with the given laws."""
    motors = neck["motors"]
    return Motors(
        drum=np.array([m["rd"] / m["R"] for m in motors]),
        inertia=np.array([m["Ia"] for m in motors]),
        friction=friction,
        tension=tension,
        x0=np.array([c.get("x0", 0.0) for c in neck["cables"]]),
    )
