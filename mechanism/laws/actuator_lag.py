"""Motors whose force follows the command after a while."""

import numpy as np
from scipy.signal import lfilter

from mechanism.arm import Array
from mechanism.laws.law import Law, Term, Values


class ActuatorLag(Law):
    """taul F' + F = f, of all motors; f is held over each row."""

    name = "actuator_lag"
    terms = (Term("taul", "s", 0.0, 0.2, 2e-3, "arm", linear=False),)

    def command(self, p: Values, f: Array, step: float) -> Array:
        left = float(np.exp(-step / np.maximum(np.ravel(p["taul"])[0], 1e-6)))
        out, _ = lfilter([1 - left], [1, -left], f, axis=-2, zi=left * f[..., :1, :])
        return out
