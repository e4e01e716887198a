"""Viscous friction of motors and gears."""

from mechanism.arm import Array
from mechanism.laws.law import Law, Term, Turning, Values


class ViscousFriction(Law):
    """(49): fv theta'."""

    name = "viscous_friction"
    terms = (Term("fv", "N s/rad", 0.0, 1.0, 0.01),)

    def rub(self, p: Values, at: Turning) -> Array:
        return p["fv"] * at.theta_d
