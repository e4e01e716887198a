"""Friction that is larger near rest (Stribeck 1902)."""

import numpy as np

from mechanism.arm import Array
from mechanism.friction import dry
from mechanism.laws.law import Law, Term, Turning, Values


class Stribeck(Law):
    """fst exp(-(theta'/vs)^2) more than the dry friction, with its change of sign; vs in rad/s at the motor."""

    name = "stribeck_friction"
    terms = (Term("fst", "N", 0.0, 50.0, 2.0), Term("vs", "rad/s", 2.0, 200.0, 5.0, "arm"))

    def rub(self, p: Values, at: Turning) -> Array:
        return p["fst"] * np.exp(-((at.theta_d / p["vs"]) ** 2)) * dry(at.theta_d, p["cm"])
