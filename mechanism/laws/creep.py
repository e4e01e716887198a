"""Cables that go on stretching under load: a spring and a dashpot in line, beside the cable's own spring (Zener)."""

from mechanism.arm import Array
from mechanism.laws.law import Law, Stretching, Term, Values


class Creep(Law):
    """z beside the linear cable, z' = km x' - z / tau: a sudden pull meets k + km, a lasting one k."""

    name = "cable_creep"
    terms = (Term("km", "N/m", 0.0, 1e5, 500.0), Term("tau", "s", 0.1, 100.0, 1.0, "arm"))
    states = 1

    def pull(self, p: Values, at: Stretching, z: Array) -> Array:
        return z[..., 0]

    def drift(self, p: Values, at: Stretching, z: Array) -> Array:
        return (p["km"] * at.x_d - z[..., 0] / p["tau"])[..., None]
