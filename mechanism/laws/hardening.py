"""Cables that get stiffer under load."""

import numpy as np

from mechanism.arm import Array
from mechanism.laws.law import CableMotion, Law, Term, Values

AT_M = 5e-3
"""elongation at which all powers agree"""

_WOULD_TELL = "vary the tension over its whole range, apart from the motion"


class Hardening(Law):
    """k2 x^2 (x / 5 mm)^(nh - 2) beside the linear cable, while it is stretched."""

    name = "cable_hardening"
    terms = (
        Term("k2", "N/m^2", low=0.0, high=1e9, size=2e5, would_tell=_WOULD_TELL),
        Term("nh", "1", low=1.2, high=6.0, size=2.0, of="arm", would_tell=_WOULD_TELL),
    )

    def pull(self, p: Values, at: CableMotion, z: Array) -> Array:
        return p["k2"] * AT_M**2 * (np.maximum(at.x, 0.0) / AT_M) ** p["nh"]
