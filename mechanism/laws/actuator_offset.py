"""Motors that pull although they are told not to."""

from mechanism.arm import Array
from mechanism.laws.law import Law, Term, Values


class ActuatorOffset(Law):
    """What is written is fo more than the force that acts."""

    name = "actuator_offset"
    terms = (Term("fo", "N", -50.0, 50.0, 1.0),)

    def command(self, p: Values, f: Array, step: float) -> Array:
        return f - p["fo"]

    def written(self, p: Values, force: Array, step: float) -> Array:
        return force + p["fo"]
