"""Motors with a constant error of their force."""

from mechanism.arm import Array
from mechanism.laws.law import Law, Term, Values


class ActuatorOffset(Law):
    """The logged force is fo more than the force that acts."""

    name = "actuator_offset"
    terms = (Term("fo", "N", low=-500.0, high=500.0, size=1.0, would_tell="carry known weights"),)

    def acting_force(self, p: Values, f: Array, step: float) -> Array:
        return f - p["fo"]

    def commanded_force(self, p: Values, force: Array, step: float) -> Array:
        return force + p["fo"]
