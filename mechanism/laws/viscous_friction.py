"""Viscous friction of motors and gears."""

from mechanism.arm import Array
from mechanism.laws.law import Law, MotorMotion, Term, Values


class ViscousFriction(Law):
    """(49): fv theta'."""

    name = "viscous_friction"
    terms = (
        Term(
            "fv",
            "N s/rad",
            low=0.0,
            high=10.0,
            size=0.01,
            would_tell="turn the motor at speeds that differ several times over",
        ),
    )

    def friction(self, p: Values, at: MotorMotion) -> Array:
        return p["fv"] * at.theta_d
