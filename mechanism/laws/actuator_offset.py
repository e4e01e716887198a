"""Motors that pull although they are told not to."""

from mechanism.arm import Array
from mechanism.laws.law import Law, Term, Values


class ActuatorOffset(Law):
    """What is written is fo more than the force that acts."""

    name = "actuator_offset"
    terms = (Term("fo", "N", low=-50.0, high=50.0, size=1.0, would_tell="carry known weights"),)

    def command(self, p: Values, f: Array, step: float) -> Array:
        return f - p["fo"]

    def written(self, p: Values, force: Array, step: float) -> Array:
        return force + p["fo"]
