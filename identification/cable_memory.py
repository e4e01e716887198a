"""What cables remember, integrated along a recorded motion."""

import numpy as np
from numpy.typing import NDArray

from mechanism.laws import Stretching
from mechanism.machine import Machine

Array = NDArray[np.float64]

_LEAST = 1e-300
"""of what a step leaves of a state: nothing times an infinite bound would be none"""


def memory_states(machine: Machine, at: Stretching, step: float) -> Array:
    """States (T, M, states) on rows `step` s apart, nothing remembered at the first.

    Every law's drift is affine in its own states, a + b z, so that each step is exact while a and b hold over it,
    but for where a bound is met.
    """
    shape = (*at.x.shape, machine.states)
    if not machine.states:
        return np.zeros(shape)
    a = machine.drift(at, np.zeros(shape))
    b = machine.drift(at, np.ones(shape)) - a
    grown = np.maximum(np.exp(b * step), _LEAST)
    safe = np.where(np.abs(b) * step > 1e-9, b, 1.0)
    added = a * np.where(np.abs(b) * step > 1e-9, (grown - 1) / safe, step)
    low, high = machine.bounds
    return _walked(grown[:-1], added[:-1], low, high)


def _walked(grown: Array, added: Array, low: Array, high: Array) -> Array:
    """z[i + 1] = grown[i] z[i] + added[i] within bounds, from zero on, (T + 1, ...).

    Steps in a row are again one such step with other numbers: stretches of rows are put together side by side, then joined.
    """
    steps, rest = len(grown), grown.shape[1:]
    length = max(1, round(np.sqrt(steps)))
    spare = -steps % length
    g = np.concatenate([grown, np.ones((spare, *rest))]).reshape(-1, length, *rest)
    c = np.concatenate([added, np.zeros((spare, *rest))]).reshape(-1, length, *rest)
    G, C, L, H = (np.empty_like(g) for _ in range(4))
    G[:, 0], C[:, 0], L[:, 0], H[:, 0] = g[:, 0], c[:, 0], low, high
    for i in range(1, length):
        G[:, i] = g[:, i] * G[:, i - 1]
        for one in (C, L, H):
            one[:, i] = g[:, i] * one[:, i - 1] + c[:, i]
        for one in (L, H):
            np.clip(one[:, i], low, high, out=one[:, i])
    out = np.empty_like(g)
    now = np.zeros(rest)
    for stretch in range(len(g)):
        out[stretch] = np.clip(G[stretch] * now + C[stretch], L[stretch], H[stretch])
        now = out[stretch, -1]
    return np.concatenate([np.zeros((1, *rest)), out.reshape(-1, *rest)[:steps]])
