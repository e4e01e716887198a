"""Friction that is larger near rest (Stribeck 1902)."""

from mechanism.arm import Array
from mechanism.laws.law import Law, MotorMotion, Term, Values

_WOULD_TELL = "creep through rest as well as move fast"


class Stribeck(Law):
    """fst (1 + (theta'/vs)^2 / ns)^-ns more than the dry friction, with its change of sign; vs in rad/s at the motor.

    ns 1 is Lorentz's curve; with a large ns it is Gauss's, exp(-(theta'/vs)^2).
    """

    name = "stribeck_friction"
    terms = (
        Term("fst", "N", low=0.0, high=500.0, size=2.0, would_tell=_WOULD_TELL),
        Term("vs", "rad/s", low=2.0, high=200.0, size=5.0, of="arm", would_tell=_WOULD_TELL),
        Term("ns", "1", low=0.5, high=50.0, size=5.0, of="arm", would_tell=_WOULD_TELL),
    )

    def friction(self, p: Values, at: MotorMotion) -> Array:
        faded = (1 + (at.theta_d / p["vs"]) ** 2 / p["ns"]) ** -p["ns"]
        return p["fst"] * faded * at.share(p["cm"])
