"""Friction of a cable on the pulleys of its route, in proportion to its tension (Euler, Eytelwein)."""

import numpy as np

from mechanism.arm import Array
from mechanism.laws.law import Law, MotorMotion, Term, Values


class PulleyFriction(Law):
    """A motor that winds in pulls exp(mu wrap) times the cable's tension, one that gives way exp(-mu wrap) times."""

    name = "pulley_friction"
    rubs_under_tension = True
    terms = (Term("mu", "1/rad", low=0.0, high=0.3, size=0.005, would_tell="vary the tension while the motors turn"),)

    def friction(self, p: Values, at: MotorMotion) -> Array:
        return np.expm1(p["mu"] * at.wrap * at.share(p["cm"])) * at.tension
