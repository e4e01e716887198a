"""One material for all cables: Fasquelle's models 2 and 3."""

from mechanism.arm import Array
from mechanism.laws.law import CableMotion, Law, Term, Values


class YoungsModulus(Law):
    """(57) with the cable's whole length: (E x + c x') S / l_total."""

    name = "youngs_modulus"
    terms = (
        Term(
            "E", "Pa", low=1e8, high=1e12, size=1e9, of="arm", would_tell="vary the cables' tension by tens of newtons"
        ),
        Term(
            "c",
            "Pa s",
            low=0.0,
            high=1e10,
            size=1e7,
            of="arm",
            would_tell="vary the tension at 2 Hz and faster, with a clock known to 0.1 ms (a light that the controller switches)",
        ),
    )

    def pull(self, p: Values, at: CableMotion, z: Array) -> Array:
        return at.arm.section / at.arm.cable_length * (p["E"] * at.x + p["c"] * at.x_d)


class YoungsModulusInPose(Law):
    """(57) with the length in the pose: (E x + c x') S / l(alpha)."""

    name = "youngs_modulus_in_pose"
    terms = YoungsModulus.terms

    def pull(self, p: Values, at: CableMotion, z: Array) -> Array:
        return at.arm.section / at.length * (p["E"] * at.x + p["c"] * at.x_d)
