"""Strands that rub against each other: a force that lags behind the elongation whatever the speed (Dahl 1968)."""

import numpy as np

from mechanism.arm import Array
from mechanism.laws.law import CableMotion, Law, Term, Values

_WOULD_TELL = "vary the tension slowly up and down by different amounts"


class Hysteresis(Law):
    """h z with z' = (x' - |x'| z) / xh: z turns from -1 to 1 over a few xh of elongation."""

    name = "cable_hysteresis"
    terms = (
        Term("h", "N", low=0.0, high=500.0, size=1.0, would_tell=_WOULD_TELL),
        Term("xh", "m", low=2e-5, high=1e-2, size=2e-4, of="arm", would_tell=_WOULD_TELL),
    )
    states = 1
    memory_start = Term("loop0", "1", low=-1.0, high=1.0, size=0.1, sigma=0.6, would_tell=_WOULD_TELL)

    def pull(self, p: Values, at: CableMotion, z: Array) -> Array:
        return p["h"] * z[..., 0]

    def memory_rate(self, p: Values, at: CableMotion, z: Array) -> Array:
        return ((at.x_d - np.abs(at.x_d) * z[..., 0]) / p["xh"])[..., None]
