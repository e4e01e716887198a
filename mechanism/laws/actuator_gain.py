"""Motors whose force is proportional to the command, but not equal to it."""

from mechanism.arm import Array
from mechanism.laws.law import Law, Term, Values


class ActuatorGain(Law):
    """The logged force is 1 + g times the force that acts."""

    name = "actuator_gain"
    terms = (Term("g", "1", low=-0.5, high=1.0, size=0.02, would_tell="carry known weights"),)

    def acting_force(self, p: Values, f: Array, step: float) -> Array:
        return f / (1 + p["g"])

    def commanded_force(self, p: Values, force: Array, step: float) -> Array:
        return force * (1 + p["g"])
