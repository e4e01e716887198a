"""Cables that get stiffer under load."""

import numpy as np

from mechanism.arm import Array
from mechanism.laws.law import Law, Stretching, Term, Values

_AT_M = 5e-3
"""elongation at which all powers agree"""


class Hardening(Law):
    """k2 x^2 (x / 5 mm)^(nh - 2) beside the linear cable, while it is stretched."""

    name = "cable_hardening"
    terms = (Term("k2", "N/m^2", 0.0, 1e8, 2e5), Term("nh", "1", 1.2, 6.0, 2.0, "arm"))

    def pull(self, p: Values, at: Stretching, z: Array) -> Array:
        return p["k2"] * _AT_M**2 * (np.maximum(at.x, 0.0) / _AT_M) ** p["nh"]
