"""Motors whose force follows the command after a while."""

import numpy as np

from mechanism.arm import Array
from mechanism.laws.law import Law, Term, Values

_LEAST_S = 1e-6


class ActuatorLag(Law):
    """taul F' + F = f, of all motors; f is held over each row, and was before the first as it is there."""

    name = "actuator_lag"
    terms = (
        Term("taul", "s", low=0.0, high=0.2, size=2e-3, of="arm", linear=False, would_tell="reverse the motors often"),
    )

    def command(self, p: Values, f: Array, step: float) -> Array:
        left = np.exp(-step / np.maximum(p["taul"], _LEAST_S))
        out = np.empty(np.broadcast_shapes(f.shape, (*np.shape(left)[:-1], 1)))
        now = out[..., :1, :] = f[..., :1, :]
        for row in range(1, f.shape[-2]):
            now = out[..., row : row + 1, :] = left * now + (1 - left) * f[..., row : row + 1, :]
        return out

    def written(self, p: Values, force: Array, step: float) -> Array:
        left = np.exp(-step / np.maximum(p["taul"], _LEAST_S))
        before = np.concatenate([force[..., :1, :], force[..., :-1, :]], axis=-2)
        return (force - left * before) / (1 - left)
