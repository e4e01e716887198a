"""Play between a motor and its drum."""

import numpy as np

from mechanism.arm import Array
from mechanism.laws.law import Law, Stretching, Term, Values


class Backlash(Law):
    """The drum lags by half the play in the direction of turning; it crosses over while the motor turns by a part of it."""

    name = "backlash"
    terms = (Term("play", "m", 0.0, 0.01, 2e-4, linear=False),)
    states = 1

    def pull(self, p: Values, at: Stretching, z: Array) -> Array:
        return -p["k"] * p["play"] / 2 * z[..., 0]

    def drift(self, p: Values, at: Stretching, z: Array) -> Array:
        reach = np.maximum(p["play"] / 2, 1e-5)
        return ((at.travel_d - np.abs(at.travel_d) * z[..., 0]) / reach)[..., None]
