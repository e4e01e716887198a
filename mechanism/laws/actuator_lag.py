"""Motors whose force follows the command with a first-order lag."""

import numpy as np
from scipy.signal import lfilter

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
        shape = np.broadcast_shapes(f.shape, (*np.shape(decay)[:-1], 1))
        force, batch = np.broadcast_to(f, shape), shape[:-2]
        out = np.empty(shape)
        for i, d in zip(np.ndindex(batch), np.broadcast_to(decay[..., 0], (*batch, 1)).reshape(-1), strict=True):
            out[i] = lfilter([1 - d], [1, -d], force[i], axis=0, zi=d * force[i][:1])[0]
        return out

    def next_force(self, p: Values, f: Array, before: Array | None, step: float) -> Array:
        decay = np.exp(-step / np.maximum(p["taul"], _MIN_LAG_S))
        return f if before is None else decay * before + (1 - decay) * f

    def commanded_force(self, p: Values, force: Array, step: float) -> Array:
        decay = np.exp(-step / np.maximum(p["taul"], _MIN_LAG_S))
        before = np.concatenate([force[..., :1, :], force[..., :-1, :]], axis=-2)
        return (force - decay * before) / (1 - decay)
