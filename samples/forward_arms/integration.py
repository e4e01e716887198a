"""Two fixed steps: one that stiff cables do not limit, and Runge's as a witness.

The first is ROS34PW2 (Rang and Angermann 2005): four stages, L-stable, third order for whatever matrix stands in its linear
systems. Its second order beside it tells where a step was too long.
"""

import numpy as np

from samples.forward_arms.forward import Rates, System
from samples.forward_arms.plant import Array

_G = 0.43586652150845967
_ALPHA = np.array(
    [
        [0.0, 0.0, 0.0, 0.0],
        [0.87173304301691801, 0.0, 0.0, 0.0],
        [0.84457060015369423, -0.11299064236484185, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
    ]
)
_GAMMA = np.array(
    [
        [_G, 0.0, 0.0, 0.0],
        [-0.87173304301691801, _G, 0.0, 0.0],
        [-0.90338057013044082, 0.054180672388095326, _G, 0.0],
        [0.24212380706095346, -1.2232505839045147, 0.54526025533510214, _G],
    ]
)
_B = np.array([0.24212380706095346, -1.2232505839045147, 1.5452602553351020, _G])
_B_OF_SECOND_ORDER = np.array([0.37810903145819369, -0.096042292212423178, 0.5, 0.21793326075422950])
# of u = Gamma k, so that no product with the matrix is needed
_STAGE = _ALPHA @ np.linalg.inv(_GAMMA)
_CARRY = np.diag(1 / np.diag(_GAMMA)) - np.linalg.inv(_GAMMA)
_END = _B @ np.linalg.inv(_GAMMA)
_ERROR = (_B - _B_OF_SECOND_ORDER) @ np.linalg.inv(_GAMMA)


def rosenbrock_step(system: System, time: float, y: Array, f: Array, h: float) -> tuple[Array, Rates, Array]:
    """State after h (s) under forces f held, the rates at its begin, and by how much the state's second order differs."""
    g = _G * h
    first = system.rates(time, y, f)
    matrix = system.implicit(first, g)
    u: list[Array] = [matrix.solve(g * first.state_d)]
    for i in range(1, 4):
        at = y + sum(_STAGE[i, j] * u[j] for j in range(i))
        here = system.rates(time + h * _ALPHA[i].sum(), at, f, slopes=False).state_d
        u.append(matrix.solve(g * here + _G * sum(_CARRY[i, j] * u[j] for j in range(i))))
    error = np.tensordot(_ERROR, np.stack(u), axes=1)
    return y + sum(_END[i] * u[i] for i in range(4)), first, error


def runge_step(system: System, time: float, y: Array, f: Array, h: float) -> tuple[Array, Rates]:
    """The classical four stages, explicit."""
    first = system.rates(time, y, f)
    k1 = first.state_d
    k2 = system.rates(time + h / 2, y + h / 2 * k1, f).state_d
    k3 = system.rates(time + h / 2, y + h / 2 * k2, f).state_d
    k4 = system.rates(time + h, y + h * k3, f).state_d
    return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), first
