"""Instrumental variables: elongations that the motors tell, in which vision's noise had no part.

Least squares divides by the variance of the elongation with vision's noise in it, so that stiffness comes out too small.
Columns built from the force, the motor's turning and the laws found so far are the same but for that noise: as instruments
they take the bias away (Brunot, Janot and others on robots: IDIM-IV). Two stages; what the first got wrong only costs precision.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from identification.memory import remembered
from identification.residuals import forces, stretching
from identification.signals import Signals
from identification.unknowns import Unknowns
from mechanism.machine import Machine

Array = NDArray[np.float64]

_ROUNDS = 12
_CLOSE_N = 1e-3
"""RMS of the tension: there it ends"""
_SLOW = 0.9
"""or where a round leaves more than this part: rates by differences are not those of the filter"""
_FAR_M = 0.1
"""beyond any cable's elongation: a law that is far off must not run away"""
_SMALL_M, _SMALL_M_S = 1e-5, 1e-3
"""steps for the slope of the cables' law"""


def driven(s: Signals, u: Unknowns, p: Array, recording: int) -> Signals:
    """The recording with the elongations under which the laws' tension is what the motors pull with."""
    values, x0 = u.values(p), u.get(p, "x0", recording)
    machine = Machine(s.arm, u.laws, values)

    def pull(x: Array, x_d: Array) -> Array:
        at = stretching(replace(s, x=x, x_d=x_d), np.zeros(1))
        return np.broadcast_to(machine.pull(at, remembered(machine, at, s.step)), x.shape)

    x, x_d = s.x + x0, s.x_d
    tension = forces(s, u.laws, values, x0, float(u.get(p, "delay", recording)[0])).drive - s.inertial
    now = pull(x, x_d)
    stiffness = np.max((pull(x + _SMALL_M, x_d) - now) / _SMALL_M, axis=0)
    damping = np.maximum(np.mean((pull(x, x_d + _SMALL_M_S) - now) / _SMALL_M_S, axis=0), 0.0)
    if np.any(stiffness <= 0):
        return s
    left = np.inf
    for _ in range(_ROUNDS):
        x = x + _answer(tension - now, stiffness, damping, s.step)
        x = np.clip(x, -_FAR_M, _FAR_M)
        x_d = np.gradient(x, s.step, axis=0)
        now = pull(x, x_d)
        before, left = left, float(np.sqrt(np.mean((tension - now) ** 2)))
        if left < _CLOSE_N or left > _SLOW * before:
            break
    return replace(s, x=x - x0, x_d=x_d)


def _answer(force: Array, stiffness: Array, damping: Array, step: float) -> Array:
    """x of stiffness x + damping x' = force, (T, M)."""
    out = np.empty_like(force)
    for j, (k, c) in enumerate(zip(stiffness, damping / step, strict=True)):
        out[:, j], _ = lfilter([1 / (k + c)], [1, -c / (k + c)], force[:, j], zi=[c / (k + c) * force[0, j] / k])
    return out
