"""Dry friction that bends before it slides (Dahl 1968)."""

import numpy as np

from mechanism.arm import Array
from mechanism.bristles import mean_bend
from mechanism.friction import dry
from mechanism.laws.law import CableMotion, Law, MotorMotion, Term, Values

_WOULD_TELL = "reverse the motors often, by little and by much"


class PreslidingFriction(Law):
    """fp of the dry friction (48) follows a bend z, z' = (theta' - |theta'| z) / wp, and not the speed: fp (z - dry(theta')) more.

    Bristles bend over a few wp of the motor's angle, and hold a motor at rest where it stands; then friction slides.
    """

    name = "presliding_friction"
    terms = (
        Term("fp", "N", low=0.0, high=100.0, size=1.0, would_tell=_WOULD_TELL),
        Term("wp", "rad", low=1e-3, high=1.0, size=0.03, would_tell=_WOULD_TELL),
    )
    states = 1
    remembers_path = True

    def friction(self, p: Values, at: MotorMotion) -> Array:
        return p["fp"] * (at.memory[..., 0] - dry(at.theta_d, p["cm"]))

    def memory_rate(self, p: Values, at: CableMotion, z: Array) -> Array:
        theta_d = at.travel_d / at.arm.drum
        return ((theta_d - np.abs(theta_d) * z[..., 0]) / p["wp"])[..., None]

    def memory_on_path(self, p: Values, theta: Array) -> Array:
        return mean_bend(theta, p["wp"])[..., None]
