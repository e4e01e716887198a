"""Dry friction that bends before it slides (Dahl 1968)."""

import numpy as np

from mechanism.arm import Array
from mechanism.bristles import bend_steps
from mechanism.laws.law import CableMotion, Law, MotorMotion, Term, Values
from mechanism.path_memory import PathSteps

_WOULD_TELL = "reverse the motors often, by little and by much"


class PreslidingFriction(Law):
    """fp of the dry friction (48) follows a bend z, z' = (theta' - |theta'| z) / wp, and not the speed: fp (z - dry(theta')) more.

    Bristles bend over a few wp of the motor's angle, and hold a motor at rest where it stands; then friction slides.
    """

    name = "presliding_friction"
    terms = (
        Term("fp", "N", low=0.0, high=1000.0, size=1.0, would_tell=_WOULD_TELL),
        Term("wp", "rad", low=1e-3, high=5.0, size=0.03, would_tell=_WOULD_TELL),
    )
    states = 1
    remembers_path = True
    # an arm rests bent, as it was left: until a motor turns, friction holds it by no more than its greatest
    memory_start = Term("bend0", "1", low=-1.0, high=1.0, size=0.1, sigma=0.6, would_tell=_WOULD_TELL)

    def friction(self, p: Values, at: MotorMotion) -> Array:
        return p["fp"] * (at.memory[..., 0] - at.share(p["cm"]))

    def memory_rate(self, p: Values, at: CableMotion, z: Array) -> Array:
        theta_d = at.travel_d / at.arm.drum
        return ((theta_d - np.abs(theta_d) * z[..., 0]) / p["wp"])[..., None]

    def path_steps(self, p: Values, travel: Array) -> PathSteps:
        return bend_steps(travel, p["wp"])
