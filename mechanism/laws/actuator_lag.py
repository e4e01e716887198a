"""Motors whose force follows the command with a first-order lag."""

import numpy as np
from scipy.signal import lfilter

from mechanism.arm import Array
from mechanism.laws.law import Law, Term, Values


class ActuatorLag(Law):
    """taul F' + F = f, of each motor; f is held over each row, and before the first row it was as in that row.

    From row to row by Euler's backward steps: F then is as late as by the law in the mean over rows, taul, however short that is.
    """

    name = "actuator_lag"
    terms = (Term("taul", "s", low=0.0, high=0.2, size=2e-3, linear=False, would_tell="reverse the motors often"),)

    def acting_force(self, p: Values, f: Array, step: float) -> Array:
        decay = _decay(p, step)
        shape = np.broadcast_shapes(f.shape, np.shape(decay))
        force, decay = np.broadcast_to(f, shape), np.broadcast_to(decay, (*shape[:-2], 1, shape[-1]))
        out = np.empty(shape)
        for *batch, motor in np.ndindex(*shape[:-2], shape[-1]):
            of_motor, d = (*batch, slice(None), motor), decay[(*batch, 0, motor)]
            out[of_motor] = lfilter([1 - d], [1, -d], force[of_motor], zi=d * force[of_motor][:1])[0]
        return out

    def next_force(self, p: Values, f: Array, before: Array | None, step: float) -> Array:
        decay = _decay(p, step)
        return f if before is None else decay * before + (1 - decay) * f

    def commanded_force(self, p: Values, force: Array, step: float) -> Array:
        decay = _decay(p, step)
        before = np.concatenate([force[..., :1, :], force[..., :-1, :]], axis=-2)
        return (force - decay * before) / (1 - decay)


def _decay(p: Values, step: float) -> Array:
    """Share of a force that is left after a row."""
    return p["taul"] / (p["taul"] + step)
