"""Elongations under which cables have given tensions, whatever their laws: the inverse of `Machine.pull`."""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_banded

from identification.cable_memory import memory_states
from mechanism.laws import CableMotion
from mechanism.machine import Machine
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

_TOLERANCE_N = 1e-8
_MAX_ITERATIONS = 100
_STEP_M, _STEP_M_S = 1e-7, 1e-5
"""steps of the differences for the slopes of the laws"""


def elongations_for(machine: Machine, tension: Array, length: Array, step: float) -> tuple[Array, Array]:
    """x, m, and x', m/s, of cables with these tensions (T, M), N, and lengths (T, M), m, on rows `step` s apart.

    The cables are at rest before the first row. x' is the backward difference of second order of x (BDF 2), which damps
    oscillations; Newton's method runs on all rows at once. Raises Refused where the laws give no elongation for the tensions.
    """
    x, length_d = np.zeros_like(tension), backward_difference(length, step)

    def pull(x: Array, x_d: Array, z: Array | None = None) -> tuple[Array, Array]:
        at = CableMotion(x, x_d, length, machine.arm, x_d - length_d)
        z = memory_states(machine, at, step) if z is None else z
        return np.broadcast_to(machine.pull(at, z), x.shape), z

    for _ in range(_MAX_ITERATIONS):
        x_d = backward_difference(x, step)
        pull_now, z = pull(x, x_d)
        error = tension - pull_now
        if np.abs(error).max() < _TOLERANCE_N:
            return x, x_d
        stiffness = (pull(x + _STEP_M, x_d, z)[0] - pull_now) / _STEP_M
        damping = np.maximum((pull(x, x_d + _STEP_M_S, z)[0] - pull_now) / _STEP_M_S, 0.0)
        if np.any(stiffness <= 0):
            break
        x = x + np.stack(
            [_solved(k, c, d, step) for k, c, d in zip(stiffness.T, damping.T, error.T, strict=True)], axis=-1
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
