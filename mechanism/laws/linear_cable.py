"""A spring and a damper side by side: Fasquelle's model 1."""

from mechanism.arm import Array
from mechanism.laws.law import CableMotion, Law, Term, Values


class LinearCable(Law):
    """(53): k x + ca x'."""

    name = "linear_cable"
    terms = (
        Term("k", "N/m", low=10.0, high=1e7, size=1000.0, would_tell="vary the cable's tension by tens of newtons"),
        Term(
            "ca",
            "N s/m",
            low=0.0,
            high=20000.0,
            size=20.0,
            would_tell="vary the tension at 2 Hz and faster, with a clock known to 0.1 ms (a light that the controller switches)",
        ),
    )

    def pull(self, p: Values, at: CableMotion, z: Array) -> Array:
        return p["k"] * at.x + p["ca"] * at.x_d
