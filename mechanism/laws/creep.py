"""Cables that go on stretching under load: a spring and a dashpot in line, beside the cable's own spring (Zener)."""

from mechanism.arm import Array
from mechanism.laws.law import CableMotion, Law, Term, Values

_WOULD_TELL = "step the tension and hold it for a while"


class Creep(Law):
    """z beside the linear cable, z' = km x' - z / tau: a sudden pull meets k + km, a lasting one k."""

    name = "cable_creep"
    terms = (
        Term("km", "N/m", low=0.0, high=1e6, size=500.0, would_tell=_WOULD_TELL),
        Term("tau", "s", low=0.1, high=100.0, size=1.0, of="arm", would_tell=_WOULD_TELL),
    )
    states = 1
    memory_start = Term("z0", "N", low=-10000.0, high=10000.0, size=5.0, would_tell=_WOULD_TELL)

    def pull(self, p: Values, at: CableMotion, z: Array) -> Array:
        return z[..., 0]

    def memory_rate(self, p: Values, at: CableMotion, z: Array) -> Array:
        return (p["km"] * at.x_d - z[..., 0] / p["tau"])[..., None]
