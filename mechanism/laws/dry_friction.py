"""Dry friction with a smooth change of sign."""

from mechanism.arm import Array
from mechanism.laws.law import Law, MotorMotion, Term, Values


class DryFriction(Law):
    """(48): (2/pi) atan(cm theta') fs; cm, 1/width of the transition, is one for all motors."""

    name = "dry_friction"
    terms = (
        Term("fs", "N", low=0.0, high=1000.0, size=1.0, would_tell="turn the motor both ways at speed, many times"),
        Term("cm", "s/rad", low=0.02, high=20.0, size=0.1, of="arm", would_tell="reverse the motors often and slowly"),
    )

    def friction(self, p: Values, at: MotorMotion) -> Array:
        return p["fs"] * at.share(p["cm"])
