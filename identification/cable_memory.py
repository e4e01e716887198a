"""Memory variables of cables (creep, hysteresis, play), integrated along a recorded motion."""

import numpy as np
from numpy.typing import NDArray

from mechanism.laws import CableMotion
from mechanism.machine import Machine

Array = NDArray[np.float64]

_MIN_DECAY = 1e-300
"""of a state over a step: zero times an infinite bound would not be a number"""


def memory_states(machine: Machine, at: CableMotion, step: float) -> Array:
    """Memory variables (T, M, states) on rows `step` s apart, `memory_start` at the first.

    Every law's drift is affine in its own states, a + b z, so that each step is exact while a and b hold over it,
    but for where a bound is met.
    """
    shape = (*at.x.shape, machine.states)
    if not machine.states:
        return np.zeros(shape)
    a = machine.memory_rate(at, np.zeros(shape))
    b = machine.memory_rate(at, np.ones(shape)) - a
    decay = np.maximum(np.exp(b * step), _MIN_DECAY)
    safe = np.where(np.abs(b) * step > 1e-9, b, 1.0)
    added = a * np.where(np.abs(b) * step > 1e-9, (decay - 1) / safe, step)
    low, high = machine.bounds
    return accumulated(machine.memory_start, decay[:-1], added[:-1], low, high)


def accumulated(start: Array, decay: Array, added: Array, low: Array, high: Array) -> Array:
    """z[i + 1] = decay[i] z[i] + added[i] clipped to the bounds, from a start on, (T + 1, ...).

    Successive steps compose to one step of the same form: they are composed within stretches of rows, all stretches at once, and
    the stretches are then run through one after the other.
    """
    steps, rest = len(decay), decay.shape[1:]
    length = max(1, round(np.sqrt(steps)))
    padding = -steps % length
    g = np.concatenate([decay, np.ones((padding, *rest))]).reshape(-1, length, *rest)
    c = np.concatenate([added, np.zeros((padding, *rest))]).reshape(-1, length, *rest)
    G, C, L, H = (np.empty_like(g) for _ in range(4))
    G[:, 0], C[:, 0], L[:, 0], H[:, 0] = g[:, 0], c[:, 0], low, high
    for i in range(1, length):
        G[:, i] = g[:, i] * G[:, i - 1]
        for term in (C, L, H):
            term[:, i] = g[:, i] * term[:, i - 1] + c[:, i]
        for bound in (L, H):
            np.clip(bound[:, i], low, high, out=bound[:, i])
    out = np.empty_like(g)
    z = start
    for stretch in range(len(g)):
        out[stretch] = np.clip(G[stretch] * z + C[stretch], L[stretch], H[stretch])
        z = out[stretch, -1]
    return np.concatenate([start[None], out.reshape(-1, *rest)[:steps]])
