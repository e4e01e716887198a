"""Cables that are soft until their strands have settled: the toe of a stress-strain curve."""

import numpy as np

from mechanism.arm import Array
from mechanism.laws.law import CableMotion, Law, Term, Values


class Toe(Law):
    """k (x - xt (1 - exp(-x/xt))): the linear cable's k, reached beyond xt; zero xt is no toe."""

    name = "cable_toe"
    terms = (
        Term("xt", "m", low=0.0, high=0.02, size=1e-3, linear=False, would_tell="let the tension come near to nothing"),
    )

    def pull(self, p: Values, at: CableMotion, z: Array) -> Array:
        xt = np.maximum(p["xt"], 1e-9)
        return p["k"] * xt * np.expm1(-np.maximum(at.x, 0.0) / xt)
