"""Elongations under which cables pull with given tensions, whatever their law: the other way round of `Machine.pull`."""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_banded

from identification.cable_memory import memory_states
from mechanism.laws import Stretching
from mechanism.machine import Machine
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

_EXACT_N = 1e-8
_ROUNDS = 100
_SMALL_M, _SMALL_M_S = 1e-7, 1e-5
"""steps for the slopes of the law"""


def elongations_for(machine: Machine, tension: Array, length: Array, step: float) -> tuple[Array, Array]:
    """x, m, and x', m/s, of cables with these tensions (T, M), N, and lengths (T, M), m, on rows `step` s apart.

    At rest before the first row. x' is the backward difference of second order of x (BDF 2), which damps what rings; Newton's
    method on all rows at once. Raises Refused where the laws give no elongation for the tensions.
    """
    x, longer = np.zeros_like(tension), backward_difference(length, step)

    def pull(x: Array, x_d: Array, z: Array | None = None) -> tuple[Array, Array]:
        at = Stretching(x, x_d, length, machine.arm, x_d - longer)
        z = memory_states(machine, at, step) if z is None else z
        return np.broadcast_to(machine.pull(at, z), x.shape), z

    for _ in range(_ROUNDS):
        x_d = backward_difference(x, step)
        now, z = pull(x, x_d)
        left = tension - now
        if np.abs(left).max() < _EXACT_N:
            return x, x_d
        stiffness = (pull(x + _SMALL_M, x_d, z)[0] - now) / _SMALL_M
        damping = np.maximum((pull(x, x_d + _SMALL_M_S, z)[0] - now) / _SMALL_M_S, 0.0)
        if np.any(stiffness <= 0):
            break
        x = x + np.stack(
            [_solved(k, c, d, step) for k, c, d in zip(stiffness.T, damping.T, left.T, strict=True)], axis=-1
        )
        if not np.all(np.abs(x) < 1.0):
            break
    raise Refused("design", "the model's cables have no elongation for the tensions asked for", "check model.yaml")


def backward_difference(x: Array, step: float) -> Array:
    """(3 x_i - 4 x_(i-1) + x_(i-2)) / 2 step along the first axis, at rest before the first row."""
    before = np.concatenate([x[:1], x[:1], x])
    return (3 * x - 4 * before[1:-1] + before[:-2]) / (2 * step)


def _solved(stiffness: Array, damping: Array, force: Array, step: float) -> Array:
    """dx of stiffness dx + damping rate(dx) = force, each (T,)."""
    c = damping / (2 * step)
    bands = np.zeros((3, len(force)))
    bands[0] = stiffness + 3 * c
    bands[1, :-1] = -4 * c[1:]
    bands[2, :-2] = c[2:]
    bands[0, 0] = stiffness[0]
    if len(c) > 1:
        bands[1, 0] = -3 * c[1]
    return np.asarray(solve_banded((2, 0), bands, force))
