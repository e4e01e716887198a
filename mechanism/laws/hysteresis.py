"""Strands that rub against each other: a force that lags behind the elongation whatever the speed (Dahl 1968)."""

import numpy as np

from mechanism.arm import Array
from mechanism.laws.law import Law, Stretching, Term, Values


class Hysteresis(Law):
    """h z with z' = (x' - |x'| z) / xh: z turns from -1 to 1 over a few xh of elongation."""

    name = "cable_hysteresis"
    terms = (Term("h", "N", 0.0, 50.0, 1.0), Term("xh", "m", 2e-5, 1e-2, 2e-4, "arm"))
    states = 1

    def pull(self, p: Values, at: Stretching, z: Array) -> Array:
        return p["h"] * z[..., 0]

    def drift(self, p: Values, at: Stretching, z: Array) -> Array:
        return ((at.x_d - np.abs(at.x_d) * z[..., 0]) / p["xh"])[..., None]
