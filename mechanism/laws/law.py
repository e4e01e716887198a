"""What every law is: named terms with units and ranges, and the places of the machine where it takes part.

Forces are in N at the cable, torques in N m at the joint. Arrays have leading axes for batches and samples. A law whose terms
are zero does nothing, so that each model is nested in the next.
"""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from typing import ClassVar, Literal

import numpy as np

from mechanism.arm import Arm, Array

Values = Mapping[str, Array]
"""By term: one number for each cable (..., M) or joint (..., N), or one for all (..., 1)"""
Part = Literal["cable", "joint", "arm"]


@dataclass(frozen=True)
class Term:
    """A number of a law or of another cause: its name, unit, range and size, and what tells it."""

    name: str
    unit: str
    _: KW_ONLY
    low: float
    high: float
    size: float
    """what a person would call a change: scales differences and priors"""
    of: Part = "cable"
    """what has a number of its own: every cable (with its motor), every joint, or the arm as a whole"""
    linear: bool = True
    """whether a law is in proportion to it where it may be zero: an estimate may then come out below, by chance"""
    would_tell: str = ""
    """what to record or to measure where it is not identified"""

    def count(self, arm: Arm) -> int:
        """Of how many places an arm has one."""
        return {"cable": arm.M, "joint": arm.N, "arm": 1}[self.of]


@dataclass(frozen=True)
class Turning:
    """What friction may depend on, all (..., M)."""

    theta_d: Array
    """motor speed, rad/s"""
    tension: Array
    """N"""
    wrap: Array
    """rad, by which the cable is wound around the pulleys of its route"""


@dataclass(frozen=True)
class Stretching:
    """What a cable's pull may depend on, all (..., M)."""

    x: Array
    """elongation (41), m"""
    x_d: Array
    """m/s"""
    length: Array
    """l(alpha), m"""
    arm: Arm
    travel_d: Array
    """what the drum winds in, (rd/R) theta', m/s"""


class Law:
    """A law takes part where it overrides; elsewhere it does nothing."""

    name: ClassVar[str]
    terms: ClassVar[tuple[Term, ...]]
    states: ClassVar[int] = 0
    """numbers that a cable remembers on account of this law"""
    most: ClassVar[float] = np.inf
    """beyond which none of these goes, to either side"""

    def command(self, p: Values, f: Array, step: float) -> Array:
        """Force that acts where f (..., T, M), N, is written, on rows `step` s apart."""
        return f

    def written(self, p: Values, force: Array, step: float) -> Array:
        """What is written where that force acts: `command` the other way."""
        return force

    def rub(self, p: Values, at: Turning) -> Array:
        """Force that friction takes from the motor's command, (..., M), N."""
        return np.zeros(())

    def pull(self, p: Values, at: Stretching, z: Array) -> Array:
        """Part of a cable's tension, (..., M), N; z (..., M, states)."""
        return np.zeros(())

    def drift(self, p: Values, at: Stretching, z: Array) -> Array:
        """Rate of the states, (..., M, states)."""
        return np.zeros_like(z)

    def resist(self, p: Values, alpha_d: Array) -> Array:
        """Torque against the joints' motion, (..., N), N m."""
        return np.zeros(())
