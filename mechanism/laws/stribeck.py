"""Friction that is larger near rest (Stribeck 1902)."""

from mechanism.arm import Array
from mechanism.friction import dry
from mechanism.laws.law import Law, Term, Turning, Values


class Stribeck(Law):
    """fst (1 + (theta'/vs)^2 / ns)^-ns more than the dry friction, with its change of sign; vs in rad/s at the motor.

    ns 1 is Lorentz's curve; with a large ns it is Gauss's, exp(-(theta'/vs)^2).
    """

    name = "stribeck_friction"
    terms = (
        Term("fst", "N", 0.0, 50.0, 2.0),
        Term("vs", "rad/s", 2.0, 200.0, 5.0, "arm"),
        Term("ns", "1", 0.5, 50.0, 5.0, "arm"),
    )

    def rub(self, p: Values, at: Turning) -> Array:
        faded = (1 + (at.theta_d / p["vs"]) ** 2 / p["ns"]) ** -p["ns"]
        return p["fst"] * faded * dry(at.theta_d, p["cm"])
