"""A spring and a damper side by side: Fasquelle's model 1."""

from mechanism.arm import Array
from mechanism.laws.law import Law, Stretching, Term, Values


class LinearCable(Law):
    """(53): k x + ca x'."""

    name = "linear_cable"
    terms = (Term("k", "N/m", 100.0, 1e6, 1000.0), Term("ca", "N s/m", 0.0, 2000.0, 20.0))

    def pull(self, p: Values, at: Stretching, z: Array) -> Array:
        return p["k"] * at.x + p["ca"] * at.x_d
