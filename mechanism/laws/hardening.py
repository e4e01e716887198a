"""Cables that get stiffer under load."""

import numpy as np

from mechanism.arm import Array
from mechanism.laws.law import Law, Stretching, Term, Values


class Hardening(Law):
    """k2 x^2 + k3 x^3 beside the linear cable, while it is stretched."""

    name = "cable_hardening"
    terms = (Term("k2", "N/m^2", 0.0, 1e8, 2e5), Term("k3", "N/m^3", 0.0, 2e10, 4e7))

    def pull(self, p: Values, at: Stretching, z: Array) -> Array:
        x = np.maximum(at.x, 0.0)
        return p["k2"] * x**2 + p["k3"] * x**3
