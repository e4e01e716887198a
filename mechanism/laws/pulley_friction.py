"""Friction of a cable on the pulleys of its route, in proportion to its tension and to the angle it is wound (Euler, Eytelwein)."""

from mechanism.arm import Array
from mechanism.friction import dry
from mechanism.laws.law import Law, Term, Turning, Values


class PulleyFriction(Law):
    """mu wrap t, against the motion; the first order of exp(mu wrap) - 1, felt at the motor."""

    name = "pulley_friction"
    terms = (Term("mu", "1/rad", 0.0, 0.3, 0.005),)

    def rub(self, p: Values, at: Turning) -> Array:
        return p["mu"] * at.wrap * at.tension * dry(at.theta_d, p["cm"])
