"""Dry friction with a smooth change of sign."""

from mechanism.arm import Array
from mechanism.friction import dry
from mechanism.laws.law import Law, Term, Turning, Values


class DryFriction(Law):
    """(48): (2/pi) atan(cm theta') fs; cm, 1/width of the transition, is one for all motors."""

    name = "dry_friction"
    terms = (Term("fs", "N", 0.0, 100.0, 1.0), Term("cm", "s/rad", 0.02, 20.0, 0.1, "arm"))

    def rub(self, p: Values, at: Turning) -> Array:
        return p["fs"] * dry(at.theta_d, p["cm"])
