"""Motors whose force follows the command with a first-order lag."""

import numpy as np

from mechanism.arm import Array
from mechanism.laws.law import Law, Term, Values

_MIN_LAG_S = 1e-6
"""lag that stands for none, so that a decay over a row is defined"""


class ActuatorLag(Law):
    """taul F' + F = f, of all motors; f is held over each row, and before the first row it was as in that row."""

    name = "actuator_lag"
    terms = (
        Term("taul", "s", low=0.0, high=0.2, size=2e-3, of="arm", linear=False, would_tell="reverse the motors often"),
    )

    def acting_force(self, p: Values, f: Array, step: float) -> Array:
        decay = np.exp(-step / np.maximum(p["taul"], _MIN_LAG_S))
        out = np.empty(np.broadcast_shapes(f.shape, (*np.shape(decay)[:-1], 1)))
        lagged = out[..., :1, :] = f[..., :1, :]
        for row in range(1, f.shape[-2]):
            lagged = out[..., row : row + 1, :] = decay * lagged + (1 - decay) * f[..., row : row + 1, :]
        return out

    def commanded_force(self, p: Values, force: Array, step: float) -> Array:
        decay = np.exp(-step / np.maximum(p["taul"], _MIN_LAG_S))
        before = np.concatenate([force[..., :1, :], force[..., :-1, :]], axis=-2)
        return (force - decay * before) / (1 - decay)
