"""What cables remember, integrated along a recorded motion."""

import numpy as np
from numpy.typing import NDArray

from mechanism.laws import Stretching
from mechanism.machine import Machine

Array = NDArray[np.float64]


def remembered(machine: Machine, at: Stretching, step: float) -> Array:
    """States (T, M, states) on rows `step` s apart, nothing remembered at the first.

    Every law's drift is affine in its own states, a + b z, so that each step is exact while a and b hold over it,
    but for where a bound is met.
    """
    shape = (*at.x.shape, machine.states)
    z = np.zeros(shape)
    if not machine.states:
        return z
    a = machine.drift(at, z)
    b = machine.drift(at, np.ones(shape)) - a
    grown = np.exp(b * step)
    safe = np.where(np.abs(b) * step > 1e-9, b, 1.0)
    added = a * np.where(np.abs(b) * step > 1e-9, (grown - 1) / safe, step)
    now = np.zeros(shape[1:])
    low, high = machine.bounds
    for i in range(shape[0] - 1):
        now = np.minimum(np.maximum(grown[i] * now + added[i], low), high)
        z[i + 1] = now
    return z
