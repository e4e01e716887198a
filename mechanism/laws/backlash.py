"""Play between a motor and its drum."""

import numpy as np

from mechanism.arm import Array
from mechanism.laws.law import CableMotion, Law, Term, Values

_MIN_TRAVEL_M = 1e-5
"""travel that crosses the play, where there is none"""
_FLANK = 1e-3
"""share of half the play within which a flank counts as reached: slopes by differences there must not count as a crossing"""

OPERATOR: Values = {"pb": np.array([0.5])}
"""with which the law is the play operator"""


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
    memory_bound = 1.0

    def pull(self, p: Values, at: CableMotion, z: Array) -> Array:
        return -p["play"] / 2 * p["k"] * z[..., 0] - self.undragged(p, at, z)

    def undragged(self, p: Values, at: CableMotion, z: Array) -> Array:
        crossing = np.where(np.sign(at.travel_d) * z[..., 0] < 1 - _FLANK, self.memory_rate(p, at, z)[..., 0], 0.0)
        return p["play"] / 2 * p["ca"] * crossing

    def memory_in_motion(self, at: CableMotion) -> Array:
        return np.broadcast_to(np.sign(at.travel_d), at.x.shape)[..., None]

    def memory_rate(self, p: Values, at: CableMotion, z: Array) -> Array:
        return (at.travel_d / np.maximum(p["pb"] * p["play"], _MIN_TRAVEL_M))[..., None]
