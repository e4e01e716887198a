"""One material for all cables: Fasquelle's models 2 and 3."""

from mechanism.arm import Array
from mechanism.laws.law import Law, Stretching, Term, Values


class YoungsModulus(Law):
    """(57) with the cable's whole length: (E x + c x') S / l_total."""

    name = "youngs_modulus"
    terms = (Term("E", "Pa", 1e8, 1e12, 1e9, "arm"), Term("c", "Pa s", 0.0, 1e10, 1e7, "arm"))

    def pull(self, p: Values, at: Stretching, z: Array) -> Array:
        return at.arm.section / at.arm.cable_length * (p["E"] * at.x + p["c"] * at.x_d)


class YoungsModulusInPose(Law):
    """(57) with the length in the pose: (E x + c x') S / l(alpha)."""

    name = "youngs_modulus_in_pose"
    terms = YoungsModulus.terms

    def pull(self, p: Values, at: Stretching, z: Array) -> Array:
        return at.arm.section / at.length * (p["E"] * at.x + p["c"] * at.x_d)
