"""Play between a motor and its drum."""

import numpy as np

from mechanism.arm import Array
from mechanism.laws.law import Law, Stretching, Term, Values

_LEAST_M = 1e-5
"""of travel by which it is crossed, where there is none"""
_FLANK = 1e-3
"""of half the play: nearer to a flank it is reached; a simulation asks for slopes there, and one step to the side is no crossing"""


class Backlash(Law):
    """The drum lags by half the play in the direction of turning; it crosses over while the motor travels pb times 2 play.

    With pb a half the drum stands still meanwhile, which is the play operator; with more it has begun to follow. What the motor
    does alone stretches no cable: neither the spring nor the damper feels it.
    """

    name = "backlash"
    terms = (
        Term(
            "play", "m", low=0.0, high=0.01, size=2e-4, linear=False, would_tell="reverse the motors often and slowly"
        ),
        Term("pb", "1", low=0.1, high=3.0, size=0.5, of="arm", linear=False),
    )
    states = 1
    most = 1.0

    def pull(self, p: Values, at: Stretching, z: Array) -> Array:
        side = z[..., 0]
        crossing = np.where(np.sign(at.travel_d) * side < 1 - _FLANK, self.drift(p, at, z)[..., 0], 0.0)
        return -p["play"] / 2 * (p["k"] * side + p["ca"] * crossing)

    def drift(self, p: Values, at: Stretching, z: Array) -> Array:
        return (at.travel_d / np.maximum(p["pb"] * p["play"], _LEAST_M))[..., None]
