"""Cables that get stiffer under load."""

import numpy as np

from mechanism.arm import Array
from mechanism.laws.law import Law, Stretching, Term, Values


class Hardening(Law):
    """k2 x^2 beside the linear cable, while it is stretched."""

    name = "cable_hardening"
    terms = (Term("k2", "N/m^2", 0.0, 1e8, 2e5),)

    def pull(self, p: Values, at: Stretching, z: Array) -> Array:
        return p["k2"] * np.maximum(at.x, 0.0) ** 2
